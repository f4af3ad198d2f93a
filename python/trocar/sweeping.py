"""Sweeps: many runs of a scenario with varied keys, on one machine or several."""

from __future__ import annotations

import os
import pickle
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import whole
from ._columns import Columns
from ._frames import freeze
from ._grid import grid_of, is_label
from ._job import Job, Points, Swept, job_of
from ._parts import Compiled, Parts, core_parts
from ._progress import Progress
from ._stored import PARTIAL, Stored
from ._workers import Workers, workers_of
from .documents import Documented
from .people import Patients
from .ranges import Range
from .running import samples_of, scenario_from
from .scenario import Scenario

if TYPE_CHECKING:
    import pandas
    import xarray
    from typing_extensions import Unpack

_OUTCOMES = np.array(["completed", "diverged", "failed"])


class Sweep(Columns, Documented, Stored):
    """The result of a sweep, with a row per case, returned by :func:`sweep`.

    ``sweep["detected_ruptures"]`` is a column. An unknown column raises a ``KeyError``.

    Attributes
    ----------
    columns : dict of str to array
        Columns with the shape ``(cases,)``: ``case`` (int64), the labels of the points, such as ``patient``, a column per
        axis, named by its key, ``seed`` (int64), ``outcome`` (``"completed"``, ``"diverged"`` or ``"failed"``), and the metrics, float64 in SI units, NaN if
        undefined.
    hash : str
        The SHA-256 of all inputs of the sweep, as in the command line's ``manifest.json``.
    cases : int
        The number of cases of the whole sweep. A shard contains some of them.
    scenario : Scenario or None
        The varied scenario; ``None`` if a sweep file names it.

    >>> import trocar
    >>> sweep = trocar.sweep("layers/skin-augmented", {"scaling.force": [0.5, 1.0]}, seeds=2)
    >>> len(sweep), sweep.cases, sweep["scaling.force"], sweep["seed"]
    (4, 4, array([0.5, 0.5, 1. , 1. ]), array([1, 2, 1, 2]))
    """

    def __init__(
        self, columns: dict[str, NDArray[Any]], hash: str, cases: int, inputs: str, scenario: Scenario | None = None
    ) -> None:
        freeze(columns)
        self.columns = self._columns = columns
        self.hash = hash
        self.cases = cases
        self.scenario = scenario
        # The text from which the hash is computed.
        self._inputs = inputs

    _keys = {"sweep", "cases", "inputs"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        scenario = self.scenario
        described: dict[str, Any] = {"sweep": self.hash, "cases": self.cases, "inputs": self._inputs}
        kept = {} if scenario is None else samples_of(scenario)
        if scenario is not None:
            described |= {"name": scenario.name, "toml": scenario.to_toml()}
        return kept | self.columns, described

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Sweep:
        scenario = scenario_from(about["name"], about["toml"], arrays) if "toml" in about else None
        return cls(arrays, about["sweep"], about["cases"], about["inputs"], scenario)

    def __len__(self) -> int:
        return len(self.columns["case"])

    @property
    def labels(self) -> list[str]:
        """The columns of the points that are no keys, such as ``patient``."""
        varied = list(self.columns)[1 : list(self.columns).index("seed")]
        return [name for name in varied if is_label(name)]

    @property
    def axes(self) -> list[str]:
        """The varied keys."""
        varied = list(self.columns)[1 : list(self.columns).index("seed")]
        return [name for name in varied if not is_label(name)]

    def _units(self) -> dict[str, tuple[str, str]]:
        return {name: (unit, meaning) for name, _, _, unit, _, meaning in _core.metrics()}

    def to_xarray(self) -> xarray.Dataset:
        """Returns the columns as an xarray Dataset. Metrics have ``units`` and a ``long_name``.

        A grid has a dimension per axis, named by its key, and the dimension ``seed`` if there are several. Labels with
        a grid, such as patients, are a dimension with their keys as coordinates. Other designs have the dimension
        ``case``.

        >>> import trocar
        >>> axes = {"scaling.force": [0.5, 1.0], "detector.threshold": [0.01, 0.02, 0.05]}
        >>> dict(trocar.sweep("layers/skin-augmented", axes, seeds=2).to_xarray().sizes)
        {'scaling.force': 2, 'detector.threshold': 3, 'seed': 2}
        """
        varied = list(self.columns)[1 : list(self.columns).index("seed") + 1]
        return grid_of(self.columns, varied, self._units()) or self._to_xarray("case", self._units())

    @staticmethod
    def merge(parts: Iterable[Sweep]) -> Sweep:
        """Joins the parts of a sweep that :func:`sweep` returned for its ``shard``, in any order. The result equals that
        of the whole sweep.

        Parameters
        ----------
        parts
            All parts, each once; empty parts may be missing.

        Raises
        ------
        ValueError
            For no part, parts of different sweeps, and missing or repeated cases.
        TypeError
            If a part is not a :class:`Sweep`.

        >>> import trocar
        >>> axes = {"scaling.force": [0.5, 0.75, 1.0]}
        >>> parts = [trocar.sweep("layers/skin-augmented", axes, shard=f"{part}/3") for part in (3, 1, 2)]
        >>> trocar.Sweep.merge(parts)["scaling.force"]
        array([0.5 , 0.75, 1.  ])
        """
        given = list(parts)
        if not all(isinstance(part, Sweep) for part in given):
            raise TypeError("parts are the results of sweep(..., shard=...), in a list")
        by_case = sorted((part for part in given if len(part)), key=lambda part: int(part["case"][0]))
        if not by_case:
            raise ValueError("there is no part to merge")
        first = by_case[0]
        if any(part.hash != first.hash or list(part) != list(first) for part in given if len(part)):
            raise ValueError(
                "the parts are not of the same sweep: their arguments, their versions of trocar or the contents of the scenario's files differ"
            )
        columns = {name: np.concatenate([part[name] for part in by_case]) for name in first}
        if not np.array_equal(columns["case"], np.arange(first.cases)):
            found = len(np.unique(columns["case"]))
            repeated = len(columns["case"]) - found
            raise ValueError(f"the parts have {found} of {first.cases} cases, and {repeated} of them more than once; give each part once")
        return Sweep(columns, first.hash, first.cases, first._inputs, first.scenario)

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns the columns as a pandas DataFrame, indexed by ``case``."""
        import pandas

        return pandas.DataFrame(self.columns).set_index("case")

    def __repr__(self) -> str:
        of_all = "" if len(self) == self.cases else f" of {self.cases}"
        return f"Sweep({len(self)}{of_all} cases, columns {', '.join(self.columns)})"

    def __str__(self) -> str:
        return str(self.document) if len(self) == self.cases else repr(self)

    def _repr_html_(self) -> str | None:
        return self.document._repr_html_() if len(self) == self.cases else None

    @property
    def _contents(self) -> dict[str, Any]:  # type: ignore[override]
        if len(self) < self.cases:
            raise ValueError(f"{len(self)} of {self.cases} cases have no document; merge the parts of the sweep")
        # The words of the outcomes are in alphabetical order.
        outcomes = np.searchsorted(_OUTCOMES, self.columns["outcome"]).astype(np.uint8)
        metrics = {name: np.ascontiguousarray(column) for name, column in self.columns.items() if column.dtype.kind == "f"}
        return _core.sweep_document(self._inputs, self.hash, outcomes, metrics)


def sweep(
    base: Scenario | Patients | str | os.PathLike[str],
    axes: Mapping[str, Range | Sequence[Any] | NDArray[Any]] | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    seeds: int | Sequence[int] = 1,
    first_seed: int | None = None,
    metrics: Sequence[str] | None = None,
    design: str = "grid",
    points: int | Points | Patients | None = None,
    design_seed: int | None = None,
    threads: int = 0,
    folder: str | os.PathLike[str] | None = None,
    progress: bool = False,
    executor: Any = None,
    client: Any = None,
    shards: int | None = None,
    shard: str | None = None,
    **parts: Unpack[Parts],
) -> Sweep:
    """Runs a scenario many times with varied keys. The results do not depend on the number of threads or machines.

    Parameters
    ----------
    base
        The scenario, or :func:`trocar.patients`, each of whom is combined with every point of the axes; without
        ``axes`` and ``points``, the path of a sweep file, such as ``"builtin:sweeps/small.toml"``.
    axes
        The varied keys, each with a list of values or a :class:`Range`.
    set
        Keys to set in all cases.
    seeds, first_seed
        Number of noise seeds per point, and the first seed; the defaults are 1 and the seed of the scenario.
        ``seeds`` can also be a list of seeds.
    metrics
        Metrics of each case, named as in ``list(trocar.metrics())``; the default is a selection.
    design, points, design_seed
        The design of axes: ``"grid"`` (every combination), ``"random"``, ``"latin-hypercube"`` or ``"sobol"``. All
        except the grid need a number of ``points`` and can have a ``design_seed``. Without axes, ``points`` contains
        the points: a table (of pandas, polars, pyarrow or DuckDB) or a dictionary with a column per key, or a list of
        dictionaries, one per point. Columns without a dot that are no keys, such as ``patient``, are labels: the
        result has them, too.
    threads
        Number of threads on one machine, up to 1024; 0 is one per processor. With an executor, the number of threads
        per shard; 0 is one.
    folder
        A folder for complete shards, with which the same call continues after an interruption. A folder holds one
        sweep.
    progress
        True to show the progress, with tqdm if installed, otherwise as a line on standard error.
    executor
        Runs the shards on other workers: an executor of ``concurrent.futures``, a ``dask.distributed.Client``, a
        ``joblib.Parallel``, a ``multiprocessing.Pool``, or the module ``ray``. The workers need the same version of
        trocar; the files of the scenario are sent along, except imported FMI units, which need the same paths.
    client
        The same as ``executor``.
    shards
        Number of shards; the default is eight per worker.
    shard
        Runs only one of several parts of the sweep, such as ``"3/8"``; :meth:`Sweep.merge` joins them. If there are
        few cases, a part can be empty.
    **parts
        User-defined parts in place of the scenario's, as for :func:`trocar.run`. The cases run one after the other
        unless all parts are compiled, or on the workers of an executor if the parts can be pickled. Metrics of the loop
        (``loop_...``) are undefined.

    Returns
    -------
    Sweep
        A row per case, in the order of the cases.

    Raises
    ------
    ScenarioError
        For a scenario or a sweep file that cannot be read, an unknown key, metric or design, a value out of range,
        and a key that is both swept and set. Raised before anything runs. It is a ``ValueError``.
    ValueError
        For points with different keys or lengths, a scenario with neither ``axes`` nor ``points``, ``threads``,
        ``shards`` or ``shard`` out of range, a ``folder`` with another sweep, another number of shards or a damaged
        file, parts together with a folder, a label with the name of a column, and keys of ``population``, whose members
        :func:`trocar.patients` draws.
    TypeError
        If the scenario is neither a ``Scenario`` nor a path, for values, points or keys of an invalid type, for an
        unknown kind of ``executor``, and for parts as in :func:`trocar.run`; also for parts that cannot be sent to
        the workers of an executor.
    OSError
        If ``folder`` cannot be created or written.
    MemoryError
        If the cases do not fit into memory. Raised before anything runs.
    Exception
        Any exception of a part; it ends the sweep.

    >>> import trocar
    >>> sweep = trocar.sweep("paper/augmented", {"scaling.force": [0.5, 1.0]}, set={"simulation.duration_s": 6.0})
    >>> sweep["detected_ruptures"]
    array([1., 1.])
    >>> points = [{"scaling.force": 0.5, "detector.threshold": 0.02}, {"scaling.force": 1.0, "detector.threshold": 0.05}]
    >>> trocar.sweep("paper/augmented", points=points, seeds=[4, 7], set={"simulation.duration_s": 6.0})["seed"]
    array([4, 7, 4, 7])
    >>> trocar.sweep("layers/skin-augmented", {"scaling.force": trocar.Range(0.5, 1.0, 16)}, shard="1/2")
    Sweep(8 of 16 cases, columns case, scaling.force, seed, outcome, ...)
    """
    threads = whole("threads", threads)
    job = job_of(base, axes, set, seeds, first_seed, metrics, design, points, design_seed)
    executor = client if executor is None else executor
    user_defined_parts = core_parts(parts)
    if user_defined_parts:
        if folder is not None:
            raise ValueError("a folder cannot tell whether user-defined parts have changed: leave out folder, and save the result")
        if executor is not None:
            _check_sendable(user_defined_parts)
        job = replace(job, parts=user_defined_parts)
    if shard is not None:
        if any(given is not None for given in (executor, folder, shards)):
            raise ValueError("shard runs one part in this process: leave out executor, folder and shards, or shard")
        with Progress("cases", progress) as bar:
            return _result(job.run(shard, threads, bar.tell), job)
    if executor is None and folder is None and (shards is None or user_defined_parts):
        with Progress("cases", progress) as bar:
            return _result(job.run("1/1", threads, bar.tell), job)
    return _in_shards(job, workers_of(executor), shards, threads, None if folder is None else Path(folder), progress)


def _result(swept: Swept, job: Job) -> Sweep:
    columns, hash, cases, inputs = swept
    arrays = {name: _OUTCOMES[column] if name == "outcome" else np.asarray(column) for name, column in columns.items()}
    case = arrays.pop("case")
    labels = {}
    for name, values in job.labels.items():
        if name in ("case", *arrays):
            raise ValueError(f"the label {name} has the name of a column of the result; give it another name")
        labels[name] = values[case // job.seeds]
    return Sweep({"case": case, **labels, **arrays}, hash, cases, inputs, job.base)


def _check_sendable(parts: dict[str, Any]) -> None:
    """Raises an error for parts that workers cannot receive."""
    for role, part in parts.items():
        try:
            if isinstance(part, Compiled):
                raise TypeError("a compiled function exists in one process only")
            pickle.dumps(part)
        except Exception as error:
            raise TypeError(
                f"the {role} cannot be sent to the workers of an executor ({error}): define it at the top of a module, as a "
                "function or as a class with a method step, or leave out executor"
            ) from None


_SHARD = re.compile(r"shard-(\d+)-of-(\d+)\.npz\Z")


def _in_shards(
    job: Job, workers: Workers | None, shards: int | None, threads: int, folder: Path | None, progress: bool
) -> Sweep:
    shards = None if shards is None else whole("shards", shards, 1)
    hash, cases = job.plan()
    kept: dict[int, Sweep] = {}
    if folder is not None:
        kept, shards = _kept(folder, hash, shards)
    # Without workers, each shard is one step whose result is kept.
    count = shards or 8 * (8 if workers is None else workers.count)
    missing = [index for index in range(1, count + 1) if index not in kept]
    with Progress("cases", progress) as bar:
        done = sum(map(len, kept.values()))
        bar.tell(done, cases)
        names = [f"{index}/{count}" for index in missing]
        results: Iterator[tuple[str, Swept]]
        if workers is None:
            results = ((name, job.run(name, threads, lambda inside, _: bar.tell(done + inside, cases))) for name in names)
        else:
            results = workers.run(job.run, names, max(threads, 1))
        for name, swept in results:
            index, part = int(name.partition("/")[0]), _result(swept, job)
            done += len(part)
            if folder is not None:
                part.save(folder / f"shard-{index}-of-{count}.npz")
            kept[index] = part
            bar.tell(done, cases)
    return Sweep.merge(kept.values())


def _kept(folder: Path, hash: str, shards: int | None) -> tuple[dict[int, Sweep], int | None]:
    """Returns the shards in a folder, and their number. Removes partial files of a killed process."""
    folder.mkdir(parents=True, exist_ok=True)
    for partial in folder.glob(f"shard-*{PARTIAL}"):
        partial.unlink()
    kept: dict[int, Sweep] = {}
    for path in sorted(folder.iterdir()):
        found = _SHARD.match(path.name)
        if found is None:
            continue
        index, count = map(int, found.groups())
        part = Sweep.load(path)
        if part.hash != hash:
            raise ValueError(f"{folder} has the shards of another sweep; give another folder, or remove it")
        if shards not in (None, count):
            raise ValueError(f"{folder} has {count} shards, not {shards}; leave out shards, or give another folder")
        shards = count
        kept[index] = part
    return kept, shards
