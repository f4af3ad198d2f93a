"""Converts arrays of users to samples for the core."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Samples = NDArray[np.float64]

_REAL = "fiu"


def samples(name: str, values: ArrayLike) -> Samples:
    """Returns one-dimensional, contiguous float64 samples; the same array if it has this form already.

    Integers and other floats are converted. Other types (complex numbers, strings, booleans, dates, objects), masked samples and
    other shapes are errors.
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
    """Returns samples as :func:`samples`, or ``None`` for ``None``."""
    return None if values is None else samples("velocity", values)


def number(name: str, value: Any) -> float:
    """Returns one real number as a float."""
    if isinstance(value, (bool, np.bool_, str, bytes)):
        raise TypeError(f"{name} is {value!r}, must be a number")
    try:
        return float(value)
    except TypeError:
        raise TypeError(f"{name} is {value!r}, must be a number") from None
