"""A controller in another process closes the loop, one step a command; the result is that of the same commands in process."""

import subprocess
import time

from conftest import NODE, SCENES
from geometry_msgs.msg import Vector3Stamped
from matpoint_msgs.msg import ComponentState
from matpoint_msgs.srv import SaveState

STEPS, STEP = 2000, 0.005


def control(peer, steps, record):
    """Damps the tip: traction against its velocity. Records the commands as they are sent."""
    states = peer.listen(ComponentState, "/matpoint/state")
    publisher = peer.node.create_publisher(Vector3Stamped, "/matpoint/load/tip", 10)
    peer.until(lambda: states and publisher.get_subscription_count() == 1, what="state and load of the node")
    peer.spin(0.5)
    velocity, begin = 0.0, time.monotonic()
    for k in range(steps):
        command = Vector3Stamped()
        command.vector.x, command.vector.y = 0.0, -2e3 * (k < 200) - 2e3 * velocity
        record.append(f"{command.vector.x!r} {command.vector.y!r}")
        publisher.publish(command)
        peer.until(lambda: states[-1].steps == k + 1, what=f"state after command {k + 1}")
        velocity = states[-1].probes[0].velocity.y
    return steps / (time.monotonic() - begin), states


def test_2000_steps_in_lock_step_are_those_in_process(start, peer, tmp_path):
    start(parameters={"lock_step": True, "step": STEP, "command.timeout": 0.0})
    commands = []
    rate, states = control(peer, STEPS, commands)
    assert peer.call(SaveState, "/matpoint/save", path=str(tmp_path / "over_ros")).success
    (tmp_path / "commands").write_text("\n".join(commands))
    program = NODE.replace("matpoint-node", "examples/in_process")
    args = [program, SCENES / "tip.toml", str(STEP), "load/tip/traction", tmp_path / "commands", tmp_path / "in_process"]
    subprocess.run(list(map(str, args)), check=True)
    over_ros, in_process = ((tmp_path / name).read_bytes() for name in ("over_ros", "in_process"))
    print(f"lock-step: {rate:.0f} steps/s, snapshot of {len(over_ros)} bytes")
    assert over_ros == in_process
    assert len(over_ros) > 100_000 and states[-1].substeps > STEPS
    assert rate > 50, "more than 200 where nothing else runs"
    displacement = [s.probes[0].displacement.y for s in states if s.steps]
    assert max(map(abs, displacement[-200:])) < 0.1 * max(map(abs, displacement)), "the controller damps"


def test_no_step_without_a_command(start, peer):
    start(parameters={"lock_step": True})
    states = peer.listen(ComponentState, "/matpoint/state")
    peer.until(lambda: states)
    peer.spin(2.5)
    assert {s.steps for s in states} == {0}
