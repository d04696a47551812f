"""The core topics with Cyclone DDS, by its Python binding: it knows the conventions of ROS on the wire, and nothing of Fast DDS."""

import json

from conftest import environment

CYCLONE = r'''
import json, time, os
from dataclasses import dataclass
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint8, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32
@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str
@dataclass
class PointField(IdlStruct, typename="sensor_msgs::msg::dds_::PointField_"):
    name: str
    offset: uint32
    datatype: uint8
    count: uint32
@dataclass
class PointCloud2(IdlStruct, typename="sensor_msgs::msg::dds_::PointCloud2_"):
    header: Header
    height: uint32
    width: uint32
    fields: sequence[PointField]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool
@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64
@dataclass
class Vector3Stamped(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3Stamped_"):
    header: Header
    vector: Vector3
@dataclass
class Clock(IdlStruct, typename="rosgraph_msgs::msg::dds_::Clock_"):
    clock: Time

def qos(reliability, depth):
    return Qos(reliability, Policy.History.KeepLast(depth), Policy.DataRepresentation(use_cdrv0_representation=True))

reliable = Policy.Reliability.Reliable(duration(seconds=1))
participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
topic = Topic(participant, "rt/matpoint/particles", PointCloud2)
readers = {}
for name, policy in (("reliable", reliable), ("best_effort", Policy.Reliability.BestEffort)):
    quality = qos(policy, 10)
    readers[name] = DataReader(participant, topic, qos=quality)
quality = qos(reliable, 100)
clock = DataReader(participant, Topic(participant, "rt/clock", Clock, qos=quality), qos=quality)
writer = DataWriter(participant, Topic(participant, "rt/matpoint/load/tip", Vector3Stamped, qos=quality), qos=quality)
print("ready", flush=True)
got, clocks, fields, whole, end = {"reliable": [], "best_effort": []}, [], None, True, None
while end is None or time.monotonic() < end:
    for name, reader in readers.items():
        for m in reader.take(20):
            got[name].append(m.header.stamp.sec * 10**9 + m.header.stamp.nanosec)
            fields = [f.name for f in m.fields]
            whole = whole and len(m.data) == m.width * m.point_step
            end = end or time.monotonic() + 6
    clocks += [c.clock.sec * 10**9 + c.clock.nanosec for c in clock.take(100)]
    writer.write(Vector3Stamped(Header(Time(0, 0), ""), Vector3(0.0, -1000.0, 0.0)))
    time.sleep(0.002)
print(json.dumps({"got": got, "clocks": clocks, "fields": fields, "whole": whole}))
'''


def test_particles_clock_and_loads_with_cyclone_dds(start, peer, beside, domain):
    from matpoint_msgs.msg import ComponentState

    env = environment(domain, CYCLONEDDS_URI="<General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces></General>")
    process = beside(CYCLONE, env)
    start("tip.toml", parameters={"particles.rate": 0.0, "step": 1 / 60})
    states = peer.listen(ComponentState, "/matpoint/state")
    peer.until(lambda: any(s.loads[0].value[1] == -1000.0 for s in states), 30, "load set by Cyclone DDS")
    peer.spin(7.0)
    out = json.loads(process.communicate(timeout=60)[0])
    for name, stamps in out["got"].items():
        span = (stamps[-1] - stamps[0]) * 1e-9 * 60 + 1
        print(f"Cyclone DDS {name}: {len(stamps)} clouds of {span:.0f}, {len(out['clocks'])} clocks")
        assert stamps == sorted(set(stamps)) and span > 200 and len(stamps) > 0.8 * span
    assert out["whole"] and out["fields"] == ["x", "y", "z", "von_mises"]
    assert len(out["clocks"]) > 200 and out["clocks"] == sorted(out["clocks"])
