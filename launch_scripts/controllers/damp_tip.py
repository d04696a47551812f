#!/usr/bin/env python3
"""Damps the tip of the cantilever: traction against its velocity, once a state. Needs rclpy, geometry_msgs and matpoint_msgs.

    python3 launch_scripts/controllers/damp_tip.py --ros-args -p gain:=5e3

In lock-step (params/lock_step.yaml) the first command starts the exchange, and every run gives the same bytes.
"""

import rclpy
from geometry_msgs.msg import Vector3Stamped
from matpoint_msgs.msg import ComponentState
from rclpy.node import Node


class DampTip(Node):
    """Listens to NODE/state, commands NODE/load/LOAD."""

    def __init__(self):
        super().__init__("damp_tip")
        node, load = (self.declare_parameter(name, value).value for name, value in (("node", "matpoint"), ("load", "tip")))
        self.probe = self.declare_parameter("probe", "tip").value
        self.declare_parameter("gain", 5e3)  # [Pa s/m]
        self.command = self.create_publisher(Vector3Stamped, f"{node}/load/{load}", 10)
        self.create_subscription(ComponentState, f"{node}/state", self.control, 10)

    def control(self, state):
        """Pushes against the velocity."""
        velocity = next(probe.velocity for probe in state.probes if probe.name == self.probe)
        gain = self.get_parameter("gain").value
        command = Vector3Stamped(header=state.header)
        command.vector.x, command.vector.y = -gain * velocity.x, -gain * velocity.y
        self.command.publish(command)


def main():
    """Until interrupted."""
    rclpy.init()
    node = DampTip()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
