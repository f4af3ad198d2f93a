"""Converts users' arrays to samples for the core."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._frames import columns_of_frame, is_frame

if TYPE_CHECKING:
    import pandas

Samples = NDArray[np.float64]

_REAL = "fiu"


def samples(name: str, values: ArrayLike) -> Samples:
    """Returns one-dimensional, contiguous float64 samples; the same array if it already has this form.

    Converts integers and other floats. Raises an error for other types (complex numbers, strings, booleans, dates,
    objects), masked samples and other shapes.
    """
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise ValueError(f"{name} has masked samples; fill or remove them")
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name} is not an array of numbers: {error}") from None
    if array.dtype.kind not in _REAL:
        raise TypeError(f"{name} has the dtype {array.dtype}, must be real numbers (float64 or convertible to it)")
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}, must be one-dimensional, one number per sample")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(array, dtype=np.float64)


def velocities(values: ArrayLike | None) -> Samples | None:
    """Returns samples like :func:`samples`, or ``None`` for ``None``."""
    return None if values is None else samples("velocity", values)


def number(name: str, value: Any) -> float:
    """Returns one real number as a float."""
    if isinstance(value, (bool, np.bool_, str, bytes)):
        raise TypeError(f"{name} is {value!r}, must be a number")
    try:
        return float(value)
    except TypeError:
        raise TypeError(f"{name} is {value!r}, must be a number") from None


def whole(name: str, value: Any, low: int = 0) -> int:
    """Returns an integer that is at least ``low``."""
    if isinstance(value, (bool, np.bool_)) or not hasattr(value, "__index__"):
        raise TypeError(f"{name} is {value!r}, must be a whole number")
    count = int(value)
    if not low <= count < 2**63:
        raise ValueError(f"{name} is {count}, must be at least {low}" if count < low else f"{name} is {count}, which is too large")
    return count


class Readable(Protocol):
    """A table that another library exports through Arrow, such as a DataFrame of polars."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...


Recorded = Union["pandas.DataFrame", Readable, Mapping[str, Any]]
"""Named samples: a table (of pandas, polars, pyarrow or DuckDB) or a dictionary with the columns ``time_s``, ``position_m``, ``force_n`` and, if measured,
``velocity_m_per_s``; or with the names of :func:`trocar.read_recording`, which have no units."""

_NAMES = ("time_s", "position_m", "velocity_m_per_s", "force_n")


def columns_of(recorded: Any) -> tuple[ArrayLike, ArrayLike, ArrayLike | None, ArrayLike]:
    """Returns the time, position, velocity (``None`` if missing) and force of named samples."""
    if not hasattr(recorded, "keys") and is_frame(recorded):
        recorded = columns_of_frame(recorded)
    if not hasattr(recorded, "keys") or not hasattr(recorded, "__getitem__"):
        raise TypeError(f"a recording is a table or a dictionary of arrays, not {type(recorded).__qualname__}")
    names = [str(name) for name in recorded.keys()]
    index = getattr(getattr(recorded, "index", None), "name", None)
    found: list[Any] = []
    for name in _NAMES:
        short = name.partition("_")[0]
        if name in names or short in names:
            found.append(recorded[name if name in names else short])
        elif index == name:
            found.append(recorded.index)
        elif name == "velocity_m_per_s":
            found.append(None)
        else:
            raise ValueError(f"the recording has no {name}; its columns are {', '.join(names)}")
    time, position, velocity, force = found
    return time, position, velocity, force


def recording_of(recorded: Any) -> _core.Recording:
    """Returns named samples as a recording in memory."""
    time, position, velocity, force = columns_of(recorded)
    return _core.Recording(samples("time", time), samples("position", position), velocities(velocity), samples("force", force))
