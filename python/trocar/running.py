"""Runs of scenarios."""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._html import quantity, table
from ._parts import Part, core_parts
from ._warnings import warn
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class Run:
    """The result of a run.

    ``run["slave_position_m"]`` is a column of the trace. Every column has the shape ``(ticks,)`` and is
    float64, except ``mode`` and ``estimate_flags``, which are uint8. :func:`trocar.trace_columns` lists them with units and meanings.

    Some estimators have an extra column, ``friction_n`` (N) or ``power``. A diverged run ends early, which
    ``run.metrics["outcome"]`` shows.
    """

    def __init__(self, scenario: Scenario, core: _core.Run, traces: dict[str, NDArray[Any]]) -> None:
        self.scenario = scenario
        self.traces = traces
        self._core = core

    def __getitem__(self, column: str) -> NDArray[Any]:
        return self.traces[column]

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of ``summary.json`` of the command line. Undefined values are ``None``."""
        return self._core.summary()

    @property
    def metrics(self) -> dict[str, Any]:
        """All metrics, in SI units; names end with the unit. Undefined values are ``None``."""
        return dict(self.summary["metrics"])

    @property
    def events(self) -> list[dict[str, Any]]:
        """The events, in order of time."""
        return list(self.summary["metrics"]["events"])

    @property
    def ruptures(self) -> list[dict[str, Any]]:
        """The ruptures with their metrics, in order of time."""
        return list(self.summary["metrics"]["ruptures"])

    @property
    def alarms_s(self) -> NDArray[np.float64]:
        """The times of the alarms, in s; shape (alarms,)."""
        return np.array([alarm["time_s"] for alarm in self.summary["metrics"]["alarms"]], dtype=np.float64)

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns the trace as a pandas DataFrame, indexed by ``time_s``."""
        import pandas

        return pandas.DataFrame(self.traces).set_index("time_s")

    def plot(self, **options: Any) -> Figure:
        """Draws positions, forces and decision over time. ``options`` are passed to ``matplotlib.pyplot.subplots``."""
        from ._figures import run_figure

        return run_figure(self, **options)

    def __str__(self) -> str:
        return self._core.text()

    def __repr__(self) -> str:
        return f"Run({self.scenario.name!r}, {len(self.traces['time_s'])} ticks)"

    def _repr_html_(self) -> str:
        rows = [(label, quantity(value, unit)) for _, label, unit, value in self._core.rows()]
        return table(["metric", self.scenario.name], rows)


def run(
    scenario: Scenario | str | os.PathLike[str],
    *,
    tissue: Part | None = None,
    operator: Part | None = None,
    estimator: Part | None = None,
    detector: Part | None = None,
    force_law: Part | None = None,
    motion_law: Part | None = None,
) -> Run:
    """Runs a scenario, given as such or as a path. The same scenario gives identical results, bit for bit.

    Parameters
    ----------
    scenario
        The scenario.
    tissue, operator, estimator, detector, force_law, motion_law
        Parts of one's own in place of the scenario's; :mod:`trocar.parts` has their arguments and results. Such a run cannot be
        repeated: its missed ruptures have no reason, its ruptures no layer, and a lasting swing is not told.

    >>> import trocar
    >>> run = trocar.run("paper/augmented")
    >>> run["slave_position_m"].shape
    (17000,)
    >>> [event["frozen_motion_m"] < 1e-4 for event in run.events]
    [True, True]
    """
    given: dict[str, Any] = {
        "tissue": tissue,
        "operator": operator,
        "estimator": estimator,
        "detector": detector,
        "force_law": force_law,
        "motion_law": motion_law,
    }
    parts = core_parts(given)
    scenario = scenario_of(scenario)
    core, traces = _core.run_with(scenario._core, parts) if parts else _core.run(scenario._core)
    warn(core.warnings())
    return Run(scenario, core, traces)
