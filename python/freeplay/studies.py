"""Studies: many runs of one scene, distributed over processes."""

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
    """Results of a study: `runs` is a pandas frame with one row per run; `info` has the numbers
    of runs that existed, were computed and failed; `table` is the text that the command prints."""

    def __init__(self, folder: Path, info: dict[str, Any]) -> None:
        self.folder, self.info = folder, info
        self.table: str = info.pop("table", "")

    @property
    def database(self) -> Path:
        """The SQLite file; docs/reference/study.md describes it."""
        return self.folder / "sweep.db"

    def sql(self, query: str) -> pd.DataFrame:
        """Result of a query of the database, which is opened read-only."""
        connection = sqlite3.connect(f"{self.database.resolve().as_uri()}?mode=ro", uri=True)
        try:
            return pd.read_sql_query(query, connection)
        finally:
            connection.close()

    @cached_property
    def runs(self) -> pd.DataFrame:
        """The view `named`: axes, statistics, measures and derived quantities of every run of
        the study."""
        return self.sql("SELECT * FROM named")

    def __repr__(self) -> str:
        return f"<study in {self.folder}: {self.info.get('total', len(self.runs))} runs>"


def read_study(folder: PathLike) -> Study:
    """Reads the study in a result folder of `freeplay sweep` or sweep()."""
    path = Path(os.fspath(folder))
    if not (path / "sweep.db").is_file():
        raise FileNotFoundError(f"{path}: has no sweep.db; give the folder of a sweep")
    return Study(path, {})


def _folder(study: Path) -> Path:
    """Default result folder out/NAME, as in the command."""
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
    """Computes the missing runs of a study, as `freeplay sweep` does. Each run is stored as a
    whole; a second call resumes.

    study: path of a study file (docs/reference/study.md).
    output: result folder; default out/NAME.
    processes: number of processes; default one per core. They are spawned, never forked.
    outside: allow files outside the folder of the study (--allow-outside).

    Returns a Study: .runs (pandas), .sql(query), .info, .table. Ctrl-C raises Interrupted;
    completed runs are kept.
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
    # In their own session: a Ctrl-C reaches them only once, through this process.
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
