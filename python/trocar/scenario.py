"""Scenarios: what is simulated."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from . import _core
from ._core import Scenario as CoreScenario
from ._settings import document, settings


class Scenario:
    """A scenario that can be run: validated, with every default filled in. It does not change.

    Made by :meth:`load`, :meth:`from_dict` or :meth:`from_toml`; ``trocar.keys()`` lists every key with its meaning, and
    ``trocar.shipped()`` the scenarios that are there already. Quantities are in SI units (m, m/s, N, s).

    >>> import trocar
    >>> trocar.Scenario.load("builtin:augmented.toml").replace(**{"scaling.force": 0.8})["scaling.force"]
    0.8
    """

    __slots__ = ("_core",)
    _core: CoreScenario

    def __init__(self) -> None:
        raise TypeError("scenarios are made by Scenario.load, Scenario.from_dict or Scenario.from_toml")

    @classmethod
    def _of(cls, core: CoreScenario) -> Scenario:
        scenario = object.__new__(cls)
        object.__setattr__(scenario, "_core", core)
        return scenario

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a scenario does not change; replace() gives another one")

    @classmethod
    def load(cls, path: str | os.PathLike[str], **changes: Any) -> Scenario:
        """Loads a file, or a shipped scenario as ``"builtin:classical.toml"``.

        Parameters
        ----------
        path
            The file. Paths in it are relative to it.
        **changes
            Keys to change, as in ``**{"scaling.force": 2.0}``.

        Raises
        ------
        ScenarioError
            A ``ValueError`` with the text that the command line prints, and its place as attributes.
        """
        return cls._of(_core.Scenario.load(os.fspath(path), settings(changes)))

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], name: str = "scenario") -> Scenario:
        """A scenario of nested or dotted keys, as in ``{"base": "builtin:classical.toml", "scaling": {"force": 2.0}}``.

        Paths are relative to the working directory. Errors point into the TOML text that the values make.
        """
        return cls.from_toml(document(values), name)

    @classmethod
    def from_toml(cls, text: str, name: str = "scenario") -> Scenario:
        """A scenario of a TOML text, as a file would hold it. Paths are relative to the working directory."""
        return cls._of(_core.Scenario.from_text(name, text, []))

    def replace(self, **changes: Any) -> Scenario:
        """The same scenario with other values of some keys, as ``--set`` changes them: what follows from them follows.

        >>> import trocar
        >>> scenario = trocar.Scenario.load("builtin:classical.toml")
        >>> scenario.replace(**{"scaling.force": 2.0, "name": "strong"}).name
        'strong'
        """
        return type(self)._of(self._core.replace(settings(changes)))

    def to_toml(self) -> str:
        """The scenario with every default written out; loading it gives the same scenario."""
        return self._core.to_toml()

    def to_dict(self) -> dict[str, Any]:
        """The same as nested dictionaries."""
        return self._core.to_dict()

    def __getitem__(self, key: str) -> Any:
        """The value of a dotted key, as in ``scenario["scaling.force"]``; a section gives a dictionary."""
        found: Any = self.to_dict()
        for part in key.split("."):
            if not isinstance(found, dict) or part not in found:
                raise KeyError(key)
            found = found[part]
        return found

    @property
    def name(self) -> str:
        """What it is called."""
        return self._core.name

    @property
    def seed(self) -> int:
        """The seed of its noise."""
        return self._core.seed

    @property
    def tick_s(self) -> float:
        """Time between two ticks, in s."""
        return self._core.tick_s

    @property
    def ticks(self) -> int:
        """How many ticks a run has."""
        return self._core.ticks

    @property
    def duration_s(self) -> float:
        """How long a run is, in s."""
        return self._core.ticks * self._core.tick_s

    @property
    def rupture_times_s(self) -> list[float]:
        """When layers rupture in truth, in s, where that is known beforehand."""
        return self._core.rupture_times_s

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scenario) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __repr__(self) -> str:
        return f"Scenario({self.name!r}, {self.ticks} ticks of {self.tick_s} s)"

    def __reduce__(self) -> tuple[object, ...]:
        # What it was made of: files that it names are read again where it is unpickled.
        return (_restored, self._core.origin())


def _restored(path: str | None, name: str, text: str | None, changes: list[str]) -> Scenario:
    if path is not None:
        return Scenario._of(_core.Scenario.load(path, changes))
    return Scenario._of(_core.Scenario.from_text(name, text or "", changes))


def scenario_of(given: Scenario | str | os.PathLike[str]) -> Scenario:
    """A scenario as it is, or loaded from its path."""
    return given if isinstance(given, Scenario) else Scenario.load(given)
