"""Tables of other libraries, as inputs and as outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core

# The types that Arrow takes without a copy.
_SHARED = ("float64", "int64", "uint8", "int8")


def stream(columns: Mapping[str, Any], about: Mapping[str, tuple[str, str]] | None = None) -> Any:
    """Returns a capsule ``arrow_array_stream`` with one batch of columns; ``about`` maps names to units and meanings,
    which become metadata. Numbers are not copied; booleans and texts are."""
    described = about or {}

    def metadata(name: str) -> list[tuple[str, str]]:
        unit, meaning = described.get(name, ("", ""))
        return [(key, text) for key, text in (("unit", unit), ("meaning", meaning)) if text]

    return _core.arrow_stream([(name, _values(column), metadata(name)) for name, column in columns.items()])


def _values(column: Any) -> Any:
    if isinstance(column, np.ndarray):
        return np.ascontiguousarray(column) if column.dtype.name in _SHARED else column.tolist()
    return column


def is_frame(given: Any) -> bool:
    """Returns true for a table of another library: of pandas, polars, pyarrow, DuckDB, xarray or any other with named
    columns that Arrow or numpy can read."""
    if hasattr(given, "__arrow_c_stream__") or hasattr(given, "collect_schema"):
        return True
    return hasattr(given, "columns") and hasattr(given, "to_numpy")


def names_of(frame: Any) -> list[str]:
    """Returns the names of the columns of a table."""
    for attribute in ("column_names", "columns"):
        names = getattr(frame, attribute, None)
        if names is not None and not callable(names):
            found = [str(name) for name in names]
            # The columns of a pyarrow.Table are arrays.
            if attribute == "column_names" or not hasattr(frame, "column_names"):
                return found
    return [str(name) for name in frame.keys()]


def columns_of_frame(frame: Any) -> dict[str, Any]:
    """Returns the columns of a table by name, each as numpy can read it."""
    if hasattr(frame, "collect_schema") and hasattr(frame, "collect"):
        # A lazy frame of polars; an eager one has no `collect`.
        frame = frame.collect()
    if hasattr(frame, "fetchnumpy"):
        # A relation of DuckDB.
        return {str(name): column for name, column in frame.fetchnumpy().items()}
    names = names_of(frame)
    repeated = {name for name in names if names.count(name) > 1}
    if repeated:
        raise ValueError(f"the table has the column {', '.join(sorted(repeated))} more than once")
    return {name: frame[name] for name in names}


def as_list(column: Any) -> list[Any]:
    """Returns the values of a column as Python objects."""
    for method in ("tolist", "to_list", "to_pylist"):
        if hasattr(column, method):
            values = getattr(column, method)()
            return list(values)
    return list(np.asarray(column).tolist()) if not isinstance(column, list) else column


def flat_rows(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Returns rows with one number or word per cell: the values of a dictionary as ``name.key``, the ends of an interval
    as ``name_low`` and ``name_high``, the values of another list as ``name_1``, ``name_2`` and so on."""
    nested = {name for row in rows for name, value in row.items() if isinstance(value, (dict, list))}

    def cells(name: str, value: Any) -> dict[str, Any]:
        if isinstance(value, dict):
            return {f"{name}.{key}": one for key, one in value.items()}
        if isinstance(value, list):
            of, is_interval = name.removesuffix("_interval"), name.endswith("_interval")
            return {f"{of}_{end}": one for end, one in zip(("low", "high") if is_interval else range(1, len(value) + 1), value)}
        return {} if name in nested else {name: value}

    return [{key: one for name, value in row.items() for key, one in cells(name, value).items()} for row in rows]


def freeze(arrays: Mapping[str, NDArray[Any]] | Sequence[NDArray[Any]]) -> None:
    """Makes arrays read-only."""
    for array in arrays.values() if isinstance(arrays, Mapping) else arrays:
        array.flags.writeable = False
