"""Runs a node and a receiver of its particles side by side; shared by the tests and by measure.py."""

import json
import subprocess
import sys

from conftest import HERE, Node, environment

HZ = 60


def receive(domain, scene, parameters, reliability, seconds, scene_args=(), depth=5, buffer=False):
    """What the receiver printed, and how the node ended. `buffer` gives the receiver 4 MiB to receive into."""
    # Jazzy looks into the first of these, Kilted into the second.
    names = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
    more = dict.fromkeys(names, HERE / "receive_buffer_4MiB.xml") if buffer else {}
    env = environment(domain, **more)
    command = [sys.executable, str(HERE / "receiver.py"), "/matpoint/particles", reliability, str(seconds), "--depth", str(depth)]
    receiver = subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True)
    node = None
    try:
        assert receiver.stdout.readline() == "ready\n"
        node = Node(domain, scene, parameters={"particles.rate": 0.0, "particles.reliability": reliability, **parameters}, args=scene_args)
        out, _ = receiver.communicate(timeout=seconds + 60)
        assert receiver.returncode == 0
    finally:
        receiver.kill()
        if node:
            node.stop(within=30)
    return json.loads(out), node


def share(got):
    """Share of the messages that came of those that the node sent between the first and the last: DDS numbers them."""
    numbers = got["numbers"]
    return len(numbers) / (max(numbers) - min(numbers) + 1)


def steps(got, step, messages_a_step=1):
    """Share of the messages that came of those that there would be if the node sent some for each step [s]."""
    return got["count"] / (messages_a_step * (round((max(got["stamps"]) - min(got["stamps"])) * 1e-9 / step) + 1))
