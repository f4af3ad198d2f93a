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

    Parameters
    ----------
    path
        A CSV, MATLAB, Parquet, TDMS, HDF5 or Excel file.

    Raises
    ------
    ValueError
        For a file that cannot be read.
    TypeError
        For a ``path`` that is not one.

    >>> import trocar
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "own.csv")
    >>> with open(path, "w") as file:
    ...     _ = file.write("time_s,position_m,force_n\\n0,0.001,0\\n0.001,0.0011,0.1\\n")
    >>> [(signal["name"], signal["samples"]) for signal in trocar.list_signals(path)["signals"]]
    [('time_s', 2), ('position_m', 2), ('force_n', 2)]
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

    Returns
    -------
    dict
        ``time`` (s), ``position`` (m), ``velocity`` (m/s, or ``None``) and ``force`` (N), each float64 of the shape ``(samples,)``.

    Raises
    ------
    ValueError
        For a file that cannot be read, for a signal that it does not have, for an unknown unit, and for samples that are not finite.
    TypeError
        For a ``path`` that is not one, and for a name that is not a string.

    >>> import trocar
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "own.csv")
    >>> with open(path, "w") as file:
    ...     _ = file.write("t;x;f\\n0;1,5;2\\n0,001;1,6;3\\n")
    >>> trocar.read_recording(path, time="t", position="x:mm", force="f:-1")["position"]
    array([0.0015, 0.0016])
    """
    return cast(Recording, _core.read_recording(os.fspath(path), time, position, velocity, force))
