"""Comparison of scenarios."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from . import _core
from ._arrays import whole
from ._parts import Parts, core_parts
from ._progress import Progress
from ._stored import Stored
from .warnings import warn
from .documents import Documented
from .running import Run
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure
    from typing_extensions import Unpack

_PAPER_PAIR = ("paper/classical", "paper/augmented")


class Comparison(Documented, Stored):
    """The comparison of several scenarios, returned by :func:`compare`. ``print`` shows its tables.

    Attributes
    ----------
    runs : list of Run
        The runs, in the order of the arguments.
    report : dict
        The content of the command line's ``comparison.json``: ``runs``, ``warnings``, ``table``, ``noise`` and, if
        present, ``paper_facts`` and ``seeds``.

    >>> import trocar
    >>> comparison = trocar.compare("paper/classical", "paper/augmented")
    >>> comparison
    Comparison(classical, augmented)
    >>> [len(run.events) for run in comparison.runs]
    [0, 2]
    """

    def __init__(
        self, report: dict[str, Any], contents: dict[str, Any], rows: list[tuple[str, str, list[float | None]]], runs: list[Run]
    ) -> None:
        self.report = report
        self.runs = runs
        self._contents = contents
        self._rows = rows

    _keys = {"comparison", "document", "rows", "runs"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        kept = [run._kept() for run in self.runs]
        arrays = {f"{place}/{name}": column for place, (columns, _) in enumerate(kept) for name, column in columns.items()}
        runs = [about for _, about in kept]
        return arrays, {"comparison": self.report, "document": self._contents, "rows": self._rows, "runs": runs}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Comparison:
        columns: list[dict[str, NDArray[Any]]] = [{} for _ in about["runs"]]
        for key, column in arrays.items():
            place, _, name = key.partition("/")
            columns[int(place)][name] = column
        rows = [(metric, unit, values) for metric, unit, values in about["rows"]]
        return cls(about["comparison"], about["document"], rows, [Run._of_kept(*kept) for kept in zip(columns, about["runs"])])

    @property
    def facts(self) -> list[dict[str, Any]] | None:
        """The paper's statements with the results of the shipped pair; ``None`` for other scenarios."""
        facts: list[dict[str, Any]] | None = self.report["paper_facts"]
        return facts

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns a pandas DataFrame with a row per metric, named as in ``comparison.csv``, its SI unit, and a column
        per scenario."""
        import pandas

        names = [run.scenario.name for run in self.runs]
        rows = [[unit, *values] for _, unit, values in self._rows]
        index = pandas.Index([metric for metric, _, _ in self._rows], name="metric")
        return pandas.DataFrame(rows, index=index, columns=["unit", *names])

    def plot(self, figure: str = "overlay", *, window: tuple[float, float] | None = None, **options: Any) -> Figure:
        """Draws ``"overlay"`` (all runs in the same axes) or ``"comparison"`` (one row per run) with matplotlib.
        Shows the time around the first rupture, or the ``window`` of time in s. Options and errors as for
        :meth:`Run.plot`."""
        from ._figures import draw, window_of

        return draw(_core.run_figure(figure, [run._drawn() for run in self.runs], window_of(window)), **options)

    def _further_figures(self) -> dict[str, Any]:
        return _core.comparison_figures([run._drawn() for run in self.runs])

    def __repr__(self) -> str:
        return f"Comparison({', '.join(run.scenario.name for run in self.runs)})"


def compare(
    *scenarios: Scenario | str | os.PathLike[str] | Iterable[Scenario | str | os.PathLike[str]],
    seeds: int | None = None,
    schemes: bool = False,
    threads: int = 0,
    progress: bool = False,
    **parts: Unpack[Parts],
) -> Comparison:
    """Runs and compares scenarios. Each also runs with added noise. Without arguments, compares the shipped pair.

    Parameters
    ----------
    *scenarios
        Scenarios or paths, one by one or in a list.
    schemes
        True to compare one scenario with every passivity scheme that its architecture allows, and without one.
    seeds
        Number of seeds with which each scenario also runs, from 2 to 100000, to get medians and central 95 %
        intervals.
    threads
        Number of threads, up to 1024; 0 is one per processor.
    progress
        True to show the progress of the seeds, with tqdm if installed, otherwise as a line on standard error.
    **parts
        User-defined parts for all scenarios, as for :func:`trocar.run`. The scenarios then run one after the other
        and without added noise. Their seeds run in threads if all parts are compiled.

    Returns
    -------
    Comparison
        The runs, their metrics in a table, and the paper's statements for the shipped pair.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        If ``seeds`` or ``threads`` is out of range, for ``schemes`` with another number of scenarios than one or with
        parts, and for parts as in :func:`trocar.run`.
    TypeError
        If a scenario is neither a ``Scenario`` nor a path, if ``seeds`` or ``threads`` is not an integer, and for
        parts as in :func:`trocar.run`.
    Exception
        Any exception of a part; it ends the comparison.

    >>> import trocar
    >>> comparison = trocar.compare()
    >>> all(fact["holds"] for fact in comparison.facts or [])
    True
    """
    seeds = None if seeds is None else whole("seeds", seeds, 2)
    threads = whole("threads", threads)
    given: list[Scenario | str | os.PathLike[str]] = []
    for one in scenarios:
        if isinstance(one, (Scenario, str, os.PathLike)):
            given.append(one)
        elif isinstance(one, Iterable):
            given += one
        else:
            raise TypeError(f"a scenario is {one!r}, must be a Scenario, a path or a list of them")
    if scenarios and not given:
        raise ValueError("there is no scenario to compare")
    all_of_them = [scenario_of(scenario) for scenario in given or _PAPER_PAIR]
    if schemes:
        return _of_schemes(given, all_of_them, seeds, threads, progress, parts)
    with Progress("runs", progress and seeds is not None) as bar:
        report, contents, rows, runs = _core.compare(
            [scenario._core for scenario in all_of_them], seeds, not scenarios, threads, core_parts(parts), bar.tell
        )
    warn(report["warnings"])
    return Comparison(
        report, contents, rows, [Run(scenario, core, traces) for scenario, (core, traces) in zip(all_of_them, runs)]
    )


def _of_schemes(
    given: list[Any], scenarios: list[Scenario], seeds: int | None, threads: int, progress: bool, parts: Parts
) -> Comparison:
    if len(given) != 1 or core_parts(parts):
        raise ValueError("schemes=True compares the passivity schemes of one scenario, without user-defined parts")
    with Progress("runs", progress and seeds is not None) as bar:
        (report, contents, rows, runs), toml = _core.compare_schemes(
            scenarios[0]._core, seeds, threads, lambda done: bar.tell(done, max(done, 1))
        )
    warn(report["warnings"])
    changed = [Scenario.from_toml(text) for text in toml]
    return Comparison(report, contents, rows, [Run(scenario, core, traces) for scenario, (core, traces) in zip(changed, runs)])

