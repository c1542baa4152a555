"""Figures by matplotlib with the content of the gnuplot figures of a result folder. Each
function draws into `axes`, or into new ones, and returns them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Optional

import numpy as np
import pandas as pd

from .results import Comparison, Run
from .scene import PathLike
from .studies import Study

#: Colours of the formulations and of the ideal mechanism, as in the gnuplot figures.
COLOURS = {"penalty": "#0072b2", "nonsmooth": "#d55e00", "ideal": "#555555"}


def _axes(axes: Any) -> Any:
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def columns(run: Run, y: str, x: str = "t", axes: Any = None, **style: Any) -> Any:
    """One column of the trajectory or the forces over another, such as "slider.vx" over "t" (s)."""
    frames = [frame for frame in (run.trajectory, run.forces) if frame is not None]
    for frame in frames:
        if x in frame and y in frame:
            axes = _axes(axes)
            axes.plot(frame[x].to_numpy(), frame[y].to_numpy(), **style)
            axes.set_xlabel(x)
            axes.set_ylabel(y)
            return axes
    known = ", ".join(name for frame in frames for name in frame)
    raise KeyError(f"{x}, {y}: no table has both; columns are: {known}")


def journal_orbit(run: Run, joint: str, axes: Any = None) -> Any:
    """Path of the journal of a joint in its bearing (mm), and the clearance circle, on which the
    gap is 0."""
    ex, ey, gap = (run.trajectory[f"{joint}.{part}"].to_numpy() for part in ("ex", "ey", "gap"))
    axes = _axes(axes)
    colour = COLOURS[run.info["formulation"]]
    axes.plot(1e3 * ex, 1e3 * ey, lw=0.6, color=colour)
    radius = float(np.median(gap + np.hypot(ex, ey)))  # the clearance
    angle = np.linspace(0, 2 * np.pi, 361)
    axes.plot(1e3 * radius * np.cos(angle), 1e3 * radius * np.sin(angle), color="black", lw=0.8)
    axes.set_aspect("equal")
    axes.set_xlabel("eccentricity x, mm")
    axes.set_ylabel("eccentricity y, mm")
    axes.set_title(joint)
    return axes


def signal(run: Run, channel: str, axes: Any = None, **style: Any) -> Any:
    """Samples of an instrument over time."""
    samples = run.signal(channel)
    axes = _axes(axes)
    style.setdefault("color", COLOURS[run.info["formulation"]])
    axes.plot(samples["t"].to_numpy(), samples["value"].to_numpy(), **{"lw": 0.8, **style})
    axes.set_xlabel("t, s")
    axes.set_ylabel(channel)
    return axes


def phase_portrait(run: Run, body: str, coordinate: str = "x", axes: Any = None, **style: Any) -> Any:
    """The rate of a body's coordinate (x, y or theta) over the coordinate."""
    rates = {"x": "vx", "y": "vy", "theta": "omega"}
    if coordinate not in rates:
        raise ValueError(f"coordinate: must be x, y or theta, is {coordinate!r}")
    return columns(run, f"{body}.{rates[coordinate]}", f"{body}.{coordinate}", axes, **{"lw": 0.8, **style})


def paired(comparison: Comparison, channel: Optional[str] = None, column: Optional[str] = None, axes: Any = None) -> Any:
    """A channel, or a column of the trajectory, of both formulations and of the ideal mechanism
    in one figure."""
    if (channel is None) == (column is None):
        raise ValueError("give a channel or a column, one of both")
    axes = _axes(axes)
    for run in (comparison.ideal, comparison.penalty, comparison.nonsmooth):
        if run is None:
            continue
        name = "ideal" if run is comparison.ideal else run.info["formulation"]
        style = {"color": COLOURS[name], "label": name, "lw": 0.8}
        if channel is not None:
            signal(run, channel, axes, **style)
        else:
            columns(run, str(column), axes=axes, **style)
    axes.legend()
    return axes


def forces(run: Run, element: str, axes: Any = None, **style: Any) -> Any:
    """|F| (N) that a joint, contact or load of this name exerts, over time. Needs a run with forces=True."""
    fx, fy = _components(run, element)
    axes = _axes(axes)
    assert run.forces is not None
    axes.plot(run.forces["t"], np.hypot(fx, fy), **{"lw": 0.8, "color": COLOURS[run.info["formulation"]], **style})
    axes.set_xlabel("t, s")
    axes.set_ylabel("|F|, N")
    axes.set_title(element)
    return axes


def load_diagram(run: Run, element: str, axes: Any = None, **style: Any) -> Any:
    """Polar load diagram of a joint, contact or load: F_y over F_x (N). Needs a run with
    forces=True."""
    fx, fy = _components(run, element)
    axes = _axes(axes)
    axes.plot(fx, fy, **{"lw": 0.6, "color": COLOURS[run.info["formulation"]], **style})
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("F_x, N")
    axes.set_ylabel("F_y, N")
    axes.set_title(element)
    return axes


def _components(run: Run, element: str) -> tuple[Any, Any]:
    if run.forces is None:
        raise ValueError("forces: the run has none; run it with forces=True")
    if f"{element}.fx" not in run.forces:
        known = ", ".join(name[:-3] for name in run.forces if name.endswith(".fx"))
        raise KeyError(f"{element}: no force of this name; there are: {known}")
    return run.forces[f"{element}.fx"].to_numpy(), run.forces[f"{element}.fy"].to_numpy()


def impacts(comparison: Comparison, axes: Any = None) -> Any:
    """Approach speeds (m/s) of the impacts that are paired between the formulations, over time,
    up to the horizon."""
    axes = _axes(axes)
    pairs = comparison.info["pairing"]["pairs"]
    for name, marker in (("penalty", "o"), ("nonsmooth", "x")):
        times = [pair[name]["t_s"] for pair in pairs]
        speeds = [-pair[name]["v_n_minus_m_per_s"] for pair in pairs]
        axes.plot(times, speeds, marker, color=COLOURS[name], mfc="none", label=name)
    axes.set_xlabel("t, s")
    axes.set_ylabel("approach speed, m/s")
    axes.legend()
    return axes


def over(study: Study, y: str, x: str, by: Optional[str] = None, axes: Any = None, **style: Any) -> Any:
    """A measure of a study's runs over an axis: mean and standard deviation over the starts, one
    line per value of `by`."""
    axes = _axes(axes)
    for key in (y, x, by):
        if key is not None and key not in study.runs:
            raise KeyError(f"{key}: no such column; there are: {', '.join(study.runs)}")
    for name, runs in study.runs.groupby(by) if by else [(None, study.runs)]:
        of = runs.groupby(x)[y]
        label = None if name is None else f"{by} {name:g}" if isinstance(name, float) else f"{by} {name}"
        axes.errorbar(of.mean().index, of.mean(), of.std(), **{"marker": "o", "ms": 4, "capsize": 3, "label": label, **style})
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if by:
        axes.legend()
    return axes


def _folder(folder: PathLike, name: str) -> tuple[dict[str, Any], Path]:
    path = Path(os.fspath(folder))
    if not (path / f"{name}.json").is_file():
        raise FileNotFoundError(f"{path}: has no {name}.json; give a folder made by freeplay {name if name != 'section' else 'poincare'}")
    document: dict[str, Any] = json.loads((path / f"{name}.json").read_text(encoding="utf-8"))
    return document, path


def _label(facts: dict[str, Any]) -> str:
    return f"{facts['name']}, {facts['unit']}" if facts.get("unit") else str(facts["name"])


def poincare(folder: PathLike, axes: Any = None, **style: Any) -> Any:
    """Points of the Poincaré section in a result folder of `freeplay poincare`."""
    document, path = _folder(folder, "section")
    section = document["section"]
    points = pd.read_csv(path / "section.csv")
    axes = _axes(axes)
    axes.plot(points[section["x"]], points[section["y"]], ".", **{"ms": 2, "color": COLOURS["penalty"], **style})
    axes.set_xlabel(_label({"name": section["x"], "unit": section["x_unit"]}))
    axes.set_ylabel(_label({"name": section["y"], "unit": section["y_unit"]}))
    return axes


def bifurcation(folder: PathLike, axes: Any = None) -> Any:
    """Section points over a parameter, from `freeplay bifurcation`: swept upwards, swept
    downwards, and from random starts."""
    document, path = _folder(folder, "bifurcation")
    facts = document["bifurcation"]
    column = facts["columns"][0]
    points = pd.read_csv(path / "bifurcation.csv")
    axes = _axes(axes)
    ways = {"up": ("swept upwards", "#0072b2"), "down": ("swept downwards", "#d55e00")}
    for branch, found in points.groupby(points["branch"].where(points["branch"].isin(list(ways)), "starts")):
        label, colour = ways.get(str(branch), ("random starts", "#5b6570"))
        axes.plot(found["value"], found[column["name"]], ".", ms=1.5, color=colour, label=label)
    axes.set_xlabel(_label(facts["axis"]))
    axes.set_ylabel(_label(column))
    axes.legend(markerscale=5)
    return axes


def basin(folder: PathLike, axes: Any = None) -> Any:
    """Attractor reached from each start of a grid, from `freeplay basin`; grey: the run failed."""
    import matplotlib.pyplot as plt

    document, path = _folder(folder, "basin")
    facts = document["basin"]
    cells = pd.read_csv(path / "basin.csv").pivot(index="y", columns="x", values="attractor")
    axes = _axes(axes)
    shown = np.ma.masked_less(cells.to_numpy(), 0)  # type: ignore[no-untyped-call]
    colours = plt.get_cmap("tab10").with_extremes(bad="#f0f0f0")
    axes.pcolormesh(cells.columns, cells.index, shown, cmap=colours, vmin=0, vmax=9, shading="nearest")
    for k, attractor in enumerate(facts["attractors"]):
        axes.plot([], [], "s", color=colours(k % 10), label=str(attractor["kind"]))
    axes.set_xlabel(_label(facts["x"]))
    axes.set_ylabel(_label(facts["y"]))
    axes.legend()
    return axes


def ensemble(folder: PathLike, column: str, axes: Any = None) -> Any:
    """Quantiles over time of a column, from `freeplay ensemble`: median, 25 to 75 % and 5 to 95
    %."""
    _, path = _folder(folder, "ensemble")
    bands = pd.read_csv(path / "bands.csv")
    if column not in set(bands["column"]):
        raise KeyError(f"{column}: no such column; there are: {', '.join(bands['column'].unique())}")
    found = bands[bands["column"] == column]
    axes = _axes(axes)
    colour = COLOURS["penalty"]
    axes.fill_between(found["t"], found["q05"], found["q95"], color=colour, alpha=0.15, lw=0, label="5 to 95 %")
    axes.fill_between(found["t"], found["q25"], found["q75"], color=colour, alpha=0.3, lw=0, label="25 to 75 %")
    axes.plot(found["t"], found["q50"], color=colour, label="median")
    axes.set_xlabel("t, s")
    axes.set_ylabel(column)
    axes.legend()
    return axes
