"""The examples and the blocks of the README run, and say what they measured."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT, SCENES

PYTHON = ROOT / "bindings" / "python"
EXAMPLES = PYTHON / "examples"
NUMBER = r"([\d.]+(?:e[+-]\d+)?)"


def run(script: Path, folder: Path) -> str:
    """What a script prints; it must end well, without a word on stderr."""
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONWARNINGS": "error"}
    command: list[str | Path] = [sys.executable, script]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout + done.stderr
    return done.stdout


def numbers(pattern: str, text: str) -> list[float]:
    """The numbers that stand where the pattern has `#`; other signs are plain."""
    found = re.search(re.escape(pattern).replace(r"\#", NUMBER), text)
    assert found is not None, f"{pattern!r} is not in {text!r}"
    return [float(number) for number in found.groups()]


def test_there_is_a_test_for_each_example() -> None:
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == ["controller", "convergence", "coupling", "sweep"]


def test_controller_takes_the_swing_out(tmp_path: Path) -> None:
    text = run(EXAMPLES / "controller.py", tmp_path)
    alone, controlled = numbers("in the fifth period: # mm alone, # mm controlled", text)
    (times,) = numbers("reduced # times", text)
    assert alone > 200.0 and times > 10.0 and times == pytest.approx(alone / controlled, rel=0.01)


def test_convergence_of_two_methods(tmp_path: Path) -> None:
    text = run(EXAMPLES / "convergence.py", tmp_path)
    lumped = numbers("particles, lumped mass: errors # # # #", text)
    consistent = numbers("splines, consistent mass: errors # # # #", text)
    assert lumped == sorted(lumped, reverse=True) and consistent == sorted(consistent, reverse=True)
    assert lumped[-1] == pytest.approx(1.91e-4, rel=0.05) and consistent[-1] == pytest.approx(1.52e-6, rel=0.05)


def test_sweep_over_processes(tmp_path: Path) -> None:
    text = run(EXAMPLES / "sweep.py", tmp_path)
    ratios = [numbers(f"height {height} m: period # s, # of a slender", text)[1] for height in (0.8, 1.0, 1.6, 2.0)]
    assert ratios == sorted(ratios) and 1.0 < ratios[0] < 1.03


def test_coupling_by_iteration(tmp_path: Path) -> None:
    text = run(EXAMPLES / "coupling.py", tmp_path)
    _, late, _ = numbers("staggered, 0.0500 s: # steps of the beam, energy off by #%, tip by #%", text)
    same_cost, _, late_tip = numbers("staggered, 0.0167 s: # steps of the beam, energy off by #%, tip by #%", text)
    cost, drift, tip = numbers("iterated, 0.0500 s: # steps of the beam, energy off by #%, tip by #%", text)
    assert cost == pytest.approx(same_cost, rel=0.1)
    assert late > 100.0 and drift < 0.5 and tip < late_tip


def test_the_blocks_of_the_readme_run_one_after_the_other(tmp_path: Path) -> None:
    text = (PYTHON / "README.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 5
    shutil.copy(SCENES / "cantilever.toml", tmp_path)
    script = tmp_path / "readme.py"
    script.write_text("\n".join(blocks))
    printed = run(script, tmp_path)
    assert "did you mean `load/tip/traction`" in printed and "('grid.cell', 'is -1; must be above 0')" in printed
    for name in re.findall(r'"([\w-]+\.(?:svg|png|rrd))"', text):
        assert (tmp_path / name).stat().st_size > 1000, f"{name} is written"
