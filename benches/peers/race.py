"""Steps all codes in turn, round after round, and writes medians: python race.py MATPOINT ROUNDS PARTICLES,... (see `run`)."""

from __future__ import annotations

import csv
import importlib.util
import itertools
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

from common import SIZES, WAVE

HERE = Path(__file__).parent
OUT = Path("target/peers/peers.csv")
# steps of a timing, by particles
STEPS = {97336: 20, 1000000: 10}


def scene(task: dict) -> str:
    """The common work for matpoint, which makes the particles itself: the same block, jittered by the same share of their distance."""
    block, cube, below = SIZES[task["particles"]]
    dx = 1.0 / cube
    low, high = [below * dx] * 3, [(below + block) * dx] * 3
    precision = ', precision = "single"' if task["precision"] == "single" else ""
    return f"""
title = "elastic block"
dimension = 3
grid = {{ origin = [0, 0, 0], size = [1, 1, 1], cell = {dx} }}
material.rubber = {{ law = "neo_hookean", young = 1e6, poisson = 0.3, density = 1e3 }}
boundary.floor = {{ face = "y-", fixed = ["y"] }}
load.weight.gravity = [0, -9.8, 0]
method = {{ transfer = "apic", integrator = "usl"{precision} }}
time = {{ end = 100, step = {0.2 * dx / WAVE} }}
[body.block]
material = "rubber"
shape = {{ box = {{ min = {low}, max = {high} }} }}
particles_per_cell = 2
positions = "jittered"
velocity = ["0.5*sin(2*PI*y)", "0.5*sin(2*PI*z)", "0.5*sin(2*PI*x)"]
"""


class Code:
    """A process that steps the work when it is told to."""

    def __init__(self, command: list[str], task: dict, threads: int) -> None:
        env = os.environ | {"RAYON_NUM_THREADS": str(threads)}
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env)
        self.particles = self.ask(task)["Ready"]["particles"]

    def ask(self, order: dict | str) -> dict:
        self.process.stdin.write(json.dumps(order) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        answer = json.loads(line) if line else {"Fault": "the process has ended"}
        if "Fault" in answer:
            self.close()
            raise RuntimeError(answer["Fault"])
        return answer

    def rate(self, steps: int) -> float:
        """Particle-steps a second."""
        return self.particles * steps / self.ask({"Step": {"calls": 1, "substeps": steps}})["Took"]

    def close(self) -> None:
        self.process.kill()
        self.process.wait()


def start(matpoint: str, task: dict) -> dict[str, Code]:
    python = lambda name: [sys.executable, str(HERE / name)]  # noqa: E731
    ours = {"scene": scene(task), "shuffled": task["order"] == "shuffled", "set": None, "get": [], "record": None}
    given = {
        "matpoint": ([matpoint, "study", "stopwatch"], ours),
        "taichi, hand-tuned": (python("taichi_tuned.py"), task),
        "taichi, usual": (python("taichi_usual.py"), task),
    }
    if task["threads"] == 1 and importlib.util.find_spec("warp"):
        given["warp"] = (python("warp_usual.py"), task)
    codes = {}
    for name, (command, first) in given.items():
        try:
            codes[name] = Code(command, first, task["threads"])
        except RuntimeError as fault:
            print(f"  {name} takes no part: {str(fault).split('; allowed')[0]}")
    return codes


def main() -> None:
    matpoint, rounds, sizes = sys.argv[1], int(sys.argv[2]), [int(size) for size in sys.argv[3].split(",")]
    rows = []
    for particles, precision, order, threads in itertools.product(sizes, ["double", "single"], ["cells", "shuffled"], [1, 2]):
        task = {"particles": particles, "precision": precision, "order": order, "threads": threads}
        print(", ".join(f"{key} {value}" for key, value in task.items()), flush=True)
        codes = start(matpoint, task)
        rates: dict[str, list[float]] = {name: [] for name in codes}
        # the first round compiles, warms caches and sorts: it does not count
        for number in range(rounds + 1):
            for name, code in codes.items():
                rate = code.rate(STEPS[particles])
                if number > 0:
                    rates[name].append(rate)
        energies = {name: code.ask("Energy")["Energy"] for name, code in codes.items()}
        for code in codes.values():
            code.close()
        if max(energies.values()) > 1.01 * min(energies.values()):
            raise RuntimeError(f"not the same work, by kinetic energies after it [J]: {energies}")
        if "matpoint" not in codes:
            continue
        for name, own in rates.items():
            ratio = statistics.median(ours / other for ours, other in zip(rates["matpoint"], own, strict=True))
            rows.append([particles, precision, order, threads, name, statistics.median(own), ratio, rounds])
            print(f"  {name:20} {1e-6 * rows[-1][5]:7.2f} M/s, matpoint {ratio:.2f} times", flush=True)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    with OUT.open("w", newline="") as file:
        file.write("particles,precision,order,threads,code,rate,ratio,rounds\n")
        csv.writer(file, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n").writerows(rows)
    print(f"wrote {OUT}")


if __name__ == "__main__":
    main()
