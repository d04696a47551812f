"""What real ROS sees of the node."""

import subprocess
import time

from conftest import NODE, PATIENCE, ROOT

TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
    "/rosout": "rcl_interfaces/msg/Log",
    "/lab/beam/particles": "sensor_msgs/msg/PointCloud2",
    "/lab/beam/scene": "matpoint_msgs/msg/SceneDescription",
    "/lab/beam/state": "matpoint_msgs/msg/ComponentState",
}
ACTION_TOPICS = {
    "/lab/beam/simulate_steps/_action/feedback": "simulation_interfaces/action/SimulateSteps_FeedbackMessage",
    "/lab/beam/simulate_steps/_action/status": "action_msgs/msg/GoalStatusArray",
}
SUBSCRIBED = {"/lab/beam/load/tip": "geometry_msgs/msg/Vector3Stamped", "/lab/beam/command": "matpoint_msgs/msg/LoadCommand"}
SERVICES = {
    "rcl_interfaces": ["DescribeParameters", "GetParameterTypes", "GetParameters", "ListParameters", "SetParameters", "SetParametersAtomically"],
    "matpoint_msgs": {"describe": "Describe", "get": "GetVariable", "set": "SetVariable", "save": "SaveState", "restore": "RestoreState",
                      "record": "Record"},
    "simulation_interfaces": [
        "DeleteEntity", "GetAvailableWorlds", "GetCurrentWorld", "GetEntities", "GetEntitiesStates", "GetEntityBounds", "GetEntityInfo",
        "GetEntityState", "GetNamedPoseBounds", "GetNamedPoses", "GetSimulationState", "GetSimulatorFeatures", "GetSpawnables", "LoadWorld",
        "ResetSimulation", "SetEntityInfo", "SetEntityState", "SetSimulationState", "SpawnEntities", "SpawnEntity", "StepSimulation",
        "UnloadWorld",
    ],
}


def snake(name):
    return "".join("_" + c.lower() if c.isupper() else c for c in name).lstrip("_")


def services():
    found = {}
    for package, names in SERVICES.items():
        pairs = names.items() if isinstance(names, dict) else ((snake(n), n) for n in names)
        found.update({f"/lab/beam/{name}": f"{package}/srv/{kind}" for name, kind in pairs})
    return found


def test_everything_is_seen_with_its_type(start, peer):
    from rclpy.action import get_action_names_and_types

    start(ros_args=["-r", "__ns:=/lab", "-r", "__node:=beam"])
    by_node = peer.node.get_publisher_names_and_types_by_node
    peer.until(lambda: ("beam", "/lab") in peer.node.get_node_names_and_namespaces(), what="node on the graph")
    peer.until(lambda: len(by_node("beam", "/lab")) >= len(TOPICS) + len(ACTION_TOPICS), what="publishers")
    peer.until(lambda: len(peer.node.get_service_names_and_types_by_node("beam", "/lab")) >= len(services()) + 3, what="services")
    peer.spin(1.0)
    assert {n: t for n, [t] in by_node("beam", "/lab")} == {**TOPICS, **ACTION_TOPICS}
    assert ("/lab/beam/simulate_steps", ["simulation_interfaces/action/SimulateSteps"]) in get_action_names_and_types(peer.node)
    assert {n: t for n, [t] in peer.node.get_subscriber_names_and_types_by_node("beam", "/lab")} == SUBSCRIBED
    assert {n: t for n, [t] in peer.node.get_service_names_and_types_by_node("beam", "/lab") if "simulate_steps" not in n} == services()
    # One type on each topic: tools that demand it, such as `ros2 topic echo` without a type, can work.
    assert all(len(types) == 1 for _, types in peer.node.get_topic_names_and_types())
    [info] = peer.node.get_publishers_info_by_topic("/lab/beam/scene")
    assert info.qos_profile.durability.name == "TRANSIENT_LOCAL"


def test_types_are_those_of_ros():
    """Every field that the node writes or reads, against the types of the ROS packages themselves."""
    import importlib

    listing = subprocess.run([NODE.replace("matpoint-node", "examples/interfaces")], capture_output=True, text=True, check=True).stdout
    ours = {}
    for line in listing.splitlines():
        name, field, kind = line.split()
        ours.setdefault(name, {})[field] = kind
    assert len(ours) > 60
    plain = {"boolean": "bool", "float": "float32", "double": "float64", "octet": "uint8"}
    for name, fields in ours.items():
        package, rest = name.split("/")
        message, _, half = rest.partition(".")
        module = importlib.import_module(f"{package}.{'srv' if half else 'msg'}")
        kind = getattr(module, message)
        kind = getattr(kind, half.capitalize()) if half else kind

        def ros(text):
            if text.startswith("sequence<"):
                # A bound, as in `sequence<X, 1>`, does not show on the wire.
                return ros(text[9:-1].split(",")[0]) + "[]"
            word, bracket, size = text.partition("[")
            return plain.get(word, word) + bracket + size

        theirs = {f: ros(t) for f, t in kind.get_fields_and_field_types().items() if f != "structure_needs_at_least_one_member"}
        assert fields == theirs, name
        assert list(fields) == list(theirs), name


def test_the_scene_is_there_for_who_comes_late(start, peer):
    from matpoint_msgs.msg import SceneDescription
    from rclpy.qos import DurabilityPolicy, QoSProfile

    start()
    peer.spin(2.0)
    scenes = peer.listen(SceneDescription, "/matpoint/scene", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    peer.until(lambda: scenes, what="scene")
    scene = scenes[0]
    assert (scene.dimension, scene.particles, scene.bodies) == (2, 1152, ["beam"])
    tip = next(v for v in scene.variables if v.name == "load/tip/traction")
    assert (tip.causality, tip.unit, list(tip.shape)) == (tip.INPUT, "Pa", [2])


def test_remaps_and_the_clock_of_another_node(start, peer, domain):
    """A node of real ROS that uses simulated time follows ours."""
    import rclpy
    from rclpy.parameter import Parameter

    start(ros_args=["-r", "~/state:=/observed"])
    follower = rclpy.create_node("follower", context=peer.context, parameter_overrides=[Parameter("use_sim_time", value=True)])
    peer.executor.add_node(follower)
    peer.until(lambda: follower.get_clock().now().nanoseconds > 0, what="simulated time")
    begin, before = time.monotonic(), follower.get_clock().now().nanoseconds
    peer.spin(2.0)
    passed = 1e-9 * (follower.get_clock().now().nanoseconds - before)
    assert 0.85 < passed / (time.monotonic() - begin) < 1.15
    assert "/observed" in dict(peer.node.get_topic_names_and_types())
    follower.destroy_node()


def test_a_second_node_of_the_same_name_is_reported(start, peer):
    from diagnostic_msgs.msg import DiagnosticArray

    first = start()
    diagnostics = peer.listen(DiagnosticArray, "/diagnostics")
    peer.until(lambda: diagnostics, what="diagnostics")
    assert diagnostics[-1].status[0].level == b"\x00"
    second = start()
    peer.until(lambda: "another node is named /matpoint" in first.said() and "another node is named /matpoint" in second.said())
    peer.until(lambda: any(s.status[0].level == b"\x01" and "another node" in s.status[0].message for s in diagnostics))
    assert second.stop() == 0
    diagnostics.clear()
    peer.until(lambda: diagnostics and diagnostics[-1].status[0].level == b"\x00", what="all well again")


def test_faults_at_the_start_are_told(domain):
    """Each names what is wrong, what is allowed and the nearest right name; nothing joins the graph."""
    from conftest import environment

    scene = str(ROOT / "tests" / "ros2" / "scenes" / "tip.toml")
    cases = [
        (["nothing.toml"], {}, "nothing.toml"),
        ([scene, "--ros-args", "-p", "stepp:=0.1"], {}, "no parameter `stepp`; did you mean `step`?"),
        ([scene, "--ros-args", "-p", "step:=-1.0"], {}, "parameter `step` is -1; allowed is a number from 0.000000001 to 1000"),
        ([scene, "--ros-args", "-p", "particles.mode:=all"], {}, "allowed is any of strided, whole, tiles"),
        ([scene, "--ros-args", "-r", "__node:=1st"], {}, "`1st` is no ROS name: its parts start with a letter"),
        ([scene, "--ros-args", "--params-file", "none.yaml"], {}, "parameter file `none.yaml`"),
        ([scene], {"ROS_DOMAIN_ID": "x"}, "ROS_DOMAIN_ID is `x`; a domain is a whole number from 0 to 232"),
        ([scene], {"ROS_AUTOMATIC_DISCOVERY_RANGE": "HERE"}, "ROS_AUTOMATIC_DISCOVERY_RANGE is `HERE`"),
    ]
    for args, variables, expected in cases:
        done = subprocess.run([NODE, *args], env={**environment(domain), **variables}, capture_output=True, text=True, timeout=PATIENCE)
        assert done.returncode == 1 and expected in done.stderr, done.stderr
