"""Runs of scenarios."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import recording_of
from ._columns import Columns
from ._frames import freeze
from ._parts import Parts, core_parts
from ._stored import Stored
from ._typed import Event, Metrics, Rupture
from .warnings import warn
from .documents import Documented
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure
    from typing_extensions import Unpack


class Run(Columns, Documented, Stored):
    """The result of a run, returned by :func:`run`. ``print`` shows its tables.

    ``run["slave_position_m"]`` is a column of the trace, and the run is a mapping of its columns. Every column has
    the shape ``(ticks,)`` and is float64, except ``mode`` and ``estimate_flags``, which are uint8. The arrays are
    read-only, so that columns and metrics always belong together; ``run["slave_position_m"].copy()`` can be changed.
    :func:`trocar.trace_columns` lists the columns with units and meanings. An unknown column raises a ``KeyError``.

    Some estimators add a column, ``friction_n`` (N) or ``power``. A diverged run ends early;
    ``run.metrics["outcome"]`` reports this.

    Attributes
    ----------
    scenario : Scenario
        The scenario.

    >>> import trocar
    >>> run = trocar.run("paper/augmented")
    >>> run
    Run('augmented', 17000 ticks)
    >>> run["slave_position_m"].shape, run["mode"].dtype
    ((17000,), dtype('uint8'))
    >>> run.metrics["outcome"], len(run.ruptures)
    ({'kind': 'completed'}, 2)
    """

    def __init__(self, scenario: Scenario, core: _core.Run, traces: dict[str, NDArray[Any]]) -> None:
        freeze(traces)
        self.scenario = scenario
        self._recorded = traces
        self._core: _core.Run | _Kept = core

    @cached_property
    def traces(self) -> dict[str, NDArray[Any]]:
        """All columns of the trace."""
        # Compute the trust in the estimates only when one or all of its columns are read.
        core = self._core
        if isinstance(core, _Kept):
            return self._recorded
        trust = core.trust(self._recorded)
        freeze(trust)
        return {**self._recorded, **trust}

    @property
    def _columns(self) -> dict[str, NDArray[Any]]:  # type: ignore[override]
        return self.traces

    def __getitem__(self, column: str) -> NDArray[Any]:
        return self._recorded[column] if column in self._recorded else super().__getitem__(column)

    def __len__(self) -> int:
        return len(self._columns)

    def __getstate__(self) -> tuple[Scenario, dict[str, NDArray[Any]], _Kept]:
        core = self._core
        return self.scenario, self.traces, _Kept(core.name, core.summary_json(), core.document(), core.named_metrics())

    def __setstate__(self, state: tuple[Scenario, dict[str, NDArray[Any]], _Kept]) -> None:
        self.scenario, self._recorded, self._core = state
        freeze(self._recorded)

    _keys = {"name", "toml", "summary", "document", "metrics"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        scenario, traces, core = self.__getstate__()
        about = {
            "name": core.name,
            "summary": core.summary_text,
            "document": core.contents,
            "metrics": core.named,
            "toml": scenario.to_toml(),
        }
        return samples_of(scenario) | traces, about

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Run:
        run = cls.__new__(cls)
        scenario = scenario_from(about["name"], about["toml"], arrays)
        run.__setstate__((scenario, arrays, _Kept(about["name"], about["summary"], about["document"], about["metrics"])))
        return run

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of the command line's ``summary.json``. Undefined values are ``None``."""
        return self._core.summary()

    @property
    def metrics(self) -> Metrics:
        """All metrics as ``summary.json`` has them, in SI units: those of the run, and lists of its ruptures, events and
        alarms. Names end with the unit. Undefined values are ``None``. :meth:`metric` has those of sweeps by name."""
        return cast(Metrics, dict(self.summary["metrics"]))

    @cached_property
    def _named(self) -> dict[str, float | None]:
        return self._core.named_metrics()

    def metric(self, name: str) -> float | None:
        """Returns a metric by its name in sweeps and tables, which :func:`trocar.metrics` lists; ``None`` if undefined.

        Raises
        ------
        KeyError
            For an unknown name, and for a rupture or an event that the run does not have.

        >>> import trocar
        >>> run = trocar.run("paper/augmented")
        >>> run.metric("detected_ruptures"), run.metric("rupture_2_detection_delay_s")
        (2.0, 0.008)
        """
        if name not in self._named:
            raise KeyError(
                f"no metric {name!r}; trocar.metrics() lists the names, and this run has {len(self.ruptures)} ruptures and "
                f"{len(self.events)} events"
            )
        return self._named[name]

    @property
    def events(self) -> list[Event]:
        """The events, in order of time."""
        return list(self.summary["metrics"]["events"])

    @property
    def ruptures(self) -> list[Rupture]:
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

    def to_xarray(self) -> xarray.Dataset:
        """Returns the trace as an xarray Dataset over ``time_s``. Every variable has ``units`` and a
        ``long_name``."""
        return self._to_xarray("time_s", self._units()).assign_attrs(scenario=self.scenario.name)

    def plot(self, figure: str = "comparison", *, window: tuple[float, float] | None = None, **options: Any) -> Figure:
        """Draws a figure of the command line with matplotlib.

        Parameters
        ----------
        figure
            ``"comparison"`` (positions and forces side by side), ``"overlay"``, ``"estimation"``, ``"parameters"``, ``"decision"`` or
            ``"residual"``.
        window
            The time in s, as ``(from, to)``; ``None`` for the whole run.
        **options
            ``ax``: the axes to draw on, as many as the figure has panels. Other options are passed to
            ``matplotlib.pyplot.subplots``.

        Raises
        ------
        ValueError
            For an unknown ``figure``, and for a wrong number of axes.
        TypeError
            For other options together with ``ax``.
        ImportError
            If matplotlib is not installed.
        """
        from ._figures import draw, window_of

        time_s = self["time_s"]
        whole = (float(time_s[0]), float(time_s[-1])) if len(time_s) > 1 else None
        return draw(_core.run_figure(figure, [self._drawn()], window_of(window) or whole), **options)

    def _drawn(self) -> _core._Drawn:
        """Returns the data of the run for a figure."""
        ruptures_s = [rupture["time_s"] for rupture in self.ruptures]
        link = self.metrics["link"]
        promised_energy_j = None if link is None else link["promised_energy_j"]
        return self.scenario._core, self._recorded, ruptures_s, self.alarms_s.tolist(), promised_energy_j

    @property
    def _contents(self) -> dict[str, Any]:  # type: ignore[override]
        return self._core.document()

    def _further_figures(self) -> dict[str, Any]:
        return _core.run_figures(self._drawn())

    def __repr__(self) -> str:
        return f"Run({self.scenario.name!r}, {len(self['time_s'])} ticks)"


@dataclass(frozen=True)
class _Kept:
    """The results of a loaded run, in place of the core's object."""

    name: str
    summary_text: str
    contents: dict[str, Any]
    named: dict[str, float | None]

    def summary(self) -> dict[str, Any]:
        summary: dict[str, Any] = json.loads(self.summary_text)
        return summary

    def warnings(self) -> list[dict[str, Any]]:
        warnings: list[dict[str, Any]] = self.summary()["warnings"]
        return warnings

    def summary_json(self) -> str:
        return self.summary_text

    def document(self) -> dict[str, Any]:
        return self.contents

    def named_metrics(self) -> dict[str, float | None]:
        return self.named


def load(path: str | os.PathLike[str]) -> Run:
    """Reads a run that :meth:`Run.save` wrote, like :meth:`Run.load`. The file includes the recording of the
    scenario.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Run
        The run, with the same trace, summary and scenario.

    Raises
    ------
    ValueError
        If :meth:`Run.save` did not write the file.
    OSError
        If the file cannot be opened.
    TypeError
        If ``path`` is not a path.

    >>> import trocar
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "run.npz")
    >>> trocar.run("layers/skin-augmented").save(path)
    >>> trocar.load(path)
    Run('skin-augmented', 9000 ticks)
    """
    return Run.load(path)


# Prefix, in a file, of the names of a recording's samples; and the name of the array with the recording's source.
_SAMPLES = "_samples_"
_READ = _SAMPLES + "read"


def samples_of(scenario: Scenario) -> dict[str, NDArray[Any]]:
    """Returns the recording of a scenario as arrays for a file, unless it is shipped or missing."""
    file = scenario.to_dict().get("recording", {}).get("file")
    *_, in_memory, (_, _, read) = scenario._core.origin()
    found: list[tuple[_core.Recording, dict[str, NDArray[Any]]]] = [(recording, {}) for recording in in_memory if recording.name == file]
    found += [(recording, {_READ: np.array([str(path), how])}) for path, how, recording in read if str(path) == file]
    for recording, arrays in found:
        named = zip(("time", "position", "velocity", "force"), recording.__getnewargs__())
        return {_SAMPLES + name: column for name, column in named if column is not None} | arrays
    return {}


def scenario_from(name: str, toml: str, arrays: dict[str, NDArray[Any]]) -> Scenario:
    """Returns the scenario of a file. Removes the samples of its recording from the arrays."""
    samples = {key[len(_SAMPLES) :]: arrays.pop(key) for key in list(arrays) if key.startswith(_SAMPLES)}
    place = samples.pop("read", None)
    recordings = [recording_of(samples)] if samples else []
    read = [] if place is None else [(Path(str(place[0])), str(place[1]), recordings.pop())]
    return Scenario._of(_core.Scenario.restored(None, name, toml, [], recordings, ([], [], read)))


def run(scenario: Scenario | str | os.PathLike[str], **parts: Unpack[Parts]) -> Run:
    """Runs a scenario or the scenario of a path. The same scenario gives identical results, bit for bit.

    Parameters
    ----------
    scenario
        The scenario.
    **parts
        User-defined parts in place of the scenario's: ``tissue``, ``operator``, ``estimator``, ``detector``,
        ``force_law``, ``motion_law``; see :mod:`trocar.parts` for their arguments and results. Such a run cannot be
        repeated for diagnosis: its missed ruptures have no reason, its ruptures no layer, and no warning reports a
        lasting oscillation.

    Returns
    -------
    Run
        The trace, the metrics and the events.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    TypeError
        If the scenario is neither a ``Scenario`` nor a path, for an unknown role, for a part that is neither a
        function, a compiled function, nor an object with a method ``step``, and for a part's result that its role
        does not allow.
    ValueError
        For a part's result that is not finite.
    Exception
        Any exception of a part; it ends the run. A diverging run is not an error.

    >>> import trocar
    >>> run = trocar.run("paper/augmented")
    >>> run["slave_position_m"].shape
    (17000,)
    >>> [event["frozen_motion_m"] < 1e-4 for event in run.events]
    [True, True]
    """
    user_defined = core_parts(parts)
    scenario = scenario_of(scenario)
    core, traces = _core.run_with(scenario._core, user_defined) if user_defined else _core.run(scenario._core)
    warn(core.warnings())
    return Run(scenario, core, traces)
