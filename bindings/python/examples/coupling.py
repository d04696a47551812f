"""Implicit coupling: a beam whose tip carries a mass on a stiff spring, the mass integrated here in Python.

In each communication step beam and mass move by the same time with a constant force between them. Staggering takes the
force of the start of the step: cheap, but the force comes late and feeds energy in. Iterating goes back with `restore`
and tries again until the force is that of the mean stretch of the spring over the step, so that what one side gains the
other side loses. All forces are per metre of thickness, as is everything in plane strain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from matpoint import Scene, Simulation
from matpoint.scene import Body, Boundary, Grid, Material, Probe, Time

LENGTH, HEIGHT = 8.0, 1.0  # [m]
MASS, STIFFNESS = 400.0, 2e4  # [kg], [N/m]
STEP, END = 0.05, 4.0  # communication step, and one period [s]
TOLERANCE = 1e-6  # [N]
MOST_TRIES = 20


def scene() -> Scene:
    return Scene(
        title="a beam that carries a mass on a spring",
        dimension=2,
        grid=Grid(origin=[0.0, -3.0], size=[9.0, 7.0], cell=0.5),
        material={"rubber": Material(law="neo_hookean", young=1e7, poisson=0.3, density=1000.0)},
        body={
            "beam": Body(
                material="rubber",
                shape={"box": {"min": [0.0, 0.0], "max": [LENGTH, HEIGHT]}},
                particles_per_cell=3,
                velocity=[0.0, f"0.5*(x/{LENGTH})^2"],
            )
        },
        boundary={"root": Boundary(face="x-", fixed=["x", "y"])},
        load={"tip": {"traction": {"body": "beam", "face": "x+", "value": "external"}}},
        probe={"tip": Probe(at=[LENGTH, 0.5 * HEIGHT])},
        time=Time(end=END),
    )


@dataclass(frozen=True)
class Mass:
    """The mass at the other end of the spring, across the beam."""

    place: float = 0.0  # from where the spring is at rest [m]
    velocity: float = 0.0  # [m/s]

    def step(self, force: float, dt: float) -> Mass:
        """After a step under a constant force [N]."""
        velocity = self.velocity + dt * force / MASS
        return Mass(self.place + dt * 0.5 * (self.velocity + velocity), velocity)

    def energy(self, tip: float) -> float:
        """Of mass and spring [J]."""
        return 0.5 * MASS * self.velocity**2 + 0.5 * STIFFNESS * (self.place - tip) ** 2


def tip(sim: Simulation) -> float:
    return float(sim["probe/tip/displacement"][1])


def push(sim: Simulation, force: float, dt: float) -> float:
    """Moves the beam by a step under a force at its tip [N]; where the tip then is [m]."""
    sim["load/tip/traction"] = [0.0, force / HEIGHT]
    sim.step(dt)
    return tip(sim)


def staggered(sim: Simulation, mass: Mass, dt: float) -> tuple[Mass, int]:
    """The mass after a step, and how often the beam was stepped."""
    force = STIFFNESS * (mass.place - tip(sim))
    push(sim, force, dt)
    return mass.step(-force, dt), 1


def iterated(sim: Simulation, mass: Mass, dt: float) -> tuple[Mass, int]:
    """The mass after a step, and how often the beam was stepped."""
    start, before = sim.save(), tip(sim)

    def missing(force: float) -> float:
        """The force of the mean stretch over the step, less the force that acted [N]."""
        sim.restore(start)
        now, after = mass.step(-force, dt), push(sim, force, dt)
        return STIFFNESS * 0.5 * (mass.place - before + now.place - after) - force

    # one fixed-point iteration, then the secant method, for the beam answers nearly linearly
    force = STIFFNESS * (mass.place - before)
    wrong = change = missing(force)
    for tries in range(1, MOST_TRIES):
        if abs(wrong) < TOLERANCE:
            return mass.step(-force, dt), tries
        force += change
        last, wrong = wrong, missing(force)
        change *= wrong / (last - wrong)
    raise RuntimeError(f"at t = {sim.time} s beam and mass do not agree on a force: {wrong} N are missing")


Coupling = Callable[[Simulation, Mass, float], tuple[Mass, int]]


def run(coupling: Coupling, dt: float) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Displacement of the tip [m] and energy of all [J] every STEP, and how often the beam was stepped."""
    sim, mass, tries = scene().build(), Mass(), 0
    tips, energies = [], []
    for step in range(round(END / dt) + 1):
        if step > 0:
            mass, more = coupling(sim, mass, dt)
            tries += more
        if step % round(STEP / dt) == 0:
            tips.append(tip(sim))
            energies.append(float(sim["energy/kinetic"] + sim["energy/strain"]) + mass.energy(tips[-1]))
    return np.array(tips), np.array(energies), tries


def main() -> None:
    reference, _, _ = run(iterated, STEP / 10.0)

    def judge(coupling: Coupling, dt: float) -> tuple[float, float]:
        """How far energy and tip are off: over the energy at the start, over the reference's largest way [-]."""
        tips, energies, tries = run(coupling, dt)
        drift = float(np.abs(energies - energies[0]).max() / energies[0])
        error = float(np.sqrt(np.mean((tips - reference) ** 2)) / np.abs(reference).max())
        name = f"{coupling.__name__}, {dt:.4f} s"
        print(f"{name}: {tries} steps of the beam, energy off by {drift:.2%}, tip by {error:.2%}")
        return drift, error

    late, _ = judge(staggered, STEP)
    # three tries a step are what iterating costs
    drift_same_cost, error_same_cost = judge(staggered, STEP / 3.0)
    drift, error = judge(iterated, STEP)
    assert late > 1.0, "at this step staggering must feed energy in, or there is no need to iterate"
    assert drift < 0.005, "with the same mean force on both sides, what one gains the other loses"
    assert drift < drift_same_cost / 10.0 and error < error_same_cost / 2.0, "iterating must pay for itself"


if __name__ == "__main__":
    main()
