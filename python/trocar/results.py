"""The classes of results, for annotations and ``isinstance``, and the types of their dictionaries.

>>> import trocar
>>> isinstance(trocar.compare(), trocar.results.Comparison)
True
"""

from ._typed import Alarm, Event, LinkMetrics, Metrics, Outcome, PortMetrics, Rupture
from .analysing import Margins, Stability
from .comparing import Comparison
from .designing import Design
from .detection import Calibration, Detection
from .documents import Document, Figure, Table
from .identifying import Identification
from .judging import Roc, Trial
from .linear import StateSpace
from .people import Patients
from .recordings import Recording
from .running import Run
from .studying import Paper, Strategies
from .sweeping import Sweep

__all__ = [
    "Alarm",
    "Calibration",
    "Comparison",
    "Design",
    "Detection",
    "Document",
    "Event",
    "Figure",
    "Identification",
    "LinkMetrics",
    "Margins",
    "Metrics",
    "Outcome",
    "Paper",
    "Patients",
    "PortMetrics",
    "Recording",
    "Roc",
    "Rupture",
    "Run",
    "Stability",
    "StateSpace",
    "Strategies",
    "Sweep",
    "Table",
    "Trial",
]
