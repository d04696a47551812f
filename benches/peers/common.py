"""What all programs are given, and how they are asked: the protocol of `matpoint study stopwatch`, a line of JSON for each order and answer."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

DENSITY, YOUNG, POISSON, GRAVITY = 1000.0, 1e6, 0.3, 9.8
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = YOUNG / (2 * (1 + POISSON))
WAVE = ((LAMBDA + 2 * MU) / DENSITY) ** 0.5

# particles: cells along an edge of the block, of the cube of 1 m, below and beside the block
SIZES = {97336: (23, 32, 4), 1000000: (50, 64, 7)}


@dataclass
class Work:
    """A block of 8 particles a cell that turns and shears while it falls in a cube."""

    x: np.ndarray  # position [m], (n, 3)
    v: np.ndarray  # velocity [m/s], (n, 3)
    cells: int  # along an edge of the cube
    dx: float  # cell size [m]
    dt: float  # step [s]: a fifth of the time that a wave takes through a cell
    volume: float  # of a particle [m3]
    threads: int
    double: bool

    @property
    def mass(self) -> float:
        """Of a particle [kg]."""
        return DENSITY * self.volume

    @property
    def number(self) -> type:
        return np.float64 if self.double else np.float32


def work(task: dict) -> Work:
    block, cube, below = SIZES[task["particles"]]
    dx = 1.0 / cube
    axis = (below + (np.arange(2 * block) + 0.5) * 0.5) * dx
    x = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    random = np.random.default_rng(1)
    x += random.uniform(-0.4, 0.4, x.shape) * 0.5 * dx
    if task["order"] == "shuffled":
        x = x[random.permutation(len(x))]
    v = 0.5 * np.sin(2 * np.pi * x[:, [1, 2, 0]])
    return Work(x, v, cube, dx, 0.2 * dx / WAVE, (dx / 2) ** 3, task["threads"], task["precision"] == "double")


def serve(make: Callable[[Work], tuple[Callable[[int], None], Callable[[], np.ndarray]]]) -> None:
    """Answers orders from standard input. `make` gives a function that takes so many steps and returns when they are done, and one that gives the
    velocities of now."""
    # what libraries print is no answer
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def answer(value: dict) -> None:
        out.write(json.dumps(value) + "\n")
        out.flush()

    given = work(json.loads(sys.stdin.readline()))
    step, velocity = make(given)
    answer({"Ready": {"particles": len(given.x), "memory": 0}})
    for line in sys.stdin:
        order = json.loads(line)
        if order == "Energy":
            answer({"Energy": float(0.5 * given.mass * (velocity().astype(float) ** 2).sum())})
            continue
        order = order["Step"]
        start = time.perf_counter()
        for _ in range(order["calls"]):
            step(order["substeps"])
        answer({"Took": time.perf_counter() - start})
