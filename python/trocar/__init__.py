"""Bilateral teleoperation of needle insertions with event-based haptic augmentation, from numpy.

>>> import trocar
>>> run = trocar.run("paper/augmented")
>>> run["slave_position_m"].shape, len(run.events)
((17000,), 2)

The results' classes, for annotations, are in :mod:`trocar.results`, the warnings in :mod:`trocar.warnings`, and the roles
of user-defined parts in :mod:`trocar.parts`. All quantities are in SI units (m, m/s, N, s); names end with the unit. Positions increase into the tissue. Forces are
positive when they resist insertion. Computations release the global interpreter lock, and Ctrl-C ends them.
"""

import importlib.util as _util

if _util.find_spec(f"{__name__}._core") is None:
    raise ImportError(
        f"trocar is imported from its source folder {__path__[0]}, which has no compiled part: "
        "run `pip install ./python` in the repository and leave the folder `python`, or run `maturin develop` in it"
    )

from . import _core
from . import results, warnings
from ._core import Command, Step
from ._core import __version__ as __version__
from ._errors import ScenarioError
from .analysing import margins, stability, verify_certificate
from .comparing import compare
from .designing import design
from .detection import Detector, calibrate, detect, record, score
from .exporting import export
from .identifying import identify
from .judging import roc, trials
from .linear import state_space
from .parts import Compiled, Simulation
from .people import patients
from .recordings import list_signals, read_recording
from .rig import HapticController
from .running import Run, load, run
from .scenario import Scenario
from .studying import paper, strategies
from .ranges import Range
from .sweeping import Sweep, sweep

__all__ = [
    "Command",
    "Compiled",
    "Detector",
    "HapticController",
    "Range",
    "Run",
    "Scenario",
    "ScenarioError",
    "Simulation",
    "Step",
    "Sweep",
    "calibrate",
    "compare",
    "design",
    "detect",
    "export",
    "identify",
    "keys",
    "list_signals",
    "load",
    "margins",
    "metrics",
    "paper",
    "patients",
    "read_recording",
    "record",
    "roc",
    "run",
    "score",
    "shipped",
    "stability",
    "state_space",
    "strategies",
    "sweep",
    "trace_columns",
    "trials",
    "verify_certificate",
]


def __dir__() -> list[str]:
    # `from trocar import *` leaves out the modules, one of which would hide the standard `warnings`.
    return [*__all__, "parts", "results", "warnings"]


def shipped() -> dict[str, str]:
    """Returns the shipped scenarios and sweep files with the question that each answers. Load a scenario with
    :meth:`Scenario.load`, and run a sweep file with :func:`sweep`.

    Returns
    -------
    dict of str to str
        The name of each file, which begins with ``builtin:`` (a sweep file with ``builtin:sweeps/``), and its question.

    >>> import trocar
    >>> "builtin:paper/classical.toml" in trocar.shipped()
    True
    >>> trocar.Scenario.load("builtin:paper/classical.toml").name
    'classical'
    """
    return dict([*_core.shipped(), *_core.shipped_sweeps()])


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
