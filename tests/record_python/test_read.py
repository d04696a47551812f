"""Every frame and value of a run, as other programs read it: from .mcap by two readers, from .rrd by Rerun's, from .pvd by meshio."""

import csv
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

RUNS = Path(os.environ["RUNS"])
# scene, dimension, frames
SCENES = [("bar_1d_vibration", 1, 21), ("cantilever", 2, 51), ("falling_block_3d", 3, 11)]
# lower corner and cell of the grid
CELLS = {"bar_1d_vibration": ([0.0], 0.78125), "cantilever": ([0.0, -3.0], 0.25), "falling_block_3d": ([0.0, 0.0, 0.0], 0.1)}
TYPES = {6: "<u4", 7: "<f4", 8: "<f8"}


def cloud(message):
    """A PointCloud2 as a structured array."""
    fields = [(field.name, TYPES[field.datatype]) for field in message.fields]
    points = np.frombuffer(bytes(message.data), dtype=fields)
    assert len(points) == message.width and points.itemsize == message.point_step
    return points


def seconds(stamp):
    return stamp.sec + 1e-9 * (stamp.nanosec if hasattr(stamp, "nanosec") else stamp.nanosec)


def by_mcap(path):
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        messages = [(channel.topic, message.log_time, decoded) for _, channel, message, decoded in reader.iter_decoded_messages()]
        extra = list(reader.iter_metadata()), list(reader.iter_attachments())
        return reader.get_header(), summary, messages, extra


def by_rosbags(path):
    with AnyReader([path]) as reader:
        return [(connection.topic, time, reader.deserialize(raw, connection.msgtype)) for connection, time, raw in reader.messages()]


def by_rerun(path, dimension):
    """Time [ns], positions, velocity and von Mises stress of each frame; rows of each curve."""
    import rerun.experimental as rerun

    frames, curves, colors = {}, {}, {}
    for chunk in rerun.RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        if chunk.is_static:
            continue
        times = batch.column("sim_time").to_numpy(zero_copy_only=False).astype("int64")
        if chunk.entity_path == "/world/particles":
            for row, time in enumerate(times):
                for name in batch.schema.names:
                    cell = batch.column(name)[row] if ":" in name or name in ("velocity", "von_mises", "body") else None
                    if cell is None or cell.as_py() is None:
                        continue
                    if name.endswith(":positions"):
                        frames.setdefault(time, {})["position"] = cell.values.flatten().to_numpy().reshape(-1, 3 if dimension == 3 else 2)
                    elif name.endswith(":colors"):
                        colors[time] = cell.values.to_numpy()
                    elif ":" not in name:
                        frames.setdefault(time, {})[name] = cell.values.to_numpy()
        elif "Scalars:scalars" in batch.schema.names:
            for row, time in enumerate(times):
                curves.setdefault(chunk.entity_path, {})[time] = batch.column("Scalars:scalars")[row].as_py()
    return dict(sorted(frames.items())), curves, colors


def table(path):
    with path.open() as file:
        rows = list(csv.reader(file))
    return {name: np.array([row[i] for row in rows[1:]]) for i, name in enumerate(rows[0])}


@pytest.mark.parametrize(("scene", "dimension", "count"), SCENES)
def test_every_frame_and_value(scene, dimension, count):
    header, summary, messages, (metadata, attachments) = by_mcap(RUNS / f"{scene}.mcap")
    assert header.profile == "ros2" and {index.compression for index in summary.chunk_indexes} == {"zstd"}
    assert summary.statistics.message_count == len(messages)
    [about] = [record.metadata for record in metadata]
    assert about["version"] and about["method.basis"] and "title" in about["scene"]
    assert any(a.name == "scene.toml" and a.data.decode() == about["scene"] for a in attachments)
    assert any(a.name.startswith("snapshot") for a in attachments)

    again = by_rosbags(RUNS / f"{scene}.mcap")
    assert [(topic, time) for topic, time, _ in again] == [(topic, time) for topic, time, _ in messages]

    clouds = [(time, cloud(message)) for topic, time, message in messages if topic == "/matpoint/particles"]
    others = [cloud(message) for topic, _, message in again if topic == "/matpoint/particles"]
    assert len(clouds) == count
    assert all((ours == theirs).all() for (_, ours), theirs in zip(clouds, others, strict=True))

    frames, curves, colors = by_rerun(RUNS / f"{scene}.rrd", dimension)
    assert list(frames) == [time for time, _ in clouds] and list(colors) == list(frames)
    for (_, points), frame in zip(clouds, frames.values(), strict=True):
        for axis, name in enumerate("xyz"[:dimension]):
            assert (points[name] == frame["position"][:, axis]).all()
            assert (points["v" + name] == frame["velocity"].reshape(-1, dimension)[:, axis]).all()
        assert (points["von_mises"] == frame["von_mises"]).all() and (points["body"] == frame["body"]).all()

    # what the run itself said, in full precision
    particles, history = table(RUNS / f"{scene}-tables/particles.csv"), table(RUNS / f"{scene}-tables/history.csv")
    last = clouds[-1][1]
    for name, column in [("x", "position_x_m"), ("vx", "velocity_x_m_per_s"), ("von_mises", "von_mises_Pa")]:
        assert (last[name] == particles[column].astype(float).astype("f4")).all()
    states = [message for topic, _, message in messages if topic == "/matpoint/state"]
    same = [message for topic, _, message in again if topic == "/matpoint/state"]
    kinetic = history["energy_kinetic_J" if "energy_kinetic_J" in history else next(n for n in history if n.startswith("energy_kinetic"))].astype(float)
    assert (np.array([state.kinetic_energy for state in states]) == kinetic).all()
    assert (np.array([state.kinetic_energy for state in same]) == kinetic).all()
    assert (np.array([value[0] for _, value in sorted(curves["/energy/kinetic"].items())]) == kinetic).all()
    assert np.allclose([seconds(state.header.stamp) for state in states], history["time_s"].astype(float), atol=1e-9)
    for ours, theirs in zip(states, same, strict=True):
        assert [p.name for p in ours.probes] == [p.name for p in theirs.probes]
        for a, b in zip(ours.probes, theirs.probes, strict=True):
            assert (a.displacement.x, list(a.stress)) == (b.displacement.x, list(b.stress))
            column = history[f"probe_{a.name}_displacement_x_m"].astype(float)
            assert a.displacement.x in column


@pytest.mark.parametrize(("scene", "dimension", "count"), SCENES)
def test_paraview(scene, dimension, count):
    import meshio

    files = sorted((RUNS / scene).glob("*.vtu"))
    text = (RUNS / f"{scene}.pvd").read_text()
    assert len(files) == count and all(file.name in text for file in files)
    clouds = [cloud(m) for topic, _, m in by_mcap(RUNS / f"{scene}.mcap")[2] if topic == "/matpoint/particles"]
    for file, points in zip(files, clouds, strict=True):
        mesh = meshio.read(file)
        for axis, name in enumerate("xyz"):
            assert (mesh.points[:, axis] == points[name]).all()
        assert (mesh.point_data["von_mises [Pa]"].ravel() == points["von_mises"]).all()


@pytest.mark.parametrize(("scene", "dimension", "count"), SCENES)
def test_rerun_shows_the_cells_that_hold_particles(scene, dimension, count):
    import rerun.experimental as rerun

    boxes, positions = {}, by_rerun(RUNS / f"{scene}.rrd", dimension)[0]
    for chunk in rerun.RrdReader(RUNS / f"{scene}.rrd").stream().to_chunks():
        if chunk.entity_path == "/world/cells":
            batch = chunk.to_record_batch()
            times = batch.column("sim_time").to_numpy(zero_copy_only=False).astype("int64")
            [centers] = [name for name in batch.schema.names if name.endswith(":centers")]
            boxes.update((time, len(cell)) for time, cell in zip(times, batch.column(centers), strict=True))
    assert sorted(boxes) == list(positions)
    origin, size = CELLS[scene]
    for time, shown in boxes.items():
        held = np.unique(np.floor((positions[time]["position"][:, :dimension] - origin) / size), axis=0)
        assert abs(len(held) - shown) <= 2, "32 bits put a particle beside the cell it is in"


def test_rerun_verifies_and_compares():
    for scene, _, _ in SCENES:
        subprocess.run(["rerun", "rrd", "verify", RUNS / f"{scene}.rrd"], check=True)
