"""Recordings in files: CSV, MATLAB, Parquet, TDMS, HDF5, Excel."""

from __future__ import annotations

import os
from typing import Any, TypedDict, cast

import numpy as np
from numpy.typing import NDArray

from . import _core


class Recording(TypedDict):
    """Samples in SI units, float64 of the shape ``(samples,)``: the first arguments of :func:`trocar.detect`."""

    time: NDArray[np.float64]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64] | None
    force: NDArray[np.float64]


def list_signals(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns what is in a file, as ``trocar detect FILE --list --json`` prints it.

    ``signals`` is a list with ``name``, ``unit``, ``shape``, ``samples``, ``rate_hz``, ``min``, ``max`` and the ``role`` that name and
    unit show, for each signal; ``command`` is a command line that detects in the file.

    Raises
    ------
    ValueError
        For a file that cannot be read.
    """
    return dict(_core.list_signals(os.fspath(path)))


def read_recording(
    path: str | os.PathLike[str],
    *,
    time: str = "time_s",
    position: str = "position_m",
    velocity: str | None = None,
    force: str = "force_n",
) -> Recording:
    """Reads a recording for :func:`trocar.detect` and :func:`trocar.calibrate`, as in ``trocar.detect(**trocar.read_recording(path))``.

    Parameters
    ----------
    path
        A CSV, MATLAB, Parquet, TDMS, HDF5 or Excel file.
    time, position, velocity, force
        The names of the signals, as :func:`list_signals` gives them, each with a factor or a unit if it is not in SI units:
        ``"scope.signals[0].values[:,1]:mm"``. Without ``velocity``, it is estimated from the positions.

    Raises
    ------
    ValueError
        For a file that cannot be read, for a signal that it does not have, and for samples that are not finite.

    >>> import trocar
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "own.csv")
    >>> with open(path, "w") as file:
    ...     _ = file.write("t;x;f\\n0;1,5;2\\n0,001;1,6;3\\n")
    >>> trocar.read_recording(path, time="t", position="x:mm", force="f:-1")["position"]
    array([0.0015, 0.0016])
    """
    return cast(Recording, _core.read_recording(os.fspath(path), time, position, velocity, force))
