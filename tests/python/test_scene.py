"""Scenes from files, text, dicts and keyword arguments, and what is said about those that are wrong."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, SCENES, beam

import matpoint
from matpoint import Scene, SceneError
from matpoint.scene import Body, Grid, Material, Time

FILE = ROOT / "tests" / "same_bytes" / "scene.toml"


def test_every_way_gives_the_same_scene() -> None:
    scene = Scene.load(FILE)
    assert scene == Scene.load(str(FILE)) == beam() == Scene.from_toml(FILE.read_text())
    for other in (Scene.from_json(scene.to_json()), Scene.from_toml(scene.to_toml()), Scene.from_dict(scene.to_dict())):
        assert other == scene
    assert Scene(**scene.to_dict()) == scene
    assert (scene.title, scene.dimension, scene.end) == ("the same from TOML, Rust and Python", 2, 1.0)
    assert scene != Scene.load(FILE, set={"grid.cell": 0.25})


def test_pickles_and_copies() -> None:
    scene = beam()
    for other in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene), copy.copy(scene)):
        assert other == scene


def test_values_are_set_in_a_file() -> None:
    scene = Scene.load(FILE, set={"grid.cell": 0.25, "method.transfer": "flip", "body.beam.velocity": [0, "0.2*x"], "time": {"end": 2}})
    keys = scene.to_dict()
    assert keys["grid"]["cell"] == 0.25 and keys["method"]["transfer"] == "flip" and scene.end == 2.0
    assert keys["body"]["beam"]["velocity"][1] == "0.2*x"
    with pytest.raises(SceneError, match=r"--set method.transfer=\"apik\".*did you mean `apic`"):
        Scene.load(FILE, set={"method.transfer": "apik"})


def test_arrays_numbers_of_numpy_and_none() -> None:
    scene = beam(
        grid=Grid(origin=np.array([0.0, -2.0]), size=np.array([5, 4]), cell=np.float64(0.5)),
        load={"weight": {"gravity": np.array([0.0, -9.81])}, "tip": beam().to_dict()["load"]["tip"]},
        contact=None,
    )
    assert scene == beam()


def test_odd_text_survives() -> None:
    title = 'quotes " and \\ and \t tab, new\nline, é ü 漢 \u007f'
    assert beam(title=title).title == title
    with pytest.raises(SceneError, match=r'probe.a "b" c: the name .* must be made of'):
        beam(probe={'a "b" c': {"at": [4.0, 0.5]}})


def test_every_fault_at_once_with_its_place() -> None:
    text = FILE.read_text().replace("young = 1e6", "young = -1e6").replace("cell = 0.5", "cell = 0.3")
    with pytest.raises(SceneError) as caught:
        Scene.from_toml(text)
    faults = caught.value.faults
    assert [fault.path for fault in faults] == ["grid.size[0]", "grid.size[1]", "material.rubber.young"] or len(faults) >= 2
    young = next(fault for fault in faults if fault.path == "material.rubber.young")
    assert young.line == 4 and young.column is not None and "must be above 0" in young.message
    assert str(caught.value).count("\n") == len(faults) - 1


def test_faults_of_a_dict_name_the_key_and_no_line() -> None:
    with pytest.raises(SceneError) as caught:
        beam(grid={"origin": [0, 0], "size": [float("nan"), 4], "cel": 0.5})
    faults = {fault.path: fault for fault in caught.value.faults}
    assert all(fault.line is None for fault in faults.values())
    assert "must be a finite number" in faults["grid.size[0]"].message
    assert any("did you mean `cell`" in fault.message for fault in faults.values())
    with pytest.raises(SceneError, match="title: is missing"):
        Scene()  # type: ignore[call-arg]


def test_faults_that_show_when_built_have_their_place_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(FILE.read_text().replace("end = 1.0", "end = 1.0, step = 0.5"))
    scene = Scene.load(path)
    with pytest.raises(SceneError, match=r"scene.toml:11:\d+: time.step: is 0.5 s, above the stable step"):
        scene.check()
    with pytest.raises(SceneError, match=r"time.step: is 0.5 s"):
        scene.build()
    assert beam().check() == []


def test_warnings_are_returned() -> None:
    (warning,) = beam(method={"mass": "consistent"}).check()
    assert warning.startswith("method.mass: is not lumped")


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ({1: 2}, "grid: keys are text, not a int"),
        (object(), "grid: cannot be a object"),
        ({"origin": [0, {1, 2}]}, r"grid.origin\[1\]: cannot be a set"),
        ({"origin": [0, 1j]}, r"grid.origin\[1\]: cannot be a complex"),
        ({"origin": [0, None]}, r"grid.origin\[1\]: cannot be a NoneType"),
    ],
)
def test_what_is_no_scene_is_refused_by_type(value: object, message: str) -> None:
    with pytest.raises(TypeError, match=message):
        beam(grid=value)


def test_what_contains_itself_is_refused() -> None:
    endless: dict[str, object] = {}
    endless["grid"] = endless
    with pytest.raises(TypeError, match="nested deeper"):
        Scene.from_dict(endless)
    with pytest.raises(SceneError, match="is 9{39}|whole number|is not"):
        beam(dimension=int("9" * 39))


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be read") as caught:
        Scene.load(tmp_path / "none.toml")
    assert caught.value.faults == []
    with pytest.raises(SceneError, match="must end in .toml or .json"):
        Scene.load(tmp_path / "scene.yaml")
    with pytest.raises(TypeError):
        Scene.load(7)  # type: ignore[arg-type]


def test_the_scenes_of_the_repository_load() -> None:
    paths = sorted(SCENES.glob("*.toml"))
    assert len(paths) >= 6
    for path in paths:
        assert Scene.load(path).title


def test_schema_and_words() -> None:
    assert Scene.schema()["properties"]["dimension"]["type"] == "integer"
    scene = beam()
    assert "dimension 2" in repr(scene) and Scene.from_toml(str(scene)) == scene


def test_parts_are_dicts() -> None:
    assert Time(end=1.0) == {"end": 1.0}
    part: Body = Body(material="m", shape={"disk": {"center": [0, 0], "radius": 1.0}})
    assert part["shape"] == {"disk": {"center": [0, 0], "radius": 1.0}}
    assert Material(law="hencky", young=1.0, density=1.0)["law"] == "hencky"
    assert "Grid" in matpoint.scene.__all__
