"""The state of a simulation by attributes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import ComponentError

if TYPE_CHECKING:
    from ._matpoint import Simulation


class Group:
    """Variables whose names begin alike: `state.probe.tip.displacement` is `probe/tip/displacement`.

    Names that are no Python names are reached with brackets: `state.probe["left end"]`.
    """

    def __init__(self, state: State, prefix: str) -> None:
        self._state = state
        self._prefix = prefix

    def __getitem__(self, name: str) -> Any:
        return self._state._find(self._prefix + name)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self[name]

    def __dir__(self) -> list[str]:
        return list(self)

    def __iter__(self) -> Iterator[str]:
        start = len(self._prefix)
        return iter(dict.fromkeys(name[start:].split("/")[0] for name in self._state._names if name.startswith(self._prefix)))

    def __repr__(self) -> str:
        return f"<{self._prefix[:-1] or 'state'}: {', '.join(self)}>"


class State(Group):
    """The state of a simulation at one time, made by `Simulation.state()`.

    Attributes follow the names of the variables: `state.particle.position`, `state.energy.total`. Values are read-only numpy arrays, and
    floats where a variable is one number. Each is computed when it is first asked for; what was asked for stays when the simulation goes on,
    what was not is then gone, and asking for it raises ComponentError.
    """

    time: float
    """Time [s]."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(self, "")
        self._simulation = simulation
        self._names = simulation.names()
        self._values: dict[str, Any] = {}
        self._steps = simulation.steps
        self.time = simulation.time

    def _find(self, name: str) -> Any:
        if name in self._values:
            return self._values[name]
        if name not in self._names:
            if any(other.startswith(name + "/") for other in self._names):
                return Group(self, name + "/")
            # says what the nearest name is
            return self._simulation[name]
        if (self._simulation.time, self._simulation.steps) != (self.time, self._steps):
            raise ComponentError(
                f"`{name}`: the simulation has gone on from t = {self.time} s to t = {self._simulation.time} s; "
                "read what you need before the next step, or take the state again"
            )
        values = self._simulation.get(name, view=True)
        value = float(values) if values.ndim == 0 else values
        self._values[name] = value
        return value

    def __getitem__(self, name: str) -> Any:
        return self._find(name)


def von_mises(stress: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The von Mises stress [Pa] of stresses of shape (..., 3, 3)."""
    mean = np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3.0
    deviator = stress - mean * np.eye(3)
    result: np.ndarray[Any, np.dtype[np.float64]] = np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator))
    return result
