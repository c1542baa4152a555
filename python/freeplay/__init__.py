"""Freeplay: the dynamics of planar mechanisms whose joints have clearance, in two formulations
of one scene.

    import freeplay as fp
    scene = fp.read_scene("scene.toml")
    scene["joints.gudgeon.clearance"] = 1e-3        # m
    result = fp.run(scene, "nonsmooth")             # or fp.compare(scene), fp.sweep("study.toml")
    result.events                                   # a pandas frame with the columns of events.csv
    result.info["energy_J"]                         # the content of run.json

All quantities are in SI units and radians. docs/tutorials/python.md is the guide; freeplay.plots draws
figures.
"""

from . import _freeplay
from .errors import (
    DoubtfulWarning,
    FailedWarning,
    FreeplayError,
    Interrupted,
    OutputError,
    SceneError,
    SnapshotError,
)
from .motions import (
    Branches,
    LoadedPoses,
    Lyapunov,
    Orbit,
    Play,
    PlayRange,
    Sensitivities,
    continue_orbit,
    lyapunov,
    orbit,
    play,
    sensitivity,
)
from .results import Comparison, Run, read_comparison, read_run
from .running import Simulation, Stop, check, compare, run
from .scene import Scene, Table, read_scene
from .studies import Study, read_study, sweep

#: Version of the program that computes the results.
__version__ = _freeplay.version()

__all__ = [
    "Branches",
    "Comparison",
    "DoubtfulWarning",
    "FailedWarning",
    "FreeplayError",
    "Interrupted",
    "LoadedPoses",
    "Lyapunov",
    "Orbit",
    "OutputError",
    "Play",
    "PlayRange",
    "Run",
    "Scene",
    "SceneError",
    "Sensitivities",
    "Simulation",
    "SnapshotError",
    "Stop",
    "Study",
    "Table",
    "check",
    "compare",
    "continue_orbit",
    "lyapunov",
    "orbit",
    "play",
    "read_comparison",
    "read_run",
    "read_scene",
    "read_study",
    "run",
    "sensitivity",
    "sweep",
]
