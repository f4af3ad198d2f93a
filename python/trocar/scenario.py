"""Scenarios."""

from __future__ import annotations

import copy
import difflib
import os
from collections.abc import Iterator, Mapping
from typing import Any

from . import _core
from ._core import Scenario as CoreScenario
from ._html import table
from ._settings import document, settings


class Scenario:
    """A validated, immutable scenario with all defaults.

    Create it from a dictionary, or with :meth:`load` or :meth:`from_toml`. ``trocar.keys()`` lists every key with its
    meaning, and ``trocar.shipped()`` lists the shipped scenarios. Quantities are in SI units (m, m/s, N, s).

    Parameters
    ----------
    values
        Nested or dotted keys, as for :meth:`from_dict`.
    name
        The name of the values in errors. It also names the scenario if neither its keys nor its base have a name.

    Raises
    ------
    ScenarioError
        For an unknown key, a value out of range, and a file that cannot be read. It is a ``ValueError``.
    ValueError
        For a number or text that TOML cannot represent, and for invalid samples of a recording.
    TypeError
        If ``values`` is not a dictionary, a key is not a string, or a value has an invalid type.
    AttributeError
        For setting an attribute; :meth:`replace` returns a changed scenario.

    >>> import trocar
    >>> scenario = trocar.Scenario({"base": "paper/augmented", "scaling": {"force": 0.8}})
    >>> scenario.replace(scaling={"force": 0.9})["scaling.force"]
    0.9
    """

    __slots__ = ("_core", "_values")
    _core: CoreScenario
    # The values, once they have been read; a scenario does not change.
    _values: dict[str, Any]

    def __init__(self, values: Mapping[str, Any], name: str = "scenario") -> None:
        if not isinstance(values, Mapping):
            raise TypeError(f"a scenario is created from a dictionary, not from {values!r}; Scenario.load reads a file")
        text, recordings = document(values)
        object.__setattr__(self, "_core", _core.Scenario.from_text(name, text, [], recordings))

    @classmethod
    def _of(cls, core: CoreScenario) -> Scenario:
        scenario = object.__new__(cls)
        object.__setattr__(scenario, "_core", core)
        return scenario

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a scenario is immutable; replace() returns a changed copy")

    @classmethod
    def load(cls, path: str | os.PathLike[str], **changes: Any) -> Scenario:
        """Loads a file, or a shipped scenario such as ``"paper/classical"``.

        Parameters
        ----------
        path
            The file. Paths in the file are relative to its folder.
        **changes
            Keys to change, as in ``scaling={"force": 2.0}`` or ``**{"scaling.force": 2.0}``.

        Raises
        ------
        ScenarioError
            For a file that cannot be read, an unknown key, and a value out of range. It is a ``ValueError`` with the
            text of the command line and the position as attributes.
        ValueError
            For changes as in :class:`Scenario`.
        TypeError
            If ``path`` is not a path, and for changes as in :class:`Scenario`.

        >>> import trocar
        >>> trocar.Scenario.load("paper/classical", scaling={"force": 2.0})["scaling.force"]
        2.0
        """
        changed, recordings = settings(changes)
        return cls._of(_core.Scenario.load(os.fspath(path), [changed], recordings))

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], name: str = "scenario") -> Scenario:
        """Returns a scenario from nested or dotted keys, as in ``{"base": "paper/classical", "scaling": {"force":
        2.0}}``.

        Paths are relative to the working directory. Positions in errors refer to the TOML text of the values. The
        errors are those of :class:`Scenario`.
        """
        return cls(values, name)

    @classmethod
    def from_toml(cls, text: str, name: str = "scenario") -> Scenario:
        """Returns the scenario of a TOML text. Paths are relative to the working directory.

        Raises
        ------
        ScenarioError
            For a text that is not TOML, an unknown key, a value out of range, and a file that cannot be read. It is a
            ``ValueError``.
        TypeError
            If ``text`` is not a string.

        >>> import trocar
        >>> trocar.Scenario.from_toml('base = "paper/classical"\\nscaling.force = 2.0')["scaling.force"]
        2.0
        """
        return cls._of(_core.Scenario.from_text(name, text, [], []))

    def replace(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Scenario:
        """Returns the scenario with changed keys, given as a dictionary or as keywords. Defaults that depend on them
        change, too.

        >>> import trocar
        >>> scenario = trocar.Scenario.load("paper/classical")
        >>> scenario.replace({"scaling.force": 2.0, "name": "strong"}).name
        'strong'

        The key ``recording.file`` also accepts samples: a DataFrame or a dictionary of arrays, as for
        :func:`trocar.detect`. They become part of the scenario and are pickled with it.

        The scenario keeps the loaded content of its file, bases and recording, even if the files have changed since.

        >>> again = scenario.replace({"recording.file": trocar.record(2)})
        >>> trocar.run(again)["desired_position_m"].shape
        (17000,)

        Raises
        ------
        ScenarioError, ValueError, TypeError
            As for :class:`Scenario`.
        """
        if changes is not None and not isinstance(changes, Mapping):
            raise TypeError(f"the changes are {changes!r}, must be a dictionary of keys and values")
        changed, recordings = settings({**(changes or {}), **more})
        return type(self)._of(self._core.replace(changed, recordings))

    def to_toml(self) -> str:
        """Returns the scenario as TOML with all defaults. Loading it gives the same scenario."""
        return self._core.to_toml()

    def to_dict(self) -> dict[str, Any]:
        """Returns the scenario as nested dictionaries, with all defaults."""
        return self._core.to_dict()

    def __getitem__(self, key: str) -> Any:
        """Returns the value of a dotted key, as in ``scenario["scaling.force"]``, or a section as a dictionary.

        Raises
        ------
        KeyError
            If the scenario does not have the key.
        """
        try:
            found: Any = self._values
        except AttributeError:
            found = self._core.to_dict()
            object.__setattr__(self, "_values", found)
        for part in str(key).split("."):
            if isinstance(found, list):
                # Layers are a list; a key names them.
                found = {one["name"]: one for one in found if isinstance(one, dict) and "name" in one}
            if not isinstance(found, dict) or part not in found:
                near = difflib.get_close_matches(str(key), (known for known, *_ in _core.keys()), 1)
                raise KeyError(f"{key}; did you mean {near[0]}?" if near and near[0] != key else key)
            found = found[part]
        return copy.deepcopy(found) if isinstance(found, (dict, list)) else found

    def __contains__(self, key: object) -> bool:
        """Returns true if the scenario has a dotted key or a section, as in ``"scaling.force" in scenario``."""
        if not isinstance(key, str):
            return False
        try:
            self[key]
        except KeyError:
            return False
        return True

    # Without this, Python would iterate over the scenario by integer keys.
    __iter__: None = None

    @property
    def name(self) -> str:
        """The name of the scenario."""
        return self._core.name

    @property
    def seed(self) -> int:
        """The seed of the noise."""
        return self._core.seed

    @property
    def tick_s(self) -> float:
        """The time between two ticks, in s."""
        return self._core.tick_s

    @property
    def ticks(self) -> int:
        """The number of ticks of a run."""
        return self._core.ticks

    @property
    def duration_s(self) -> float:
        """The duration of a run, in s."""
        return self._core.ticks * self._core.tick_s

    @property
    def rupture_times_s(self) -> list[float]:
        """The times of the true ruptures that are known before a run, in s."""
        return self._core.rupture_times_s

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scenario) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __repr__(self) -> str:
        return f"Scenario({self.name!r}, {self.ticks} ticks of {self.tick_s} s)"

    def _repr_html_(self) -> str:
        """Returns the changed keys as a table; the others have their defaults."""
        defaults = {path: default for path, _, default, _ in _core.keys()}
        rows = []
        for key, shown in flat_text(self._core.to_dict()):
            if defaults.get(key) != shown:
                rows.append([key, shown])
        return table(["key", "value"], rows, f"{self.name}: {self.ticks} ticks of {self.tick_s} s; keys with other values than their defaults")

    # A scenario is immutable.
    def __copy__(self) -> Scenario:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Scenario:
        return self

    def __reduce__(self) -> tuple[object, ...]:
        # Include the content of the files, so that they are not read again.
        return (_restored, self._core.origin())


def flat_text(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yields the dotted keys of nested values, each with its value in TOML."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from flat_text(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", _core.toml_value(value)


def _restored(*origin: Any) -> Scenario:
    return Scenario._of(_core.Scenario.restored(*origin))


def scenario_of(given: Scenario | str | os.PathLike[str]) -> Scenario:
    """Returns a scenario, or loads it from its path."""
    if not isinstance(given, (Scenario, str, os.PathLike)):
        raise TypeError(f"the scenario is {given!r}, must be a Scenario or a path; a dictionary becomes one by trocar.Scenario.from_dict")
    return given if isinstance(given, Scenario) else Scenario.load(given)
