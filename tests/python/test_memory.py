"""Memory stays flat."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable

import numpy as np
from conftest import beam

from matpoint import Scene


def resident() -> int:
    """Resident memory of this process [bytes]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def growth(work: Callable[[], object], rounds: int) -> int:
    """Growth of the resident memory over `rounds` calls, after a tenth as many to warm up [bytes]."""
    for _ in range(rounds // 10):
        work()
    gc.collect()
    before = resident()
    for _ in range(rounds):
        work()
    gc.collect()
    return resident() - before


# pages that the allocator keeps differ by some hundred kB from run to run; a leak of 64 bytes a call would be 6.4 MB
FLAT = 2_000_000


def test_create_step_destroy() -> None:
    scene = Scene.from_toml(
        """
        title = "one particle"
        dimension = 1
        grid = { origin = [0], size = [1], cell = 1 }
        material.m = { law = "neo_hookean", young = 1.0, density = 1.0 }
        body.b = { material = "m", shape = { box = { min = [0], max = [1] } }, particles_per_cell = 1 }
        time = { end = 1 }
        """
    )

    def cycle() -> None:
        sim = scene.build()
        sim.step(0.1)
        sim["particle/position"]
        sim.state().energy.total

    assert growth(cycle, 100_000) < FLAT


def test_save_restore_views_and_errors() -> None:
    sim = beam().build()
    out = np.empty((64, 2))

    def cycle() -> None:
        saved = sim.save()
        sim.step(1e-3)
        sim.get("particle/position", view=True)
        sim.get("particle/position", out)
        sim.restore(saved)
        try:
            sim.step(-1.0)
        except Exception:
            pass
        try:
            sim.set("load/tip/traction", [np.nan, 0.0])
        except Exception:
            pass

    assert growth(cycle, 10_000) < FLAT
