"""Launch files, parameter files, the example controller. With the real `launch` package where it can be imported (it is not on PyPI),
else with a stand-in that reads the description: the test that ran says which."""

import importlib.util
import os
import signal
import subprocess
import sys
import types

import pytest
import yaml
from conftest import NODE, PATIENCE, ROOT, environment
from matpoint_msgs.msg import ComponentState

LAUNCH = ROOT / "launch_scripts" / "matpoint.launch.py"
REAL = importlib.util.find_spec("launch") is not None and hasattr(__import__("launch"), "LaunchService")


def stand_in():
    """Just enough of `launch` to read a description: actions keep their arguments."""

    def action(name):
        def init(self, *args, **kwargs):
            self.args, self.kwargs = args, kwargs

        return type(name, (), {"__init__": init})

    modules = {
        "launch": ["LaunchDescription"], "launch.actions": ["DeclareLaunchArgument", "ExecuteProcess", "Shutdown"],
        "launch.conditions": ["IfCondition"], "launch.substitutions": ["LaunchConfiguration"],
    }
    for name, classes in modules.items():
        module = types.ModuleType(name)
        for c in classes:
            setattr(module, c, action(c))
        sys.modules[name] = module
    return list(modules)


def load():
    spec = importlib.util.spec_from_file_location("matpoint_launch", LAUNCH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def commands(**given):
    """The command lines of the launch file with these arguments, resolved by the stand-in."""
    names = stand_in()
    try:
        module = load()
        description = module.generate_launch_description().args[0]
    finally:
        for name in names:
            sys.modules.pop(name, None)
    values = {}
    processes = []
    for entry in description:
        if type(entry).__name__ == "DeclareLaunchArgument":
            values[entry.args[0]] = given.pop(entry.args[0], entry.kwargs["default_value"])
            assert len(entry.kwargs["description"]) > 5
        else:
            processes.append(entry)
    assert not given, f"unknown arguments {given}"

    def text(part):
        if isinstance(part, list):
            return "".join(map(text, part))
        return part if isinstance(part, str) else values[part.args[0]]

    chosen = []
    for process in processes:
        condition = process.kwargs.get("condition")
        if condition is None or text(condition.args[0]) == "true":
            chosen.append([text(part) for part in process.kwargs["cmd"]])
    return chosen


@pytest.mark.skipif(REAL, reason="the real package is there")
def test_launch_file_read_by_a_stand_in_and_its_command_run(peer, domain, tmp_path):
    print("launch is not installed: its description was read by a stand-in")
    [node] = commands(node=NODE, namespace="/lab", rate="0.5", record=str(tmp_path / "run"), paused="false")
    assert node[1].endswith("controlled_cantilever.toml")
    process = subprocess.Popen(node, env=environment(domain))
    try:
        check(peer, "/lab/matpoint/state", 0.5)
    finally:
        process.terminate()
        assert process.wait(10) == 0
    assert list((tmp_path / "run").glob("*.csv"))
    assert len(commands(rviz="true", controller="true")) == 3
    for launched in commands(controller="true")[1:]:
        assert os.path.exists(launched[1])


@pytest.mark.skipif(not REAL, reason="launch is not on PyPI and not installed here")
def test_launch_file_with_the_real_launch_package(peer, domain, tmp_path):
    run = "import sys; from launch import LaunchService; from launch.launch_description_sources import *; from launch import LaunchDescription; " \
          "from launch.actions import IncludeLaunchDescription; s = LaunchService(); " \
          "s.include_launch_description(LaunchDescription([IncludeLaunchDescription(PythonLaunchDescriptionSource(sys.argv[1]), " \
          "launch_arguments=[tuple(a.split(':=')) for a in sys.argv[2:]])])); sys.exit(s.run())"
    arguments = [f"node:={NODE}", "namespace:=/lab", "rate:=0.5", f"record:={tmp_path / 'run'}"]
    process = subprocess.Popen([sys.executable, "-c", run, str(LAUNCH), *arguments], env=environment(domain), start_new_session=True)
    try:
        check(peer, "/lab/matpoint/state", 0.5)
    finally:
        os.killpg(process.pid, signal.SIGINT)  # as Ctrl-C in a terminal
        assert process.wait(15) == 0
    assert list((tmp_path / "run").glob("*.csv"))
    print("run with the real launch package")


def check(peer, topic, factor):
    states = peer.listen(ComponentState, topic)
    near = lambda: abs(states[-1].real_time_factor - factor) < 0.05 * factor  # noqa: E731
    peer.until(lambda: states and near(), what=f"states on {topic} at a real-time factor of {factor}")


def test_parameter_files_have_only_parameters_that_there_are(start, peer):
    from test_parameters import NAMES

    for file in (ROOT / "launch_scripts" / "params").glob("*.yaml"):
        def leaves(tree, path=""):
            for key, value in tree.items():
                if isinstance(value, dict):
                    yield from leaves(value, f"{path}{key}.")
                else:
                    yield f"{path}{key}"

        [content] = yaml.safe_load(file.read_text()).values()
        unknown = set(leaves(content["ros__parameters"])) - NAMES
        assert not unknown, file


@pytest.mark.parametrize("lock_step", [False, True])
def test_the_example_controller_damps_the_tip(start, peer, domain, lock_step):
    import time

    parameters = {"real_time_factor": 2.0} if not lock_step else {}
    files = ["--params-file", str(ROOT / "launch_scripts" / "params" / ("lock_step.yaml" if lock_step else "matpoint.yaml"))]
    start(ROOT / "launch_scripts" / "scenes" / "controlled_cantilever.toml", parameters=parameters, ros_args=files)
    controller = subprocess.Popen([sys.executable, str(ROOT / "launch_scripts/controllers/damp_tip.py")], env=environment(domain))
    try:
        states = peer.listen(ComponentState, "/matpoint/state")
        peer.until(lambda: states and states[-1].header.stamp.sec >= 12, 60, "12 s of simulated time")
    finally:
        controller.kill()
        controller.wait()

    def swing(begin, end):
        heights = [s.probes[0].position.y for s in states if begin <= s.header.stamp.sec + 1e-9 * s.header.stamp.nanosec < end]
        return max(heights) - min(heights)

    assert swing(8, 12) < 0.25 * swing(0, 4), (swing(0, 4), swing(8, 12))
    if lock_step:
        # Each step was made with the command that answers the state before it.
        pairs = [(a, b) for a, b in zip(states, states[1:]) if b.steps == a.steps + 1]
        assert len(pairs) > 1000
        for a, b in pairs:
            velocity = a.probes[0].velocity
            assert list(b.loads[0].value) == [-5e3 * velocity.x, -5e3 * velocity.y], (a.steps, len(states))
