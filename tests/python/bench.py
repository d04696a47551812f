"""What Python costs: calls, copies, views; beside what the same costs in Rust and numpy.

    python tests/python/bench.py [FACTOR]

FACTOR (1 by default) multiplies the number of repeats. Times are medians; a noisy machine needs a second look. The Rust call comes from
`cargo bench --bench step -- "one particle"`, which is run first.
"""

from __future__ import annotations

import re
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from conftest import ROOT, block

from matpoint import Scene

FACTOR = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0


def median(work: Callable[[], object], repeats: int, inner: int = 1) -> float:
    """Median time of one call [s]."""
    times = []
    for _ in range(max(3, int(repeats * FACTOR))):
        start = time.perf_counter()
        for _ in range(inner):
            work()
        times.append((time.perf_counter() - start) / inner)
    return statistics.median(times)


def rust_call() -> float:
    """Time of `step` with one particle and one substep, called from Rust [s]."""
    command = ["cargo", "bench", "--bench", "step", "--", "one particle"]
    text = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    found = re.search(r"time:\s+\[\S+ \S+ ([0-9.]+) (ns|µs)", text)
    if found is None:
        raise RuntimeError(f"cargo bench says no time:\n{text}")
    return float(found[1]) * {"ns": 1e-9, "µs": 1e-6}[found[2]]


def line(what: str, seconds: float, note: str = "") -> None:
    print(f"  {what:58} {1e6 * seconds:12.3f} µs  {note}")


def calls() -> None:
    rust = rust_call()
    sim = Scene.load(ROOT / "benches" / "scenes" / "one_particle.toml").build()
    dt = 0.1 * sim.max_step
    python = median(lambda: sim.step(dt), 21, 10_000)
    loop = median(lambda: None, 21, 10_000)
    print("calls, one particle")
    line("step, from Rust", rust)
    line("step, from Python", python, f"{1e6 * (python - rust):.3f} µs more, of which {1e6 * loop:.3f} are the timing loop")
    line("time", median(lambda: sim.time, 21, 10_000))
    line('get("energy/total")', median(lambda: sim.get("energy/total"), 21, 10_000))


def arrays() -> None:
    sim = block(50).build()
    n = sim.describe().particles
    print(f"arrays, {n:,} particles, (n, 3) float64: {24e-6 * n:.1f} MB")
    source, out = np.random.default_rng(0).random((n, 3)), np.zeros((n, 3))
    copy = median(lambda: np.copyto(out, source), 41)
    sim.get("particle/position", out)
    line("numpy.copyto", copy, f"{24e-9 * n / copy:.1f} GB/s")
    got = median(lambda: sim.get("particle/position", out), 41)
    line("get(out=)", got, f"{24e-9 * n / got:.1f} GB/s, {got / copy:.2f} of a copy")
    line("get()", median(lambda: sim.get("particle/position"), 41), "a new array: the system clears its pages first")
    line("numpy copy()", median(lambda: source.copy(), 41), "the same in numpy")
    view = median(lambda: sim.get("particle/position", view=True), 21, 1000)
    few = block(2).build()
    line("get(view=True)", view, f"with {few.describe().particles} particles: "
         f"{1e6 * median(lambda: few.get('particle/position', view=True), 21, 1000):.3f} µs")

    first = []
    for _ in range(7):
        sim.step(0.4 * sim.max_step)
        start = time.perf_counter()
        sim.get("particle/position", view=True)
        first.append(time.perf_counter() - start)
    line("get(view=True), the first after a step", statistics.median(first), "collects the values in the order of the particles")


if __name__ == "__main__":
    calls()
    arrays()
