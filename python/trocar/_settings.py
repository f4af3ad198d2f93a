"""Converts Python values to TOML for the core."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from typing import Any

from . import _core
from ._arrays import recording_of

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


def value(key: str, given: Any) -> str:
    """Returns the value of a key as TOML on one line."""
    try:
        return _core.toml_value(given)
    except TypeError as error:
        raise TypeError(f"{key} is {error}") from None
    except (OverflowError, UnicodeError):
        raise ValueError(f"{key} is {given!r}, which TOML cannot represent") from None


def settings(changes: Mapping[str, Any]) -> tuple[list[str], list[_core.Recording]]:
    """Returns nested or dotted changes in the form of the core, and the recordings in memory among them."""
    flat, recordings = _named(changes)
    return [f"{key}={value(key, given)}" for key, given in flat], recordings


def key_of(setting: str) -> str:
    """Returns the key of a setting."""
    return setting.split("=", 1)[0]


def dotted(key: Any) -> str:
    """Returns a dotted key as TOML. Quotes parts that are not bare keys."""
    if not isinstance(key, str):
        raise TypeError(f"the key {key!r} is not a string; write it as in \"scaling.force\"")
    return ".".join(part if _BARE.match(part) else _core.toml_value(part).replace("=", "\\u003d") for part in key.split("."))


def document(values: Mapping[str, Any]) -> tuple[str, list[_core.Recording]]:
    """Returns nested or dotted keys as a TOML document with one line per key, and the recordings in memory among
    them."""
    flat, recordings = _named(values)
    return "".join(f"{key} = {value(key, given)}\n" for key, given in flat), recordings


# The key of a recording, whose value may be samples.
RECORDING = "recording.file"


def _named(values: Mapping[str, Any]) -> tuple[list[tuple[str, Any]], list[_core.Recording]]:
    """Returns the keys with their values, and the recordings in memory. The value of such a recording is its name."""
    named, recordings = [], []
    for key, given in _flat("", values):
        if key == RECORDING and not isinstance(given, (str, os.PathLike)):
            recording = recording_of(given)
            recordings.append(recording)
            given = recording.name
        named.append((key, given))
    return named, recordings


def _flat(prefix: str, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key, given in values.items():
        path = prefix + dotted(key)
        if isinstance(given, Mapping) and given and path != RECORDING:
            yield from _flat(path + ".", given)
        else:
            yield path, dict(given) if isinstance(given, Mapping) else given
