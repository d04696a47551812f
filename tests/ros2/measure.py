"""Measures what test_clouds.py can only bound on a machine that others use too, and prints a table.

    target/ros2/jazzy/bin/python tests/ros2/measure.py [clouds] [limits]
"""

import itertools
import os
import sys
import time

from clouds import HZ, receive, share, steps
from conftest import DOMAINS

STEP = 1.0 / HZ
SLOW = 1e-3  # real-time factor that leaves the solver one substep a step


def show(what, got, step, messages=1, asked=HZ):
    print(f"| {what} | {got['count']} | {100 * share(got):.2f} % | {got['count'] / got['wall'] / messages:.1f} of {asked} Hz "
          f"| {got['median']:.2f} / {got['p99']:.2f} / {got['max']:.1f} |", flush=True)


def header():
    print("| what | messages | share that came | clouds a second | latency median / p99 / max [ms] |\n|---|---|---|---|---|")


def bar(points, mode, reliability, hz=HZ, seconds=8, buffer=False):
    parameters = {"step": SLOW / hz, "real_time_factor": SLOW, "particles.mode": mode, "particles.fields": "[id]"}
    args = ["--set", f"grid.cell={5.0 / points}", "--threads", "1"]
    tiles = -(-points // 5000) if mode == "tiles" else 1
    got, _ = receive(next(DOMAINS), "bar.toml", parameters, reliability, seconds, args, depth=5 * tiles, buffer=buffer)
    note = ", receive buffer 4 MiB" if buffer else ""
    show(f"{points:,} points {mode}, {reliability}{note}", got, SLOW / hz, tiles, hz)


def clouds():
    header()
    for reliability in ("reliable", "best_effort"):
        got, _ = receive(next(DOMAINS), "particles_5000.toml", {"step": STEP}, reliability, 10)
        show(f"5,000 points, {reliability}", got, STEP)
    bar(100_000, "tiles", "best_effort")
    bar(100_000, "tiles", "best_effort", buffer=True)
    for reliability in ("best_effort", "reliable"):
        bar(100_000, "whole", reliability, buffer=True)


def limits():
    header()
    for points, hz in ((10_000, 60), (100_000, 60)):
        for reliability in ("best_effort", "reliable"):
            bar(points, "whole", reliability, hz)
    for points, hz in ((10_000, 60), (200_000, 30), (500_000, 10), (1_000_000, 5), (1_000_000, 2)):
        try:
            bar(points, "whole", "best_effort", hz, buffer=True)
        except Exception:
            print(f"| {points:,} points whole, best_effort, receive buffer 4 MiB | 0 | 0 % | 0 of {hz} Hz | - |", flush=True)
    for points, hz in ((200_000, 30), (1_000_000, 5)):
        bar(points, "tiles", "best_effort", hz)


if __name__ == "__main__":
    print(time.strftime("%Y-%m-%d"), os.cpu_count(), "processors, load", os.getloadavg()[0])
    for what in sys.argv[1:] or ["clouds"]:
        {"clouds": clouds, "limits": limits}[what]()
