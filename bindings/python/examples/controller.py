"""A PD controller damps the swing of a cantilever with a traction on its tip.

The beam starts with a velocity close to that of its first mode and swings for five periods, once alone and once under
control. The controller sees the tip 50 times in a period and cannot push harder than a bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from matpoint import History, Scene
from matpoint.scene import Body, Boundary, Grid, Material, Method, Probe, Time

LENGTH, HEIGHT = 8.0, 1.0  # [m]
YOUNG, POISSON, DENSITY = 1e7, 0.3, 1000.0  # [Pa], [-], [kg/m3]
# Euler and Bernoulli's first frequency of a cantilever in plane strain [rad/s], 1.875^2 sqrt(E' I / (rho A L^4))
FREQUENCY = 1.8751**2 * math.sqrt(YOUNG / (1.0 - POISSON**2) * HEIGHT**2 / 12.0 / DENSITY) / LENGTH**2
PERIOD = 2.0 * math.pi / FREQUENCY
PERIODS, SAMPLES = 5, 50  # samples a period
# What swings at the tip is about a quarter of the mass [kg/m]. The damper is 40 % of the critical one, the spring soft.
SWINGING = 0.25 * DENSITY * LENGTH * HEIGHT
DAMPING = 0.4 * 2.0 * SWINGING * FREQUENCY  # [Pa s/m]
STIFFNESS = 0.1 * SWINGING * FREQUENCY**2  # [Pa/m]
BOUND = 1000.0  # [Pa]


def scene() -> Scene:
    return Scene(
        title="a beam with a controller at its tip",
        dimension=2,
        grid=Grid(origin=[0.0, -2.0], size=[9.0, 5.0], cell=0.5),
        material={"rubber": Material(law="neo_hookean", young=YOUNG, poisson=POISSON, density=DENSITY)},
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
        method=Method(transfer="flip"),
        time=Time(end=PERIODS * PERIOD),
    )


def pd(displacement: float, velocity: float) -> float:
    """The traction across the beam [Pa] for the displacement [m] and velocity [m/s] of the tip."""
    return float(np.clip(-STIFFNESS * displacement - DAMPING * velocity, -BOUND, BOUND))


def swing(control: Callable[[float, float], float]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times [s] and displacements of the tip across the beam [m]."""
    sim = scene().build()
    history = History("probe/tip/displacement")
    history(sim)
    for _ in range(PERIODS * SAMPLES):
        displacement, velocity = sim["probe/tip/displacement"], sim["probe/tip/velocity"]
        sim["load/tip/traction"] = [0.0, control(float(displacement[1]), float(velocity[1]))]
        sim.step(PERIOD / SAMPLES)
        history(sim)
    return history.time, history["probe/tip/displacement"][:, 1]


def amplitude(time: NDArray[np.float64], displacement: NDArray[np.float64]) -> float:
    """Half of the way from lowest to highest in the fifth period [m]."""
    return float(np.ptp(displacement[time >= (PERIODS - 1) * PERIOD])) / 2.0


def main() -> None:
    alone = amplitude(*swing(lambda displacement, velocity: 0.0))
    controlled = amplitude(*swing(pd))
    print(f"amplitude of the tip in the fifth period: {1e3 * alone:.1f} mm alone, {1e3 * controlled:.2f} mm controlled")
    print(f"reduced {alone / controlled:.0f} times")
    assert controlled < alone / 10.0, "within five periods the controller must take nine tenths of the swing"
    assert alone > 0.2, "the beam alone must still swing, or there was nothing to damp"


if __name__ == "__main__":
    main()
