"""What can go wrong. A failed call leaves the simulation as it was."""

from __future__ import annotations

from typing import NamedTuple


class Fault(NamedTuple):
    """One thing that is wrong with a scene."""

    path: str
    """The key, as in `body.beam.shape.box.min[1]`; empty where the scene as a whole is meant."""
    line: int | None
    """Line in the file, from 1; None for scenes that are not text."""
    column: int | None
    """Column in that line, from 1."""
    message: str
    """What is wrong and what would be right."""


class MatpointError(Exception):
    """Any error of matpoint."""


class SceneError(MatpointError):
    """A scene that is not well-formed or makes no sense; the message has every fault, a line each."""

    faults: list[Fault] = []
    """Every fault; empty where the file could not be read."""


class StepError(MatpointError):
    """A step that could not be done. The state is as it was before the call."""

    time: float | None = None
    """Time at which it went wrong [s]."""
    particle: int | None = None
    """The particle with which it went wrong: a row of `particle/position`."""
    position: list[float] | None = None
    """Where it went wrong [m]."""


class ComponentError(MatpointError):
    """A call with wrong words or numbers: unknown variable, wrong shape, not finite, no snapshot of this scene. Nothing was changed."""


class RecordError(MatpointError):
    """A recording that could not be written."""
