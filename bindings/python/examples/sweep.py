"""A parameter sweep over processes: the first period of cantilevers, slender to stout, beside Euler and Bernoulli's.

Each process runs whole simulations; each simulation gets one thread, for several simulations fill the cores better than
one that is shared out. The result does not depend on the number of processes, to the last bit.
"""

from __future__ import annotations

import math
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from matpoint import History, Scene
from matpoint.scene import Body, Boundary, Grid, Material, Probe, Time

LENGTH = 8.0  # [m]
HEIGHTS = [0.8, 1.0, 1.6, 2.0]  # [m]
YOUNG, POISSON, DENSITY = 1e7, 0.3, 1000.0  # [Pa], [-], [kg/m3]


def theory(height: float) -> float:
    """Period of a slender cantilever in plane strain [s]: without shear and rotary inertia."""
    return 2.0 * math.pi * LENGTH**2 / 1.8751**2 * math.sqrt(12.0 * DENSITY * (1.0 - POISSON**2) / YOUNG) / height


def period(height: float) -> float:
    """Period of a cantilever [s]: twice the time between the first two passages of the tip through rest."""
    sim = Scene(
        title=f"a cantilever, {height} m high",
        dimension=2,
        # four cells over each height, so that none is resolved better than the others
        grid=Grid(origin=[0.0, -2.0], size=[10.0, 6.0], cell=height / 4.0),
        material={"rubber": Material(law="linear_elastic", young=YOUNG, poisson=POISSON, density=DENSITY)},
        body={
            "beam": Body(
                material="rubber",
                shape={"box": {"min": [0.0, 0.0], "max": [LENGTH, height]}},
                particles_per_cell=2,
                velocity=[0.0, f"0.01*(x/{LENGTH})^2"],
            )
        },
        boundary={"root": Boundary(face="x-", fixed=["x", "y"])},
        probe={"tip": Probe(at=[LENGTH, 0.5 * height])},
        time=Time(end=1.4 * theory(height)),
        record={"every": 0.005 * theory(height)},
    ).build()
    history = History("probe/tip/displacement")
    sim.run(callback=history, progress=False)
    time, tip = history.time, history["probe/tip/displacement"][:, 1]
    before = np.flatnonzero(tip[1:] * tip[:-1] <= 0.0)[:2]
    passages = time[before] + (time[before + 1] - time[before]) * tip[before] / (tip[before] - tip[before + 1])
    return float(2.0 * (passages[1] - passages[0]))


def sweep(processes: int) -> list[float]:
    # spawned, so that the processes start with nothing of this one, as they do on every system
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        return list(pool.map(period, HEIGHTS))


def main() -> None:
    os.environ["RAYON_NUM_THREADS"] = "1"
    periods = sweep(processes=2)
    ratios = [period / theory(height) for height, period in zip(HEIGHTS, periods, strict=True)]
    for height, measured, ratio in zip(HEIGHTS, periods, ratios, strict=True):
        print(f"height {height} m: period {measured:.4f} s, {ratio:.4f} of a slender beam's")
    assert periods == sweep(processes=1), "the number of processes must not change a bit of the result"
    assert abs(ratios[0] - 1.0) < 0.03, "a slender beam must swing as Euler and Bernoulli say"
    assert ratios == sorted(ratios), "the stouter a beam, the more shear and rotary inertia slow it down"


if __name__ == "__main__":
    main()
