"""Stepping, inputs, outputs, snapshots, and calls that are wrong."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import numpy as np
import pytest
from conftest import SCENES, beam, block

import matpoint
from matpoint import ComponentError, MatpointError, Scene, Simulation, StepError


def test_step_lands_on_time_and_reports(sim: Simulation) -> None:
    report = sim.step(0.01)
    assert report.time == sim.time == 0.01
    assert report.substeps == sim.steps >= 1 and 0 < report.smallest_step <= sim.max_step
    assert report.iterations == 0
    sim.step(np.float64(0.01))
    sim.step(1)
    assert sim.time == 0.01 + 0.01 + 1
    assert eval(repr(report), vars(matpoint) | {"Report": lambda **keys: keys})["time"] == 0.01


def test_shapes_and_order_of_arrays(sim: Simulation) -> None:
    sim.step(0.01)
    n = sim.describe().particles
    shapes = {"particle/position": (n, 2), "particle/stress": (n, 3, 3), "particle/mass": (n,), "energy/total": (), "probe/tip/velocity": (2,)}
    for name, shape in shapes.items():
        for array in (sim[name], sim.get(name), sim.get(name, view=True), sim.get(name, np.empty(shape))):
            assert array.shape == shape == sim.variable(name).shape
            assert array.dtype == np.float64 and array.flags.c_contiguous
    f = sim["particle/deformation_gradient"]
    strain = sim["particle/strain"]
    # C order: F is not transposed, and so E = (F^T F - I) / 2 comes out, up to round-off
    assert not np.array_equal(f, f.transpose(0, 2, 1))
    np.testing.assert_allclose(strain, (f.transpose(0, 2, 1) @ f - np.eye(3)) / 2, atol=1e-15)


def test_copies_belong_to_the_caller(sim: Simulation) -> None:
    a, b = sim["particle/position"], sim["particle/position"]
    assert not np.shares_memory(a, b) and a.flags.owndata and a.flags.writeable
    a[:] = 0
    assert sim["particle/position"].max() > 3


def test_out_is_written_and_returned(sim: Simulation) -> None:
    n = sim.describe().particles
    out = np.full((n, 2), np.nan)
    assert sim.get("particle/position", out) is out
    np.testing.assert_array_equal(out, sim["particle/position"])
    assert sim.get("particle/position", out=out) is out
    # a part of a larger array, in order itself
    many = np.zeros((3, n, 2))
    sim.get("particle/position", out=many[1])
    np.testing.assert_array_equal(many[1], out)
    assert not many[0].any() and not many[2].any()


def test_views_are_read_only_and_stay_as_they_were(sim: Simulation) -> None:
    view = sim.get("particle/position", view=True)
    again = sim.get("particle/position", view=True)
    assert np.shares_memory(view, again) and not view.flags.owndata
    with pytest.raises(ValueError):
        view[0, 0] = 1.0
    with pytest.raises(ValueError):
        view.flags.writeable = True
    before = view.copy()
    sim.step(0.1)
    np.testing.assert_array_equal(view, before)
    assert not np.array_equal(sim["particle/position"], before)
    part = sim.get("particle/position", view=True)[3:7, 1]
    kept = part.copy()
    sim.reset()
    del sim, view, again
    np.testing.assert_array_equal(part, kept)


def test_inputs(sim: Simulation) -> None:
    value: Any
    for value in ([0.0, 5.0], (0, 5), np.array([0, 5]), np.array([0, 5], np.float32), np.array([[0.0, 1.0], [5.0, 1.0]])[:, 0]):
        sim.set("load/tip/traction", value)
        np.testing.assert_array_equal(sim["load/tip/traction"], [0.0, 5.0])
        sim["load/tip/traction"] = [0.0, 0.0]
    assert "load/tip/traction" in sim and "load/tap/traction" not in sim
    assert sim.variable("load/tip/traction").causality == "input"
    pressed = Scene.load(SCENES / "cantilever.toml", set={"load": {"p": {"pressure": {"body": "beam", "face": "x+", "value": "external"}}}}).build()
    for value in (7.0, [7.0], np.float64(7.0), np.array(7.0), 7):
        pressed["load/p/pressure"] = value
        assert pressed["load/p/pressure"] == [7.0]


class Odd:
    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("no")


@pytest.mark.parametrize(
    "value",
    [[0.0], [0.0, 1.0, 2.0], 1.0, [[0.0, 1.0]], [[0.0], [1.0]], [0.0, math.nan], [math.inf, 0.0], "ab", ["0", "1"], None, {}, [0, 1j],
     [True, False], True, b"12", object(), [None, None], [[0, 1], [2]], Odd(), np.array([0, 1], "datetime64[s]"), np.array([0.0, 1.0], object)],
)  # fmt: skip
def test_wrong_values_are_refused_and_change_nothing(sim: Simulation, value: Any) -> None:
    sim["load/tip/traction"] = [1.0, 2.0]
    saved = sim.save()
    with pytest.raises(ComponentError, match="load/tip/traction"):
        sim.set("load/tip/traction", value)
    assert sim.save() == saved


def test_wrong_names(sim: Simulation) -> None:
    with pytest.raises(ComponentError, match="did you mean `particle/position`"):
        sim.get("particle/positon")
    with pytest.raises(ComponentError, match="did you mean `load/tip/traction`"):
        sim["load/tip/tracton"] = [0.0, 0.0]
    with pytest.raises(ComponentError, match="is an output"):
        sim.set("particle/position", sim["particle/position"])
    for call in (lambda: sim.get(3), lambda: sim[0], lambda: sim.set(None, 1.0), lambda: sim.variable([])):  # type: ignore[call-overload,index,arg-type]
        with pytest.raises(TypeError):
            call()


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (np.empty((64, 3)), r"its shape is \[64, 3\]"),
        (np.empty((64, 2), np.float32), "an array of float32"),
        (np.empty((2, 64)).T, "not in C order"),
        (np.empty((64, 4))[:, ::2], "not in C order"),
        ([[0.0]] * 64, "it is a list"),
        (np.frombuffer(bytes(64 * 16)).reshape(64, 2), "out must be a writable"),
        (np.frombuffer(bytearray(64 * 16 + 1), np.uint8)[1:].view(np.float64).reshape(64, 2), "out must be a writable"),
    ],
)
def test_wrong_out(sim: Simulation, out: Any, message: str) -> None:
    with pytest.raises(ComponentError, match=message):
        sim.get("particle/position", out)


def test_out_and_view_exclude_each_other(sim: Simulation) -> None:
    with pytest.raises(ComponentError, match="not both"):
        sim.get("particle/position", np.empty((64, 2)), view=True)  # type: ignore[call-overload]


@pytest.mark.parametrize("dt", [0.0, -1.0, math.nan, math.inf])
def test_wrong_steps(sim: Simulation, dt: float) -> None:
    saved = sim.save()
    with pytest.raises(StepError, match="positive, finite"):
        sim.step(dt)
    assert sim.save() == saved


def test_steps_of_a_wrong_type(sim: Simulation) -> None:
    for dt in ("1", None, [0.1], 1j):
        with pytest.raises(TypeError):
            sim.step(dt)  # type: ignore[arg-type]


def test_a_failed_step_says_where_and_leaves_the_state() -> None:
    sim = beam(load={"tip": {"traction": {"body": "beam", "face": "x+", "value": "external"}}}).build()
    sim.step(0.1)
    saved = sim.save()
    sim["load/tip/traction"] = [0.0, -1e9]
    loaded = sim.save()
    with pytest.raises(StepError) as caught:
        sim.step(1.0)
    error = caught.value
    assert isinstance(error, MatpointError)
    assert error.particle is not None and 0 <= error.particle < 64
    assert error.time is not None and 0.1 <= error.time < 1.1
    assert error.position is not None and len(error.position) == 2
    assert f"particle {error.particle}" in str(error)
    assert sim.save() == loaded and sim.time == 0.1
    with pytest.raises(StepError):
        sim.step(1.0)
    # and goes on as if nothing had been
    other = beam(load={"tip": {"traction": {"body": "beam", "face": "x+", "value": "external"}}}).build()
    other.restore(saved)
    sim["load/tip/traction"] = [0.0, 0.0]
    sim.step(0.1)
    other.step(0.1)
    assert sim.save() == other.save()
    # the error travels between processes with what it knows
    copied = pickle.loads(pickle.dumps(error))
    assert (copied.time, copied.particle, copied.position, str(copied)) == (error.time, error.particle, error.position, str(error))


def test_save_restore_reset(sim: Simulation) -> None:
    fresh = sim.save()
    assert isinstance(fresh, bytes)
    sim["load/tip/traction"] = [0.0, 3.0]
    sim.step(0.1)
    middle = sim.save()
    sim.step(0.1)
    end = sim.save()
    sim.restore(middle)
    assert sim.time == 0.1 and sim["load/tip/traction"][1] == 3.0
    sim.step(0.1)
    assert sim.save() == end
    sim.reset()
    assert sim.save() == fresh and sim.time == 0.0


def test_wrong_snapshots(sim: Simulation) -> None:
    good = sim.save()
    for wrong in (b"", b"hello", good[:-1], good + b"0", block(1).build().save()):
        with pytest.raises(ComponentError, match="cannot restore"):
            sim.restore(wrong)
    for not_bytes in ("text", None, 7, [1, 2]):
        with pytest.raises(TypeError):
            sim.restore(not_bytes)  # type: ignore[arg-type]
    assert sim.save() == good


def test_simulations_pickle_and_copy_with_their_state(sim: Simulation) -> None:
    sim["load/tip/traction"] = [0.0, 3.0]
    sim.step(0.1)
    for other in (pickle.loads(pickle.dumps(sim)), copy.deepcopy(sim)):
        assert other.save() == sim.save() and other.scene == sim.scene
        other.step(0.1)
    sim.step(0.1)
    assert other.save() == sim.save()


def test_state_by_attributes(sim: Simulation) -> None:
    sim.step(0.1)
    state = sim.state()
    assert state.time == 0.1 and isinstance(state.energy.total, float)
    np.testing.assert_array_equal(state.particle.position, sim["particle/position"])
    np.testing.assert_array_equal(state.probe.tip.displacement, sim["probe/tip/displacement"])
    np.testing.assert_array_equal(state["boundary"]["root"]["reaction"], sim["boundary/root/reaction"])
    assert {"particle", "energy", "momentum", "probe", "boundary", "load"} <= set(dir(state))
    assert "position" in dir(state.particle) and "position" in repr(state.particle)
    with pytest.raises(ComponentError, match="did you mean `particle/position`"):
        state.particle.positon
    with pytest.raises(ComponentError):
        state.nothing
    kept = state.particle.position.copy()
    sim.step(0.1)
    np.testing.assert_array_equal(state.particle.position, kept)
    with pytest.raises(ComponentError, match="has gone on from t = 0.1 s to t = 0.2 s"):
        state.particle.velocity


def test_describe(sim: Simulation) -> None:
    description = sim.describe()
    assert (description.title, description.dimension, description.particles) == (sim.scene.title, 2, 64)
    assert description.bodies == {"beam": 64} and description.method["transfer"] == "APIC"
    assert description.end == 1.0 and 0 < description.stable_step and description.memory > 64 * 8
    assert set(description.variables) == set(sim.names())
    position = description.variables["particle/position"]
    assert (position.unit, position.shape, position.causality) == ("m", (64, 2), "output") and position == sim.variable("particle/position")
    assert "stable step" in str(description) and "particle/position" in str(description)
    for html in (description._repr_html_(), sim._repr_html_()):
        assert "<table>" in html and "particle/position" in html
    odd = beam(title="<script>").build()._repr_html_()
    assert "<script>" not in odd and "&lt;script&gt;" in odd
    assert "64 particles" in repr(sim)
