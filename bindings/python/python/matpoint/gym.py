"""An environment for Gymnasium over any scene.

Needs gymnasium: `pip install matpoint[gym]`. Importing this module registers `matpoint/Scene-v0`.

>>> env = SceneEnv(
...     "beam.toml",
...     actions={"load/tip/traction": ([0.0, -500.0], [0.0, 500.0])},
...     observations=["probe/tip/displacement", "probe/tip/velocity"],
...     reward=lambda sim: -abs(float(sim["probe/tip/displacement"][1])),
...     step=0.02,
... )

One environment for each process is fastest with `RAYON_NUM_THREADS=1`: the processes then do not fight for the cores.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._matpoint import Scene, Simulation
from .errors import StepError

try:
    import gymnasium
except ImportError as error:
    raise ImportError("matpoint.gym needs Gymnasium: pip install matpoint[gym]") from error

__all__ = ["SceneEnv"]


class SceneEnv(gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]):
    """Episodes of a scene: loads are the action, variables the observation.

    The action is one flat vector in [-1, 1], float32, as learning libraries want it: -1 stands for the lower bound, 1
    for the upper, what is beyond is cut off. The observation is one flat vector, float64, in SI units and without
    bounds. Both follow the order in which the variables are given, arrays in C order; `action_names` and
    `observation_names` name each entry.

    A step that cannot be done (StepError) ends the episode: `terminated` is then True and `info["error"]` says why;
    observation and reward are those of the state before it. `info["time"]` is the simulated time [s]; the info of
    `reset` also has both `..._names`.

    The same seed and actions give the same episode, bit for bit.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}

    def __init__(
        self,
        scene: Scene | str | PathLike[str],
        actions: Mapping[str, tuple[ArrayLike, ArrayLike]],
        observations: Sequence[str],
        reward: Callable[[Simulation], float],
        *,
        step: float,
        terminated: Callable[[Simulation], bool] | None = None,
        duration: float | None = None,
        prepare: Callable[[Simulation, np.random.Generator], None] | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Builds the scene.

        scene: a scene, or the path of its file.
        actions: inputs with their lower and upper bounds, each a number or an array of the input's shape, in its unit.
        observations: variables.
        reward: called after each step. The inputs are variables too: `sim["load/tip/traction"]` is the action.
        step: simulated time of a step [s]; the action is held over it.
        terminated: called after each step; True ends the episode.
        duration: time after which an episode is truncated [s], from where `prepare` leaves off, rounded to whole steps;
            by default it lasts until the end of the scene.
        prepare: called at the end of each reset with the seeded generator, to start from somewhere else: sets loads and
            steps.
        render_mode: "rgb_array" for pictures by `render`, drawn by `matpoint.plot`.
        """
        if not step > 0.0:
            raise ValueError(f"step is {step} s; must be above 0")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode is {render_mode!r}; may be None or 'rgb_array'")
        self.sim = (scene if isinstance(scene, Scene) else Scene.load(scene)).build()
        """The simulation."""
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": max(1, round(1.0 / step))}
        self._step, self._duration = step, duration
        self._reward, self._terminated, self._prepare = reward, terminated, prepare
        self._end = math.inf

        self._actions = _Entries(self.sim, actions)
        self._observations = _Entries(self.sim, observations)
        self.action_names, self.observation_names = self._actions.names(), self._observations.names()
        self._low, self._high = np.empty((2, self._actions.size))
        for name, part, shape in self._actions.parts:
            for all_bounds, bound in zip((self._low, self._high), actions[name], strict=True):
                all_bounds[part].reshape(shape)[...] = bound
                # refuses outputs and what is not finite
                self.sim.set(name, all_bounds[part].reshape(shape))
            if np.any(self._low[part] > self._high[part]):
                raise ValueError(f"the lower bound of `{name}` is above the upper: {actions[name]}")
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self._actions.size,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (self._observations.size,), np.float64)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Starts an episode. Takes no options."""
        super().reset(seed=seed)
        self.sim.reset()
        if self._prepare is not None:
            self._prepare(self.sim, self.np_random)
        start = self.sim.time
        # half a step early, for times are sums that are rounded
        self._end = (self.sim.scene.end if self._duration is None else start + self._duration) - 0.5 * self._step
        names = {"action_names": self.action_names, "observation_names": self.observation_names}
        return self._observe(), {"time": start, **names}

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """Holds an action for a step: observation, reward, terminated, truncated, info."""
        sim = self.sim
        share = 0.5 + 0.5 * np.minimum(np.maximum(np.asarray(action, dtype=float).reshape(self._low.shape), -1.0), 1.0)
        values = (1.0 - share) * self._low + share * self._high
        for name, part, shape in self._actions.parts:
            sim.set(name, values[part].reshape(shape))
        info: dict[str, Any] = {}
        try:
            sim.step(self._step)
        except StepError as error:
            info["error"] = str(error)
        info["time"] = time = sim.time
        terminated = "error" in info or (self._terminated is not None and bool(self._terminated(sim)))
        return self._observe(), float(self._reward(sim)), terminated, time > self._end, info

    def render(self) -> NDArray[np.uint8] | None:
        """The particles coloured by von Mises stress, in a window as large as the grid, shape (height, width, 3)."""
        return None if self.render_mode is None else _picture(self.sim)

    def _observe(self) -> NDArray[np.float64]:
        # new each time, for the caller may keep it
        values = np.empty(self._observations.size)
        for name, part, shape in self._observations.parts:
            self.sim.get(name, out=values[part].reshape(shape))
        return values


class _Entries:
    """Where variables are in a flat vector."""

    def __init__(self, sim: Simulation, names: Mapping[str, Any] | Sequence[str]) -> None:
        self.parts: list[tuple[str, slice, tuple[int, ...]]] = []
        """Name, place and shape of each variable."""
        self.size = 0
        for name in names:
            shape = tuple(sim.variable(name).shape)
            end = self.size + math.prod(shape)
            self.parts.append((name, slice(self.size, end), shape))
            self.size = end
        if self.size == 0:
            raise ValueError("an environment needs an action and an observation")

    def names(self) -> tuple[str, ...]:
        """A name for each entry: `energy/total`, `probe/tip/stress[0, 1]`."""
        return tuple(f"{name}{list(index) or ''}" for name, _, shape in self.parts for index in np.ndindex(shape))


def _picture(sim: Simulation) -> NDArray[np.uint8]:
    # without pyplot, which keeps figures and may want a screen
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from . import plot

    figure = Figure()
    # fixed, that the frame may stand still, with room for the colours
    figure.subplots_adjust(left=0.1, right=0.82)
    canvas: Any = FigureCanvasAgg(figure)
    dimension = sim.scene.dimension
    ax: Any = figure.add_subplot(projection="3d" if dimension == 3 else None)
    grid = sim.scene.to_dict()["grid"]
    for axis, low, size in zip("xyz", grid["origin"], grid["size"], strict=False):
        # all pictures of an episode show the same part of space
        ax.set(**{f"{axis}lim": (low, low + size)})
    plot.particles(sim, ax=ax)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


gymnasium.register(id="matpoint/Scene-v0", entry_point="matpoint.gym:SceneEnv")
