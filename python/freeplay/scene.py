"""Scenes as nested mappings with the keys of docs/reference/scene.md."""

from __future__ import annotations

import difflib
import os
import tomllib
from collections.abc import Iterator, Mapping, MutableMapping
from typing import Any, Optional, Union

import tomli_w

from . import _freeplay
from .errors import IN_PYTHON

PathLike = Union[str, "os.PathLike[str]"]


def _plain(value: Any) -> Any:
    """Converts a value to a TOML type: NumPy numbers to Python numbers, mappings to dicts,
    sequences to lists."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (str, bool, int, float)):
        return value
    if hasattr(value, "tolist"):  # arrays and numbers of NumPy
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"a scene holds numbers, texts, lists and mappings, not {type(value).__name__}")


def _spelled(value: Any) -> str:
    """A value in the syntax of --set."""
    if isinstance(value, list):
        return "[" + ", ".join(_spelled(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k} = {_spelled(v)}" for k, v in value.items()) + "}"
    return tomli_w.dumps({"value": value}).partition(" = ")[2].rstrip("\n")


def _apply(document: dict[str, Any], override: str) -> None:
    key, _, text = override.partition("=")
    try:
        value = tomllib.loads("value = " + text)["value"]
    except tomllib.TOMLDecodeError:
        value = text
    *tables, last = key.split(".")
    for name in tables:
        document = document.setdefault(name, {})
    document[last] = value


def _find(document: Mapping[str, Any], key: str) -> Any:
    for name in key.split("."):
        if not isinstance(document, Mapping) or name not in document:
            raise KeyError(key)
        document = document[name]
    return document


class Table(MutableMapping[str, Any]):
    """A table of a scene. Setting or deleting a key changes the scene, which is then validated
    like a file."""

    def __init__(self, scene: "Scene", path: str) -> None:
        self._scene, self._path = scene, path

    def _key(self, key: str) -> str:
        if not isinstance(key, str) or not key:
            raise TypeError(f"a key is a dotted text such as joints.pin.clearance, not {key!r}")
        return f"{self._path}.{key}" if self._path else key

    def __getitem__(self, key: str) -> Any:
        full = self._key(key)
        try:
            found = _find(self._scene._document(), full)
        except KeyError:
            found = self._scene._in_force(full)
        return Table(self._scene, full) if isinstance(found, dict) else found

    def __setitem__(self, key: str, value: Any) -> None:
        self._scene.set({self._key(key): value})

    def __delitem__(self, key: str) -> None:
        self._scene._delete(self._key(key))

    def _own(self) -> dict[str, Any]:
        found: dict[str, Any] = self._scene._document()
        return dict(_find(found, self._path)) if self._path else found

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._own()))

    def __len__(self) -> int:
        return len(self._own())

    def to_dict(self) -> dict[str, Any]:
        """A copy in plain dicts, lists, numbers and strings."""
        return tomllib.loads(tomli_w.dumps(self._own()))

    def __repr__(self) -> str:
        return f"<{self._path or 'scene'}: {', '.join(self)}>"


class Scene(Table):
    """A scene: the mechanism and the settings of its runs.

    Built from nested mappings with the keys of docs/reference/scene.md, or read by read_scene(). Numbers
    are in SI units and radians, except where a key names another unit; a string such as "0.25
    mm" may replace a number. Reading an absent key gives its default. `folder`: the folder of
    the files that the scene refers to. Raises SceneError, which names the key.

    >>> scene["joints.pin.clearance"] = 1e-3          # m; the same as scene["joints"]["pin"]["clearance"] = 1e-3
    """

    def __init__(self, mapping: Mapping[str, Any], *, folder: PathLike = ".", outside: bool = False) -> None:
        super().__init__(self, "")
        name = os.path.join(os.fspath(folder), IN_PYTHON) if os.fspath(folder) != "." else IN_PYTHON
        text = tomli_w.dumps(_plain(mapping))
        self._take(_freeplay.Scene.parse(text, name, [], outside))

    @classmethod
    def _of(cls, handle: "_freeplay.Scene") -> "Scene":
        scene = cls.__new__(cls)
        Table.__init__(scene, scene, "")
        scene._take(handle)
        return scene

    def _take(self, handle: "_freeplay.Scene") -> None:
        self._handle = handle
        self._read: Optional[dict[str, Any]] = None
        self._facts: Optional[dict[str, Any]] = None

    def _document(self) -> dict[str, Any]:
        if self._read is None:
            self._read = tomllib.loads(self._handle.text)
            for override in self._handle.overrides:
                _apply(self._read, override)
        return self._read

    def _in_force(self, key: str) -> Any:
        if self._facts is None:
            self._facts = tomllib.loads(self._handle.canonical())
        try:
            return _find(self._facts, key)
        except KeyError:
            pass
        parent, _, last = key.rpartition(".")
        try:
            table = _find(self._facts, parent) if parent else self._facts
            beside = [*table] if isinstance(table, dict) else []
        except KeyError:
            beside = []
        near = difflib.get_close_matches(last, beside, 1)
        hint = f"; did you mean {parent + '.' if parent else ''}{near[0]}?" if near else ""
        raise KeyError(f"{key}: the scene has no such key{hint}")

    def _again(self, document: dict[str, Any]) -> "_freeplay.Scene":
        return _freeplay.Scene.parse(tomli_w.dumps(document), self._handle.file or IN_PYTHON, [], self._handle.outside)

    def _delete(self, key: str) -> None:
        document = self.to_dict()
        parent, _, last = key.rpartition(".")
        try:
            del (_find(document, parent) if parent else document)[last]
        except KeyError:
            raise KeyError(f"{key}: the scene does not say it; what it leaves out has a default") from None
        self._take(self._again(document))

    def set(self, values: Mapping[str, Any]) -> None:
        """Sets several dotted keys at once, as `--set KEY=VALUE` does, and validates the scene
        after the last one. On an error the scene is not changed. A mapping as value replaces a
        table."""
        plain = {key: _plain(value) for key, value in values.items()}
        if any(isinstance(value, dict) for value in plain.values()):
            document = self.to_dict()
            for key, value in plain.items():
                _apply(document, f"{key}={_spelled(value)}")
            return self._take(self._again(document))
        handle = self._handle
        if handle.text and len(plain) > 1:
            more = [f"{key}={_spelled(value)}" for key, value in plain.items()]
            handle = _freeplay.Scene.parse(handle.text, handle.file, [*handle.overrides, *more], handle.outside)
        else:
            handle = handle.copy()
            for key, value in plain.items():
                handle.set(key, _spelled(value))
        self._take(handle)

    def copy(self) -> "Scene":
        """A copy of the scene."""
        return Scene._of(self._handle.copy())

    def with_(self, values: Mapping[str, Any]) -> "Scene":
        """A copy with these keys set."""
        other = self.copy()
        other.set(values)
        return other

    @property
    def file(self) -> str:
        """The file of the scene."""
        return self._handle.file

    @property
    def text(self) -> str:
        """The TOML text of the scene, without overrides."""
        return self._handle.text

    @property
    def overrides(self) -> list[str]:
        """KEY=VALUE, in the order given."""
        return self._handle.overrides

    @property
    def idle(self) -> list[str]:
        """Keys of the scene that have no effect, with the reasons."""
        return self._handle.idle

    def canonical(self) -> str:
        """All keys with their values in force, defaults included, in SI units. The identity of a
        run derives from this text."""
        return self._handle.canonical()

    def to_toml(self) -> str:
        """The TOML text of the scene, with overrides."""
        return tomli_w.dumps(self._document())


def read_scene(file: PathLike, overrides: Optional[Mapping[str, Any]] = None, *, outside: bool = False) -> Scene:
    """Reads and validates a scene file.

    overrides: dotted keys and their values, as for `--set`.
    outside: allow files outside the folder of the scene and its subfolders (`--allow-outside`).
    Raises SceneError with file, line, column and key.
    """
    given = [f"{key}={_spelled(_plain(value))}" for key, value in (overrides or {}).items()]
    return Scene._of(_freeplay.Scene.read(os.fspath(file), given, outside))
