"""Methods other than the default one, from Python."""

from __future__ import annotations

import math

import numpy as np
import pytest
from conftest import beam

from matpoint import SceneError
from matpoint.scene import Method, Time


def test_a_balance_of_forces() -> None:
    method = Method(formulation="total", degree=3, integrator="quasi_static")
    sim = beam(method=method, body={"beam": {**beam().to_dict()["body"]["beam"], "velocity": [0.0, 0.0]}}, time=Time(end=1.0, step=1.0)).build()
    assert math.isinf(sim.max_step) and sim.residuals == []
    sim["load/tip/traction"] = [0.0, -2000.0]
    report = sim.step(1.0)
    # Newton's method, to 1e-10 of the forces
    assert report.substeps == 1 and 4 <= report.iterations <= 20
    assert sim.residuals[-1] < 1e-10 < sim.residuals[0]
    # what the wall holds is the load on the upright end of 1 m, and the weight of 4 m2 of 100 kg/m2
    assert np.allclose(sim["boundary/root/reaction"], [0.0, 2000.0 + 400.0 * 9.81], atol=1e-5)
    assert sim["probe/tip/displacement"][1] < 0.0 and np.allclose(sim["particle/velocity"], 0.0)


def test_the_method_chosen_by_the_scene() -> None:
    scene = beam(method="auto")
    assert scene.to_dict()["method"] == "auto"
    sim = scene.build()
    chosen = {part: (what, why) for part, what, why in sim.describe().choices}
    assert chosen["formulation"][0] == "total" and chosen["integrator"][0] == "verlet" and all(why for _, why in chosen.values())
    assert beam().build().describe().choices == []
    sim.step(0.1)
    with pytest.raises(SceneError, match="is the text \"automatic\"; must be a table with the keys .*, or \"auto\""):
        beam(method="automatic")
