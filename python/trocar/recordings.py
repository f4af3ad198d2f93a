"""Reads recordings from files: CSV, MATLAB, Parquet, TDMS, HDF5, Excel."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from . import _core
from ._columns import Columns
from ._frames import freeze, stream

if TYPE_CHECKING:
    import pandas


class Recording(Columns):
    """Samples of a recording, returned by :func:`read_recording`: a mapping for the first arguments of
    :func:`trocar.detect`, and a table for polars, pyarrow, pandas and DuckDB.

    The columns are ``time`` (s), ``position`` (m), ``velocity`` (m/s, or ``None`` if not measured) and ``force`` (N),
    each float64 with the shape ``(samples,)``.

    >>> import trocar
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "mine.csv")
    >>> trocar.run("layers/skin-augmented").to_dataframe().to_csv(path)
    >>> trocar.read_recording(path, position="slave_position_m", force="measured_force_n")
    Recording(9000 samples, time, position, force)
    """

    def __init__(self, columns: dict[str, Any]) -> None:
        freeze({name: column for name, column in columns.items() if column is not None})
        self._columns = columns

    def __arrow_c_stream__(self, requested_schema: object = None) -> Any:
        """Returns the columns, with their units in the names, for a library that reads Arrow."""
        units = {"time": "time_s", "position": "position_m", "velocity": "velocity_m_per_s", "force": "force_n"}
        return stream({units[name]: column for name, column in self._columns.items() if column is not None})

    def __len__(self) -> int:
        return len(self._columns)

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns the samples as a pandas DataFrame, indexed by ``time_s``."""
        import pandas

        units = {"time": "time_s", "position": "position_m", "velocity": "velocity_m_per_s", "force": "force_n"}
        columns = {units[name]: column for name, column in self._columns.items() if column is not None}
        return pandas.DataFrame(columns).set_index("time_s")

    def __repr__(self) -> str:
        return f"Recording({len(self['time'])} samples, {', '.join(name for name, column in self.items() if column is not None)})"


def list_signals(path: str | os.PathLike[str], *, skip_lines: int = 0) -> dict[str, Any]:
    """Lists the signals of a file.

    ``signals`` is a list with the ``name``, ``unit``, ``shape``, ``samples``, ``rate_hz``, ``min``, ``max`` and
    ``role`` of each signal; its name and unit suggest the role. ``command`` is a command line of the shell that detects in the file.

    Parameters
    ----------
    path
        A CSV (also in gzip), MATLAB, NumPy, Parquet, MCAP, TDMS, HDF5 or Excel file, or JSON lines.
    skip_lines
        The number of lines of text before the table. A preamble is usually found without it.

    Raises
    ------
    ValueError
        If the file cannot be read or has no signal.
    TypeError
        If ``path`` is not a path.

    >>> import trocar
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "mine.csv")
    >>> with open(path, "w") as file:
    ...     _ = file.write("time_s,position_m,force_n\\n0,0.001,0\\n0.001,0.0011,0.1\\n")
    >>> [(signal["name"], signal["samples"]) for signal in trocar.list_signals(path)["signals"]]
    [('time_s', 2), ('position_m', 2), ('force_n', 2)]
    """
    return dict(_core.list_signals(os.fspath(path), skip_lines))


def read_recording(
    path: str | os.PathLike[str],
    *,
    time: str = "time_s",
    position: str = "position_m",
    velocity: str | None = None,
    force: str = "force_n",
    rate_hz: float | None = None,
    skip_lines: int = 0,
    zero_at_start: bool = False,
) -> Recording:
    """Reads a recording for :func:`trocar.detect` and :func:`trocar.calibrate`, as in
    ``trocar.detect(**trocar.read_recording(path))``.

    Parameters
    ----------
    path
        A CSV (also in gzip), MATLAB, NumPy, Parquet, MCAP, TDMS, HDF5 or Excel file, or JSON lines.
    time, position, velocity, force
        The names of the signals, as :func:`list_signals` returns them. A signal that is not in SI units has a factor
        or a unit after a colon, as in ``"scope.signals[0].values[:,1]:mm"``, and may have an offset, as in
        ``"z:-mm+100mm"``. Without ``velocity``, it is estimated from the positions. A column that states another unit
        and has no factor raises a warning, and so does a file that seems to end before the recording did.
    rate_hz
        Samples per second of a file without a time; ``time`` is then not read.
    skip_lines
        The number of lines of text before the table. A preamble is usually found without it.
    zero_at_start
        True to subtract the first position from all positions.

    Returns
    -------
    Recording
        A mapping of ``time`` (s), ``position`` (m), ``velocity`` (m/s, or ``None``) and ``force`` (N), each float64 with
        the shape ``(samples,)``; also a table.

    Raises
    ------
    ValueError
        For a file that cannot be read, a signal that the file does not contain, an unknown unit, and samples that are
        not finite.
    TypeError
        If ``path`` is not a path, or a name is not a string.

    >>> import trocar
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "mine.csv")
    >>> with open(path, "w") as file:
    ...     _ = file.write("t;x;f\\n0;1,5;2\\n0,001;1,6;3\\n")
    >>> trocar.read_recording(path, time="t", position="x:mm", force="f:-1")["position"]
    array([0.0015, 0.0016])
    """
    options = (rate_hz, skip_lines, zero_at_start)
    return Recording(_core.read_recording(os.fspath(path), time, position, velocity, force, *options))
