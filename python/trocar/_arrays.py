"""From what users have to the samples that the core takes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Samples = NDArray[np.float64]

_REAL = "fiu"


def samples(name: str, values: ArrayLike) -> Samples:
    """One-dimensional float64 samples in one piece; the very array where it is that already.

    Integers and other floats are converted. Whatever else there is (complex numbers, texts, truth values, dates, objects,
    masked samples, another shape) is refused.
    """
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise ValueError(f"{name} has masked samples; fill them in or leave them out")
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name} is no array of numbers: {error}") from None
    if array.dtype.kind not in _REAL:
        raise TypeError(f"{name} has the dtype {array.dtype}, must be real numbers (float64, or what fits into it)")
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}, must be one-dimensional: a number per sample")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(array, dtype=np.float64)


def velocities(values: ArrayLike | None) -> Samples | None:
    """As :func:`samples`, where there are any."""
    return None if values is None else samples("velocity", values)


def number(name: str, value: Any) -> float:
    """One real number."""
    if isinstance(value, (bool, np.bool_, str, bytes)):
        raise TypeError(f"{name} is {value!r}, must be a number")
    try:
        return float(value)
    except TypeError:
        raise TypeError(f"{name} is {value!r}, must be a number") from None
