"""Identification of machines, arms and tissues from recordings."""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import Recorded, samples
from ._frames import columns_of_frame, is_frame
from ._progress import Progress
from ._stored import Stored
from .warnings import warn
from .documents import Documented
from .scenario import Scenario

Machine = Literal["slave", "master", "arm", "tissue"]


class Identification(Documented, Stored):
    """An identified machine, arm or tissue, returned by :func:`identify`. ``print`` shows its tables.

    Attributes
    ----------
    report : dict
        The content of the command line's ``identification.json``.
    files : dict of str to str
        The text of the files by name: ``machine.toml`` with the parameters; a scenario, ``slave.toml``, ``master.toml``,
        ``arm.toml`` or ``tissue.toml``; with ``slave.toml`` also ``twin.toml``, a sweep over the intervals.
    data : dict of str to dict
        For each recording, the columns of the measured and the simulated signal.

    >>> import trocar
    >>> recorded = trocar.run("layers/through-the-skin").to_dataframe().reset_index()
    >>> recorded = recorded[recorded["time_s"] < 4.5]
    >>> found = trocar.identify(recorded, machine="tissue", slave="slave_position_m", force="tissue_force_n")
    >>> found.scenario is not None and "tissue.toml" in found.files
    True
    """

    def __init__(
        self, report: dict[str, Any], contents: dict[str, Any], files: dict[str, str], data: dict[str, dict[str, Any]]
    ) -> None:
        self.report = report
        self.files = files
        self.data = data
        self._contents = contents

    _keys = {"identification", "document", "files"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        arrays = {f"{table}/{name}": np.asarray(column) for table, columns in self.data.items() for name, column in columns.items()}
        return arrays, {"identification": self.report, "document": self._contents, "files": self.files}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Identification:
        data: dict[str, dict[str, Any]] = {}
        for key, column in arrays.items():
            table, _, name = key.rpartition("/")
            data.setdefault(table, {})[name] = column
        return cls(about["identification"], about["document"], about["files"], data)

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """The parameters by name, each with ``value``, the ends ``low`` and ``high`` of its 95 % interval (``None`` if the
        recordings do not determine it) and ``unit``."""
        return dict(self.report["parameters"])

    @property
    def scenario(self) -> Scenario | None:
        """The scenario with what was identified; ``None`` if the recordings do not determine forces."""
        for name in ("slave.toml", "master.toml", "arm.toml", "tissue.toml"):
            if name in self.files:
                return Scenario.from_toml(self.files[name], name)
        return None

    def __repr__(self) -> str:
        return f"Identification({self.report['machine']!r}, {', '.join(self.parameters)})"


Recordings = Recorded | str | os.PathLike[str]
"""A recording: a path, a table or a dictionary of columns."""


def identify(
    recordings: Recordings | Sequence[Recordings],
    *,
    machine: Machine = "slave",
    predict: Recordings | Sequence[Recordings] = (),
    time: str = "time_s",
    force: str = "force_n",
    master: str | None = None,
    slave: str | None = None,
    actuator: str | None = None,
    desired: str | None = None,
    progress: bool = False,
) -> Identification:
    """Identifies a slave with its controller, a master, an operator's arm or a tissue from recordings: parameters with
    95 % intervals, and predictions of other recordings.

    Parameters
    ----------
    recordings
        One recording or a list: files (CSV, MATLAB, Parquet, TDMS, HDF5, Excel), tables (of pandas, polars, pyarrow or
        DuckDB) or dictionaries of columns.
    machine
        What is identified.
    predict
        Recordings that are predicted, and not used for the estimation.
    time, force
        The columns with the time and the force. A column that is not in SI units has a factor or a unit after a colon,
        as in ``"xs_mm:mm"``. The force of slave and tissue acts on the slave and is positive when it resists; that of
        arm and master is the force of the hand, positive when it pushes forwards.
    master
        The column with the position of the master, for a slave scaled to its side (slave, arm, master).
    slave
        The column with the position of the slave or the needle, increasing into the tissue (slave, tissue).
    actuator
        The column with the force of the motor, positive when it pushes forwards (optional for slave and master).
    desired
        The column with the position that the hand is to have (optional for an arm).
    progress
        True to show the progress.

    Raises
    ------
    ValueError
        For a recording that cannot be read, lacks a column or determines nothing, for another ``machine``, and for a
        column that is missing or not used for this machine.
    TypeError
        If a recording is neither a path nor a table.

    >>> import numpy as np, trocar
    >>> time_s = np.arange(0.0, 4.0, 0.001)
    >>> depth_m = 0.01 * (1.0 - np.cos(2.0 * np.pi * 0.5 * time_s))
    >>> needle = {"time_s": time_s, "z_mm": 1e3 * depth_m, "force_n": 300.0 * depth_m}
    >>> found = trocar.identify(needle, machine="tissue", slave="z_mm:mm")
    >>> round(found.parameters["stiffness_n_per_m"]["value"])
    300
    """
    columns = {"time": time, "master": master, "slave": slave, "force": force, "actuator": actuator, "desired": desired}
    with tempfile.TemporaryDirectory(prefix="trocar-identify-") as folder, Progress("steps", progress) as bar:
        training, others = _paths(recordings, "recording", Path(folder)), _paths(predict, "prediction", Path(folder))
        if not training:
            raise ValueError("there is no recording to identify from")
        try:
            report, contents, files, data = _core.identify(machine, training, others, folder, columns, bar.tell)
        except ValueError as error:
            # The user does not know the folder.
            raise ValueError(str(error).replace(f"{folder}{os.sep}", "")) from None
    warn(contents["warnings"])
    return Identification(report, contents, dict(files), data)


def _paths(given: Any, name: str, folder: Path) -> list[str]:
    """Returns the paths of recordings. Writes those in memory into a folder."""
    is_one = isinstance(given, (str, os.PathLike)) or is_frame(given) or hasattr(given, "keys")
    return [_path(one, f"{name}_{number}", folder) for number, one in enumerate([given] if is_one else list(given), 1)]


def _path(given: Any, name: str, folder: Path) -> str:
    if isinstance(given, (str, os.PathLike)):
        return os.fspath(given)
    if is_frame(given):
        given = columns_of_frame(given)
    if not hasattr(given, "keys"):
        raise TypeError(f"a recording is a path, a table or a dictionary of columns, not {type(given).__qualname__}")
    names = [str(key) for key in given.keys()]
    columns = [samples(key, given[key]) for key in names]
    if len({len(column) for column in columns}) != 1:
        raise ValueError(f"the columns of {name} have different lengths")
    path = folder / f"{name}.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        # The text of a float is exact.
        writer.writerows(zip(*(column.tolist() for column in columns)))
    return str(path)
