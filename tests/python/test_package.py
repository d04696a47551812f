"""The package itself: what it says of itself, and what it needs."""

from __future__ import annotations

import inspect
import json
import re
import subprocess
import sys
from pathlib import Path

from conftest import ROOT

import matpoint

PACKAGE = ROOT / "bindings" / "python"


def test_typed_parts_are_those_of_the_schema() -> None:
    """Where this fails: matpoint schema | python bindings/python/generate_scene.py > bindings/python/python/matpoint/scene.py"""
    schema = json.dumps(matpoint.Scene.schema())
    made = subprocess.run([sys.executable, PACKAGE / "generate_scene.py"], input=schema, capture_output=True, text=True, check=True).stdout
    assert made == (PACKAGE / "python" / "matpoint" / "scene.py").read_text()


def test_version_is_that_of_the_library() -> None:
    found = re.search(r'^version = "(.+)"$', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)
    assert found is not None and matpoint.__version__ == found[1]


def test_everything_public_has_a_doc() -> None:
    for name in matpoint.__all__:
        thing = getattr(matpoint, name)
        if name == "__version__":
            continue
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing) and thing.__module__ == "matpoint":
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    assert inspect.getdoc(value), f"{name}.{member}"


def test_only_numpy_is_needed() -> None:
    program = "import sys, matpoint; print(*(name for name in ('gymnasium', 'matplotlib', 'IPython') if name in sys.modules))"
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert said.strip() == ""


def test_typed_marker_and_stub_are_installed() -> None:
    folder = Path(matpoint.__file__).parent
    assert (folder / "py.typed").exists() and (folder / "_matpoint.pyi").exists()
