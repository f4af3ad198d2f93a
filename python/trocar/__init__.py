"""Bilateral teleoperation of needle insertions with event-based haptic augmentation, from numpy.

>>> import trocar
>>> run = trocar.run("paper/augmented")
>>> run["slave_position_m"].shape, len(run.events)
((17000,), 2)

All quantities are in SI units (m, m/s, N, s); names end with the unit. Positions increase into the tissue. Forces are
positive when they resist insertion. Computations release the global interpreter lock, and Ctrl-C ends them.
"""

import importlib.util as _util

if _util.find_spec(f"{__name__}._core") is None:
    raise ImportError(
        f"trocar is imported from its source folder {__path__[0]}, which has no compiled part: "
        "run `pip install ./python` in the repository and leave the folder `python`, or run `maturin develop` in it"
    )

from . import _core
from ._core import Step, __version__
from ._errors import ScenarioError
from ._warnings import (
    ActiveLoopWarning,
    ColumnsSwappedWarning,
    ConstantForceWarning,
    DelayBeyondRunWarning,
    DelayRoundedWarning,
    ForceMagnitudeWarning,
    ForceNotBoundedWarning,
    ForceOffsetWarning,
    ForceOutOfContactWarning,
    ForceSignWarning,
    GuessedColumnsWarning,
    HandEnergyImpossibleWarning,
    HarmlessAlarmsWarning,
    HighSamplingRateWarning,
    KeyWithoutEffectWarning,
    LayerNotRupturedWarning,
    LimitActsWarning,
    LowSamplingRateWarning,
    MissedRuptureWarning,
    MissingSectionWarning,
    MotionBeyondRunWarning,
    NoContactWarning,
    NoRupturesWarning,
    OscillatingWarning,
    OutsideMeasuredWarning,
    PeerRestartedWarning,
    PeerSilentWarning,
    PositionMagnitudeWarning,
    PromiseBrokenWarning,
    PromiseNotCoveredWarning,
    RarelyArmedWarning,
    SeedsWithoutEffectWarning,
    SlowRupturesMissedWarning,
    StrayAlarmWarning,
    TissueNotCoveredWarning,
    TissueNotTouchedWarning,
    TrocarWarning,
    UnchangedMetricsWarning,
    UnfinishedFileWarning,
    UnitIgnoredWarning,
    UnmodelledWarning,
    VelocityMagnitudeWarning,
)
from .comparing import Comparison, compare
from .detection import Calibration, Detection, Detector, calibrate, detect, record, score
from .documents import Document, Figure, Table
from .exporting import export_fmu
from .judging import Roc, Trial, roc, trials
from .linear import Stability, StateSpace, stability, state_space, verify_certificate
from .parts import Compiled, Simulation
from .recordings import list_signals, read_recording
from .rig import HapticController
from .running import Run, load, run
from .scenario import Scenario
from .sweeping import Range, Sweep, merge, shard, sweep

__all__ = [
    "ActiveLoopWarning",
    "ColumnsSwappedWarning",
    "ConstantForceWarning",
    "Calibration",
    "Comparison",
    "Compiled",
    "DelayBeyondRunWarning",
    "DelayRoundedWarning",
    "Detection",
    "Detector",
    "Document",
    "Figure",
    "ForceMagnitudeWarning",
    "ForceNotBoundedWarning",
    "ForceOffsetWarning",
    "ForceOutOfContactWarning",
    "ForceSignWarning",
    "HandEnergyImpossibleWarning",
    "HapticController",
    "GuessedColumnsWarning",
    "HarmlessAlarmsWarning",
    "HighSamplingRateWarning",
    "KeyWithoutEffectWarning",
    "LayerNotRupturedWarning",
    "LimitActsWarning",
    "LowSamplingRateWarning",
    "MissedRuptureWarning",
    "MissingSectionWarning",
    "MotionBeyondRunWarning",
    "NoContactWarning",
    "NoRupturesWarning",
    "OscillatingWarning",
    "OutsideMeasuredWarning",
    "PeerRestartedWarning",
    "PeerSilentWarning",
    "PositionMagnitudeWarning",
    "PromiseBrokenWarning",
    "PromiseNotCoveredWarning",
    "Range",
    "RarelyArmedWarning",
    "Roc",
    "Run",
    "Scenario",
    "ScenarioError",
    "SeedsWithoutEffectWarning",
    "Simulation",
    "SlowRupturesMissedWarning",
    "Stability",
    "StateSpace",
    "Step",
    "StrayAlarmWarning",
    "Sweep",
    "Table",
    "TissueNotCoveredWarning",
    "TissueNotTouchedWarning",
    "Trial",
    "TrocarWarning",
    "UnchangedMetricsWarning",
    "UnfinishedFileWarning",
    "UnitIgnoredWarning",
    "UnmodelledWarning",
    "VelocityMagnitudeWarning",
    "__version__",
    "calibrate",
    "compare",
    "detect",
    "export_fmu",
    "keys",
    "list_signals",
    "load",
    "merge",
    "metric_names",
    "metrics",
    "read_recording",
    "record",
    "roc",
    "run",
    "score",
    "shard",
    "shipped",
    "stability",
    "state_space",
    "sweep",
    "trace_columns",
    "trials",
    "verify_certificate",
]


def shipped() -> dict[str, str]:
    """Returns the shipped scenarios with the question that each answers. Load one with :meth:`Scenario.load`.

    Returns
    -------
    dict of str to str
        The name of each scenario, which begins with ``builtin:``, and its question.

    >>> import trocar
    >>> "builtin:paper/classical.toml" in trocar.shipped()
    True
    >>> trocar.Scenario.load("builtin:paper/classical.toml").name
    'classical'
    """
    return dict(_core.shipped())


def keys() -> dict[str, tuple[str, str | None, str]]:
    """Returns every key of a scenario.

    Returns
    -------
    dict of str to (str, str or None, str)
        For each dotted key: its type with the allowed range, its default in TOML (``None`` without a default), and
        its meaning.

    >>> import trocar
    >>> trocar.keys()["scaling.force"]
    ('a number, at least 0 and at most 1000', '1.0', 'Feedback force per measured force.')
    """
    return {path: (kind, default, meaning) for path, kind, default, meaning in _core.keys()}


def metrics() -> dict[str, tuple[str, str, str, str, str]]:
    """Returns every metric that :func:`sweep` can record. The names of rupture and event metrics contain the number
    1.

    Returns
    -------
    dict of str to (str, str, str, str, str)
        For each metric: its scope (``run``, ``rupture``, ``event``, ``link``, ``loop``), its label in tables, its SI
        unit, which values are better (``lower``, ``higher``, ``neither``), and its meaning.

    >>> import trocar
    >>> trocar.metrics()["detected_ruptures"]
    ('run', 'detected ruptures', '1', 'higher', 'Ruptures with an alarm within 0.1 s, after the force has fallen.')
    """
    return {
        name: (scope, label, unit, better, meaning) for name, scope, label, unit, better, meaning in _core.metrics()
    }


def metric_names() -> list[str]:
    """Returns the metric names that :func:`sweep` accepts; :func:`metrics` describes them.

    >>> import trocar
    >>> "detected_ruptures" in trocar.metric_names()
    True
    """
    return list(metrics())


def trace_columns() -> dict[str, tuple[str, str]]:
    """Returns the columns of the trace of a :class:`Run`.

    Returns
    -------
    dict of str to (str, str)
        For each column: its SI unit (empty for codes) and its meaning.

    >>> import trocar
    >>> trocar.trace_columns()["slave_position_m"]
    ('m', 'Position of the slave, x_e, increasing into the tissue.')
    """
    return {name: (unit, meaning) for name, unit, meaning in _core.trace_columns()}
