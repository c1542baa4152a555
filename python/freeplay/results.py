"""Runs as pandas frames, from memory or from a result folder."""

from __future__ import annotations

import json
import os
from functools import cached_property
from pathlib import Path
from typing import Any, Optional

import numpy as np
import pandas as pd

from . import _freeplay
from .scene import PathLike

#: The values of ending.status in run.json, in the order of the library's codes.
_STATUS = ("finished", "interrupted", "failed")


class Run:
    """A run: `trajectory`, `events`, `forces` and `signals` are pandas frames with the columns
    of the CSV files of the same names (SI units, rad). A table that the run does not have is
    None. `info` is the content of run.json.

    The numbers of a run in memory are not copied: `trajectory` and `forces` are views of the
    recorded data.
    """

    #: The result folder; None for a run in memory.
    folder: Optional[Path] = None

    @cached_property
    def trajectory(self) -> pd.DataFrame:
        """t (s); of each body NAME.x, .y (m), .theta (rad), .vx, .vy (m/s), .omega (rad/s); of
        each contact NAME.ex, .ey, .gap (m). The rows are at multiples of run.output_step and at
        the end."""
        raise NotImplementedError

    @cached_property
    def events(self) -> Optional[pd.DataFrame]:
        """t (s), joint, kind (impact, contact, separation), crank_angle (rad), v_n_minus,
        v_n_plus, v_t_minus, v_t_plus (m/s; v_n is the rate of the gap, negative on approach),
        impulse_n, impulse_t (N s), duration (s), t_uncertainty (s). None if the scene has no
        contacts."""
        raise NotImplementedError

    @cached_property
    def forces(self) -> Optional[pd.DataFrame]:
        """Forces (N), moments (N m), powers (W), accelerations (m/s², rad/s²) and means since
        the previous row, at the rows of the trajectory. None unless the scene has run.forces =
        true or run() has forces=True."""
        raise NotImplementedError

    @cached_property
    def signals(self) -> Optional[pd.DataFrame]:
        """channel, t (s), crank_angle (rad), value: samples of the instruments. None if the
        scene has none."""
        raise NotImplementedError

    @cached_property
    def info(self) -> dict[str, Any]:
        """Content of run.json: ending, contacts, energy_J, work, cost, notes, provenance, ..."""
        raise NotImplementedError

    @property
    def status(self) -> str:
        """finished, interrupted or failed; `info["ending"]["reason"]` is the reason."""
        return str(self.info["ending"]["status"])

    @property
    def statistics(self) -> pd.DataFrame:
        """Statistics of the contacts from run.json, one row per contact."""
        table = {name: {k: v for k, v in facts.items() if not isinstance(v, dict)} for name, facts in self.info["contacts"].items()}
        return pd.DataFrame.from_dict(table, orient="index")

    def signal(self, channel: str) -> pd.DataFrame:
        """t (s), crank_angle (rad) and value of one instrument."""
        if self.signals is None or channel not in set(self.signals["channel"]):
            known = [] if self.signals is None else sorted(set(self.signals["channel"]))
            raise KeyError(f"{channel}: no such channel; there are: {', '.join(known) or 'none'}")
        found = self.signals[self.signals["channel"] == channel]
        return found.drop(columns="channel").reset_index(drop=True)

    def __repr__(self) -> str:
        ending = self.info["ending"]
        return f"<{self.info['formulation']} run, {ending['status']} at {ending['t_s']:.6g} s, {len(self.trajectory)} rows>"


def _words(words: tuple[list[str], np.ndarray[Any, Any]]) -> np.ndarray[Any, Any]:
    names, codes = words
    if not names:
        return np.empty(0, dtype=object)
    found: np.ndarray[Any, Any] = np.array(names, dtype=object)[codes]
    return found


def _frame(table: tuple[list[str], np.ndarray[Any, Any]]) -> pd.DataFrame:
    names, numbers = table
    return pd.DataFrame(numbers, columns=names, copy=False)


class MemoryRun(Run):
    """A run with its tables in memory."""

    def __init__(self, record: "_freeplay.Record") -> None:
        self._record = record

    @cached_property
    def trajectory(self) -> pd.DataFrame:
        return _frame(self._record.trajectory())

    @cached_property
    def events(self) -> Optional[pd.DataFrame]:
        found = self._record.events()
        if found is None:
            return None
        table, joint, kind = found
        frame = _frame(table)
        frame.insert(1, "joint", _words(joint))
        frame.insert(2, "kind", _words(kind))
        return frame

    @cached_property
    def forces(self) -> Optional[pd.DataFrame]:
        found = self._record.forces()
        return None if found is None else _frame(found)

    @cached_property
    def signals(self) -> Optional[pd.DataFrame]:
        found = self._record.signals()
        if found is None:
            return None
        table, channel = found
        frame = _frame(table)
        frame.insert(0, "channel", _words(channel))
        return frame

    @cached_property
    def info(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._record.info())
        return found

    @property
    def status(self) -> str:
        return _STATUS[self._record.status]


class FolderRun(Run):
    """A run with its tables in files, which are read at first access."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def _table(self, name: str) -> Optional[pd.DataFrame]:
        assert self.folder is not None
        file = self.folder / name
        if not file.exists():
            return None
        texts = {column: str for column in ("joint", "kind", "channel")}
        # These columns contain names of the user: a joint named "NA" is not a missing value.
        return pd.read_csv(file, float_precision="round_trip", dtype=texts, keep_default_na=False)

    @cached_property
    def trajectory(self) -> pd.DataFrame:
        found = self._table("trajectory.csv")
        if found is None:
            raise FileNotFoundError(f"{self.folder}: has no trajectory.csv")
        return found

    @cached_property
    def events(self) -> Optional[pd.DataFrame]:
        return self._table("events.csv")

    @cached_property
    def forces(self) -> Optional[pd.DataFrame]:
        return self._table("forces.csv")

    @cached_property
    def signals(self) -> Optional[pd.DataFrame]:
        return self._table("signals.csv")

    @cached_property
    def info(self) -> dict[str, Any]:
        assert self.folder is not None
        found: dict[str, Any] = json.loads((self.folder / "run.json").read_text(encoding="utf-8"))
        return found


def read_run(folder: PathLike) -> Run:
    """Reads the run in a result folder of `freeplay run` or run(..., output=folder)."""
    path = Path(os.fspath(folder))
    if not (path / "run.json").is_file():
        raise FileNotFoundError(f"{path}: has no run.json; give the folder of one run")
    return FolderRun(path)


class Comparison:
    """One scene in both formulations. `penalty`, `nonsmooth` and `ideal` (None if no joint has a
    clearance) are runs, `info` is the content of comparison.json, `table` the text of
    comparison.md."""

    def __init__(self, folder: Path, keep: Any = None) -> None:
        # `keep` owns a temporary folder, which is deleted with it.
        self.folder, self._keep = folder, keep
        self.penalty = read_run(folder / "penalty")
        self.nonsmooth = read_run(folder / "nonsmooth")
        self.ideal = read_run(folder / "ideal") if (folder / "ideal" / "run.json").exists() else None

    @cached_property
    def info(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads((self.folder / "comparison.json").read_text(encoding="utf-8"))
        return found

    @cached_property
    def table(self) -> str:
        return (self.folder / "comparison.md").read_text(encoding="utf-8")

    def _repr_markdown_(self) -> str:
        return self.table


def read_comparison(folder: PathLike) -> Comparison:
    """Reads the comparison in a result folder of `freeplay compare`."""
    path = Path(os.fspath(folder))
    if not (path / "comparison.json").is_file():
        raise FileNotFoundError(f"{path}: has no comparison.json; give a folder made by compare")
    return Comparison(path)
