"""Evaluation of detectors on recordings with known ruptures."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core, warnings
from ._arrays import Recorded, number, recording_of, whole
from ._columns import Columns
from ._frames import flat_rows
from ._parts import Part, core_parts
from ._progress import Progress
from ._reported import Reported
from .detection import _changes
from .scenario import Scenario

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class Trial(Columns):
    """A synthetic recording: a needle that is moved into layers, foam, a spring, a rigid stop, or nothing.

    It is a mapping of the columns ``time_s``, ``position_m`` and ``force_n``, float64 with the shape ``(samples,)``,
    which :func:`trocar.detect` accepts. An unknown column raises a ``KeyError``. The same number gives the same
    recording.

    Parameters
    ----------
    number
        The number of the recording, from 1.

    Attributes
    ----------
    number : int
        The number of the recording, from 1.
    ruptures_s, durations_s, drops_n : array, shape (ruptures,)
        Beginning of the force drop at each rupture, in s after the first sample; its duration, in s; and the drop, in
        N.
    is_above_noise : list of bool
        True for each drop that exceeds both six standard deviations of the noise and 0.2 N. Detectors are not
        expected to find the others.
    contact_m : float
        Contact position for the estimator, in m.
    contact : str
        The knowledge of the contact position: ``known``, ``wrong`` (by some mm), or ``from first sample`` (unknown).
    noise_std_n : float
        Standard deviation of the noise, in N.
    noise, hand, matter : str
        The kind of noise, the kind of motion, and the material that the needle touches.

    Raises
    ------
    TypeError
        If ``number`` is not an integer.

    >>> import trocar
    >>> trial = trocar.results.Trial(6)
    >>> trial
    Trial(6, 6340 samples, membranes, 2 ruptures)
    >>> trial.ruptures_s.round(2)
    array([1.14, 1.43])
    >>> len(trocar.detect(trial, contact_m=trial.contact_m).alarms)
    2
    """

    def __init__(self, number: int) -> None:
        number = whole("number", number, 1)
        columns, about = _core.trial(number)
        self._columns = columns
        self.number = number
        self.ruptures_s: NDArray[np.float64] = about["ruptures_s"]
        self.durations_s: NDArray[np.float64] = about["durations_s"]
        self.drops_n: NDArray[np.float64] = about["drops_n"]
        self.is_above_noise: list[bool] = about["is_above_noise"]
        self.contact_m: float = about["contact_m"]
        self.contact: str = about["contact"]
        self.noise_std_n: float = about["noise_std_n"]
        self.noise: str = about["noise"]
        self.hand: str = about["hand"]
        self.matter: str = about["matter"]

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"Trial({self.number}, {len(self['time_s'])} samples, {self.matter}, {len(self.ruptures_s)} ruptures)"


def trials(numbers: int | Iterable[int] = 1000) -> Iterator[Trial]:
    """Yields the synthetic recordings on which ``trocar roc --trials`` evaluates detectors.

    Rates, stiffness, noise, speeds, force drops and their durations are drawn over the ranges of real recordings of
    needle insertions.

    Parameters
    ----------
    numbers
        The number of recordings, or a list of their numbers, from 1.

    Raises
    ------
    ValueError
        For a negative number of recordings, and for a number below 1 in a list.
    TypeError
        If ``numbers`` is neither an integer nor an iterable of integers.

    >>> import trocar
    >>> next(trocar.trials())
    Trial(1, ...)
    """
    if hasattr(numbers, "__index__"):
        return map(Trial, range(1, whole("numbers", numbers) + 1))
    return map(Trial, numbers)


class Roc(Reported):
    """The operating characteristics of detectors, returned by :func:`roc`. ``print`` shows them as a table.

    Attributes
    ----------
    report : dict
        The content of the command line's ``roc.json``, with a curve per detector in ``characteristics``.

    >>> import trocar
    >>> judged = trocar.roc(detectors=["adaptive", "squared-residual"], seeds=5, thresholds=4)
    >>> judged
    Roc(adaptive, squared-residual)
    >>> judged.at_own_threshold()["adaptive"]["detection"]
    1.0
    >>> sorted(judged.curves) == ["adaptive", "squared-residual"]
    True
    """

    _name = "roc"

    @property
    def curves(self) -> dict[str, list[dict[str, Any]]]:
        """The points of each detector over all conditions, by threshold. A user-defined detector has a point per
        given threshold, or one.

        A point has ``threshold``, ``cases``, ``ruptures``, ``detected``, ``late``, ``detection`` (the fraction
        detected in time) with its interval, ``delay_median_s`` and other delays, ``false_alarms``, ``hours``, and
        ``false_alarms_per_minute`` with its interval.
        """
        return {curve["detector"]: curve["points"] for curve in self.report["characteristics"]["all"]}

    def at_own_threshold(self) -> dict[str, dict[str, Any]]:
        """Returns the point of each detector at its own threshold; for a user-defined detector with several, at the
        first."""
        found = {}
        for curve in self.report["characteristics"]["all"]:
            at = [point for point in curve["points"] if point["threshold"] == curve["own_threshold"]]
            found[curve["detector"]] = (at or curve["points"])[0]
        return found

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns a pandas DataFrame with a row per condition, detector and threshold; the first condition combines
        all conditions. Intervals have two columns, as in ``detection_low`` and ``detection_high``."""
        import pandas

        studied = self.report["characteristics"]
        rows = []
        for condition in [{"signal": "all", "noise_std_n": None, "curves": studied["all"]}, *studied["conditions"]]:
            shared = {key: condition[key] for key in ("signal", "noise_std_n")}
            for curve in condition["curves"]:
                rows += [{**shared, "detector": curve["detector"], **point} for point in curve["points"]]
        return pandas.DataFrame(flat_rows(rows))

    def plot(self, **options: Any) -> Figure:
        """Draws the best detection fraction and the delay of each detector over the false alarms with matplotlib.
        Options and errors as for :meth:`Run.plot`."""
        return self.document.figures["roc"].plot(**options)

    def __repr__(self) -> str:
        return f"Roc({', '.join(self.curves)})"


def roc(
    signal: Recorded | Scenario | str | os.PathLike[str] | None = None,
    *,
    detectors: Sequence[str] | Mapping[str, Part | Mapping[float, Part] | None] | None = None,
    trials: bool = False,
    contact_m: float | None = None,
    ruptures_s: Sequence[float] = (),
    noise_std_n: float | Sequence[float] = 0.025,
    seeds: int = 100,
    thresholds: int = 24,
    within_s: float = 0.01,
    threads: int = 0,
    progress: bool = False,
    **settings: Any,
) -> Roc:
    """Evaluates detectors on a signal with known ruptures, in noise of many seeds, like ``trocar roc``.

    Parameters
    ----------
    signal
        A recording (a DataFrame or a dictionary, as for :func:`trocar.detect`) with its ``ruptures_s``; or a
        scenario, whose closed loop runs with each seed. The default is the shipped insertion.
    detectors
        The names of built-in detectors; the default is all. Or a dictionary of user-defined parts by name: each is
        called as the ``detector`` of :mod:`trocar.parts`, in the same cases as the built-in ones. A dictionary of
        parts by threshold gives a curve, and ``None`` is the built-in detector with that name.
    trials
        True to evaluate on synthetic recordings of every kind instead of a signal; see :func:`trials`.
    contact_m, ruptures_s, **settings
        As for :func:`trocar.detect`. The keys of the detector apply to the built-in detectors.
    noise_std_n
        Standard deviations of the added white noise, in N, from 0 to 100.
    seeds
        Number of seeds per condition, up to 1e6.
    thresholds
        Number of thresholds per built-in detector, from 2 to 1000.
    within_s
        Maximum delay of an alarm that counts as a detection, in s, up to 0.5.
    threads
        Number of threads, up to 1024; 0 is one per processor. They run the built-in detectors, and the user-defined
        ones if all of these are compiled; otherwise user-defined detectors run one after the other.
    progress
        True to show the progress, with tqdm if installed, otherwise as a line on standard error.

    Returns
    -------
    Roc
        The points of each detector, by threshold.

    Raises
    ------
    ValueError
        For an unknown detector, a number out of range, an empty ``noise_std_n``, invalid samples as in
        :func:`trocar.detect`, a threshold that is not finite, ``trials`` together with a signal, ruptures or a
        contact position, and a scenario together with settings, ruptures or a contact position.
    ScenarioError
        For an invalid setting or rupture, and for a scenario that cannot be read or is invalid. It is a
        ``ValueError``.
    TypeError
        If the signal is neither a recording nor a scenario, a detector is neither a name nor a part, or an argument
        is not a number.
    Exception
        Any exception of a user-defined detector; it ends the study.

    >>> import trocar
    >>> def steep(
    ...     force_n: float, predicted_n: float, residual_n: float, depth_m: float, velocity_m_per_s: float, in_contact: bool
    ... ) -> bool:
    ...     return in_contact and residual_n < -0.5
    >>> roc = trocar.roc(detectors={"steep": steep, "adaptive": None}, seeds=5)
    >>> [point["cases"] for point in roc.at_own_threshold().values()]
    [5, 5]
    """
    user_defined, kinds = _detectors(detectors)
    seeds, thresholds, threads = whole("seeds", seeds, 1), whole("thresholds", thresholds, 2), whole("threads", threads)
    if trials and signal is not None:
        raise ValueError("trials replace the signal: give either trials or a signal")
    if trials and (len(ruptures_s) or contact_m is not None):
        raise ValueError("trials contain their ruptures and contact position: leave out ruptures_s and contact_m")
    is_scenario = isinstance(signal, (Scenario, str, os.PathLike))
    scenario = (signal if isinstance(signal, Scenario) else Scenario.load(signal)) if is_scenario else None  # type: ignore[arg-type]
    if scenario is not None and (settings or contact_m is not None or len(ruptures_s)):
        raise ValueError("a scenario contains its settings, contact position and ruptures: change them with replace()")
    recording = None if signal is None or is_scenario else recording_of(signal)
    name = "trials" if trials else "in_vivo_like" if signal is None else "recording"
    noises = [0.0] if trials else [float(std_n) for std_n in np.atleast_1d(np.asarray(noise_std_n, dtype=np.float64))]
    if not noises:
        raise ValueError("noise_std_n is empty, must have at least one standard deviation in N")
    changes = _changes(contact_m, ruptures_s, settings)
    with Progress("cases", progress) as bar:
        report, contents = _core.roc(
            name,
            None if scenario is None else scenario._core,
            recording,
            trials,
            changes,
            kinds,
            user_defined,
            noises,
            seeds,
            thresholds,
            within_s,
            threads,
            bar.tell,
        )
    warnings.warn(report["warnings"])
    return Roc(report, contents)


# The name, the threshold (if any) and the part of each user-defined detector.
_UserDefined = list[tuple[str, float | None, Any]]


def _detectors(given: Sequence[str] | Mapping[str, Part | Mapping[float, Part] | None] | None) -> tuple[_UserDefined, list[str]]:
    """Returns the user-defined detectors, each with its name and threshold, and the names of the built-in ones."""
    if given is None:
        return [], _core.detectors()
    if isinstance(given, str):
        return [], [given]
    if not given:
        raise ValueError("detectors are empty: give at least one")
    if not isinstance(given, Mapping):
        return [], list(given)
    user_defined: _UserDefined = []
    for name, part in given.items():
        if isinstance(part, Mapping):
            user_defined += [(name, _threshold(name, threshold), _detector(one)) for threshold, one in part.items()]
        elif part is not None:
            user_defined.append((name, None, _detector(part)))
    return user_defined, [name for name, part in given.items() if part is None]


def _threshold(name: str, threshold: Any) -> float:
    given = number(f"a threshold of {name}", threshold)
    if not math.isfinite(given):
        raise ValueError(f"a threshold of {name} is {given}, must be finite")
    return given


def _detector(part: Part) -> Any:
    return core_parts({"detector": part})["detector"]
