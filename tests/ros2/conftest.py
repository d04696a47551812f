"""What the tests share: a node under test, a peer of real ROS beside it. Each test has a domain of its own on this machine."""

import itertools
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time

import pytest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
NODE = os.environ.get("MATPOINT_NODE", str(ROOT / "target" / "release" / "matpoint-node"))
SCENES = HERE / "scenes"
PATIENCE = 15.0  # [s] for discovery and answers on a loaded machine


def environment(domain, **more):
    env = dict(os.environ, ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST")
    env.pop("ROS_LOCALHOST_ONLY", None)
    env.update({k: str(v) for k, v in more.items()})
    return env


def free(domain):
    """Whether nobody is there: the first participant of a domain takes this port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", 7400 + 250 * domain + 10))
        except OSError:
            return False
    return True


# Those up to 101 keep clear of the ports that Linux hands out. Each process begins elsewhere: two test runs at once do not meet.
DOMAINS = filter(free, itertools.cycle(1 + (os.getpid() * 7 + i) % 100 for i in range(100)))


class Node:
    """A matpoint-node."""

    def __init__(self, domain, scene="tip.toml", parameters=None, ros_args=(), args=(), env=None):
        self.log = tempfile.NamedTemporaryFile("w+", suffix=".log", delete=False)
        command = [NODE, str(SCENES / scene), *args, "--ros-args", *ros_args]
        for name, value in (parameters or {}).items():
            command += ["-p", f"{name}:={value}"]
        self.process = subprocess.Popen(command, env=env or environment(domain), stdout=self.log, stderr=self.log)

    def said(self):
        return pathlib.Path(self.log.name).read_text()

    def memory(self):
        """Resident memory [MB]."""
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
        return 0.0

    def threads(self):
        return len(list(pathlib.Path(f"/proc/{self.process.pid}/task").iterdir()))

    def files(self):
        return len(list(pathlib.Path(f"/proc/{self.process.pid}/fd").iterdir()))

    def stop(self, number=signal.SIGINT, within=10.0):
        if self.process.poll() is None:
            self.process.send_signal(number)
            try:
                self.process.wait(within)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
                raise
        return self.process.returncode


class Peer:
    """A node of real ROS in this process."""

    def __init__(self, domain, name="peer"):
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self.rclpy = rclpy
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node(name, context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.02)

    def until(self, condition, within=PATIENCE, what=None):
        end = time.monotonic() + within
        while not condition():
            assert time.monotonic() < end, f"not within {within} s: {what or condition}"
            self.executor.spin_once(timeout_sec=0.02)

    def listen(self, kind, topic, qos=10):
        messages = []
        self.node.create_subscription(kind, topic, messages.append, qos)
        return messages

    def listen_timed(self, kind, topic, qos=10):
        """Like `listen`, with the wall time [s] at which each was sent."""
        messages = []
        self.node.create_subscription(kind, topic, lambda m, info: messages.append((m, 1e-9 * info["source_timestamp"])), qos)
        return messages

    def client(self, kind, name):
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(PATIENCE), f"no service {name}"
        self.spin(0.5)  # the server must have found our reader too
        return client

    def call(self, kind, service, /, within=PATIENCE, **request):
        client = self.client(kind, service) if isinstance(service, str) else service
        future = client.call_async(kind.Request(**request))
        self.until(future.done, within, f"answer of {service}")
        return future.result()

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.rclpy.shutdown(context=self.context)


@pytest.fixture
def domain():
    return next(DOMAINS)


@pytest.fixture
def start(domain):
    """Starts nodes that end with the test."""
    nodes = []

    def begin(*args, **kwargs):
        nodes.append(Node(domain, *args, **kwargs))
        return nodes[-1]

    yield begin
    for node in nodes:
        if node.process.poll() is None:
            node.process.kill()
            node.process.wait()
        sys.stdout.write(node.said())


@pytest.fixture
def beside(domain):
    """Runs Python code in processes that end with the test; each says "ready" first."""
    processes = []

    def begin(code, env=None):
        processes.append(subprocess.Popen([sys.executable, "-c", code], env=env or environment(domain), stdout=subprocess.PIPE, text=True))
        assert processes[-1].stdout.readline() == "ready\n"
        return processes[-1]

    yield begin
    for process in processes:
        process.kill()
        process.wait()


@pytest.fixture
def peer(domain):
    peer = Peer(domain)
    yield peer
    peer.close()


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def pace(timed):
    """Simulated over wall time, of pairs of both [s]. The least lag of the first quarter against that of the last: a lag that the node makes
    up for does not count, nor does the time that a message took to come here. Both happen on a machine that others use too."""
    quarter = len(timed) // 4
    first, last = timed[:quarter], timed[-quarter:]
    lost = min(wall - time for time, wall in last) - min(wall - time for time, wall in first)
    return 1.0 - lost / (last[0][1] - first[0][1])
