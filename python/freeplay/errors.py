"""Exceptions and warnings of the package. Each message is the line that the command prints."""

from __future__ import annotations

import re
from typing import Any, Optional

_PLACE = re.compile(r"(?:^|: )(?P<file>[^:\n]+):(?P<line>\d+):(?P<column>\d+)(?:: (?P<key>[\w.\-]+))?(?:: |$)")


class FreeplayError(Exception):
    """Base class of all errors of this package except wrong arguments, which raise TypeError or
    ValueError."""


class SceneError(FreeplayError, ValueError):
    """A scene or study that is incomplete or contradictory.

    file, line, column: place of the error; None if the scene was built in Python.
    key: dotted key; None if the error belongs to no key.  message: the error and its correction.
    """

    def __init__(
        self,
        what: str,
        file: Optional[str] = None,
        line: Optional[int] = None,
        column: Optional[int] = None,
        key: Optional[str] = None,
        message: Optional[str] = None,
    ) -> None:
        super().__init__(what)
        self.file, self.line, self.column = file, line, column
        self.key, self.message = key, what if message is None else message


class SnapshotError(FreeplayError):
    """A snapshot that is damaged, or belongs to another scene, formulation or program."""


class OutputError(FreeplayError, OSError):
    """A file that cannot be written, with the reason."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a run after its current step. `result` is complete up to that step; None if
    there is no result."""

    def __init__(self, what: str = "interrupted", result: Any = None) -> None:
        super().__init__(what)
        self.result = result


class DoubtfulWarning(UserWarning):
    """A result may be wrong; the text gives the reason."""


class FailedWarning(UserWarning):
    """A run that ended early for a numerical reason; `result.status` is "failed"."""


#: Stands for the file name in messages about scenes that were built in Python.
IN_PYTHON = "scene in Python"


def scene_error(what: str, key: str, message: str) -> SceneError:
    """Makes a SceneError from a message line of the library and splits it into its parts."""
    tail = f": {key}: {message}"
    place = what[: -len(tail)] if key and what.endswith(tail) else ""
    found = _PLACE.search(place or what)
    if not found or found["file"].endswith(IN_PYTHON):
        if found:  # line numbers of generated TOML mean nothing to the user
            what = what.replace(f"{found['file']}:{found['line']}:{found['column']}", IN_PYTHON)
        return SceneError(what, None, None, None, key or (found and found["key"]) or None, message)
    if not place:  # the line contains another message: its key and error follow the place
        key, message = key or found["key"] or "", what[found.end() :]
    return SceneError(what, found["file"], int(found["line"]), int(found["column"]), key or None, message)
