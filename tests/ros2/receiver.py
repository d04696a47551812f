"""Receives ~/particles in a process of its own and prints what came, as JSON.

    receiver.py TOPIC reliable|best_effort SECONDS [--depth N]
"""

import argparse
import json
import time

import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("topic")
    arguments.add_argument("reliability")
    arguments.add_argument("seconds", type=float)
    arguments.add_argument("--depth", type=int, default=5)
    a = arguments.parse_args()
    rclpy.init()
    node = rclpy.create_node("receiver")
    policy = ReliabilityPolicy.RELIABLE if a.reliability == "reliable" else ReliabilityPolicy.BEST_EFFORT
    stamps, numbers, widths, latencies, lengths = [], [], [], [], set()

    def take(message, info):
        latencies.append(1e-6 * (time.time_ns() - info["source_timestamp"]))  # from the call of publish to here [ms]
        stamps.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)
        numbers.append(info["publication_sequence_number"])
        widths.append(message.width)
        lengths.add(len(message.data) == message.width * message.point_step == message.row_step)

    node.create_subscription(PointCloud2, a.topic, take, QoSProfile(depth=a.depth, reliability=policy))
    print("ready", flush=True)
    end, first = None, None
    while end is None or time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.05)
        if end is None and stamps:
            first = time.monotonic()
            end = first + a.seconds
    latencies.sort()
    n = len(latencies)
    print(json.dumps({
        "count": n, "stamps": stamps, "numbers": numbers, "widths": sorted(set(widths)), "points": sum(widths), "whole": lengths == {True},
        "median": latencies[n // 2], "p99": latencies[n * 99 // 100], "max": latencies[-1], "wall": time.monotonic() - first,
    }))
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
