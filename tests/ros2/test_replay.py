"""Recordings published again by `matpoint replay --to ros2`, compared byte by byte with what is in the file, as `rosbags` reads it."""

import os
import signal
import subprocess

import pytest
from conftest import NODE, ROOT, environment, seconds
from diagnostic_msgs.msg import DiagnosticArray
from matpoint_msgs.msg import ComponentState, SceneDescription
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2

MATPOINT = os.environ.get("MATPOINT", str(ROOT / "target" / "release" / "matpoint"))
TOPICS = {"/clock": Clock, "~/particles": PointCloud2, "~/state": ComponentState, "/diagnostics": DiagnosticArray, "~/scene": SceneDescription}
LONG = 120.0  # [s] for a whole replay on a loaded machine


def record(path, until, every):
    """Records the cantilever: 1,152 particles of 36 bytes, one frame and one state at each multiple of `every` [s]."""
    scene = ROOT / "launch_scripts" / "scenes" / "cantilever.toml"
    more = [f"--until={until}", f"--set=record.every={every}", f"--set=record.history={every}"]
    subprocess.run([MATPOINT, "run", str(scene), f"--record={path}", "--quiet", *more], check=True, stdout=subprocess.DEVNULL)
    with AnyReader([path]) as reader:
        recorded = {}
        for connection, _, data in reader.messages():
            recorded.setdefault(connection.topic, []).append(bytes(data))
    recorded.pop("/rosout", None)  # a replay says more on it
    return recorded


@pytest.fixture
def replay(domain):
    """Starts `matpoint replay RUN --to ros2`; waits for the subscriber for as long as a test may take."""
    processes = []

    def begin(path, *args):
        command = [MATPOINT, "replay", str(path), "--to", "ros2", "--", "--wait", str(LONG), *args]
        env = environment(domain, MATPOINT_NODE=NODE)
        processes.append(subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True))
        return processes[-1]

    yield begin
    for process in processes:
        process.kill()
        print(process.communicate()[0])


def listen(peer, node):
    """The bytes of all messages on the topics of `node`."""
    received = {}
    for name, kind in TOPICS.items():
        name = name.replace("~", node)
        received[name] = []
        durability = DurabilityPolicy.TRANSIENT_LOCAL if kind is SceneDescription else DurabilityPolicy.VOLATILE
        take = lambda message, to=received[name]: to.append(bytes(message))  # noqa: E731
        peer.node.create_subscription(kind, name, take, QoSProfile(depth=10_000, durability=durability), raw=True)
    return received


def check(received, recorded, node):
    assert {name: len(m) for name, m in received.items()} == {name.replace("/matpoint", node): len(m) for name, m in recorded.items()}
    for name, messages in recorded.items():
        assert received[name.replace("/matpoint", node)] == messages, f"{name}: the same bytes in the same order"


def test_every_frame_of_a_recording_arrives_in_its_time(replay, peer, tmp_path):
    recorded = record(tmp_path / "run.mcap", until=0.6, every=0.02)
    assert len(recorded["/matpoint/particles"]) == len(recorded["/matpoint/state"]) == 31
    received = listen(peer, "/matpoint")
    timed = peer.listen_timed(Clock, "/clock", 1000)
    process = replay(tmp_path / "run.mcap")
    peer.until(lambda: process.poll() is not None, LONG, "end of the replay")
    assert process.returncode == 0
    peer.spin(0.5)
    check(received, recorded, "/matpoint")
    clouds = [deserialize_message(m, PointCloud2) for m in received["/matpoint/particles"]]
    assert [round(seconds(c.header.stamp), 9) for c in clouds] == [round(0.02 * i, 9) for i in range(31)]
    assert all(c.width == 1152 and c.header.frame_id == "map" for c in clouds) and len({bytes(c.data) for c in clouds}) == 31
    times = [seconds(c.clock) for c, _ in timed]
    assert times == sorted(set(times)) and len(times) == 31, "the clock rises"
    # However busy the machine is, it is not ahead of its time; a lag of 0.1 s is made up for.
    assert timed[-1][1] - timed[0][1] > 0.45


def test_as_fast_as_the_subscriber_takes_it_and_under_another_name(replay, peer, tmp_path):
    recorded = record(tmp_path / "run.mcap", until=1.0, every=0.002)
    received = listen(peer, "/lab/again")
    timed = peer.listen_timed(Clock, "/clock", 1000)
    process = replay(tmp_path / "run.mcap", "--ros-args", "-p", "real_time_factor:=0", "-r", "__ns:=/lab", "-r", "__node:=again")
    peer.until(lambda: process.poll() is not None, LONG, "end of the replay")
    assert process.returncode == 0
    peer.spin(0.5)
    check(received, recorded, "/lab/again")
    clouds = received["/lab/again/particles"]
    wall = timed[-1][1] - timed[0][1]
    print(f"{len(clouds)} clouds of {len(clouds[0])} bytes, each with a state, in {wall:.2f} s, none missing")
    assert len(clouds) == 501


def test_one_that_goes_round_ends_when_it_is_told_to(replay, peer, tmp_path):
    record(tmp_path / "run.mcap", until=0.1, every=0.02)
    clocks = peer.listen(Clock, "/clock", 1000)
    process = replay(tmp_path / "run.mcap", "--loop")
    peer.until(lambda: any(seconds(b.clock) < seconds(a.clock) for a, b in zip(clocks, clocks[1:])), LONG, "second round")
    process.send_signal(signal.SIGINT)
    peer.until(lambda: process.poll() is not None, what="end")
    assert process.returncode == 0
    peer.until(lambda: "matpoint" not in peer.node.get_node_names(), what="off the graph")


def test_large_clouds_come_in_tiles(replay, peer, tmp_path):
    recorded = [deserialize_message(m, PointCloud2) for m in record(tmp_path / "run.mcap", until=0.5, every=0.1)["/matpoint/particles"]]
    whole = {seconds(c.header.stamp): bytes(c.data) for c in recorded}
    # Tiles are best effort.
    tiles = peer.listen(PointCloud2, "/matpoint/particles", QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT))
    process = replay(tmp_path / "run.mcap", "--ros-args", "-p", "particles.mode:=tiles", "-p", "particles.max_bytes:=18000")
    peer.until(lambda: process.poll() is not None, LONG, "end of the replay")
    assert process.returncode == 0
    peer.spin(0.5)
    places = [(seconds(t.header.stamp), whole[seconds(t.header.stamp)].find(bytes(t.data)), t.width) for t in tiles]
    assert set(places) <= {(time, place, width) for time in whole for place, width in ((0, 500), (18_000, 500), (36_000, 152))}
    assert places == sorted(set(places)) and len(places) > 0.8 * 3 * len(whole)
