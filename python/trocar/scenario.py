"""Scenarios."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from . import _core
from ._core import Scenario as CoreScenario
from ._settings import document, settings


class Scenario:
    """A validated, immutable scenario with all defaults.

    Create it from a dictionary, or with :meth:`load` or :meth:`from_toml`. ``trocar.keys()`` lists every key with its meaning, and
    ``trocar.shipped()`` lists the shipped scenarios. Quantities are in SI units (m, m/s, N, s).

    Parameters
    ----------
    values
        Nested or dotted keys, as for :meth:`from_dict`.
    name
        The name of the values in errors, and of the scenario if neither its keys nor its base have a name.

    Raises
    ------
    ScenarioError
        For an unknown key, a value out of its range, and a file that cannot be read. It is a ``ValueError``.
    ValueError
        For a number or text that TOML cannot represent, and for invalid samples of a recording.
    TypeError
        For ``values`` that are not a dictionary, a key that is not a string, and a value of a type that is not allowed.
    AttributeError
        For an attribute that is set; :meth:`replace` returns a changed scenario.

    >>> import trocar
    >>> scenario = trocar.Scenario({"base": "paper/augmented", "scaling": {"force": 0.8}})
    >>> scenario.replace(scaling={"force": 0.9})["scaling.force"]
    0.9
    """

    __slots__ = ("_core",)
    _core: CoreScenario

    def __init__(self, values: Mapping[str, Any], name: str = "scenario") -> None:
        if not isinstance(values, Mapping):
            raise TypeError(f"a scenario is made of a dictionary, not of {values!r}; Scenario.load reads a file")
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
            The file. Paths in it are relative to its folder.
        **changes
            Keys to change, as in ``scaling={"force": 2.0}`` or ``**{"scaling.force": 2.0}``.

        Raises
        ------
        ScenarioError
            For a file that cannot be read, an unknown key, and a value out of its range. It is a ``ValueError`` with the text of the
            command line, and its position as attributes.
        ValueError
            For changes as in :class:`Scenario`.
        TypeError
            For a ``path`` that is not one, and for changes as in :class:`Scenario`.

        >>> import trocar
        >>> trocar.Scenario.load("paper/classical", scaling={"force": 2.0})["scaling.force"]
        2.0
        """
        changed, recordings = settings(changes)
        return cls._of(_core.Scenario.load(os.fspath(path), [changed], recordings))

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], name: str = "scenario") -> Scenario:
        """Returns a scenario of nested or dotted keys, as in ``{"base": "paper/classical", "scaling": {"force": 2.0}}``.

        Paths are relative to the working directory. Positions of errors refer to the TOML text of the values. The errors are those of
        :class:`Scenario`.
        """
        return cls(values, name)

    @classmethod
    def from_toml(cls, text: str, name: str = "scenario") -> Scenario:
        """Returns the scenario of a TOML text. Paths are relative to the working directory.

        Raises
        ------
        ScenarioError
            For a text that is not TOML, an unknown key, a value out of its range, and a file that cannot be read. It is a ``ValueError``.
        TypeError
            For a ``text`` that is not a string.

        >>> import trocar
        >>> trocar.Scenario.from_toml('base = "paper/classical"\\nscaling.force = 2.0')["scaling.force"]
        2.0
        """
        return cls._of(_core.Scenario.from_text(name, text, [], []))

    def replace(self, **changes: Any) -> Scenario:
        """Returns the scenario with other values of some keys, as with ``--set``. Dependent defaults change accordingly.

        >>> import trocar
        >>> scenario = trocar.Scenario.load("paper/classical")
        >>> scenario.replace(**{"scaling.force": 2.0, "name": "strong"}).name
        'strong'

        The key ``recording.file`` takes samples, too: a DataFrame or a dictionary of arrays, as for :func:`trocar.detect`. They become
        part of the scenario, are pickled with it, and are not read again.

        The scenario's file, its bases and its recording are those that were loaded, also if the files have changed since.

        >>> again = scenario.replace(**{"recording.file": trocar.record(2)})
        >>> trocar.run(again)["desired_position_m"].shape
        (17000,)

        Raises
        ------
        ScenarioError, ValueError, TypeError
            As for :class:`Scenario`.
        """
        changed, recordings = settings(changes)
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
            For a key that the scenario does not have.
        """
        found: Any = self.to_dict()
        for part in str(key).split("."):
            if not isinstance(found, dict) or part not in found:
                raise KeyError(key)
            found = found[part]
        return found

    def __contains__(self, key: object) -> bool:
        """Whether the scenario has a dotted key or a section, as in ``"scaling.force" in scenario``."""
        if not isinstance(key, str):
            return False
        try:
            self[key]
        except KeyError:
            return False
        return True

    # Otherwise it would be iterated over by numbers, until the first is no key.
    __iter__: None = None

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self._core.name

    @property
    def seed(self) -> int:
        """Seed of the noise."""
        return self._core.seed

    @property
    def tick_s(self) -> float:
        """Time between two ticks, in s."""
        return self._core.tick_s

    @property
    def ticks(self) -> int:
        """Number of ticks of a run."""
        return self._core.ticks

    @property
    def duration_s(self) -> float:
        """Duration of a run, in s."""
        return self._core.ticks * self._core.tick_s

    @property
    def rupture_times_s(self) -> list[float]:
        """Times of the true ruptures, in s, as far as they are known before a run."""
        return self._core.rupture_times_s

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scenario) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __repr__(self) -> str:
        return f"Scenario({self.name!r}, {self.ticks} ticks of {self.tick_s} s)"

    # It does not change.
    def __copy__(self) -> Scenario:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Scenario:
        return self

    def __reduce__(self) -> tuple[object, ...]:
        # With the content of its files, which are not read again.
        return (_restored, self._core.origin())


def _restored(*origin: Any) -> Scenario:
    return Scenario._of(_core.Scenario.restored(*origin))


def scenario_of(given: Scenario | str | os.PathLike[str]) -> Scenario:
    """Returns a scenario, or loads it from its path."""
    return given if isinstance(given, Scenario) else Scenario.load(given)
