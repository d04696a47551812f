"""simulation_interfaces: the time and the state that the standard says."""

import time

from action_msgs.msg import GoalStatus
from conftest import seconds
from matpoint_msgs.msg import ComponentState
from matpoint_msgs.srv import Describe, GetVariable, Record, RestoreState, SaveState, SetVariable
from rclpy.action import ActionClient
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import EntityCategory, EntityFilters, Result, SimulationState, SimulatorFeatures, TagsFilter
from simulation_interfaces.srv import (
    GetAvailableWorlds, GetEntities, GetEntitiesStates, GetEntityBounds, GetEntityInfo, GetEntityState, GetNamedPoses, GetSimulationState,
    GetSimulatorFeatures, LoadWorld, ResetSimulation, SetEntityState, SetSimulationState, SpawnEntities, SpawnEntity, StepSimulation,
)

STOPPED, PLAYING, PAUSED, QUITTING = range(4)


def call(peer, kind, **request):
    name = "".join("_" + c.lower() if c.isupper() else c for c in kind.__name__).lstrip("_")
    return peer.call(kind, f"/matpoint/{name}", **request)


def go(peer, state):
    return call(peer, SetSimulationState, state=SimulationState(state=state)).result.result


def state(peer):
    return call(peer, GetSimulationState).state.state


def when(peer):
    return peer.call(GetVariable, "/matpoint/get", name="particle/mass").time


def test_pause_step_reset_play(start, peer):
    start(parameters={"paused": True, "step": 0.01})
    features = call(peer, GetSimulatorFeatures).features.features
    for feature in ("SIMULATION_RESET", "SIMULATION_STATE_SETTING", "SIMULATION_STATE_PAUSE", "STEP_SIMULATION_MULTIPLE", "STEP_SIMULATION_ACTION"):
        assert getattr(SimulatorFeatures, feature) in features
    assert (state(peer), when(peer)) == (PAUSED, 0.0)

    assert call(peer, StepSimulation).result.result == Result.RESULT_OK  # one step unless it says otherwise
    assert abs(when(peer) - 0.01) < 1e-12
    assert call(peer, StepSimulation, steps=25).result.result == Result.RESULT_OK
    assert abs(when(peer) - 0.26) < 1e-12
    assert state(peer) == PAUSED
    assert call(peer, StepSimulation, steps=0).result.result == Result.RESULT_OPERATION_FAILED

    assert go(peer, PAUSED) == SetSimulationState.Response.ALREADY_IN_TARGET_STATE
    assert go(peer, PLAYING) == Result.RESULT_OK
    begin, before = time.monotonic(), when(peer)
    peer.spin(1.0)
    passed = when(peer) - before
    assert 0.7 < passed < time.monotonic() - begin + 0.1, "real time"
    refused = call(peer, StepSimulation).result
    assert refused.result == Result.RESULT_OPERATION_FAILED and refused.error_message == "the simulation is not paused"

    assert call(peer, ResetSimulation, scope=ResetSimulation.Request.SCOPE_TIME).result.result == Result.RESULT_FEATURE_UNSUPPORTED
    assert call(peer, ResetSimulation, scope=ResetSimulation.Request.SCOPE_SPAWNED).result.result == Result.RESULT_OK
    late = when(peer)
    assert call(peer, ResetSimulation).result.result == Result.RESULT_OK
    assert when(peer) < late and state(peer) == PLAYING, "goes on playing from the start"

    assert go(peer, STOPPED) == Result.RESULT_OK
    assert (state(peer), when(peer)) == (STOPPED, 0.0), "stopped is paused and reset"
    assert go(peer, PAUSED) == Result.RESULT_OK
    assert go(peer, SimulationState.STATE_NO_WORLD) == SetSimulationState.Response.INCORRECT_TRANSITION
    assert go(peer, 77) == SetSimulationState.Response.INCORRECT_TRANSITION


def test_quitting_ends_the_node(start, peer):
    node = start()
    assert go(peer, QUITTING) == Result.RESULT_OK
    assert node.process.wait(10) == 0


def test_steps_by_action_can_be_watched_and_cancelled(start, peer):
    start(parameters={"paused": True, "step": 0.01})
    client = ActionClient(peer.node, SimulateSteps, "/matpoint/simulate_steps")
    assert client.wait_for_server(15.0)
    peer.spin(0.5)

    def run(steps, cancel_after=None):
        told = []
        goal = client.send_goal_async(SimulateSteps.Goal(steps=steps), feedback_callback=lambda m: told.append(m.feedback))
        peer.until(goal.done)
        assert goal.result().accepted
        result = goal.result().get_result_async()
        if cancel_after is not None:
            peer.spin(cancel_after)
            cancelled = goal.result().cancel_goal_async()
            peer.until(cancelled.done)
            assert len(cancelled.result().goals_canceling) == 1
        peer.until(result.done)
        return result.result().status, result.result().result.result.result, told

    status, outcome, told = run(200)
    assert (status, outcome) == (GoalStatus.STATUS_SUCCEEDED, Result.RESULT_OK)
    assert told and all(f.completed_steps + f.remaining_steps == 200 for f in told)
    assert abs(when(peer) - 2.0) < 1e-9
    status, outcome, _ = run(10_000_000, cancel_after=0.5)
    assert (status, outcome) == (GoalStatus.STATUS_CANCELED, Result.RESULT_OPERATION_FAILED)
    assert state(peer) == PAUSED and 2.0 < when(peer) < 1e5
    go(peer, PLAYING)
    status, outcome, _ = run(5)
    assert (status, outcome) == (GoalStatus.STATUS_ABORTED, Result.RESULT_OPERATION_FAILED), "not paused"


def test_bodies_are_entities_and_the_rest_is_unsupported(start, peer):
    start(parameters={"paused": True})
    assert call(peer, GetEntities).entities == ["beam"]
    assert call(peer, GetEntities, filters=EntityFilters(filter="be.*")).entities == ["beam"]
    assert call(peer, GetEntities, filters=EntityFilters(filter="b")).entities == []
    human = EntityFilters(categories=[EntityCategory(category=EntityCategory.CATEGORY_HUMAN)])
    assert call(peer, GetEntities, filters=human).entities == []
    tagged = EntityFilters(tags=TagsFilter(tags=["x"]))
    assert call(peer, GetEntities, filters=tagged).result.result == Result.RESULT_FEATURE_UNSUPPORTED
    info = call(peer, GetEntityInfo, entity="beam")
    assert info.info.category.category == EntityCategory.CATEGORY_DYNAMIC_OBJECT and "1152" in info.info.description
    at = call(peer, GetEntityState, entity="beam").state
    assert abs(at.pose.position.x - 4.0) < 1e-9 and abs(at.pose.position.y - 0.5) < 1e-9 and at.pose.orientation.w == 1.0
    upper, lower = call(peer, GetEntityBounds, entity="beam").bounds.points
    assert 7.9 < upper.x < 8.0 and 0.0 < lower.x < 0.1
    assert len(call(peer, GetEntitiesStates).states) == 1
    missing = call(peer, GetEntityState, entity="bean").result
    assert missing.result == Result.RESULT_NOT_FOUND and missing.error_message == "no entity `bean`; there are: beam"
    for kind in (SpawnEntity, SpawnEntities, SetEntityState, LoadWorld, GetAvailableWorlds, GetNamedPoses):
        answer = call(peer, kind).result
        assert answer.result == Result.RESULT_FEATURE_UNSUPPORTED, kind


def test_variables_and_snapshots(start, peer):
    start(parameters={"paused": True})
    scene = peer.call(Describe, "/matpoint/describe").scene
    assert scene.title == "Cantilever behind a controller" and any(line.startswith("basis:") for line in scene.method)
    wrong = peer.call(GetVariable, "/matpoint/get", name="probe/tap/position")
    assert not wrong.success and "did you mean `probe/tip/position`?" in wrong.message
    refused = peer.call(SetVariable, "/matpoint/set", name="load/tip/traction", values=[1.0])
    assert not refused.success and refused.message == "`load/tip/traction` takes 2 values, not 1"
    assert peer.call(SetVariable, "/matpoint/set", name="load/tip/traction", values=[0.0, -1e3]).success
    call(peer, StepSimulation, steps=10)
    saved = peer.call(SaveState, "/matpoint/save")
    assert saved.success and len(saved.snapshot) > 100_000 and abs(saved.time - 0.1) < 1e-12

    def tip():
        answer = peer.call(GetVariable, "/matpoint/get", name="probe/tip/position")
        assert answer.success and answer.variable.unit == "m" and list(answer.variable.shape) == [2]
        return list(answer.values)

    call(peer, StepSimulation, steps=10)
    later = tip()
    assert peer.call(RestoreState, "/matpoint/restore", snapshot=saved.snapshot).success
    assert abs(when(peer) - 0.1) < 1e-12
    call(peer, StepSimulation, steps=10)
    assert tip() == later, "bitwise the same as without the restore"
    spoiled = peer.call(RestoreState, "/matpoint/restore", snapshot=b"nothing")
    assert not spoiled.success and "cannot restore" in spoiled.message


def test_recordings_by_service_and_parameter(start, peer, tmp_path):
    node = start(parameters={"record": tmp_path / "first", "record.every": 0.1})
    peer.until(lambda: "recording to" in node.said())
    answer = peer.call(Record, "/matpoint/record", path=str(tmp_path / "second"))
    assert answer.success and answer.files and all(f.startswith(str(tmp_path / "first")) for f in answer.files)
    taken = peer.call(Record, "/matpoint/record", path=str(tmp_path / "first"))
    assert not taken.success and "exists" in taken.message
    assert peer.call(Record, "/matpoint/record", path=str(tmp_path / "third")).success
    peer.spin(0.5)
    assert node.stop() == 0, "a recording under way is closed"
    for name in ("first", "third"):
        rows = [f.read_text().splitlines() for f in (tmp_path / name).glob("*.csv")]
        assert rows and all(len({line.count(",") for line in file}) == 1 for file in rows), "no half line"


def test_bags_are_what_is_published(start, peer, tmp_path):
    """An .mcap of the node, read without our definitions, holds the states that a subscriber gets."""
    from rosbags.highlevel import AnyReader

    start(parameters={"paused": True, "step": 0.01, "record.every": 0.01})
    states = peer.listen(ComponentState, "/matpoint/state")
    run = tmp_path / "run.mcap"
    assert peer.call(Record, "/matpoint/record", path=str(run)).success
    call(peer, StepSimulation, steps=20)
    peer.until(lambda: states and states[-1].steps == 20, what="the last state")
    ended = peer.call(Record, "/matpoint/record", path="")
    assert ended.success and ended.files == [str(run)]
    with AnyReader([run]) as reader:
        bag = {}
        for connection, _, raw in reader.messages():
            bag.setdefault(connection.topic, []).append(reader.deserialize(raw, connection.msgtype))
    assert set(bag) >= {"/clock", "/matpoint/state", "/matpoint/scene", "/matpoint/particles", "/diagnostics"}
    recorded = {round(seconds(s.header.stamp), 6): s for s in bag["/matpoint/state"]}
    for state in states:
        same = recorded[round(seconds(state.header.stamp), 6)]
        assert (same.header.frame_id, same.kinetic_energy, same.substeps) == (state.header.frame_id, state.kinetic_energy, state.substeps)
        assert [list(p.stress) for p in same.probes] == [list(p.stress) for p in state.probes]


def test_states_while_time_stands_still(start, peer):
    """Who comes late to a paused simulation sees it all the same."""
    start(parameters={"paused": True})
    states = peer.listen(ComponentState, "/matpoint/state")
    peer.until(lambda: len(states) >= 2, what="states")
    assert {seconds(s.header.stamp) for s in states} == {0.0}
    tip = states[-1].probes[0]
    assert (tip.name, tip.position.x, tip.position.y) == ("tip", 8.0, 0.5)
    assert [r.name for r in states[-1].reactions] == ["root"]
    load = states[-1].loads[0]
    assert (load.name, load.kind, list(load.value), load.timed_out) == ("tip", "traction", [0.0, 0.0], True)
