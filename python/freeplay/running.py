"""Runs, comparisons and checks of a scene."""

from __future__ import annotations

import inspect
import os
import signal
import tempfile
import threading
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

from . import _freeplay
from .errors import DoubtfulWarning, FailedWarning, Interrupted
from .results import Comparison, FolderRun, MemoryRun, Run
from .scene import PathLike, Scene, read_scene

SceneLike = Union[Scene, Mapping[str, Any], str, "os.PathLike[str]"]
Watch = Callable[[dict[str, Any]], Any]
Law = Union[Callable[[str, float, float, float], float], str, "os.PathLike[str]"]
LoadForce = Callable[[float, tuple[float, float], tuple[float, float]], Sequence[float]]
Loads = Mapping[str, LoadForce]


class Stop:
    """A flag that ends a run after its current step. An observer or another thread may set it.

    >>> stop = fp.Stop(); ...; stop.set()
    """

    def __init__(self) -> None:
        self._flag = _freeplay.StopFlag()

    def set(self) -> None:
        """Requests the end of all runs that have this flag."""
        self._flag.set()

    def is_set(self) -> bool:
        """Whether the flag is set."""
        return self._flag.is_set()


def _scene(scene: SceneLike) -> Scene:
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return Scene(scene)
    return read_scene(scene)


def _with_own(scene: Scene, formulation: Optional[str], law: Optional[Law], loads: Optional[Loads]) -> Scene:
    """A copy of the scene with user-defined normal force of contacts and forces of loads."""
    if law is None and not loads:
        return scene
    own, normal = scene.copy(), False
    if callable(law):
        own._handle.take_function(law, _name_of(law), _text_of(law))
        normal = True
    elif law is not None:
        normal = own._handle.take_plugin(Path(os.fspath(law)))
    if normal and formulation != "penalty":
        raise ValueError("law: an impact law has no normal force; it is of the formulation 'penalty'")
    for load, force in (loads or {}).items():
        own._handle.take_load(load, force, _name_of(force), _text_of(force))
    return own


def _name_of(function: Callable[..., Any]) -> str:
    return getattr(function, "__qualname__", type(function).__name__)


def _text_of(function: Callable[..., Any]) -> str:
    """Text that identifies a function: its source, or its byte code if there is no source, with
    defaults and enclosed values."""
    try:
        text = inspect.getsource(function)
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        text = repr((code.co_code, code.co_consts, code.co_names)) if code else repr(function)
    enclosed = [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
    return text + repr((getattr(function, "__defaults__", None), getattr(function, "__kwdefaults__", None), enclosed))


def _here() -> bool:
    return threading.current_thread() is threading.main_thread()


def _formulation(name: str) -> str:
    if name not in ("penalty", "nonsmooth"):
        raise ValueError(f"formulation: must be 'penalty' or 'nonsmooth', is {name!r}")
    return name


def _interrupt(result: Any) -> None:
    """Handles a Ctrl-C that was pressed during a run as Python would; Interrupted carries the
    partial result."""
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise Interrupted("interrupted", result) from None


def _tell(info_notes: list[str], status: str, reason: str) -> None:
    for note in info_notes:
        if note.startswith(("warning: ", "DOUBTFUL")):  # the latter: earlier versions
            warnings.warn(note, DoubtfulWarning, stacklevel=4)
    if status == "failed":
        warnings.warn(reason, FailedWarning, stacklevel=4)


def _finish(record: "_freeplay.Record") -> MemoryRun:
    run = MemoryRun(record)
    if record.pressed:
        _interrupt(run)
    _tell(record.notes, run.status, record.reason)
    return run


def run(
    scene: SceneLike,
    formulation: str,
    *,
    set: Optional[Mapping[str, Any]] = None,
    forces: bool = False,
    matched: bool = False,
    law: Optional[Law] = None,
    loads: Optional[Loads] = None,
    companion: bool = True,
    on_event: Optional[Watch] = None,
    on_row: Optional[Watch] = None,
    stop: Optional[Stop] = None,
    output: Optional[PathLike] = None,
) -> Run:
    """Solves a scene in one formulation, as `freeplay run` does, with bitwise identical results.

    scene: a Scene, a nested mapping, or the path of a scene file.
    formulation: "penalty" or "nonsmooth".
    set: dotted keys and values for this run only; the scene is not changed.
    forces: also record the forces, as run.forces = true does.
    matched: the impact law uses the restitution that the scene's penalty law yields, as in
        compare().
    law: normal force of the contacts in the penalty formulation, replaces penalty.contact.
        Either a function law(contact, penetration, rate, touch_speed) that returns N, with the
        name of the contact, the penetration δ > 0 (m), its rate δ̇ (m/s) and the speed at
        contact onset v₀ > 0 (m/s); or the file of a compiled plugin (docs/reference/library.md), which is
        faster. A negative value counts as 0. At rate 0 the force must depend on δ only and grow
        with it.
    loads: forces of loads of type "force", by name; each replaces the force in the scene: f(t,
        place, velocity) -> (Fx, Fy) in N along the axes of the load, with t in s, and position
        (m) and velocity (m/s) of the loaded point in the world frame as tuples.
    companion: after a time-stepped run, a short run at a smaller step estimates the error of the
        first contact onsets.
    on_event: called with each final event, a dict with the columns of events.csv.
    on_row: called with each row of the trajectory, a dict with its columns. Both functions may
        return True to end the run after its current step. An exception that they raise ends the
        run at once and is raised here. They are not called in every internal step.
    stop: a Stop that another thread may set.
    output: a folder for the files of `freeplay run`; without it nothing is written.

    Returns a Run: .trajectory, .events, .forces, .signals (pandas, SI units), .info (run.json).
    Ctrl-C raises Interrupted (a KeyboardInterrupt), whose .result is complete up to the last
    step. A numerical failure raises no exception: .status is "failed", and a FailedWarning
    states the reason. A warning of the run becomes a DoubtfulWarning. Raises SceneError for an
    incomplete or contradictory scene.

    >>> result = fp.run("scene.toml", "nonsmooth", set={"joints.gudgeon.clearance": 1e-3})
    >>> result.events[result.events.kind == "impact"].impulse_n.max()      # N s
    """
    given: dict[str, Any] = dict(set or {})
    if forces:
        given["run.forces"] = True
    wanted = _scene(scene)
    if given:
        wanted = wanted.with_(given)
    wanted = _with_own(wanted, _formulation(formulation), law, loads)
    flag = (stop or Stop())._flag
    if output is None:
        simulation = _freeplay.Simulation(wanted._handle, _formulation(formulation), matched, flag, _here())
        return _finish(simulation.run(None, on_event, on_row, flag, _here(), companion))
    if on_event is not None or on_row is not None:
        raise ValueError("output: observers are called in runs that stay in memory; leave one of both out")
    folder = Path(os.fspath(output))
    pressed = _freeplay.run_into(wanted._handle, _formulation(formulation), folder, matched, companion, flag, _here())
    there = FolderRun(folder)
    if pressed:
        _interrupt(there)
    _tell(there.info["notes"], there.status, there.info["ending"]["reason"])
    return there


def compare(
    scene: SceneLike,
    *,
    set: Optional[Mapping[str, Any]] = None,
    forces: bool = False,
    matched: bool = True,
    loads: Optional[Loads] = None,
    stop: Optional[Stop] = None,
    output: Optional[PathLike] = None,
) -> Comparison:
    """Solves a scene in both formulations and compares the results, as `freeplay compare` does.

    matched: True: the impact law uses the restitution that the penalty law yields; False: that
        of the scene (--as-given).
    output: folder for the files; by default a temporary folder, which is deleted with the
        Comparison.
    The other arguments are those of run().

    Returns a Comparison: .penalty, .nonsmooth, .ideal (runs), .info, .table.
    """
    given: dict[str, Any] = dict(set or {})
    if forces:
        given["run.forces"] = True
    wanted = _scene(scene)
    if given:
        wanted = wanted.with_(given)
    wanted = _with_own(wanted, None, None, loads)
    keep = tempfile.TemporaryDirectory(prefix="freeplay-") if output is None else None
    folder = Path(keep.name if keep else os.fspath(output))  # type: ignore[arg-type]
    flag = (stop or Stop())._flag
    pressed = _freeplay.compare_into(wanted._handle, folder, matched, flag, _here())
    if pressed:
        _interrupt(None)
    if flag.is_set():
        raise Interrupted()
    return Comparison(folder, keep)


def check(scene: SceneLike, *, set: Optional[Mapping[str, Any]] = None) -> dict[str, Any]:
    """Size and properties of a scene, as printed by `freeplay check`: bodies, coordinates,
    constraint_rows, redundant_rows, degrees_of_freedom, contacts, duration_s (s), ..., and for
    each formulation the restitution that it yields in each contact, or a text with the reason
    why the formulation is not available. Raises SceneError."""
    wanted = _scene(scene)
    if set:
        wanted = wanted.with_(set)
    return _freeplay.check(wanted._handle)


class Simulation:
    """A simulation of a scene that can be interrupted, continued, saved and restored.

    >>> simulation = fp.Simulation(scene, "nonsmooth")
    >>> first = simulation.run(until=0.1); simulation.snapshot("here.snapshot")
    >>> rest = simulation.run(); simulation.restore("here.snapshot")

    An object must not be used by two threads at a time.
    """

    def __init__(
        self,
        scene: SceneLike,
        formulation: str,
        *,
        matched: bool = False,
        law: Optional[Law] = None,
        loads: Optional[Loads] = None,
        set: Optional[Mapping[str, Any]] = None,
    ) -> None:
        wanted = _scene(scene)
        if set:
            wanted = wanted.with_(set)
        self.scene = _with_own(wanted, _formulation(formulation), law, loads).copy()
        self._it = _freeplay.Simulation(self.scene._handle, _formulation(formulation), matched, Stop()._flag, _here())

    def run(
        self,
        until: Optional[float] = None,
        *,
        on_event: Optional[Watch] = None,
        on_row: Optional[Watch] = None,
        stop: Optional[Stop] = None,
    ) -> Run:
        """Continues to `until` (s; default: the end of the scene's run). The tables cover this
        interval only."""
        return _finish(self._it.run(until, on_event, on_row, (stop or Stop())._flag, _here(), False))

    @property
    def t(self) -> float:
        """Current time, s."""
        return self._it.state()[0]

    @property
    def q(self) -> Any:
        """Copy of the coordinates: x, y (m) and theta (rad) of each body."""
        return self._it.state()[1]

    @property
    def v(self) -> Any:
        """Copy of the velocities: the rates of the coordinates (m/s, rad/s)."""
        return self._it.state()[2]

    def snapshot(self, file: PathLike) -> None:
        """Writes the complete state to a file."""
        self._it.snapshot(Path(os.fspath(file)))

    def restore(self, file: PathLike) -> None:
        """Restores a state bit for bit. Raises SnapshotError if the snapshot belongs to another
        simulation."""
        self._it.restore(Path(os.fspath(file)))
