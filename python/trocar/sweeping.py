"""Sweeps: many runs of a scenario with varied keys, on one machine or on many."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._columns import Columns
from ._html import table
from ._parts import Parts, core_parts
from ._settings import dotted, key_of, value
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import pandas
    from typing_extensions import Unpack

_OUTCOMES = np.array(["completed", "diverged", "failed"])


@dataclass(frozen=True)
class Range:
    """An axis from one value to another: evenly spaced, or logarithmic if ``log``.

    ``points`` applies to a grid only; other designs have their own number of points.
    """

    start: float
    stop: float
    points: int | None = None
    log: bool = False

    def _table(self) -> dict[str, Any]:
        table: dict[str, Any] = {"from": self.start, "to": self.stop}
        if self.points is not None:
            table["points"] = self.points
        if self.log:
            table["log"] = True
        return table


class Sweep(Columns):
    """The result of a sweep, a row per case.

    Attributes
    ----------
    columns : dict of str to array
        Each of the shape ``(cases,)``: ``case`` (int64), a column per axis by its key, ``seed`` (int64), ``outcome``
        (``"completed"``, ``"diverged"`` or ``"failed"``), and the metrics, float64 in SI units, NaN where undefined.
    hash : str
        The SHA-256 of all inputs of the sweep, as in ``manifest.json`` of the command line.
    """

    def __init__(self, columns: dict[str, Any], hash: str) -> None:
        self.columns: dict[str, NDArray[Any]] = {
            name: _OUTCOMES[column] if name == "outcome" else np.asarray(column) for name, column in columns.items()
        }
        self._columns = self.columns
        self.hash = hash

    def __len__(self) -> int:
        return len(self.columns["case"])

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns the columns as a pandas DataFrame, indexed by ``case``."""
        import pandas

        return pandas.DataFrame(self.columns).set_index("case")

    def __repr__(self) -> str:
        return f"Sweep({len(self)} cases, columns {', '.join(self.columns)})"

    def _repr_html_(self) -> str:
        rows = []
        for name in list(self.columns)[1:]:
            column = self.columns[name]
            if column.dtype.kind == "f":
                defined = column[np.isfinite(column)]
                count, numbers = len(defined), np.quantile(defined, [0, 0.5, 1]) if len(defined) else []
                rows.append((name, str(count), *(f"{number:.4g}" for number in numbers), *([] if count else ["—"] * 3)))
        return table(["column", "defined", "min", "median", "max"], rows, caption=f"{len(self)} cases")


def sweep(
    base: Scenario | str | os.PathLike[str],
    axes: Mapping[str, Range | Sequence[Any] | NDArray[Any]] | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    seeds: int = 1,
    first_seed: int | None = None,
    metrics: Sequence[str] | None = None,
    design: str = "grid",
    points: int | None = None,
    design_seed: int | None = None,
    threads: int = 0,
    client: Any = None,
    shards: int | None = None,
    **parts: Unpack[Parts],
) -> Sweep:
    """Runs a scenario many times with varied keys. The results do not depend on the number of threads and machines.

    Parameters
    ----------
    base
        The scenario; without ``axes``, the path of a sweep file.
    axes
        The varied keys, each with a list of values or a :class:`Range`.
    set
        Keys of all cases.
    seeds, first_seed
        Number of noise seeds per point, and the first seed; the defaults are 1 and the seed of the scenario.
    metrics
        Metrics of each case, by the names of ``trocar.metric_names()``; the default is a selection.
    design, points, design_seed
        The design: ``"grid"`` (every combination), ``"random"``, ``"latin-hypercube"`` or ``"sobol"``. All but the grid
        need ``points`` and can have a ``design_seed``.
    threads
        Number of threads on one machine; 0 is one per processor. With a client, the number of threads per shard; 0 is one.
    client
        A ``dask.distributed.Client``: its workers run the shards, and the shards of a lost worker run again. The workers need
        the same version of trocar, and the files of the scenario at the same paths.
    shards
        Number of shards; the default is eight per worker thread.
    **parts
        Parts of one's own in place of the scenario's, as for :func:`trocar.run`. The cases then run one after the other, and metrics of
        the loop (``loop_...``) are undefined.

    >>> import trocar
    >>> sweep = trocar.sweep("paper/augmented", {"scaling.force": [0.5, 1.0]}, set={"simulation.duration_s": 6.0})
    >>> sweep["detected_ruptures"]
    array([1., 1.])
    """
    if axes is None:
        others = (set, first_seed, metrics, points, design_seed)
        if isinstance(base, Scenario) or any(one is not None for one in others) or seeds != 1 or design != "grid":
            raise ValueError("without axes, base must be the path of a sweep file, without other arguments of the sweep")
        job = _Job(os.fspath(base), "", None, [])
    else:
        shared = dict(set or {})
        lines = _header(seeds, first_seed, metrics, design, points, design_seed)
        lines += _section("set", shared)
        lines += _section("axes", {key: _levels(one) for key, one in axes.items()})
        scenario = scenario_of(base)
        # Keys of the sweep have priority over changes of the scenario.
        overridden = {*shared, *axes}
        changes = [setting for call in scenario._core.origin()[3] for setting in call]
        own = [setting for setting in changes if key_of(setting) not in overridden]
        job = _Job(None, "\n".join(lines) + "\n", scenario, own)
    own_parts = core_parts(parts)
    if own_parts and client is not None:
        raise ValueError("a sweep with parts of one's own_parts runs here: give no client")
    if client is None:
        columns, hash, _, former_names = job.run_with(own_parts) if own_parts else job.run("1/1", threads)
        _name_former(former_names)
        return Sweep(columns, hash)
    return _over_workers(job, client, shards, max(threads, 1))


def _name_former(former_names: list[tuple[str, str]]) -> None:
    for former, name in former_names:
        warnings.warn(f"the metric {former} is called {name} now", FutureWarning, stacklevel=3)


def _levels(given: Any) -> Any:
    return given._table() if isinstance(given, Range) else given


def _section(name: str, values: Mapping[str, Any]) -> list[str]:
    lines = [f"{dotted(key)} = {value(key, one)}" for key, one in values.items()]
    return [f"[{name}]", *lines] if lines else []


def _header(
    seeds: int,
    first_seed: int | None,
    metrics: Sequence[str] | None,
    design: str,
    points: int | None,
    design_seed: int | None,
) -> list[str]:
    all_of_them: dict[str, Any] = {
        "seeds": seeds,
        "first_seed": first_seed,
        "metrics": None if metrics is None else list(metrics),
        "design.kind": design,
        "design.points": points,
        "design.seed": design_seed,
    }
    return [f"{key} = {value(key, given)}" for key, given in all_of_them.items() if given is not None]


@dataclass(frozen=True)
class _Job:
    """The inputs of a shard, which are sent to the workers."""

    path: str | None
    text: str
    base: Scenario | None
    settings: list[str]

    def run(self, shard: str, threads: int) -> tuple[dict[str, Any], str, int, list[tuple[str, str]]]:
        base = None if self.base is None else self.base._core
        return _core.sweep(self.path, self.text, base, self.settings, shard, threads)

    def run_with(self, parts: dict[str, Any]) -> tuple[dict[str, Any], str, int, list[tuple[str, str]]]:
        base = None if self.base is None else self.base._core
        return _core.sweep_with(self.path, self.text, base, self.settings, parts)


def _over_workers(job: _Job, client: Any, shards: int | None, threads: int) -> Sweep:
    if shards is None:
        shards = 8 * max(1, sum(client.nthreads().values()))
    if shards < 1:
        raise ValueError(f"shards is {shards}, must be at least 1")
    # A lost worker counts as an attempt; `retries` are for errors that do not come from the shard.
    futures = client.map(job.run, [f"{shard}/{shards}" for shard in range(1, shards + 1)], [threads] * shards, pure=False, retries=2)
    try:
        parts = client.gather(futures)
    except BaseException:
        client.cancel(futures)
        raise
    _name_former(parts[0][3])
    hashes = {hash for _, hash, _, _ in parts}
    if len(hashes) > 1:
        raise RuntimeError(
            "the workers did not run the same sweep: their versions of trocar or the contents of the scenario's files differ"
        )
    columns = {name: np.concatenate([np.asarray(part[name]) for part, _, _, _ in parts if len(part["case"])]) for name in parts[0][0]}
    cases = parts[0][2]
    if not np.array_equal(columns["case"], np.arange(cases)):
        raise RuntimeError(f"the workers returned {len(columns['case'])} of {cases} cases")
    return Sweep(columns, hashes.pop())
