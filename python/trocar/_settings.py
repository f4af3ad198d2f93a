"""From Python's values to the lines of TOML that the core reads."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from . import _core

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


def value(key: str, given: Any) -> str:
    """A key's value as TOML writes it on one line."""
    try:
        return _core.toml_value(given)
    except TypeError as error:
        raise TypeError(f"{key} is {error}") from None
    except (OverflowError, UnicodeError):
        raise ValueError(f"{key} is {given!r}, which TOML has no way to write") from None


def settings(changes: Mapping[str, Any]) -> list[str]:
    """Changes as the command line's ``--set`` writes them."""
    return [f"{dotted(key)}={value(key, given)}" for key, given in changes.items()]


def key_of(setting: str) -> str:
    """The key of a setting."""
    return setting.split("=", 1)[0]


def dotted(key: Any) -> str:
    """A dotted key as TOML writes it; parts that are no bare keys are quoted."""
    if not isinstance(key, str):
        raise TypeError(f"the key {key!r} is no text; write it as in \"scaling.force\"")
    return ".".join(part if _BARE.match(part) else _core.toml_value(part).replace("=", "\\u003d") for part in key.split("."))


def document(values: Mapping[str, Any]) -> str:
    """Nested or dotted keys as a TOML document, a line each."""
    return "".join(f"{key} = {value(key, given)}\n" for key, given in _flat("", values))


def _flat(prefix: str, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key, given in values.items():
        path = prefix + dotted(key)
        if isinstance(given, Mapping) and given:
            yield from _flat(path + ".", given)
        else:
            yield path, dict(given) if isinstance(given, Mapping) else given
