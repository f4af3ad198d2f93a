"""Comparing scenarios."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from . import _core
from ._html import quantity, table
from .running import Run
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

_PAPER_PAIR = ("builtin:classical.toml", "builtin:augmented.toml")


class Comparison:
    """Scenarios side by side.

    Attributes
    ----------
    runs : list of Run
        In the order given.
    report : dict
        What ``comparison.json`` of the command line holds: ``runs``, ``table``, ``noise``, ``paper_facts``, ``seeds``.
    """

    def __init__(self, report: dict[str, Any], text: str, rows: list[tuple[str, str, str, list[float | None]]], runs: list[Run]) -> None:
        self.report = report
        self.runs = runs
        self._text = text
        self._rows = rows

    @property
    def facts(self) -> list[dict[str, Any]] | None:
        """The paper's facts beside ours, for the shipped pair; else ``None``."""
        facts: list[dict[str, Any]] | None = self.report["paper_facts"]
        return facts

    def to_dataframe(self) -> pandas.DataFrame:
        """A row per metric, named as in ``comparison.csv``, with its SI unit, a column per scenario."""
        import pandas

        names = [run.scenario.name for run in self.runs]
        rows = [[unit, *values] for _, _, unit, values in self._rows]
        index = pandas.Index([metric for metric, _, _, _ in self._rows], name="metric")
        return pandas.DataFrame(rows, index=index, columns=["unit", *names])

    def plot(self, **options: Any) -> Figure:
        """Slave positions and fed-back forces of all runs, drawn by matplotlib."""
        from ._figures import comparison_figure

        return comparison_figure(self, **options)

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"Comparison({', '.join(run.scenario.name for run in self.runs)})"

    def _repr_html_(self) -> str:
        rows = [(label, *(quantity(value, unit) for value in values)) for _, label, unit, values in self._rows]
        return table(["metric", *(run.scenario.name for run in self.runs)], rows)


def compare(*scenarios: Scenario | str | os.PathLike[str], seeds: int | None = None) -> Comparison:
    """Runs scenarios side by side, each also in noise; with none, the shipped pair, classical against augmented.

    Parameters
    ----------
    *scenarios
        Scenarios or paths.
    seeds
        How many seeds each is also run with, for medians and the middle 95 %; from 2 on.
    """
    all_of_them = [scenario_of(scenario) for scenario in scenarios or _PAPER_PAIR]
    report, text, rows, runs = _core.compare([scenario._core for scenario in all_of_them], seeds, not scenarios)
    return Comparison(
        report, text, rows, [Run(scenario, core, traces) for scenario, (core, traces) in zip(all_of_them, runs)]
    )
