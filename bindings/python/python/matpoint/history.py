"""Variables over time, kept in memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ._matpoint import Simulation

ENERGIES = ("energy/kinetic", "energy/strain", "energy/external", "energy/total")


class History:
    """Keeps variables whenever it is called with a simulation: by your loop, or as `callback` of `Simulation.run`.

    >>> history = History("probe/tip/displacement", "energy/total")
    >>> history(sim)                    # the start
    >>> sim.run(callback=history)
    >>> history.time, history["probe/tip/displacement"]
    """

    def __init__(self, *names: str) -> None:
        self.names = names or ENERGIES
        """The variables that are kept; the energies if none are named."""
        self._times: list[float] = []
        self._values: dict[str, list[NDArray[np.float64]]] = {name: [] for name in self.names}

    def __call__(self, simulation: Simulation) -> None:
        values = {name: simulation[name] for name in self.names}
        self._times.append(simulation.time)
        for name, value in values.items():
            self._values[name].append(value)

    def __len__(self) -> int:
        return len(self._times)

    @property
    def time(self) -> NDArray[np.float64]:
        """Times [s], shape (m,)."""
        return np.array(self._times)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Values of a variable, shape (m, ...)."""
        return np.array(self._values[name])
