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
    """A flag that ends a run after its present step, set from an observer or another thread.

    >>> stop = fp.Stop(); ...; stop.set()
    """

    def __init__(self) -> None:
        self._flag = _freeplay.StopFlag()

    def set(self) -> None:
        """Asks all runs that were given this flag to end."""
        self._flag.set()

    def is_set(self) -> bool:
        """Whether it was."""
        return self._flag.is_set()


def _scene(scene: SceneLike) -> Scene:
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return Scene(scene)
    return read_scene(scene)


def _with_own(scene: Scene, formulation: Optional[str], law: Optional[Law], loads: Optional[Loads]) -> Scene:
    """A copy with this normal force of contacts and these forces of loads."""
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
    """What tells a function from others: its source, or byte code where it has none, with its defaults and what it encloses."""
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
    """Ctrl-C was pressed meanwhile: what Python would have done then, with what was made until then."""
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise Interrupted("interrupted", result) from None


def _tell(info_notes: list[str], status: str, reason: str) -> None:
    for note in info_notes:
        if note.startswith("DOUBTFUL"):
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
    """Solves a scene in one formulation, as `freeplay run` does, with the same digits.

    scene: a Scene, a nested mapping, or the path of a scene file.
    formulation: "penalty" or "nonsmooth".
    set: dotted keys and values for this run alone; the scene stays as it is.
    forces: record the forces too, as run.forces = true does.
    matched: an impact law takes the restitution that the scene's penalty law delivers, as compare() does.
    law: of the penalty formulation: the normal force of contacts in place of penalty.contact, law(contact, penetration, rate,
        touch_speed) in N with the contact's name, δ > 0 (m), δ̇ (m/s) and v₀ > 0 (m/s), for trials; or the file of a
        compiled plugin (docs/reference/library.md), for speed. Less than 0 counts as 0; with rate 0 it must be of δ alone and grow with it.
    loads: of loads of type "force", by name: the force in place of what the scene says, f(t, place, velocity) -> (Fx, Fy) in N
        along the load's axes, with t in s and the loaded point's place (m) and velocity (m/s) in the world, as tuples.
    companion: after a time-stepped run, a short one at a smaller step says how far the first touches may be off.
    on_event: called with each settled event, a dict with the columns of events.csv.
    on_row: called with each row of the trajectory, a dict with its columns. Either may return True to end the run after
        its present step; what they raise ends it at once and comes out here. They are never called per inner step.
    stop: a Stop that another thread may set.
    output: a folder for the files of `freeplay run`; without one nothing is written.

    Returns a Run: .trajectory, .events, .forces, .signals (pandas, SI units), .info (run.json).
    Ctrl-C raises Interrupted (a KeyboardInterrupt), whose .result is whole up to the step that it ended.
    A numerical failure is no exception: .status is "failed", and a FailedWarning says why. A note DOUBTFUL is a
    DoubtfulWarning. Throws SceneError for a scene that lacks or contradicts something.

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
    """Solves a scene in both formulations and says how far they agree, as `freeplay compare` does.

    matched: the impact law takes the restitution that the penalty law delivers; False: the one asked for (--as-given).
    output: folder for its files; without one they lie in a temporary folder, which goes with the Comparison.
    The other arguments are those of run(). Returns a Comparison: .penalty, .nonsmooth, .ideal (runs), .info, .table.
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
    """What a scene makes the solver carry, as `freeplay check` says: bodies, coordinates, constraint_rows, redundant_rows,
    degrees_of_freedom, contacts, duration_s (s), ..., and of each formulation the restitution that it delivers in each
    contact, or a text that says why it is not available. Throws SceneError."""
    wanted = _scene(scene)
    if set:
        wanted = wanted.with_(set)
    return _freeplay.check(wanted._handle)


class Simulation:
    """A scene that moves, for those who want to stop midway, go on, or go back.

    >>> simulation = fp.Simulation(scene, "nonsmooth")
    >>> first = simulation.run(until=0.1); simulation.snapshot("here.snapshot")
    >>> rest = simulation.run(); simulation.restore("here.snapshot")

    One thread at a time; make one for each thread.
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
        """Goes on to `until` (s; default the scene's end). The tables are those of this stretch."""
        return _finish(self._it.run(until, on_event, on_row, (stop or Stop())._flag, _here(), False))

    @property
    def t(self) -> float:
        """s, now."""
        return self._it.state()[0]

    @property
    def q(self) -> Any:
        """x, y (m) and theta (rad) of each body, a copy."""
        return self._it.state()[1]

    @property
    def v(self) -> Any:
        """Their rates (m/s, rad/s), a copy."""
        return self._it.state()[2]

    def snapshot(self, file: PathLike) -> None:
        """Writes all that the future depends on."""
        self._it.snapshot(Path(os.fspath(file)))

    def restore(self, file: PathLike) -> None:
        """Goes back, bit for bit. Throws SnapshotError for a snapshot of something else."""
        self._it.restore(Path(os.fspath(file)))
