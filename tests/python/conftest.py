"""Scenes that the tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

import matpoint
from matpoint.scene import Body, Boundary, Grid, Material, Probe, Time

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "launch_scripts" / "scenes"


def beam(**changed: object) -> matpoint.Scene:
    """A beam of 64 particles with a load that is set from outside; the scene of tests/same_bytes/scene.toml."""
    keys: dict[str, object] = dict(
        title="the same from TOML, Rust and Python",
        dimension=2,
        grid=Grid(origin=[0.0, -2.0], size=[5.0, 4.0], cell=0.5),
        material={"rubber": Material(law="neo_hookean", young=1e6, poisson=0.3, density=100.0)},
        body={"beam": Body(material="rubber", shape={"box": {"min": [0.0, 0.0], "max": [4.0, 1.0]}}, velocity=[0.0, "0.1*x"])},
        boundary={"root": Boundary(face="x-", fixed=["x", "y"])},
        load={"weight": {"gravity": [0.0, -9.81]}, "tip": {"traction": {"body": "beam", "face": "x+", "value": "external"}}},
        probe={"tip": Probe(at=[4.0, 0.5])},
        method={"transfer": "apic"},
        time=Time(end=1.0),
    )
    return matpoint.Scene.from_dict(keys | changed)


def block(cells: int, particles: int = 2) -> matpoint.Scene:
    """A free cube that flies: cells^3 particles_per_cell^3 particles."""
    return matpoint.Scene(
        title="a block",
        dimension=3,
        grid=Grid(origin=[0, 0, 0], size=[cells + 8] * 3, cell=1.0),
        material={"m": Material(law="neo_hookean", young=1e4, poisson=0.3, density=100.0)},
        body={
            "block": Body(
                material="m",
                shape={"box": {"min": [4, 4, 4], "max": [cells + 4] * 3}},
                particles_per_cell=particles,
                velocity=["0.01*y", 0, 0],
            )
        },
        time=Time(end=1.0),
    )


@pytest.fixture
def sim() -> matpoint.Simulation:
    return beam().build()
