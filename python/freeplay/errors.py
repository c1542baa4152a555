"""What goes wrong, as exceptions. Each message is the one line that the command prints."""

from __future__ import annotations

import re
from typing import Any, Optional

_PLACE = re.compile(r"(?:^|: )(?P<file>[^:\n]+):(?P<line>\d+):(?P<column>\d+)(?:: (?P<key>[\w.\-]+))?(?:: |$)")


class FreeplayError(Exception):
    """Any error of this package but wrong arguments, which are TypeError and ValueError."""


class SceneError(FreeplayError, ValueError):
    """A scene or study that lacks or contradicts something.

    file, line, column: where it stands, None where the scene was built in Python.
    key: dotted, None where no key is to blame.  message: what is wrong and what would be right.
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
    """A snapshot that is damaged, or of another scene, formulation or program."""


class OutputError(FreeplayError, OSError):
    """What cannot be written, and why."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a run after its present step. `result` is whole up to there; None where nothing was made."""

    def __init__(self, what: str = "interrupted", result: Any = None) -> None:
        super().__init__(what)
        self.result = result


class DoubtfulWarning(UserWarning):
    """A result says of itself that it may not be what it seems; the text says why."""


class FailedWarning(UserWarning):
    """A run ended before its time for a numerical reason; `result.status` is "failed"."""


#: What scenes that were built in Python are called where a file's name would stand.
IN_PYTHON = "scene in Python"


def scene_error(what: str, key: str, message: str) -> SceneError:
    """Of the library's one line, with its parts."""
    tail = f": {key}: {message}"
    place = what[: -len(tail)] if key and what.endswith(tail) else ""
    found = _PLACE.search(place or what)
    if not found or found["file"].endswith(IN_PYTHON):
        if found:  # lines of a text that nobody wrote
            what = what.replace(f"{found['file']}:{found['line']}:{found['column']}", IN_PYTHON)
        return SceneError(what, None, None, None, key or (found and found["key"]) or None, message)
    if not place:  # composed of another line: the key and what is wrong stand behind the place
        key, message = key or found["key"] or "", what[found.end() :]
    return SceneError(what, found["file"], int(found["line"]), int(found["column"]), key or None, message)
