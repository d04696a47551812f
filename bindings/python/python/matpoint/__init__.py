"""Elastic solids with the material point method, made to be stepped by somebody else: loads in, `step(dt)`, numpy arrays out.

>>> import matpoint
>>> sim = matpoint.Scene.load("cantilever.toml").build()
>>> while sim.time < 6.0:
...     sim.step(0.01)
>>> sim["particle/position"].shape
(1152, 2)

`sim.describe()` lists every variable with unit, shape and meaning. `matpoint.scene` has a typed dict for each part of a scene,
`matpoint.gym` an environment for Gymnasium, `matpoint.plot` pictures with matplotlib.
"""

import os as _os

from . import scene
from ._matpoint import Description, Recording, Report, Scene, Simulation, Summary, Variable, __version__, _forked
from .errors import ComponentError, Fault, MatpointError, RecordError, SceneError, StepError
from .history import History
from .state import State

if hasattr(_os, "register_at_fork"):
    _os.register_at_fork(after_in_child=_forked)

__all__ = [
    "ComponentError",
    "Description",
    "Fault",
    "History",
    "MatpointError",
    "RecordError",
    "Recording",
    "Report",
    "Scene",
    "SceneError",
    "Simulation",
    "State",
    "StepError",
    "Summary",
    "Variable",
    "__version__",
    "scene",
]
