"""The inputs of a sweep, in the form of the core."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import Readable, recording_of, whole
from ._frames import as_list, columns_of_frame, is_frame
from ._grid import is_label
from ._settings import RECORDING, dotted, key_of, value
from .people import Patients
from .ranges import Range, check_varied, written
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import pandas

Points = Union["pandas.DataFrame", Readable, Mapping[str, Any], Sequence[Mapping[str, Any]]]
"""Points of a sweep: a table (of pandas, polars, pyarrow or DuckDB) or a dictionary with a column per key, or a list of
dictionaries, one per point. Columns whose names have no dot and are no keys are labels, which the result has, too."""


Swept = tuple[dict[str, Any], str, int, str]
Tell = Callable[[int, int], None]


def _memory_bytes() -> int:
    """Returns the memory of this machine, in bytes; unlimited if the system does not report it."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError):
        return 2**63


@dataclass(frozen=True)
class Job:
    """The inputs of a shard, which are sent to the workers."""

    path: str | None
    text: str
    base: Scenario | None
    settings: list[str]
    # The labels of the points, and the number of seeds of each point.
    labels: dict[str, NDArray[Any]] = field(default_factory=dict)
    seeds: int = 1
    parts: dict[str, Any] = field(default_factory=dict)

    @property
    def _sources(self) -> tuple[str | None, str, _core.Scenario | None, list[str]]:
        return self.path, self.text, None if self.base is None else self.base._core, self.settings

    def run(self, shard: str, threads: int, tell: Tell | None = None) -> Swept:
        if self.parts:
            return _core.sweep_with(*self._sources, self.parts, shard, threads, _memory_bytes(), tell)
        return _core.sweep(*self._sources, shard, threads, _memory_bytes(), tell)

    def plan(self) -> tuple[str, int]:
        """Returns the hash and the number of cases, without running any."""
        return _core.sweep_plan(*self._sources)


def job_of(
    base: Scenario | Patients | str | os.PathLike[str],
    axes: Mapping[str, Any] | None,
    set: Mapping[str, Any] | None,
    seeds: int | Sequence[int],
    first_seed: int | None,
    metrics: Sequence[str] | None,
    design: str,
    points: int | Points | Patients | None,
    design_seed: int | None,
) -> Job:
    if axes is not None:
        check_varied("axes", axes)
    given = None if points is None or isinstance(points, (int, np.integer)) else _columns(points)
    drawn = base if isinstance(base, Patients) else None
    if drawn is not None:
        if given is not None or design != "grid" or points is not None:
            raise ValueError("patients are points: combine them with axes, without points or another design")
        base, given, axes = drawn.scenario, _combined(drawn, axes or {}), None
    assert not isinstance(base, Patients)
    if axes is None and given is None:
        others = (set, first_seed, metrics, points, design_seed)
        if isinstance(base, Scenario) or any(one is not None for one in others) or seeds != 1 or design != "grid":
            raise ValueError("without axes, base must be the path of a sweep file or patients, without other arguments of the sweep")
        return Job(os.fspath(base), "", None, [])
    labels: dict[str, NDArray[Any]] = {}
    if given is not None:
        if axes is not None or design != "grid":
            raise ValueError("points with values of the keys have neither axes nor another design")
        labels = {name: np.asarray(column) for name, column in given.items() if is_label(name)}
        axes, design, points = {key: column for key, column in given.items() if key not in labels}, "list", None
        if not axes:
            raise ValueError(f"points need a key, and have the labels {', '.join(labels)} only")
    assert axes is not None
    recordings: list[_core.Recording] = []
    set, axes = _with_names(set or {}, recordings), _with_names(axes, recordings)
    header: dict[str, Any] = {
        "seeds": list(seeds) if isinstance(seeds, Iterable) else whole("seeds", seeds),
        "first_seed": first_seed,
        "metrics": [metrics] if isinstance(metrics, str) else None if metrics is None else list(metrics),
        "design.kind": design,
        "design.points": points,
        "design.seed": design_seed,
    }
    shared = dict(set)
    lines = [f"{key} = {value(key, one)}" for key, one in header.items() if one is not None]
    lines += _section("set", shared)
    lines += _section("axes", {key: written(one) for key, one in axes.items()})
    scenario = scenario_of(base)
    if any(str(key).partition(".")[0] == "population" for key in (*set, *axes)) or (
        drawn is None and _core.population(scenario._core, 1)
    ):
        raise ValueError(
            "a sweep does not draw the members of a [population]: sweep trocar.patients(200, scenario), which draws them, "
            "or remove [population]"
        )
    if recordings:
        # The scenario holds the recordings, and takes them to the workers.
        scenario = Scenario._of(scenario._core.replace([], recordings))
    # Keys of the sweep override changes of the scenario.
    overridden = {*shared, *axes}
    changes = [setting for call in scenario._core.origin()[3] for setting in call]
    kept = [setting for setting in changes if key_of(setting) not in overridden]
    count = len(header["seeds"]) if isinstance(header["seeds"], list) else int(header["seeds"])
    return Job(None, "\n".join(lines) + "\n", scenario, kept, labels, count)


def _combined(patients: Patients, axes: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Returns every patient with every combination of the values of axes, the last of which varies fastest."""
    both = [key for key in axes if key in patients.columns]
    if both:
        raise ValueError(f"the patients have the key {both[0]}, which cannot be an axis as well")
    levels = [axis.values() if isinstance(axis, Range) else as_list(axis) for axis in axes.values()]
    if not all(levels):
        raise ValueError("an axis needs at least one value")
    combinations = list(itertools.product(*levels))
    columns = {name: [value for value in column.tolist() for _ in combinations] for name, column in patients.columns.items()}
    return columns | {key: [values[at] for _ in range(len(patients)) for values in combinations] for at, key in enumerate(axes)}


def _with_names(values: Mapping[str, Any], recordings: list[_core.Recording]) -> dict[str, Any]:
    """Returns values by key, with names in place of recordings in memory, which are appended to the list."""

    def name(given: Any) -> Any:
        if isinstance(given, (str, os.PathLike)):
            return given
        recording = recording_of(given)
        recordings.append(recording)
        return recording.name

    def of_key(key: str, given: Any) -> Any:
        if key == RECORDING:
            return [name(one) for one in given] if isinstance(given, (list, tuple)) else name(given)
        if key == RECORDING.partition(".")[0] and isinstance(given, Mapping):
            return {inner: of_key(f"{key}.{inner}", one) for inner, one in given.items()}
        return given

    return {key: of_key(key, given) for key, given in values.items()}


def _section(name: str, values: Mapping[str, Any]) -> list[str]:
    lines = [f"{dotted(key)} = {value(key, one)}" for key, one in values.items()]
    return [f"[{name}]", *lines] if lines else []


def _columns(points: Points | Patients) -> dict[str, list[Any]]:
    """Returns points as a list of values per key."""
    if isinstance(points, Patients):
        columns = {name: column.tolist() for name, column in points.columns.items()}
    elif is_frame(points):
        columns = {name: as_list(column) for name, column in columns_of_frame(points).items()}
    elif isinstance(points, Mapping):
        columns = {key: as_list(column) for key, column in points.items()}
    else:
        rows: list[Any] = list(points)  # type: ignore[arg-type]
        if not all(isinstance(row, Mapping) for row in rows):
            raise TypeError(
                "points are a table, a dictionary of columns, or a list of dictionaries; an array has no names of keys: give "
                "dict(zip(keys, array.T))"
            )
        keys = list(rows[0]) if rows else []
        for index, row in enumerate(rows):
            if sorted(row) != sorted(keys):
                raise ValueError(f"points[{index}] has the keys {', '.join(row)}, must have {', '.join(keys)}")
        columns = {key: [row[key] for row in rows] for key in keys}
    lengths = {key: len(column) if isinstance(column, list) else 0 for key, column in columns.items()}
    if not lengths or min(lengths.values()) < 1 or len({*lengths.values()}) > 1:
        described = ", ".join(f"{key}: {length}" for key, length in lengths.items())
        raise ValueError(f"points need one value per key and point, and have {described or 'no key'}")
    return columns
