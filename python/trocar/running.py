"""Running scenarios."""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._html import quantity, table
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class Run:
    """A scenario that was run.

    ``run["slave_position_m"]`` is a column of the trace. Every column has the shape ``(ticks,)``, a value per tick, and is
    float64, but for ``mode``, which is uint8. :func:`trocar.trace_columns` lists them with units and meanings.

    Some estimators have one column more, ``friction_n`` (N) or ``power``. A run that diverged ends early: that is a result,
    in ``run.metrics["outcome"]``.
    """

    def __init__(self, scenario: Scenario, core: _core.Run, traces: dict[str, NDArray[Any]]) -> None:
        self.scenario = scenario
        self.traces = traces
        self._core = core

    def __getitem__(self, column: str) -> NDArray[Any]:
        return self.traces[column]

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What ``summary.json`` of the command line holds. Undefined values are ``None``."""
        return self._core.summary()

    @property
    def metrics(self) -> dict[str, Any]:
        """Every metric, in SI units; the names carry the unit. Undefined values are ``None``."""
        return dict(self.summary["metrics"])

    @property
    def events(self) -> list[dict[str, Any]]:
        """The augmented events, in time order."""
        return list(self.summary["metrics"]["events"])

    @property
    def ruptures(self) -> list[dict[str, Any]]:
        """The ruptures with what became of each, in time order."""
        return list(self.summary["metrics"]["ruptures"])

    @property
    def alarms_s(self) -> NDArray[np.float64]:
        """When alarms were taken, in s; shape (alarms,)."""
        return np.array([alarm["time_s"] for alarm in self.summary["metrics"]["alarms"]], dtype=np.float64)

    def to_dataframe(self) -> pandas.DataFrame:
        """The trace as a pandas DataFrame, a column each, indexed by ``time_s``."""
        import pandas

        return pandas.DataFrame(self.traces).set_index("time_s")

    def plot(self, **options: Any) -> Figure:
        """Positions, forces and decision over time, drawn by matplotlib; ``options`` go to ``matplotlib.pyplot.subplots``."""
        from ._figures import run_figure

        return run_figure(self, **options)

    def __str__(self) -> str:
        return self._core.text()

    def __repr__(self) -> str:
        return f"Run({self.scenario.name!r}, {len(self.traces['time_s'])} ticks)"

    def _repr_html_(self) -> str:
        rows = [(label, quantity(value, unit)) for _, label, unit, value in self._core.rows()]
        return table(["metric", self.scenario.name], rows)


def run(scenario: Scenario | str | os.PathLike[str]) -> Run:
    """Runs a scenario, given as such or as a path, for its trace and its metrics. The same scenario gives the same bits.

    >>> import trocar
    >>> run = trocar.run("builtin:augmented.toml")
    >>> run["slave_position_m"].shape
    (17000,)
    >>> [event["frozen_motion_m"] < 1e-4 for event in run.events]
    [True, True]
    """
    scenario = scenario_of(scenario)
    core, traces = _core.run(scenario._core)
    return Run(scenario, core, traces)
