"""Studies: many runs of one scene, in processes that share the work."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
from functools import cached_property
from pathlib import Path
from typing import Any, Optional

import pandas as pd

from . import _freeplay
from .errors import FreeplayError, Interrupted
from .running import Stop, _here, _interrupt
from .scene import PathLike


class Study:
    """A study's results: `runs` is a pandas frame, a run a row; `info` says how many were there, made and failed; `table` is
    what the command prints."""

    def __init__(self, folder: Path, info: dict[str, Any]) -> None:
        self.folder, self.info = folder, info
        self.table: str = info.pop("table", "")

    @property
    def database(self) -> Path:
        """The SQLite file, described in docs/reference/study.md."""
        return self.folder / "sweep.db"

    def sql(self, query: str) -> pd.DataFrame:
        """Any query of the database, read only."""
        connection = sqlite3.connect(f"{self.database.resolve().as_uri()}?mode=ro", uri=True)
        try:
            return pd.read_sql_query(query, connection)
        finally:
            connection.close()

    @cached_property
    def runs(self) -> pd.DataFrame:
        """The view `named`: axes, statistics, measures and what is derived of every run that the study names."""
        return self.sql("SELECT * FROM named")

    def __repr__(self) -> str:
        return f"<study in {self.folder}: {self.info.get('total', len(self.runs))} runs>"


def read_study(folder: PathLike) -> Study:
    """What `freeplay sweep` or sweep() left in a folder."""
    path = Path(os.fspath(folder))
    if not (path / "sweep.db").is_file():
        raise FileNotFoundError(f"{path}: has no sweep.db; give the folder of a sweep")
    return Study(path, {})


def _folder(study: Path) -> Path:
    """out/NAME, as the command has it."""
    name = study.stem
    if name in ("scene", "study"):
        name = study.resolve().parent.name
    return Path("out") / name


def sweep(
    study: PathLike,
    *,
    output: Optional[PathLike] = None,
    processes: Optional[int] = None,
    outside: bool = False,
    stop: Optional[Stop] = None,
) -> Study:
    """Makes what is missing of a study, as `freeplay sweep` does, and stores each run whole: called again it goes on.

    study: path of a study file (docs/reference/study.md).
    output: result folder; default out/NAME.
    processes: how many share the work; default one for each core. They are spawned, never forked.
    outside: the study may name files that lie anywhere (--allow-outside).

    Returns a Study: .runs (pandas), .sql(query), .info, .table. Ctrl-C raises Interrupted; the runs that are made stay.
    """
    file = Path(os.fspath(study))
    folder = Path(os.fspath(output)) if output is not None else _folder(file)
    count = processes if processes is not None else (os.cpu_count() or 1)
    if count < 1:
        raise ValueError(f"processes: must be at least 1, is {count}")
    _freeplay.refuse_forked()
    if not file.is_file():
        raise FileNotFoundError(f"{file}: no such study")
    command = [sys.executable, "-m", "freeplay.worker", os.fspath(file), os.fspath(folder), str(int(outside))]
    environment = dict(os.environ)
    environment["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parent.parent), environment.get("PYTHONPATH", "")])
    # In a process group of their own: a Ctrl-C reaches them through this process alone, once.
    helpers = [
        subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            start_new_session=True,
        )
        for _ in range(count - 1)
    ]
    flag = (stop or Stop())._flag
    try:
        info = _freeplay.sweep_into(file, folder, outside, 1, flag, _here())
    finally:
        if flag.is_set() or sys.exc_info()[0] is not None:
            for helper in helpers:
                helper.terminate()
        ends = [(helper, helper.communicate()[1]) for helper in helpers]
    pressed = info.pop("pressed")
    found = Study(folder, info)
    if pressed:
        _interrupt(found)
    if info["interrupted"]:
        raise Interrupted("interrupted", found)
    for helper, said in ends:
        if helper.returncode != 0:
            raise FreeplayError(f"a process of the sweep ended with status {helper.returncode}: {said.decode(errors='replace')}")
    return found
