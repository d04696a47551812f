"""The same scene from TOML, Rust and Python gives the same bytes after 1,000 steps."""

from __future__ import annotations

from conftest import ROOT, beam

from matpoint import Scene, Simulation

# written by `cargo test --release --test same_bytes`, on the same machine: other kinds of CPU may round differently
FROM_RUST = ROOT / "target" / "tmp" / "same_bytes.snapshot"


def a_thousand_steps(sim: Simulation) -> bytes:
    for step in range(1000):
        sim["load/tip/traction"] = [0.0, step % 7 - 3.0]
        sim.step(1e-3)
    return sim.save()


def test_same_bytes() -> None:
    assert FROM_RUST.exists(), "first run: cargo test --release --test same_bytes"
    wanted = FROM_RUST.read_bytes()
    assert a_thousand_steps(Scene.load(ROOT / "tests" / "same_bytes" / "scene.toml").build()) == wanted
    assert a_thousand_steps(beam().build()) == wanted
