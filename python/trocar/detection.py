"""The estimator and the detector on samples of your own."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import number, samples, velocities
from ._html import quantity, table
from ._settings import settings as lines

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class Detection:
    """What estimator and detector found in a recording.

    ``detection["residual_n"]`` is a column, float64 of the shape ``(samples,)``: ``time_s``, ``position_m``,
    ``velocity_m_per_s`` (as given, or estimated), ``measured_force_n``, ``residual_n``, ``stiffness_n_per_m``,
    ``damping_n_s_per_m``, ``distance``, ``decision``; some estimators have one more. Uneven samples were resampled at their
    median interval first.

    Attributes
    ----------
    columns : dict of str to array
        All of them.
    alarms : array of int64, shape (alarms,)
        The samples at which a rupture is announced.
    report : dict
        What ``detection.json`` of the command line holds: alarms, scores, the residual's statistics, phases, settings.
    """

    def __init__(
        self, name: str, columns: dict[str, NDArray[np.float64]], alarms: NDArray[np.int64], report: dict[str, Any], text: str
    ) -> None:
        self.name = name
        self.columns = columns
        self.alarms = alarms
        self.report = report
        self._text = text

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        return self.columns[column]

    @property
    def alarms_s(self) -> NDArray[np.float64]:
        """When ruptures are announced, in the recording's own time, in s; shape (alarms,)."""
        return self.columns["time_s"][self.alarms]

    def to_dataframe(self) -> pandas.DataFrame:
        """The columns as a pandas DataFrame, with ``alarm``, indexed by ``time_s``."""
        import pandas

        frame = pandas.DataFrame(self.columns)
        alarm = np.zeros(len(frame), dtype=bool)
        alarm[self.alarms] = True
        frame["alarm"] = alarm
        return frame.set_index("time_s")

    def plot(self, **options: Any) -> Figure:
        """Force, residual and decision over time with the alarms, drawn by matplotlib."""
        from ._figures import detection_figure

        return detection_figure(self, **options)

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"Detection({self.name!r}, {len(self.columns['time_s'])} samples, {len(self.alarms)} alarms)"

    def _repr_html_(self) -> str:
        keys = {"time_s": "s", "position_m": "m", "depth_m": "m", "force_n": "N", "residual_n": "N", "delay_s": "s"}
        named = [(key, {"s": "1"}.get(unit, unit) if key == "time_s" else unit) for key, unit in keys.items()]
        rows = [
            (str(index), *(quantity(alarm[key], unit) for key, unit in named))
            for index, alarm in enumerate(self.report["alarms"], 1)
        ]
        heading = ["alarm", "time in s", "position", "depth", "force", "residual", "delay"]
        return table(heading, rows, caption=repr(self))


def detect(
    time: ArrayLike,
    position: ArrayLike,
    velocity: ArrayLike | None,
    force: ArrayLike,
    *,
    contact_m: float | None = None,
    ruptures_s: Sequence[float] = (),
    settings_file: str | os.PathLike[str] | None = None,
    name: str = "recording",
    **settings: Any,
) -> Detection:
    """Runs the estimator and the detector over samples.

    Parameters
    ----------
    time : array, shape (samples,)
        In s, strictly ascending; the first need not be 0.
    position : array, shape (samples,)
        Of the needle, in m, growing into the tissue.
    velocity : array, shape (samples,), or None
        In m/s; estimated from the positions where it is ``None``.
    force : array, shape (samples,)
        On the needle, in N, positive when it resists insertion.
    contact_m
        Where the tissue begins, in m; 0 where nothing says otherwise.
    ruptures_s
        True ruptures, in s after the first sample, to judge the alarms by.
    settings_file
        A file with ``[estimator]`` and ``[detector]``, as ``trocar calibrate`` writes it.
    name
        What to call the recording.
    **settings
        Keys of estimator, detector, sensor and recording, as in ``**{"detector.threshold": 0.02}``; they count before those of
        the file.

    Raises
    ------
    ValueError, TypeError
        For samples that are no recording, naming the sample, and for settings out of range.
    """
    changes = _changes(contact_m, ruptures_s, settings)
    columns, alarms, report, text = _core.detect(
        name,
        samples("time", time),
        samples("position", position),
        velocities(velocity),
        samples("force", force),
        changes,
        None if settings_file is None else os.fspath(settings_file),
    )
    return Detection(name, columns, alarms, report, text)


def _changes(contact_m: float | None, ruptures_s: Sequence[float], settings: dict[str, Any]) -> list[str]:
    flags: dict[str, Any] = {}
    if contact_m is not None:
        flags["estimator.contact_m"] = number("contact_m", contact_m)
    if len(ruptures_s) > 0:
        flags["recording.ruptures_s"] = [number("ruptures_s", rupture) for rupture in ruptures_s]
    return lines({**flags, **settings})


def record(seed: int = 1) -> dict[str, NDArray[np.float64]]:
    """The in-vivo-like recording: a made insertion through two layers, which rupture at 5.52 s and 8.85 s.

    Columns ``time_s`` (s), ``position_m`` (m), ``velocity_m_per_s`` (m/s) and ``force_n`` (N), each float64 of the shape
    ``(samples,)``, at 1 kHz. The seed is that of the measurement noise; the recording that is shipped has the seed 1.
    """
    heading, *lines = (line for line in _core.record(seed).splitlines() if not line.startswith("#"))
    table = np.array([line.split(",") for line in lines], dtype=np.float64)
    return {name: np.ascontiguousarray(column) for name, column in zip(heading.split(","), table.T)}


class Detector:
    """Estimator and detector on samples that come one by one, as on a rig; evenly spaced, ``interval_s`` apart.

    The same samples give the bits that :func:`detect` gives, as long as they have velocities.

    Parameters
    ----------
    interval_s
        Time between two samples, in s.
    velocity
        ``"measured"``: each sample has one; ``"filtered"``: it is estimated from the positions, whose steps are
        ``sensor.position_resolution_m``, or 1 µm where that is not given.
    contact_m, settings_file, **settings
        As for :func:`detect`.

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
        self._core = _core.Detector(number("interval_s", interval_s), velocity == "filtered", changes, file)

    def step(self, position: float, velocity: float | None, force: float) -> _core.Step:
        """Takes a sample: position in m, velocity in m/s (``None`` where it is filtered), force in N.

        Gives what came of it: ``alarm`` (whether a rupture is announced), ``residual_n``, ``decision``, ``distance``,
        ``stiffness_n_per_m``, ``damping_n_s_per_m``, ``predicted_force_n``, ``velocity_m_per_s``, ``depth_m``. A sample that is
        not finite, or beyond 1e6 in SI units, raises ``ValueError`` and leaves the detector as it was.
        """
        return self._core.step(position, velocity, force)

    def steps(
        self, position: ArrayLike, velocity: ArrayLike | None, force: ArrayLike
    ) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.int64]]:
        """Takes samples that have come together, arrays of the shape ``(samples,)``: all of them, or none where one is wrong.

        Gives what :meth:`step` gives by columns, float64 of the shape ``(samples,)``, and which samples raise an alarm, int64 of
        the shape ``(alarms,)``.
        """
        return self._core.steps(samples("position", position), velocities(velocity), samples("force", force))

    def reset(self) -> None:
        """Forgets everything that it has seen."""
        self._core.reset()

    @property
    def samples(self) -> int:
        """How many samples it has taken."""
        return self._core.samples

    def __repr__(self) -> str:
        return f"Detector({self.samples} samples taken)"


class Calibration:
    """Settings of estimator and detector from the beginning of a recording.

    Attributes
    ----------
    report : dict
        What ``calibration.json`` of the command line holds.
    settings : dict
        Keys with their values, for ``trocar.detect(..., **calibration.settings)``.
    toml : str
        The same as ``[estimator]`` and ``[detector]`` to paste into a scenario.
    """

    def __init__(self, report: dict[str, Any], text: str, toml: str) -> None:
        from .scenario import Scenario

        self.report = report
        self.toml = toml
        self._text = text
        resolved = Scenario.from_toml(toml + '[operator]\nkind = "ramp"\n[tissue]\nkind = "kelvin-voigt"\n').to_dict()
        keys = [line.partition(" = ")[0] for line in toml.splitlines()]
        section = ""
        self.settings: dict[str, Any] = {}
        for key in keys:
            if key.startswith("["):
                section = key.strip("[]")
            elif key:
                self.settings[f"{section}.{key}"] = resolved[section][key]

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"Calibration({self.settings})"

    def _repr_html_(self) -> str:
        return table(["setting", "value"], [(key, str(value)) for key, value in self.settings.items()])


def calibrate(
    time: ArrayLike,
    position: ArrayLike,
    velocity: ArrayLike | None,
    force: ArrayLike,
    *,
    contact_m: float | None = None,
    ruptures_s: Sequence[float] = (),
    first_s: float | None = None,
    quiet_s: tuple[float, float] | None = None,
    false_alarm_s: float | None = None,
    slowest_rupture_s: float | None = None,
    fastest_harmless_s: float | None = None,
    variance_ratio: float | None = None,
    name: str = "recording",
    **settings: Any,
) -> Calibration:
    """Finds settings of estimator and detector from the beginning of a recording, for a wanted time between false alarms.

    Parameters
    ----------
    time, position, velocity, force, contact_m, ruptures_s, name, **settings
        As for :func:`detect`; a contact that is given is kept.
    first_s
        How much of the recording is looked at, in s; 5 where it is not given.
    quiet_s
        A quiet segment, in s after the first sample, where it is not to be found.
    false_alarm_s
        Wanted time between false alarms, in s; 3600 where it is not given.
    slowest_rupture_s, fastest_harmless_s
        In what time the slowest rupture, and the fastest harmless change, take half of the force, in s; 0.03 and 0.5.
    variance_ratio
        The residual's variance after a rupture over the quiet one, above 1; 100.
    """
    report, text, toml = _core.calibrate(
        name,
        samples("time", time),
        samples("position", position),
        velocities(velocity),
        samples("force", force),
        _changes(contact_m, ruptures_s, settings),
        first_s=first_s,
        quiet_s=quiet_s,
        keeps_contact=contact_m is not None or "estimator.contact_m" in settings,
        false_alarm_s=false_alarm_s,
        slowest_rupture_s=slowest_rupture_s,
        fastest_harmless_s=fastest_harmless_s,
        variance_ratio=variance_ratio,
    )
    return Calibration(report, text, toml)
