"""The dimensions of a sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core

if TYPE_CHECKING:
    import xarray


def grid_of(
    columns: dict[str, NDArray[Any]], varied: list[str], units: dict[str, tuple[str, str]]
) -> xarray.Dataset | None:
    """Returns the columns of a sweep over the dimensions that its ``varied`` columns span; ``None`` if the cases are no
    grid.

    A varied column is a dimension unless the dimensions before it determine it. It is then a coordinate of the first
    dimension that determines it.
    """
    import xarray

    count = len(columns["case"])
    sizes: dict[str, int] = {}
    codes: dict[str, NDArray[Any]] = {}
    firsts: dict[str, NDArray[Any]] = {}
    coordinates: dict[str, tuple[str, NDArray[Any]]] = {}
    joint = np.zeros(count, dtype=np.int64)
    for name in varied:
        values = columns[name]
        _, first, code = np.unique(values, return_index=True, return_inverse=True)
        # Levels in the order of their first appearance.
        rank = np.argsort(np.argsort(first))
        code = rank[code.reshape(-1)]
        combined = np.unique(joint * (code.max(initial=0) + 1) + code)
        if name == "seed" and len(first) == 1:
            continue
        is_single_axis = len(first) == 1 and not any(is_label(at) for at in sizes)
        if sizes and not is_single_axis and len(combined) == len(np.unique(joint)):
            of = next((at for at in sizes if _determines(codes[at], code)), None)
            if of is not None:
                coordinates[name] = (of, values[firsts[of]])
            continue
        sizes[name], codes[name], firsts[name] = len(first), code, np.sort(first)
        joint = joint * len(first) + code
    is_labelled = any(is_label(at) for at in sizes)
    determined = [name for name in coordinates if not is_label(name)]
    if count == 0 or int(np.prod(list(sizes.values()))) != count or len(np.unique(joint)) != count:
        return None
    if determined and not is_labelled:
        return None
    order = np.argsort(joint)
    dimensions, shape = tuple(sizes), tuple(sizes.values())
    data = xarray.Dataset(
        {name: (dimensions, column[order].reshape(shape)) for name, column in columns.items() if name not in varied and name != "case"},
        coords={
            **{name: (name, columns[name][firsts[name]]) for name in sizes},
            **{name: (of, values) for name, (of, values) in coordinates.items()},
        },
    )
    for variable_name, variable in data.variables.items():
        unit, meaning = units.get(str(variable_name), ("", ""))
        variable.attrs.update({"units": unit, "long_name": meaning})
    return data


def is_label(name: str) -> bool:
    """Returns true for a column of points that is no key: its name has no dot, and no key has this name."""
    return "." not in name and name not in _PLAIN_KEYS and name not in _SECTIONS


_PLAIN_KEYS = frozenset(key for key, *_ in _core.keys() if "." not in key) | {"seed", "case"}
_SECTIONS = frozenset(key.partition(".")[0] for key, *_ in _core.keys() if "." in key)


def _determines(known: NDArray[Any], code: NDArray[Any]) -> bool:
    return len(np.unique(known * (code.max(initial=0) + 1) + code)) == len(np.unique(known))
