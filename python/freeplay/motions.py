"""Derivatives of runs, periodic motions, their branches, Lyapunov exponents, and output play."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from . import _freeplay
from .errors import Interrupted
from .running import SceneLike, Stop, _here, _interrupt, _scene


def _searched(stop: Optional[Stop], call: Callable[[_freeplay.StopFlag], dict[str, Any]]) -> dict[str, Any]:
    flag = (stop or Stop())._flag
    found = call(flag)
    if found["pressed"]:
        _interrupt(None)
    if flag.is_set():
        raise Interrupted()
    return found


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of results of a run, in SI units.

    values: a Series, quantity to value.
    keys: a Series, key to value.
    jacobian: a frame with one row per quantity and one column per key; NaN where there is no derivative.
    reasons: a frame of the same shape; the reason where there is no derivative, else "".
    errors: a frame of the same shape; the estimated error of each derivative, inf if a run with other
        settings has none.
    stopped: the reason why the run stopped before its end, or "".
    influence: (p/Q) dQ/dp, a frame of the same shape: the relative change of a quantity for a relative change
        of a key. NaN where the value is zero: below 1e-10 of the greatest p dQ/dp.
    """

    values: pd.Series
    keys: pd.Series
    jacobian: pd.DataFrame
    reasons: pd.DataFrame
    errors: pd.DataFrame
    stopped: str
    influence: pd.DataFrame


def sensitivity(
    scene: SceneLike,
    of: Sequence[str],
    to: Sequence[str],
    formulation: str = "nonsmooth",
    *,
    set: Optional[Mapping[str, Any]] = None,
    stop: Optional[Stop] = None,
) -> Sensitivities:
    """Runs a scene with its variational equations, as `freeplay sensitivity` does.

    of: quantities, such as "event.1.t", "end.slider.x", "energy.dissipated_in_contacts".
    to: keys of the scene with one number, such as "joints.gudgeon.clearance", or "initial.slider.vx".

    Returns Sensitivities. Raises SceneError for an unknown quantity or key.
    """
    wanted = _scene(scene)
    if set:
        wanted = wanted.with_(set)
    found = _searched(
        stop, lambda flag: _freeplay.sensitivities_of(wanted._handle, list(of), list(to), formulation, flag, _here())
    )
    quantities, keys = found["quantities"], [key["name"] for key in found["keys"]]
    names = [q["name"] for q in quantities]

    def frame(part: str) -> pd.DataFrame:
        return pd.DataFrame([q[part] for q in quantities], index=names, columns=keys)

    return Sensitivities(
        pd.Series([q["value"] for q in quantities], index=names, dtype=float),
        pd.Series([key["value"] for key in found["keys"]], index=keys, dtype=float),
        frame("derivatives").astype(float),
        frame("reasons").fillna(""),
        frame("error").astype(float),
        found["stopped"],
        frame("relative_influence").astype(float),
    )


@dataclass(frozen=True)
class Orbit:
    """A periodic motion, in SI units.

    period: of the drive; without a drive, of the motion over `periods`.
    residual: greatest change over the periods, relative to its error scale.
    t, q, v: time, coordinates and rates at the section.
    impacts: a frame of the contact onsets within the periods: t, joint, speed.
    multipliers: Floquet multipliers of the mechanism's own degrees of freedom, largest modulus first.
    stable: whether all multipliers are inside the unit circle.
    step_error: greatest change of the end of the motion with finer time steps, in the unit of residual;
        0 without time stepping.
    shift: change of the coordinates of `shift` over the periods, m or rad.
    failure: the reason why no periodic motion was found, or "".
    """

    period: float
    periods: int
    residual: float
    t: float
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    impacts: pd.DataFrame
    multipliers: NDArray[np.complex128]
    stable: bool
    step_error: float
    shift: float
    failure: str


def _orbit(found: Mapping[str, Any]) -> Orbit:
    return Orbit(
        found["period"],
        found["periods"],
        found["residual"],
        found["t"],
        np.array(found["q"], dtype=float),
        np.array(found["v"], dtype=float),
        pd.DataFrame(found["impacts"], columns=["t", "joint", "speed"]),
        np.array(found["multipliers"], dtype=complex),
        found["stable"],
        found["step_error"],
        found["shift"],
        found["failure"],
    )


def orbit(
    scene: SceneLike,
    formulation: str = "nonsmooth",
    *,
    periods: int = 1,
    settle: float = 10,
    period: Optional[float] = None,
    shift: Sequence[str] = (),
    set: Optional[Mapping[str, Any]] = None,
    stop: Optional[Stop] = None,
) -> Orbit:
    """Searches a periodic motion near the scene's motion after `settle` periods of the drive, as
    `freeplay orbit` does. `period` (s): an estimate, required for a mechanism without a drive.
    `shift`: coordinates, such as "bird.y", that may all change by the same amount.

    Raises SceneError if the period is not known, and if a shift is no symmetry of the mechanism."""
    wanted = _scene(scene)
    if set:
        wanted = wanted.with_(set)
    return _orbit(
        _searched(
            stop,
            lambda flag: _freeplay.orbit_of(
                wanted._handle, formulation, periods, settle, period, list(shift), flag, _here()
            ),
        )
    )


@dataclass(frozen=True)
class Branches:
    """Branches of periodic motions over one key, and curves of their bifurcations over two, in SI units.

    points: a frame with one row per motion: branch, point, parameter, period, stable, greatest_modulus, impacts.
    orbits: the motions, one Orbit per row of points.
    bifurcations: a frame: kind, parameter, period, branch, joint, follows, new_branch.
    ends: a frame: branch, points, begins, reason.
    curves: a frame with one row per point of the curves over two keys: curve, kind, parameter, second, period,
        periods, stable, multiplier (of the greatest modulus), joint, residual.
    curve_ends: a frame with one row per curve: curve, kind, points, parameter, first_reason, last_reason.
    failure: the reason why there is no first motion, or "".
    """

    points: pd.DataFrame
    orbits: list[Orbit]
    bifurcations: pd.DataFrame
    ends: pd.DataFrame
    curves: pd.DataFrame
    curve_ends: pd.DataFrame
    failure: str


def _columns(table: Mapping[str, Any], names: Sequence[str]) -> pd.DataFrame:
    """Columns of a table of the program, with complex multipliers and flags."""
    frame = pd.DataFrame(table).rename(columns={"period_s": "period"})
    frame["multiplier"] = frame["multiplier_re"] + 1j * frame["multiplier_im"]
    if "stable" in frame:
        frame["stable"] = frame["stable"].astype(bool)
    return frame[list(names)]


def continue_orbit(
    scene: SceneLike,
    key: str,
    from_: float,
    to: float,
    *,
    start: Optional[float] = None,
    step: Optional[float] = None,
    periods: int = 1,
    settle: float = 10,
    period: Optional[float] = None,
    follow_doubled: int = 1,
    most_points: int = 2000,
    second: Optional[str] = None,
    second_from: Optional[float] = None,
    second_to: Optional[float] = None,
    second_step: Optional[float] = None,
    curves: Sequence[str] = (),
    set: Optional[Mapping[str, Any]] = None,
    stop: Optional[Stop] = None,
) -> Branches:
    """Follows the periodic motion at key = from_ towards to, round folds, as `freeplay continue` does.

    The names and meanings of the parameters are those of the table [continue], with from_ for `from`; numbers are
    in SI units.

    start: value of the key at which the branch begins instead; it is then followed to both ends.
    step: greatest change of the key; default: a fiftieth of the range.
    second, second_from, second_to: a second key and its range, over which the bifurcations are followed.
    second_step: its greatest change; default: a fiftieth of its range.
    curves: kinds of bifurcations that are followed: fold, flip, torus, grazing, liftoff; default: all of them.

    Raises SceneError for an unknown key or kind and for a scheme without derivatives, TypeError for an incomplete
    second key."""
    wanted = _scene(scene)
    if set:
        wanted = wanted.with_(set)
    over: Optional[tuple[str, float, float, Optional[float], list[str]]] = None
    if second is not None:
        if second_from is None or second_to is None:
            raise TypeError("continue_orbit: second needs second_from and second_to")
        over = (second, second_from, second_to, second_step, list(curves))
    elif curves or any(value is not None for value in (second_from, second_to, second_step)):
        raise TypeError("continue_orbit: second_from, second_to, second_step and curves need second")
    found = _searched(
        stop,
        lambda flag: _freeplay.branches_of(
            wanted._handle,
            key,
            from_,
            to,
            start,
            step,
            periods,
            settle,
            period,
            follow_doubled,
            most_points,
            over,
            flag,
            _here(),
        ),
    )
    orbits = [_orbit(p) for p in found["points"]]
    points = pd.DataFrame(
        [
            [
                p["branch"],
                p["point"],
                p["parameter"],
                o.period,
                o.stable,
                max(map(abs, o.multipliers), default=0.0),
                len(o.impacts),
            ]
            for p, o in zip(found["points"], orbits)
        ],
        columns=["branch", "point", "parameter", "period", "stable", "greatest_modulus", "impacts"],
    )
    return Branches(
        points,
        orbits,
        _columns(found["bifurcations"], ["kind", "parameter", "period", "branch", "joint", "follows", "new_branch"]),
        pd.DataFrame(found["ends"], columns=["branch", "points", "begins", "ends"]).rename(columns={"ends": "reason"}),
        _columns(
            found["curve_points"],
            ["curve", "kind", "parameter", "second", "period", "periods", "stable", "multiplier", "joint", "residual"],
        ),
        pd.DataFrame(
            [[c["curve"], c["kind"], c["points"], c["parameter"], *c["ends"]] for c in found["curves"]],
            columns=["curve", "kind", "points", "parameter", "first_reason", "last_reason"],
        ),
        found["failure"],
    )


@dataclass(frozen=True)
class Lyapunov:
    """Lyapunov exponents of a motion, 1/s.

    exponents: a frame, greatest first: value (-inf where perturbations vanish), standard_error, reason.
    sum, sum_predicted: of all exponents, and from the divergence of the flow and the impacts alone.
    impacts: contact onsets after the transient.
    transient, duration: excluded and evaluated time, s.
    stopped: the reason of an early end, or "". failure: why there are no exponents, or "".
    """

    exponents: pd.DataFrame
    sum: float
    sum_predicted: float
    impacts: int
    transient: float
    duration: float
    stopped: str
    failure: str


def lyapunov(
    scene: SceneLike,
    formulation: str = "nonsmooth",
    *,
    batches: int = 20,
    transient: Optional[float] = None,
    set: Optional[Mapping[str, Any]] = None,
    stop: Optional[Stop] = None,
) -> Lyapunov:
    """Computes the Lyapunov exponents of the scene's motion through impacts, as `freeplay lyapunov` does.

    batches: number of batch means for the standard errors. transient (s): default run.discard, at least a
    tenth of the run. Raises SceneError for a scheme without derivatives."""
    wanted = _scene(scene)
    if set:
        wanted = wanted.with_(set)
    found = _searched(
        stop,
        lambda flag: _freeplay.lyapunov_of(wanted._handle, formulation, batches, transient, flag, _here()),
    )
    return Lyapunov(
        pd.DataFrame(
            [[e["per_s"], e["standard_error_per_s"], e["reason"]] for e in found["exponents"]],
            columns=["value", "standard_error", "reason"],
        ),
        found["sum_per_s"],
        found["sum_predicted_per_s"],
        found["impacts"],
        found["transient_s"],
        found["duration_s"],
        found["stopped"],
        found["failure"],
    )


@dataclass(frozen=True)
class PlayRange:
    """Range of one output over the positions, in m or rad. Rows of refused positions are NaN.

    name, unit: the output as it was asked for; "m" or "rad".
    ideal: values without clearances.
    least, greatest: found within the clearances; bound_least, bound_greatest: no position within the
        clearances is beyond them.
    linear: sum of the influences of all joints to first order; the linear range is ideal - linear to
        ideal + linear.
    settled: whether both searches converged; the bounds hold nevertheless.
    parts: a frame with one row per position and one column per joint: the part of each joint in width.
    variance: likewise, the shares of the joints, and of the keys with tolerances, in the variance to first order.
    at_least, at_greatest: the poses q at both ends, one row per position.
    quantiles, quantile_errors: frames with one column per share, with their standard errors; None without
        samples.
    loaded_up, loaded_down: values in equilibrium under the loads, approached from the position before and from
        the next one; NaN without equilibrium; None without loads.
    verdict: the widest range in a sentence.
    """

    name: str
    unit: str
    ideal: NDArray[np.float64]
    least: NDArray[np.float64]
    greatest: NDArray[np.float64]
    bound_least: NDArray[np.float64]
    bound_greatest: NDArray[np.float64]
    linear: NDArray[np.float64]
    settled: NDArray[np.bool_]
    parts: pd.DataFrame
    variance: pd.DataFrame
    at_least: NDArray[np.float64]
    at_greatest: NDArray[np.float64]
    quantiles: Optional[pd.DataFrame]
    quantile_errors: Optional[pd.DataFrame]
    loaded_up: Optional[NDArray[np.float64]]
    loaded_down: Optional[NDArray[np.float64]]
    verdict: str

    @property
    def width(self) -> NDArray[np.float64]:
        """greatest - least."""
        return self.greatest - self.least


@dataclass(frozen=True)
class LoadedPoses:
    """Equilibria under the loads at all positions.

    poses: q, one row per position; NaN without equilibrium.
    reactions: a frame with the columns JOINT.fx, JOINT.fy (N) and JOINT.m (N m), on the second body of each joint
        in world axes.
    failures: for each position the reason why there is no equilibrium, or "".
    """

    poses: NDArray[np.float64]
    reactions: pd.DataFrame
    failures: list[str]


@dataclass(frozen=True)
class Play:
    """Ranges of outputs within the clearances over positions of a driven joint, in SI units.

    joint, unit: the driven joint ("" without one) and the unit of its positions, "rad" or "m".
    positions: of the driven joint.
    ranges: a PlayRange for each output, by its name.
    refusals: for each position the reason why it has no range, or "".
    clearances: a frame with one row per loose joint or pair of opposite contacts: joint, part, kind ("disc" or
        "two-sided"), clearance (m).
    poses: q of the ideal mechanism, one row per position.
    up, down: the equilibria under the loads, approached from the position before and from the next one; None
        without loads.
    jumps: a frame of the joints that change sides between two positions under the loads: joint, from_, to, up.
    allocation: a frame of the allocated clearances: joint, before, after (m), cost, limit ("least", "greatest" or
        ""); None without a target. All other results then have these clearances.
    regions: the reachable regions of points of which both coordinates are outputs, at some positions: a frame with
        one row per direction: at (position), point, ideal_x, ideal_y, phi, the farthest place x, y along phi, and
        bound, beyond which no place is from the ideal one along phi.
    verdicts: the widest range of each output in a sentence.
    notes: what is not considered.
    """

    joint: str
    unit: str
    positions: NDArray[np.float64]
    ranges: dict[str, PlayRange]
    refusals: list[str]
    clearances: pd.DataFrame
    poses: NDArray[np.float64]
    up: Optional[LoadedPoses]
    down: Optional[LoadedPoses]
    jumps: pd.DataFrame
    allocation: Optional[pd.DataFrame]
    regions: pd.DataFrame
    verdicts: list[str]
    notes: list[str]


def _rows(lists: Sequence[Sequence[float]], size: int) -> NDArray[np.float64]:
    """A row for each list; NaN for an empty one."""
    rows = np.full((len(lists), size), np.nan)
    for row, numbers in zip(rows, lists):
        if len(numbers) > 0:
            row[:] = numbers
    return rows


def _play(found: Mapping[str, Any], allocated: bool) -> Play:
    positions = np.array(found["positions"], dtype=float)
    index = pd.Index(positions, name=found["joint"] or "t")
    coordinates = len(found["poses"][0])

    def frame(lists: Sequence[Sequence[float]], columns: Sequence[Any]) -> pd.DataFrame:
        return pd.DataFrame(_rows(lists, len(columns)), index=index, columns=list(columns))

    def shares(one: Mapping[str, Any], part: str) -> Optional[pd.DataFrame]:
        return frame(one[part], found["shares"]) if part in one else None

    def loaded_value(one: Mapping[str, Any], part: str) -> Optional[NDArray[np.float64]]:
        return np.array(one[part], dtype=float) if part in one else None

    def loaded(side: Mapping[str, Any]) -> Optional[LoadedPoses]:
        if not found["loaded"]:
            return None
        columns = [f"{joint}.{part}" for joint in found["reactions"] for part in ("fx", "fy", "m")]
        return LoadedPoses(_rows(side["poses"], coordinates), frame(side["reactions"], columns), side["failures"])

    def range_of(one: Mapping[str, Any], verdict: str) -> PlayRange:
        return PlayRange(
            name=one["name"],
            unit=one["unit"],
            ideal=np.array(one["ideal"], dtype=float),
            least=np.array(one["least"], dtype=float),
            greatest=np.array(one["greatest"], dtype=float),
            bound_least=np.array(one["bound_least"], dtype=float),
            bound_greatest=np.array(one["bound_greatest"], dtype=float),
            linear=np.array(one["linear"], dtype=float),
            settled=np.array(one["settled"], dtype=bool),
            parts=frame(one["parts"], found["joints"]),
            variance=frame(one["variance"], found["sources"]),
            at_least=_rows(one["at_least"], coordinates),
            at_greatest=_rows(one["at_greatest"], coordinates),
            quantiles=shares(one, "quantiles"),
            quantile_errors=shares(one, "quantile_errors"),
            loaded_up=loaded_value(one, "loaded_up"),
            loaded_down=loaded_value(one, "loaded_down"),
            verdict=verdict,
        )

    return Play(
        found["joint"],
        found["unit"],
        positions,
        {one["name"]: range_of(one, verdict) for one, verdict in zip(found["ranges"], found["verdicts"])},
        found["refusals"],
        pd.DataFrame(found["clearances"], columns=["joint", "part", "kind", "clearance"]),
        _rows(found["poses"], coordinates),
        loaded(found["up"]),
        loaded(found["down"]),
        pd.DataFrame(found["jumps"], columns=["joint", "from_", "to", "up"]),
        pd.DataFrame(found["allocation"], columns=["joint", "before", "after", "cost", "limit"]) if allocated else None,
        pd.DataFrame(found["regions"], columns=["at", "point", "ideal_x", "ideal_y", "phi", "x", "y", "bound"]),
        found["verdicts"],
        found["notes"],
    )


def play(
    scene: SceneLike,
    of: Sequence[str],
    over: Optional[str] = None,
    from_: Optional[float] = None,
    to: Optional[float] = None,
    *,
    points: int = 73,
    loads: bool = False,
    samples: int = 0,
    place: str = "within",
    target: Optional[float] = None,
    costs: Optional[Union[pd.DataFrame, Sequence[Mapping[str, Any]]]] = None,
    set: Optional[Mapping[str, Any]] = None,
    stop: Optional[Stop] = None,
) -> Play:
    """Computes how far outputs can be from their ideal values because of clearances, as `freeplay play` does.

    of: outputs: BODY.x, BODY.y, BODY.theta, BODY.POINT.x, BODY.POINT.y, a joint, "distance(POINT, POINT)".
    over, from_, to: a joint with prescribed motion, and its first and last position (rad or m); default: the
        position of the start alone.
    points: number of positions, ends included.
    loads: also the equilibrium under the loads at each position, without friction.
    samples: number of random states of the joints, at least 100, for quantiles; 0: no quantiles.
    place: the random places: "within" the clearances, or at their "rim".
    target: width of the only output (m or rad) for which the clearances of least cost are computed.
    costs: a frame, or a list of mappings, with joint, cost, exponent, least and greatest (m): the cost of a joint
        is cost (scene's clearance/clearance)^exponent.

    Returns Play. Raises SceneError for an unknown output or joint, for undriven motions, for positions that the
    mechanism cannot reach, if no position has a range, and for a target that cannot be met; TypeError for
    incomplete arguments."""
    if isinstance(of, str):
        raise TypeError("play: of must be a list of outputs")
    if over is None and (from_ is not None or to is not None):
        raise TypeError("play: from_ and to need over")
    if over is not None and (from_ is None or to is None):
        raise TypeError("play: over needs from_ and to")
    if (target is None) != (costs is None):
        raise TypeError("play: target and costs need each other")
    if place not in ("within", "rim"):
        raise ValueError(f"place: must be 'within' or 'rim', is {place!r}")
    wanted = _scene(scene)
    if set:
        wanted = wanted.with_(set)
    columns = ["joint", "cost", "exponent", "least", "greatest"]
    table = pd.DataFrame(costs if costs is not None else [], columns=None if costs is not None else columns)
    missing = [name for name in columns if name not in table]
    if missing:
        raise ValueError(f"costs: {missing[0]!r} is missing")
    rows = [
        (str(row[0]), float(row[1]), float(row[2]), float(row[3]), float(row[4]))
        for row in table[columns].itertuples(index=False, name=None)
    ]
    found = _searched(
        stop,
        lambda flag: _freeplay.play_of(
            wanted._handle,
            list(of),
            over or "",
            from_ or 0.0,
            to or 0.0,
            points,
            loads,
            samples,
            place == "rim",
            target,
            rows,
            flag,
            _here(),
        ),
    )
    return _play(found, target is not None)
