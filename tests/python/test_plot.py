"""Pictures: what is drawn is the data, with names and units."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from typing import Any

import matplotlib
import numpy as np
import pytest
from conftest import SCENES, beam, block
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from matpoint import History, Scene, Simulation
from matpoint.scene import Body, Shape
from matpoint.state import von_mises

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

from matpoint import plot  # noqa: E402


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    plt.close("all")


def pieces(ax: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of the quadrilaterals, shape (n, 4, 2), and the values that colour them."""
    (collection,) = ax.collections
    assert isinstance(collection, PolyCollection)
    corners = np.array([np.asarray(path.vertices)[:4] for path in collection.get_paths()])
    return corners, np.asarray(collection.get_array())


def colour_label(ax: Any) -> str:
    """What the colour bar says."""
    bar = ax.collections[0].colorbar
    return str(bar.ax.get_ylabel() or bar.ax.get_xlabel())


def areas(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y = corners[..., 0], corners[..., 1]
    twice: NDArray[np.float64] = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    return twice / 2.0


def test_particles_in_2d_are_pieces_of_the_body(sim: Simulation) -> None:
    sim.run(until=0.5, progress=False)
    ax = plot.particles(sim)
    corners, values = pieces(ax)
    assert np.array_equal(values, von_mises(sim["particle/stress"]))
    assert np.allclose(corners.mean(axis=1), sim["particle/position"], atol=1e-14)
    assert np.allclose(areas(corners), sim["particle/volume"], rtol=1e-12), "plane strain: the area is the volume"
    assert (ax.get_xlabel(), ax.get_ylabel(), colour_label(ax)) == ("x [m]", "y [m]", "von Mises stress [Pa]")
    assert ax.get_aspect() == 1.0 and ax.get_title() == "t = 0.5 s"
    assert ax.collections[0].get_cmap().name == "viridis"
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    assert left <= corners[..., 0].min() and corners[..., 0].max() <= right
    assert low <= corners[..., 1].min() and corners[..., 1].max() <= high


def test_pieces_of_several_bodies_fill_them() -> None:
    long: Shape = {"box": {"min": [0.0, 0.0], "max": [2.0, 1.0]}}
    high: Shape = {"box": {"min": [2.0, 0.0], "max": [3.0, 1.5]}}
    bodies = {
        "z": Body(material="rubber", shape=long, particles_per_cell=[2, 3]),
        "a": Body(material="rubber", shape=high, particles_per_cell=[3, 2], positions="gauss"),
    }
    sim = beam(body=bodies, load={}, probe={}).build()
    corners, values = pieces(plot.particles(sim, "particle/body"))
    assert np.allclose(areas(corners), sim["particle/volume"], rtol=1e-12)
    corners = corners[values == list(sim.describe().bodies).index("z")]
    assert np.allclose(np.ptp(corners, axis=1), [0.5 / 2, 0.5 / 3])
    assert np.allclose(corners.min(axis=(0, 1)), 0.0) and np.allclose(corners.max(axis=(0, 1)), [2.0, 1.0])


def test_particles_in_1d_are_values_over_x() -> None:
    sim = Scene.load(SCENES / "bar_1d_vibration.toml").build()
    sim.run(until=1.0, progress=False)
    ax = plot.particles(sim, "particle/stress", "xx")
    (line,) = ax.lines
    assert np.array_equal(line.get_xdata(), sim["particle/position"][:, 0])
    assert np.array_equal(line.get_ydata(), sim["particle/stress"][:, 0, 0])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x [m]", "stress xx [Pa]")
    ax = plot.particles(sim, "particle/velocity")
    assert np.array_equal(ax.lines[0].get_ydata(), sim["particle/velocity"][:, 0]), "in 1D a vector keeps its sign"
    assert ax.get_ylabel() == "velocity [m/s]"


def test_particles_in_3d_touch_their_neighbours() -> None:
    sim = block(cells=3).build()
    ax: Any = plot.particles(sim, "particle/velocity", "x")
    (balls,) = ax.collections
    position = sim["particle/position"]
    assert np.array_equal(np.column_stack(balls._offsets3d), position)
    assert np.array_equal(balls.get_array(), sim["particle/velocity"][:, 0])
    assert [ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()] == ["x [m]", "y [m]", "z [m]"]
    assert colour_label(ax) == "velocity x [m/s]"
    # seen along z, a particle is as wide as it is far from the next one along x
    (width,) = np.unique(np.sqrt(balls.get_sizes()))
    ax.figure.set_layout_engine("none")
    ax.view_init(elev=90.0, azim=-90.0)
    ends = np.array([[*position[0], 1.0], [*(position[0] + [0.5, 0.0, 0.0]), 1.0]]) @ ax.get_proj().T
    distance = np.ptp(ax.transData.transform(ends[:, :2] / ends[:, 3:])[:, 0]) * 72.0 / ax.figure.dpi
    assert width == pytest.approx(distance, rel=1e-6)
    ax.figure.draw_without_rendering()
    with pytest.raises(ValueError, match="needs a 3D axes"):
        plot.particles(sim, ax=plt.subplots()[1])


@pytest.mark.parametrize(
    ("color", "component", "label"),
    [
        ("particle/velocity", "y", "velocity y [m/s]"),
        ("particle/velocity", "", "velocity, magnitude [m/s]"),
        ("particle/deformation_gradient", "yx", "deformation gradient yx [-]"),
        ("particle/density", "", "density [kg/m3]"),
    ],
)
def test_any_variable_may_colour(sim: Simulation, color: str, component: str, label: str) -> None:
    sim.step(0.1)
    values = sim[color]
    expected = {
        "velocity y [m/s]": values[:, -1] if values.ndim == 2 else None,
        "velocity, magnitude [m/s]": np.linalg.norm(values, axis=-1),
        "deformation gradient yx [-]": values[:, 1, 0] if values.ndim == 3 else None,
        "density [kg/m3]": values,
    }[label]
    assert expected is not None
    ax = plot.particles(sim, color, component)
    assert np.allclose(pieces(ax)[1], expected, rtol=1e-15) and colour_label(ax) == label


@pytest.mark.parametrize(
    ("color", "component", "message"),
    [
        ("energy/total", "", "has no value for each particle"),
        ("particle/stress", "", "component must be like 'xx', not ''"),
        ("particle/stress", "x", "component must be like 'xx'"),
        ("particle/velocity", "z", "component must be like 'x', not 'z'"),
        ("particle/velocity", "q", "component must be like 'x'"),
        ("particle/density", "x", "component must be like ''"),
    ],
)
def test_what_cannot_colour_is_refused(sim: Simulation, color: str, component: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        plot.particles(sim, color, component)


def test_energies_over_time(sim: Simulation) -> None:
    history = History("energy/kinetic", "probe/tip/displacement", "energy/total")
    sim.run(callback=history, progress=False)
    ax = plot.energy(history)
    assert [line.get_label() for line in ax.lines] == ["kinetic", "total"]
    for line, name in zip(ax.lines, ("energy/kinetic", "energy/total"), strict=True):
        assert np.array_equal(line.get_xdata(), history.time) and np.array_equal(line.get_ydata(), history[name])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "energy [J]")
    units = {sim.variable(name).unit for name in sim.names() if name.startswith("energy/")}
    assert units == {"J"}, "the label says J"
    with pytest.raises(ValueError, match="has no energy, only probe/tip/displacement"):
        plot.energy(History("probe/tip/displacement"))


def test_orders_of_convergence() -> None:
    h = [0.1, 0.4, 0.2]
    ax = plot.convergence(h, {"u [m]": [0.02 * size**2 for size in h], "stress [Pa]": [3.0 * size for size in h]})
    legend = ax.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["u [m], order 2.00", "stress [Pa], order 1.00"]
    displacement, stress, triangle = ax.lines
    assert np.array_equal(displacement.get_xdata(), [0.1, 0.2, 0.4]), "from fine to coarse"
    assert np.allclose(stress.get_ydata(), [0.3, 0.6, 1.2])
    (x0, x1, *_), (_, low, high, _) = np.asarray(triangle.get_data())
    assert np.isclose(np.log(high / low) / np.log(x1 / x0), 2.0), "the triangle has the order of the lowest line"
    assert high < 0.02 * x1**2 and [text.get_text() for text in ax.texts] == ["2"]
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("cell size [m]", "error")


@pytest.mark.parametrize(
    ("h", "errors"), [([0.1], {"u": [1.0]}), ([0.1, 0.2], {"u": [1.0]}), ([0.1, 0.2], {}), (0.1, {"u": [1.0]})]
)
def test_too_little_for_an_order_is_refused(h: Any, errors: dict[str, list[float]]) -> None:
    with pytest.raises(ValueError, match="two or more cell sizes"):
        plot.convergence(h, errors)


def test_axes_that_are_given_are_used(sim: Simulation) -> None:
    figure, (first, second, third) = plt.subplots(3)
    history = History()
    sim.run(until=0.1, callback=history, progress=False)
    assert plot.particles(sim, ax=first) is first
    assert plot.energy(history, ax=second) is second
    assert plot.convergence([0.1, 0.2], {"u": [1.0, 2.0]}, ax=third) is third
    assert plt.get_fignums() == [figure.number]


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "matpoint.plot")
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match=r"pip install matpoint\[plot\]"):
        importlib.import_module("matpoint.plot")
