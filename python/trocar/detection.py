"""The estimator and the detector on recorded samples."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import Recorded, Samples, columns_of, number, samples, velocities, whole
from ._columns import Columns
from ._frames import freeze
from ._html import table
from ._progress import Progress
from ._settings import settings as lines
from ._stored import Stored
from .warnings import warn
from .documents import Documented

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


class Detection(Columns, Documented, Stored):
    """The result of the estimator and the detector for a recording, returned by :func:`detect`. ``print`` shows its
    tables.

    ``detection["residual_n"]`` is a column, float64 with the shape ``(samples,)``. The columns are ``time_s``,
    ``position_m``, ``velocity_m_per_s`` (as given, or estimated), ``measured_force_n``, ``residual_n``,
    ``stiffness_n_per_m``, ``damping_n_s_per_m``, ``distance`` and ``decision``; some estimators add a column. An
    unknown column raises a ``KeyError``. Unevenly spaced samples are first resampled at their median interval; the
    rows are then at the times ``time_s``.

    Attributes
    ----------
    columns : dict of str to array
        All columns.
    alarms : array of int64, shape (alarms,)
        The indices of the given samples with an alarm. If the samples were resampled, each is the last sample before
        the alarm.
    alarm_rows : array of int64, shape (alarms,)
        The rows of the columns with an alarm. They equal ``alarms`` unless the samples were resampled.
    report : dict
        The content of the command line's ``detection.json``: alarms, scores, statistics of the residual, phases,
        settings.

    >>> import trocar
    >>> detection = trocar.detect(trocar.record(), contact_m=0.012)
    >>> detection
    Detection('recording', 17000 samples, 2 alarms)
    >>> detection.alarms
    array([5527, 8860])
    >>> detection["residual_n"].shape
    (17000,)
    """

    def __init__(
        self,
        name: str,
        columns: dict[str, NDArray[np.float64]],
        alarms: NDArray[np.int64],
        alarm_rows: NDArray[np.int64],
        report: dict[str, Any],
        contents: dict[str, Any],
    ) -> None:
        self.name = name
        freeze(columns)
        self.columns = self._columns = columns
        self.alarms = alarms
        self.alarm_rows = alarm_rows
        self.report = report
        self._contents = contents

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def alarms_s(self) -> NDArray[np.float64]:
        """The times of the alarms, in s, on the clock of the recording; shape (alarms,)."""
        return self.columns["time_s"][self.alarm_rows]

    _keys = {"detection", "report", "document"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        rows = {"_alarms": self.alarms, "_alarm_rows": self.alarm_rows}
        return self.columns | rows, {"detection": self.name, "report": self.report, "document": self._contents}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Detection:
        alarms, rows = arrays.pop("_alarms"), arrays.pop("_alarm_rows")
        return cls(about["detection"], arrays, alarms, rows, about["report"], about["document"])

    def to_xarray(self) -> xarray.Dataset:
        """Returns the columns as an xarray Dataset over ``time_s``. Every variable has ``units`` and a
        ``long_name``."""
        return self._to_xarray("time_s", self._units())

    def _units(self) -> dict[str, tuple[str, str]]:
        about = super()._units()
        about["position_m"], about["velocity_m_per_s"] = ("m", "Position of the needle."), ("m/s", "Velocity of the needle.")
        return about

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns the columns and ``alarm`` as a pandas DataFrame, indexed by ``time_s``."""
        import pandas

        frame = pandas.DataFrame(self.columns)
        alarm = np.zeros(len(frame), dtype=bool)
        alarm[self.alarm_rows] = True
        frame["alarm"] = alarm
        return frame.set_index("time_s")

    def plot(self, figure: str = "estimation", **options: Any) -> Figure:
        """Draws ``"estimation"`` (measured and estimated force), ``"parameters"`` (stiffness and damping with two
        standard errors), ``"decision"``, ``"residual"`` or ``"timeline"`` (phases and alarms) with matplotlib.
        Options and errors as for :meth:`Run.plot`."""
        figures = self.document.figures
        if figure not in figures:
            raise ValueError(f'figure is "{figure}", must be one of {", ".join(figures)}')
        return figures[figure].plot(**options)

    def _further_figures(self) -> dict[str, Any]:
        report, detector = self.report, self.report["settings"]["detector"]
        sampling = (report["settings"]["estimator"]["contact_m"], report["interval_s"])
        ruptures_s, alarms_s = report["labelled_ruptures_s"], self.alarms_s.tolist()
        about = (sampling, detector["threshold"], detector["distance"])
        return _core.detection_figures(self.name, self.columns, *about, ruptures_s, alarms_s)

    def __repr__(self) -> str:
        return f"Detection({self.name!r}, {len(self.columns['time_s'])} samples, {len(self.alarms)} alarms)"


def detect(
    time: ArrayLike | Recorded,
    position: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    force: ArrayLike | None = None,
    *,
    contact_m: float | None = None,
    ruptures_s: Sequence[float] = (),
    settings_file: str | os.PathLike[str] | None = None,
    name: str = "recording",
    **settings: Any,
) -> Detection:
    """Runs the estimator and the detector on samples.

    The default is the adaptive detector, which needs no settings. Settings select another detector, such as the
    paper's, ``**{"detector.distance": "squared-residual"}``, or ``**{"detector.threshold": 0.02}``.

    Parameters
    ----------
    time : array, shape (samples,)
        Times in s, strictly increasing, from any start. Or a whole recording in place of the four arrays: a table (of
        pandas, polars, pyarrow or DuckDB) or a dictionary with the columns ``time_s``, ``position_m``, ``force_n`` and, if measured,
        ``velocity_m_per_s``.
    position : array, shape (samples,)
        Position of the needle, in m, increasing into the tissue.
    velocity : array, shape (samples,), or None
        Velocity of the needle, in m/s; ``None`` to estimate it from the positions.
    force : array, shape (samples,)
        Force on the needle, in N, positive when it resists insertion.
    contact_m
        Contact position, in m; the default is 0.
    ruptures_s
        True ruptures, in s after the first sample, for scores.
    settings_file
        A file with ``[estimator]`` and ``[detector]``, such as ``calibrated.toml`` of ``trocar calibrate``.
    name
        Name of the recording.
    **settings
        Keys of estimator, detector, sensor and recording, as in ``**{"detector.threshold": 0.02}``. They override the
        file.

    Returns
    -------
    Detection
        The columns, the alarms and, with ``ruptures_s``, the scores.

    Raises
    ------
    ValueError
        For fewer than two samples, samples that are not finite, times that do not increase, a gap in time, arrays of
        different lengths or with more than one dimension, a recording that lacks a column, and a ``settings_file``
        with neither section. The message names the sample.
    ScenarioError
        For an invalid setting, for ``ruptures_s`` that do not ascend or lie outside the recording, and for a
        ``settings_file`` that cannot be read. It is a ``ValueError``.
    TypeError
        For arrays that are not real numbers, missing arrays, and a ``contact_m`` or a setting of an invalid type.

    >>> import trocar
    >>> trocar.detect(trocar.record(), contact_m=0.012).alarms_s.round(3)
    array([5.527, 8.86 ])
    """
    changes = _changes(contact_m, ruptures_s, settings)
    times, positions, speeds, forces = _samples(time, position, velocity, force)
    columns, rows, is_resampled, report, contents = _core.detect(
        name,
        times,
        positions,
        speeds,
        forces,
        changes,
        None if settings_file is None else os.fspath(settings_file),
    )
    warn(report["warnings"])
    alarms = rows
    if is_resampled:
        # The time of a row differs from the time of its sample by rounding.
        alarms_s = columns["time_s"][rows] + 1e-3 * report["interval_s"]
        alarms = np.searchsorted(times, alarms_s, side="right").astype(np.int64) - 1
    return Detection(name, columns, alarms, rows, report, contents)


def _changes(contact_m: float | None, ruptures_s: Sequence[float], settings: dict[str, Any]) -> list[str]:
    flags: dict[str, Any] = {}
    if contact_m is not None:
        flags["estimator.contact_m"] = number("contact_m", contact_m)
    ruptures = samples("ruptures_s", ruptures_s).tolist()
    if ruptures:
        flags["recording.ruptures_s"] = ruptures
    return lines({**flags, **settings})[0]


def _samples(
    time: ArrayLike | Recorded, position: ArrayLike | None, velocity: ArrayLike | None, force: ArrayLike | None
) -> tuple[Samples, Samples, Samples | None, Samples]:
    """Returns the samples of a recording, from arrays or from a DataFrame or dictionary in place of the times."""
    if position is None and velocity is None and force is None and not isinstance(time, (str, os.PathLike)):
        time, position, velocity, force = columns_of(time)
    if isinstance(time, (str, os.PathLike)):
        raise TypeError(f"the recording is a path: read it, as in trocar.detect(**trocar.read_recording({os.fspath(time)!r}))")
    if position is None or force is None:
        missing = " and ".join(name for name, given in {"position": position, "force": force}.items() if given is None)
        raise TypeError(
            f"{missing} missing: give time, position, velocity and force (velocity=None estimates it), or one recording"
        )
    return samples("time", cast(ArrayLike, time)), samples("position", position), velocities(velocity), samples("force", force)


def record(
    seed: int = 1, *, drop_n: float | None = None, sharpness_s: float | None = None, depth_m: float | None = None
) -> dict[str, NDArray[np.float64]]:
    """Returns the in-vivo-like recording: a synthetic insertion through two layers, which rupture at 5.52 s and 8.85
    s.

    The columns are ``time_s`` (s), ``position_m`` (m), ``velocity_m_per_s`` (m/s) and ``force_n`` (N), each float64
    with the shape ``(samples,)``, at 1 kHz. The defaults give the shipped recording.

    Parameters
    ----------
    seed
        Seed of the measurement noise.
    drop_n
        Force that each rupture releases, in N, from 0.01 to 1000; the shipped ruptures release 5.32 and 3.2.
    sharpness_s
        Time constant of each drop, in s, from 1e-4 to 10; the shipped value is 0.045.
    depth_m
        Depth of the first rupture, in m, from 0.001 to 1; it scales all lengths. The shipped value is 0.02705.

    Raises
    ------
    ValueError
        For a number out of range.
    TypeError
        If ``seed`` is not an integer, or another argument is not a number.

    >>> import trocar
    >>> small = trocar.record(drop_n=1.0)
    >>> trocar.detect(small, contact_m=0.012).alarms_s.round(2)
    array([5.53, 8.86])
    """
    lines = (line for line in _core.record(whole("seed", seed), drop_n, sharpness_s, depth_m).splitlines() if not line.startswith("#"))
    heading, *rows = lines
    table = np.array([row.split(",") for row in rows], dtype=np.float64)
    return {name: np.ascontiguousarray(column) for name, column in zip(heading.split(","), table.T)}


class Detector:
    """The estimator and the detector for single samples, for use on a rig. Samples are evenly spaced by
    ``interval_s``.

    If the samples have velocities, the results equal those of :func:`detect` bit for bit. A pickled or copied
    detector continues from its state.

    Parameters
    ----------
    interval_s
        Time between two samples, in s.
    velocity
        ``"measured"``: each sample has a velocity. ``"filtered"``: the detector estimates it from the positions, with
        the resolution ``sensor.position_resolution_m`` (default 1 µm).
    contact_m, settings_file, **settings
        As for :func:`detect`.

    Raises
    ------
    ValueError
        If ``interval_s`` is not positive and finite, for another ``velocity``, and for a ``settings_file`` with
        neither section.
    ScenarioError
        For an invalid setting, and for a ``settings_file`` that cannot be read. It is a ``ValueError``.
    TypeError
        If ``interval_s`` or ``contact_m`` is not a number, and for a setting of an invalid type.

    >>> import trocar
    >>> detector = trocar.Detector(0.001, contact_m=0.012)
    >>> detector.step(0.011, 0.01, 0.0).alarm
    False
    """

    def __init__(
        self,
        interval_s: float,
        *,
        velocity: Literal["measured", "filtered"] = "measured",
        contact_m: float | None = None,
        settings_file: str | os.PathLike[str] | None = None,
        **settings: Any,
    ) -> None:
        if velocity not in ("measured", "filtered"):
            raise ValueError(f'velocity is {velocity!r}, must be "measured" or "filtered"')
        file = None if settings_file is None else os.fspath(settings_file)
        changes = _changes(contact_m, (), settings)
        self._arguments = number("interval_s", interval_s), velocity == "filtered", changes, file
        self._core = _core.Detector(*self._arguments)

    def step(self, position: float, velocity: float | None, force: float) -> _core.Step:
        """Processes a sample: position in m, velocity in m/s (``None`` if the detector estimates it), force in N.

        Returns the results as a :class:`Step`. An error leaves the detector unchanged.

        Raises
        ------
        ValueError
            For a number that is not finite or beyond 1e6 in SI units, for a missing velocity, and for a velocity if
            the detector estimates it.
        TypeError
            If an argument is not a number.
        """
        return self._core.step(position, velocity, force)

    def steps(
        self, position: ArrayLike, velocity: ArrayLike | None, force: ArrayLike
    ) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.int64]]:
        """Processes several samples, arrays with the shape ``(samples,)``. Processes none of them if one is invalid.

        Returns the results of :meth:`step` as columns, float64 with the shape ``(samples,)``, and the indices of the
        samples with an alarm, int64 with the shape ``(alarms,)``.

        Raises
        ------
        ValueError
            As for :meth:`step`, and for arrays of different lengths or with more than one dimension.
        TypeError
            If an array does not contain real numbers.
        """
        return self._core.steps(samples("position", position), velocities(velocity), samples("force", force))

    def reset(self) -> None:
        """Resets the detector to its initial state."""
        self._core.reset()

    @property
    def samples(self) -> int:
        """The number of processed samples."""
        return self._core.samples

    def __copy__(self) -> Detector:
        other = object.__new__(Detector)
        other._core, other._arguments = self._core.copy(), self._arguments
        return other

    def __deepcopy__(self, memo: dict[int, Any]) -> Detector:
        return self.__copy__()

    def __reduce__(self) -> tuple[object, ...]:
        return _detector, (self._arguments, *self._core.state())

    def __repr__(self) -> str:
        return f"Detector({self.samples} samples)"

    def _repr_html_(self) -> str:
        interval_s, is_filtered, changes, file = self._arguments
        rows = [["samples", str(self.samples)], ["interval", f"{interval_s} s"], ["velocity", "filtered" if is_filtered else "measured"]]
        rows += [["settings file", file]] if file else []
        rows += [list(change.split("=", 1)) for change in changes]
        return table(["detector", ""], rows)


def _detector(arguments: tuple[float, bool, list[str], str | None], count: int, state: NDArray[np.uint64]) -> Detector:
    detector = object.__new__(Detector)
    detector._core, detector._arguments = _core.Detector(*arguments), arguments
    detector._core.restore(count, state)
    return detector


def score(
    alarms_s: ArrayLike, ruptures_s: ArrayLike, *, within_s: float = 0.5, recorded_s: float | None = None
) -> dict[str, Any]:
    """Scores alarms against true ruptures, like ``trocar detect``.

    An alarm matches a rupture if it follows within ``within_s``. Each alarm and each rupture match at most once.

    Parameters
    ----------
    alarms_s : array, shape (alarms,)
        Times of the alarms, in s, in any order.
    ruptures_s : array, shape (ruptures,)
        Times of the ruptures, in s, in any order.
    within_s
        Maximum time from a rupture to its alarm, in s, at least 0.
    recorded_s
        Recorded time in s, for the false alarms per minute.

    Returns
    -------
    dict
        ``found``, ``missed``, ``false_alarms``, ``precision``, ``recall``, ``f1``, ``median_delay_s``,
        ``min_delay_s``, ``max_delay_s``, ``false_alarms_per_minute`` (``None`` if undefined), the numbers of
        ``ruptures`` and ``alarms``, and ``matches``: pairs of the indices of a rupture and its alarm, in order of
        time.

    Raises
    ------
    ValueError
        For times that are not finite or not one-dimensional, if ``within_s`` is negative or not finite, and if
        ``recorded_s`` is not positive and finite.
    TypeError
        If times, ``within_s`` or ``recorded_s`` are not numbers.

    >>> import trocar
    >>> scores = trocar.score([1.02, 3.0], [1.0, 2.0])
    >>> scores["found"], scores["missed"], scores["false_alarms"], scores["median_delay_s"]
    (1, 1, 1, 0.02)
    """
    alarms, ruptures = samples("alarms_s", alarms_s), samples("ruptures_s", ruptures_s)
    by_time = np.argsort(alarms, kind="stable"), np.argsort(ruptures, kind="stable")
    times = float("nan")
    if recorded_s is not None:
        times = number("recorded_s", recorded_s)
        if not times > 0.0:
            raise ValueError(f"recorded_s is {times}, must be above 0")
    scores, matches = _core.score(alarms[by_time[0]], ruptures[by_time[1]], number("within_s", within_s), times)
    scores["matches"] = [(int(by_time[1][rupture]), int(by_time[0][alarm])) for rupture, alarm in matches]
    return scores


class Calibration(Documented, Stored):
    """Settings of estimator and detector from the beginning of a recording, returned by :func:`calibrate`. ``print``
    shows its tables.

    Attributes
    ----------
    report : dict
        The content of the command line's ``calibration.json``.
    settings : dict
        Keys with their values, for ``trocar.detect(..., **calibration.settings)``.
    toml : str
        The settings as ``[estimator]`` and ``[detector]`` tables for a scenario.

    >>> import trocar
    >>> calibration = trocar.calibrate(trocar.record(), contact_m=0.012)
    >>> calibration.settings["estimator.contact_m"]
    0.012
    >>> "detector.threshold" in calibration.settings, calibration.toml.startswith("[estimator]")
    (True, True)
    """

    def __init__(self, report: dict[str, Any], contents: dict[str, Any], toml: str) -> None:
        from .scenario import Scenario

        self.report = report
        self.toml = toml
        self._contents = contents
        resolved = Scenario.from_toml(toml + '[operator]\nkind = "ramp"\n[tissue]\nkind = "kelvin-voigt"\n').to_dict()
        keys = [line.partition(" = ")[0] for line in toml.splitlines()]
        section = ""
        self.settings: dict[str, Any] = {}
        for key in keys:
            if key.startswith("["):
                section = key.strip("[]")
            elif key:
                self.settings[f"{section}.{key}"] = resolved[section][key]

    _keys = {"calibration", "document", "toml"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        return {}, {"calibration": self.report, "document": self._contents, "toml": self.toml}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Calibration:
        return cls(about["calibration"], about["document"], about["toml"])

    def __repr__(self) -> str:
        return f"Calibration({self.settings})"


def calibrate(
    time: ArrayLike | Recorded,
    position: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    force: ArrayLike | None = None,
    *,
    contact_m: float | None = None,
    ruptures_s: Sequence[float] = (),
    first_s: float | None = None,
    quiet_s: tuple[float, float] | None = None,
    false_alarm_s: float | None = None,
    slowest_rupture_s: float | None = None,
    fastest_harmless_s: float | None = None,
    variance_ratio: float | None = None,
    threads: int = 0,
    progress: bool = False,
    name: str = "recording",
    **settings: Any,
) -> Calibration:
    """Computes settings of estimator and detector from the beginning of a recording, for a requested time between
    false alarms.

    Parameters
    ----------
    time, position, velocity, force, contact_m, ruptures_s, name, **settings
        As for :func:`detect`. A given contact position is kept.
    first_s
        Length of the analysed part, in s; the default is 5.
    quiet_s
        The quiet segment, in s after the first sample; computed by default.
    false_alarm_s
        Requested mean time between false alarms, in s; the default is 3600.
    slowest_rupture_s, fastest_harmless_s
        Time in which the force of the slowest rupture, and of the fastest harmless change, falls by half, in s; the
        defaults are 0.03 and 0.5.
    variance_ratio
        Ratio of the residual's variance at a rupture to its quiet variance, above 1; the default is 100.
    threads
        Number of threads, up to 1024; 0 is one per processor.
    progress
        True to show the progress, with tqdm if installed, otherwise as a line on standard error.

    Returns
    -------
    Calibration
        The settings, and the data of their computation.

    Raises
    ------
    ValueError
        For invalid samples as in :func:`detect`, fewer than 100 samples, a time that is not positive and finite, a
        ``quiet_s`` that does not ascend, a ``fastest_harmless_s`` not above ``slowest_rupture_s``, a
        ``variance_ratio`` of 1 or less, and ``threads`` out of range.
    ScenarioError
        For an invalid setting or rupture, as in :func:`detect`. It is a ``ValueError``.
    TypeError
        If an argument does not have the type above.

    >>> import trocar
    >>> calibration = trocar.calibrate(trocar.record(1), contact_m=0.012)
    >>> trocar.detect(trocar.record(2), **calibration.settings).alarms_s.round(2)
    array([5.52, 8.85])
    """
    with Progress("steps", progress) as bar:
        report, contents, toml = _core.calibrate(
            name,
            *_samples(time, position, velocity, force),
            _changes(contact_m, ruptures_s, settings),
            first_s=first_s,
            quiet_s=quiet_s,
            keeps_contact=contact_m is not None or "estimator.contact_m" in settings,
            false_alarm_s=false_alarm_s,
            slowest_rupture_s=slowest_rupture_s,
            fastest_harmless_s=fastest_harmless_s,
            variance_ratio=variance_ratio,
            threads=whole("threads", threads),
            tell=bar.tell,
        )
    warn(report["warnings"])
    return Calibration(report, contents, toml)
