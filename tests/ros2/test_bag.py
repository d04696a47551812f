"""A bag of the topics in the format of rosbag2, read by the `rosbags` package with nothing but our .msg files.

`ros2 bag` itself is not on PyPI: real rclpy receives the serialised messages, and `rosbags` writes them as rosbag2 does.
"""

import os

from conftest import ROOT, seconds
from rosbags.rosbag2 import Reader, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def types():
    store = get_typestore(Stores[f"ROS2_{os.environ.get('ROS_DISTRO_UNDER_TEST', 'jazzy').upper()}"])
    new = {}
    for path in (ROOT / "msgs" / "msg").glob("*.msg"):
        new.update(get_types_from_msg(path.read_text(), f"matpoint_msgs/msg/{path.stem}"))
    store.register(new)
    return store


def test_a_bag_of_all_topics_is_readable_and_complete(start, peer, tmp_path):
    from matpoint_msgs.msg import ComponentState, SceneDescription
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import PointCloud2

    store = types()
    start(parameters={"step": 0.02, "particles.rate": 0.0})
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    topics = {"/clock": Clock, "/matpoint/state": ComponentState, "/matpoint/particles": PointCloud2, "/matpoint/scene": SceneDescription}
    received, numbers = [], {name: [] for name in topics}
    for name, kind in topics.items():
        def take(data, info, name=name):
            received.append((name, peer.node.get_clock().now().nanoseconds, bytes(data)))
            numbers[name].append(info["publication_sequence_number"])

        peer.node.create_subscription(kind, name, take, latched if kind is SceneDescription else 50, raw=True)
    peer.until(lambda: {name for name, _, _ in received} == set(topics), what="every topic")
    peer.spin(3.0)
    with Writer(tmp_path / "bag", version=9) as writer:
        connections = {}
        for name, kind in topics.items():
            kind = f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"
            connections[name] = writer.add_connection(name, kind, typestore=store)
        for name, stamp, data in received:
            writer.write(connections[name], stamp, data)

    with Reader(tmp_path / "bag") as reader:
        messages = {name: [] for name in topics}
        for connection, _, data in reader.messages():
            messages[connection.topic].append(store.deserialize_cdr(data, connection.msgtype))
    assert {name: len(m) for name, m in messages.items()} == {name: sum(r[0] == name for r in received) for name in topics}
    [scene] = messages["/matpoint/scene"]
    assert scene.particles == 1152 and "particle/stress" in [v.name for v in scene.variables]
    # A node that must wait for the processor skips a state for a newer one; what it sent has come.
    assert all(n == list(range(n[0], n[0] + len(n))) for n in numbers.values()), "no message is missing"
    steps = [s.steps for s in messages["/matpoint/state"]]
    assert len(steps) > 100 and steps == sorted(set(steps)) and steps[-1] - steps[0] < 1.5 * len(steps)
    by_time = {seconds(c.header.stamp): c for c in messages["/matpoint/particles"]}
    assert len(by_time) > 100 and all(c.width * c.point_step == len(c.data) for c in by_time.values())
    assert all(abs(seconds(s.header.stamp) - 0.02 * s.steps) < 1e-6 for s in messages["/matpoint/state"])
    clocks = [seconds(c.clock) for c in messages["/clock"]]
    assert clocks == sorted(clocks)
