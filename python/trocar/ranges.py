"""Ranges of values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np


def check_varied(name: str, given: Any) -> None:
    """Raises an error for what is no dictionary of keys that vary."""
    if not isinstance(given, Mapping):
        raise TypeError(f"{name} is {given!r}, must be a dictionary of keys, each with a list of values or a trocar.Range")
    for key, values in given.items():
        # Elsewhere a tuple is a range, so that its meaning here would be a guess.
        if isinstance(values, tuple):
            raise TypeError(f"{name} has the tuple {values!r} for {key}, must have a list of values or trocar.Range(first, last, points)")


def written(values: Any) -> Any:
    """Returns the values of a key that varies, or its range, as files have them."""
    return values._table() if isinstance(values, Range) else values


@dataclass(frozen=True)
class Range:
    """An axis of a sweep from one value to another, with even or logarithmic spacing.

    :func:`sweep` checks it and raises :class:`ScenarioError` for a value that the key does not allow.

    Parameters
    ----------
    start, stop
        The first and the last value, in the unit of the key.
    points
        The number of values, at least 2, for a grid only. Other designs have their own number of points.
    log
        True for even spacing on a logarithmic scale.

    >>> import trocar
    >>> axes = {"scaling.force": trocar.Range(0.5, 2.0, 3, log=True)}
    >>> trocar.sweep("layers/skin-augmented", axes)["scaling.force"]
    array([0.5, 1. , 2. ])
    """

    start: float
    stop: float
    points: int | None = None
    log: bool = False

    def values(self) -> list[float]:
        """Returns the values, which need a number of ``points``.

        Raises
        ------
        ValueError
            Without a number of points, and for a logarithmic range that does not begin above 0.
        """
        if self.points is None or self.points < 2:
            raise ValueError(f"{self} needs at least 2 points here")
        if self.log and not 0.0 < min(self.start, self.stop):
            raise ValueError(f"{self} is logarithmic, and must begin and end above 0")
        spaced = np.geomspace if self.log else np.linspace
        return [float(value) for value in spaced(self.start, self.stop, self.points)]

    def _table(self) -> dict[str, Any]:
        table: dict[str, Any] = {"from": self.start, "to": self.stop}
        if self.points is not None:
            table["points"] = self.points
        if self.log:
            table["log"] = True
        return table
