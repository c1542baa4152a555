"""Figures by matplotlib that show what the gnuplot figures of a result folder show. Each draws into `axes`, or makes new
ones, and returns them."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

from .results import Comparison, Run

#: Of penalty, nonsmooth and ideal, as in the other figures.
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
    """Where the journal of a joint went in its bearing (mm), and the circle of the clearance where gap = 0."""
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
    """An instrument's samples over time."""
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
    """A channel, or a column of the trajectory, of both formulations and of the ideal mechanism over one another."""
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
