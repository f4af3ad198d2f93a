"""Warning classes, one per code, for ``warnings.filterwarnings`` and ``pytest.warns``."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

from . import _core


class TrocarWarning(UserWarning):
    """A warning about a scenario, a recording or a result.

    Attributes
    ----------
    code : str
        The code; ``trocar explain`` explains it.
    place : str or None
        The key or column concerned.
    remedy : str or None
        The remedy.
    """

    code = ""

    def __init__(self, message: str, place: str | None = None, remedy: str | None = None) -> None:
        super().__init__(message)
        self.place = place
        self.remedy = remedy


class MissedRuptureWarning(TrocarWarning):
    """A layer ruptured, and no alarm followed within 0.1 s."""

    code = "missed-rupture"


class OscillatingWarning(TrocarWarning):
    """The needle or the master swings, and the swing does not decay."""

    code = "oscillating"


class ActiveLoopWarning(TrocarWarning):
    """The master gives the hand more energy than hand and tissue have supplied."""

    code = "active-loop"


class LimitActsWarning(TrocarWarning):
    """A limit of the safety stage changed a command."""

    code = "limit-acts"


class PeerRestartedWarning(TrocarWarning):
    """A side of a link was started anew while the link ran."""

    code = "peer-restarted"


class PeerSilentWarning(TrocarWarning):
    """Nothing came from the other side of a link for longer than three outages."""

    code = "peer-silent"


class PromiseBrokenWarning(TrocarWarning):
    """A passivity scheme has generated more energy than it promises."""

    code = "promise-broken"


class PromiseNotCoveredWarning(TrocarWarning):
    """The promise of the passivity scheme does not cover a part of the scenario."""

    code = "promise-not-covered"


class DelayBeyondRunWarning(TrocarWarning):
    """A delay of the link is longer than the run."""

    code = "delay-beyond-run"


class DelayRoundedWarning(TrocarWarning):
    """A delay of the link is rounded up to a whole number of ticks."""

    code = "delay-rounded"


class TissueNotTouchedWarning(TrocarWarning):
    """The needle never touches the tissue."""

    code = "tissue-not-touched"


class LayerNotRupturedWarning(TrocarWarning):
    """A layer or a labelled rupture of the scenario does not occur in the run."""

    code = "layer-not-ruptured"


class MotionBeyondRunWarning(TrocarWarning):
    """The operator's movement takes longer than the run."""

    code = "motion-beyond-run"


class StrayAlarmWarning(TrocarWarning):
    """An alarm near a rupture does not count as its detection."""

    code = "stray-alarm"


class OutsideMeasuredWarning(TrocarWarning):
    """A property of the tissue is outside the range of the measurements."""

    code = "outside-measured"


class SeedsWithoutEffectWarning(TrocarWarning):
    """The scenario has no random numbers, so every seed gives the same run."""

    code = "seeds-without-effect"


class UnchangedMetricsWarning(TrocarWarning):
    """No metric differs between the cases of a sweep."""

    code = "unchanged-metrics"


class UnmodelledWarning(TrocarWarning):
    """The analysis of stability leaves out a part of the scenario."""

    code = "unmodelled"


class TissueNotCoveredWarning(TrocarWarning):
    """The certificate does not cover the whole tissue of the scenario."""

    code = "tissue-not-covered"


class LowSamplingRateWarning(TrocarWarning):
    """The samples are too far apart to show a rupture."""

    code = "low-sampling-rate"


class HighSamplingRateWarning(TrocarWarning):
    """The sampling rate is higher than that of any force sensor."""

    code = "high-sampling-rate"


class ForceSignWarning(TrocarWarning):
    """The force does not resist the insertion."""

    code = "force-sign"


class ForceMagnitudeWarning(TrocarWarning):
    """The forces are implausible for a needle in tissue."""

    code = "force-magnitude"


class PositionMagnitudeWarning(TrocarWarning):
    """The positions are implausible for a needle insertion."""

    code = "position-magnitude"


class VelocityMagnitudeWarning(TrocarWarning):
    """The recorded velocity is not the derivative of the recorded position."""

    code = "velocity-magnitude"


class NoContactWarning(TrocarWarning):
    """The needle never reaches the contact position."""

    code = "no-contact"


class ForceOutOfContactWarning(TrocarWarning):
    """The largest force of a recording, or the force at an alarm, acts above the contact position."""

    code = "force-out-of-contact"


class ForceOffsetWarning(TrocarWarning):
    """The force is not 0 before the needle touches the tissue."""

    code = "force-offset"


class KeyWithoutEffectWarning(TrocarWarning):
    """A given key changes nothing in this command."""

    code = "key-without-effect"


class ConstantForceWarning(TrocarWarning):
    """The force does not change although the needle moves in contact."""

    code = "constant-force"


class SlowRupturesMissedWarning(TrocarWarning):
    """The calibrated settings detect less than half of the slowest inserted ruptures."""

    code = "slow-ruptures-missed"


class HarmlessAlarmsWarning(TrocarWarning):
    """The calibrated settings raise alarms at more than a fifth of the inserted harmless changes."""

    code = "harmless-alarms"


class GuessedColumnsWarning(TrocarWarning):
    """The columns of a recording are guessed from their names and units."""

    code = "guessed-columns"


class UnitIgnoredWarning(TrocarWarning):
    """A column is read in SI units, and the file states another unit."""

    code = "unit-ignored"


class UnfinishedFileWarning(TrocarWarning):
    """The file of a recording seems to end before the recording did."""

    code = "unfinished-file"


class NoRupturesWarning(TrocarWarning):
    """A study of detectors has no rupture."""

    code = "no-ruptures"


BY_CODE: dict[str, type[TrocarWarning]] = {kind.code: kind for kind in TrocarWarning.__subclasses__()}


def warning_of(one: dict[str, Any]) -> TrocarWarning:
    """Returns the warning object for a warning of an answer."""
    message, place, remedy = (None if one[key] is None else _core.in_python(one[key]) for key in ("message", "place", "remedy"))
    source = f"{one['source']}: " if one.get("source") else ""
    text = f"{source}{message} ({remedy})" if remedy else f"{source}{message}"
    return BY_CODE[one["code"]](text, place, remedy)


def warn(found: Iterable[dict[str, Any]]) -> None:
    """Issues the warnings of an answer, attributed to the caller of the calling function."""
    for one in found:
        warnings.warn(warning_of(one), stacklevel=3)
