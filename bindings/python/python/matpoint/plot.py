"""Pictures with matplotlib: particles, energies, convergence.

Needs matplotlib: `pip install matpoint[plot]`. Each function draws on `ax`, or on a new figure, and returns the axes,
so that titles, limits and files are matplotlib's matter: `plot.particles(sim).figure.savefig("beam.svg")`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .state import von_mises

try:
    import matplotlib.pyplot as plt
    from matplotlib.collections import PolyCollection
except ImportError as error:
    raise ImportError("matpoint.plot needs matplotlib: pip install matpoint[plot]") from error

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._matpoint import Simulation
    from .history import History

Floats = NDArray[np.float64]

__all__ = ["convergence", "energy", "particles"]

_AXES = "xyz"
# Okabe and Ito's colours, which people with any colour vision can tell apart
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_MARKERS = "osD^vP"
_WIDTH = 7.0
"""Width of a new figure [inch]."""
_SLIM = 0.4
"""Axes whose height is less than this share of their width have their colour bar below."""


def particles(sim: Simulation, color: str = "von_mises", component: str = "", ax: Axes | None = None) -> Axes:
    """Draws the particles of a simulation where they are now.

    `color` is `"von_mises"` or a variable with a value for each particle, such as `"particle/velocity"`. `component` is
    an axis of a vector (`"x"`) or two of a tensor (`"xy"`); a vector without one is coloured by its magnitude.

    In 1D the value stands over the position. In 2D each particle is its piece of the body, deformed with it. In 3D
    (`ax` must be a 3D axes, if given) it is a disk as wide as the particle at the size that the figure has now.
    """
    values, label = _values(sim, color, component)
    position = sim.get("particle/position", view=True)
    dimension = position.shape[1]
    figure = None if ax else plt.figure(figsize=(_WIDTH, 4.8), layout="constrained")
    axes: Any = figure.add_subplot(projection="3d" if dimension == 3 else "rectilinear") if figure else ax
    if dimension == 3 and axes.name != "3d":
        raise ValueError('dimension 3 needs a 3D axes: figure.add_subplot(projection="3d")')
    axes.set_title(f"t = {sim.time:.4g} s")
    axes.set(**{f"{axis}label": f"{axis} {_unit(sim, 'particle/position')}" for axis in _AXES[:dimension]})
    if dimension == 1:
        axes.set_ylabel(label)
        axes.plot(position[:, 0], values, ".", color=_COLOURS[0])
        axes.grid(alpha=0.3)
    elif dimension == 2:
        _pieces(axes, sim, position, values, label)
    else:
        _balls(axes, sim, position, values, label)
    if figure and dimension == 2:
        # about as high as the body, and room for numbers and colours
        height = 0.85 * _WIDTH * min(1.0, max(0.15, _aspect(axes)))
        figure.set_size_inches(_WIDTH, height + (1.4 if _aspect(axes) < _SLIM else 0.6))
    return cast("Axes", axes)


def energy(history: History, ax: Axes | None = None) -> Axes:
    """Draws the energies of a history [J] over time [s]: all that it kept of `energy/...`."""
    names = [name for name in history.names if name.startswith("energy/")]
    if not names:
        raise ValueError(f"the history has no energy, only {', '.join(history.names)}")
    ax = ax or plt.subplots(figsize=(_WIDTH, 4.0), layout="constrained")[1]
    colours = iter(_COLOURS * len(names))
    for name in names:
        # the total is what the others add up to
        style: dict[str, Any] = {"color": "black", "ls": "--"} if name == "energy/total" else {"color": next(colours)}
        ax.plot(history.time, history[name], label=_word(name), **style)
    ax.set(xlabel="time [s]", ylabel="energy [J]")
    ax.grid(alpha=0.3)
    ax.legend()
    return ax


def convergence(h: ArrayLike, errors: Mapping[str, Sequence[float]], ax: Axes | None = None) -> Axes:
    """Draws errors over the cell size `h` [m], both logarithmic.

    `errors` has a name, with its unit, and as many errors as there are sizes: `{"displacement [m]": [4e-3, 1e-3]}`. The
    legend tells each observed order: the slope of the straight line that fits best. A triangle shows the whole order
    nearest to that of the lowest line.
    """
    sizes = np.asarray(h, dtype=float)
    lines = {name: np.asarray(values, dtype=float) for name, values in errors.items()}
    if not lines or sizes.ndim != 1 or len(sizes) < 2 or any(line.shape != sizes.shape for line in lines.values()):
        raise ValueError("convergence takes two or more cell sizes, and as many errors for each name")
    order = np.argsort(sizes)
    orders = {name: float(np.polyfit(np.log(sizes), np.log(line), 1)[0]) for name, line in lines.items()}
    ax = ax or plt.subplots(figsize=(_WIDTH, 4.5), layout="constrained")[1]
    for index, (name, line) in enumerate(lines.items()):
        style: dict[str, Any] = {"color": _COLOURS[index % len(_COLOURS)], "marker": _MARKERS[index % len(_MARKERS)]}
        ax.loglog(sizes[order], line[order], label=f"{name}, order {orders[name]:.2f}", **style)
    lowest = min(lines, key=lambda name: float(lines[name][order[0]]))
    _triangle(ax, sizes[order], lines[lowest][order], round(orders[lowest]))
    ax.set(xlabel="cell size [m]", ylabel="error")
    ax.grid(which="both", alpha=0.2)
    ax.legend()
    return ax


def _values(sim: Simulation, color: str, component: str) -> tuple[Floats, str]:
    """A value for each particle, and what it is, with its unit."""
    if color == "von_mises":
        return von_mises(sim.get("particle/stress", view=True)), f"von Mises stress {_unit(sim, 'particle/stress')}"
    if not color.startswith("particle/"):
        raise ValueError(f"`{color}` has no value for each particle; particle/... has, and von_mises")
    values = sim.get(color, view=True)
    word, unit, shape = _word(color), _unit(sim, color), values.shape[1:]
    if shape == (1,):
        return values[:, 0], f"{word} {unit}"
    if len(shape) == 1 and not component:
        return np.linalg.norm(values, axis=1), f"{word}, magnitude {unit}"
    indices = [_AXES.find(axis) for axis in component]
    if len(indices) != len(shape) or any(not 0 <= index < size for index, size in zip(indices, shape, strict=True)):
        like = _AXES[0] * len(shape)
        raise ValueError(f"`{color}` has shape {values.shape}: component must be like {like!r}, not {component!r}")
    for index in indices:
        values = values[:, index]
    return values, " ".join(filter(None, (word, component, unit)))


def _word(name: str) -> str:
    return name.rsplit("/", 1)[-1].replace("_", " ")


def _unit(sim: Simulation, name: str) -> str:
    return f"[{sim.variable(name).unit or '-'}]"


def _sizes(sim: Simulation) -> Floats:
    """Edges of the box that each particle stands for at time 0 [m], shape (n, dimension)."""
    scene = sim.scene
    keys = scene.to_dict()
    cell = np.broadcast_to(keys["grid"]["cell"], scene.dimension)
    # equal ones along all axes if left out; how many they are does not change the proportions
    boxes = np.array([cell / np.asarray(keys["body"][name].get("particles_per_cell", 1)) for name in sim.describe().bodies])
    sizes = boxes[sim.get("particle/body", view=True).astype(int)]
    determinant = np.linalg.det(sim.get("particle/deformation_gradient", view=True))
    # particles with uneven weights keep the proportions of the box
    share = sim.get("particle/volume", view=True) / determinant / np.prod(sizes, axis=1)
    return cast("Floats", sizes * share[:, None] ** (1.0 / scene.dimension))


def _aspect(ax: Axes) -> float:
    """Height over width of what an axes shows [-]."""
    return float(np.ptp(ax.get_ylim()) / np.ptp(ax.get_xlim()))


def _pieces(ax: Axes, sim: Simulation, position: Floats, values: Floats, label: str) -> None:
    corners = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * _sizes(sim)[:, None, :]
    deformation = sim.get("particle/deformation_gradient", view=True)[:, :2, :2]
    vertices = position[:, None, :] + np.einsum("nij,nkj->nki", deformation, corners)
    pieces = PolyCollection(cast("Any", vertices), array=values, cmap="viridis", edgecolors="face", linewidths=0.5)
    ax.add_collection(pieces)
    ax.set_aspect("equal")
    ax.autoscale_view()
    if _aspect(ax) < _SLIM:
        ax.figure.colorbar(pieces, ax=ax, label=label, location="bottom", aspect=50.0)
    else:
        # as high as the axes are, whatever their aspect
        ax.figure.colorbar(pieces, cax=ax.inset_axes((1.02, 0.0, 0.03, 1.0)), label=label)


def _balls(ax: Any, sim: Simulation, position: Floats, values: Floats, label: str) -> None:
    edge = {"edgecolors": (0.0, 0.0, 0.0, 0.3), "linewidths": 0.3}
    balls = ax.scatter(*position.T, c=values, cmap="viridis", depthshade=False, **edge)
    # without perspective a particle is as large in front as at the back
    ax.set_proj_type("ortho")
    ax.set_aspect("equal")
    ax.locator_params(nbins=5)
    ax.figure.colorbar(balls, ax=ax, label=label, shrink=0.7, pad=0.1)
    stretch = np.cbrt(np.linalg.det(sim.get("particle/deformation_gradient", view=True)))
    diameters = np.mean(_sizes(sim), axis=1) * stretch
    balls.set_sizes((diameters * _points_per_metre(ax, position.mean(axis=0))) ** 2)


def _points_per_metre(ax: Any, centre: Floats) -> float:
    """How long a metre across the line of sight is on paper, in points, at a place of a 3D axes."""
    # only drawing places the axes
    ax.figure.canvas.figure.draw_without_rendering()
    corners = np.column_stack([np.vstack([centre, centre + np.eye(3)]), np.ones(4)]) @ ax.get_proj().T
    pixels = ax.transData.transform(corners[:, :2] / corners[:, 3:])
    # of three axes at right angles the squares of the lengths on paper add up to two
    length = math.sqrt(np.sum((pixels[1:] - pixels[0]) ** 2) / 2.0)
    return float(length * 72.0 / ax.figure.dpi)


def _triangle(ax: Axes, sizes: Floats, line: Floats, order: int) -> None:
    """A right triangle of a slope below the fine end of a line."""
    left, right = sizes[0], sizes[0] * (sizes[-1] / sizes[0]) ** 0.3
    rise = (right / left) ** order
    # below the line at both ends
    at_right = float(np.exp(np.interp(np.log(right), np.log(sizes), np.log(line))))
    low = 0.6 * min(line[0], at_right / rise)
    ax.plot([left, right, right, left], [low, low, low * rise, low], color="0.4", lw=1.0)
    place = (right, low * math.sqrt(rise))
    ax.annotate(str(order), place, (4, 0), textcoords="offset points", va="center", color="0.4")
