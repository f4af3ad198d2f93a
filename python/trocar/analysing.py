"""The stability of the loop."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import number, samples, whole
from ._html import table
from ._progress import Progress
from ._stored import Stored
from .warnings import warn
from .documents import Documented
from .scenario import Scenario, scenario_of
from .ranges import Range

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Axis = Union[str, Mapping[str, Union[Range, "tuple[float, float, int]"]]]
"""An axis: a key with a :class:`Range` or a tuple ``(low, high, count)``, or a text ``KEY=LOW:HIGH:COUNT``."""

Response = Union[str, "os.PathLike[str]", "tuple[ArrayLike, ArrayLike]"]
"""A frequency response: a CSV file, or frequencies in Hz and complex responses."""


class Stability(Documented, Stored):
    """The stability analysis of a loop, returned by :func:`stability`. ``print`` shows its tables.

    Attributes
    ----------
    report : dict
        The content of the command line's ``stability.json``: mode, margins, limits, sensitivities, ports, switching.
    x, y : array, float64, shapes (columns,) and (rows,)
        The axes of the map.
    stable : array, bool, shape (rows, columns)
        True where the loop is stable on the map.
    boundary : array, float64, shape (pieces, 2, 2)
        Segments of the boundary, each with two points ``(x, y)``.
    simulated : array, int8, shape (rows, columns), or None
        The results of simulated runs: 1 decays, 0 grows, -1 undecided.
    files : dict of str to str
        The text of further files by name, such as ``certificate.json`` and ``worst_events.toml``.
    data : dict of str to dict
        Further tables by name, each with its columns: the two-port over frequency and, if requested, the locus of the
        poles, the absolute stability over a parameter, the Z-width, the measured loop and the population.

    >>> import trocar
    >>> classical = trocar.Scenario.load("paper/classical", **{"tissue.stiffness_n_per_m": 200.0})
    >>> x, y = {"scaling.force": trocar.Range(5, 20, 3)}, {"tissue.stiffness_n_per_m": (500, 2000, 2)}
    >>> stability = trocar.stability(classical, x, y)
    >>> stability
    Stability('classical', stable)
    >>> stability.stable
    array([[ True, False, False],
           [False, False, False]])
    >>> round(stability.largest_stable["scaling.force"] or 0.0, 1)
    15.8
    """

    def __init__(
        self,
        report: dict[str, Any],
        contents: dict[str, Any],
        columns: dict[str, NDArray[Any]],
        files: dict[str, str],
        data: dict[str, dict[str, Any]],
    ) -> None:
        self.report = report
        self.files = files
        self.data = data
        self._contents = contents
        self.x: NDArray[np.float64] = columns["x"]
        self.y: NDArray[np.float64] = columns["y"]
        shape = (len(self.y), len(self.x))
        self.stable: NDArray[np.bool_] = columns["stable"].reshape(shape)
        self.boundary: NDArray[np.float64] = columns["boundary"].reshape(-1, 2, 2)
        simulated = columns.get("simulated")
        self.simulated: NDArray[np.int8] | None = None if simulated is None else simulated.reshape(shape)

    _keys = {"stability", "document"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        arrays: dict[str, NDArray[Any]] = {"x": self.x, "y": self.y, "stable": self.stable, "boundary": self.boundary}
        simulated = {} if self.simulated is None else {"simulated": self.simulated}
        for name, columns in self.data.items():
            arrays |= {f"{name}/{key}": np.asarray(column) for key, column in columns.items()}
        return arrays | simulated, {"stability": self.report, "document": self._contents, "files": self.files}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Stability:
        data: dict[str, dict[str, Any]] = {}
        for key in [key for key in arrays if "/" in key]:
            name, _, column = key.rpartition("/")
            data.setdefault(name, {})[column] = arrays.pop(key)
        return cls(about["stability"], about["document"], arrays, about.get("files", {}), data)

    @property
    def is_stable(self) -> bool | None:
        """True if the loop of the scenario is stable; ``None`` if the analysis leaves out a part of the scenario."""
        return None if self.report["is_stable"] is None else bool(self.report["is_stable"])

    @property
    def largest_stable(self) -> dict[str, float | None]:
        """The maximum stable value of each parameter, in SI units; ``None`` without a limit in the search range."""
        return {limit["parameter"]: limit["largest_stable"] for limit in self.report["limits"]}

    def plot(self, **options: Any) -> Figure:
        """Draws the map and its boundary with matplotlib. Options and errors as for :meth:`Run.plot`."""
        return self.document.figures["stability"].plot(**options)

    def __repr__(self) -> str:
        verdict = {True: "stable", False: "unstable", None: "unknown"}[self.is_stable]
        return f"Stability({self.report['scenario']!r}, {verdict})"


def stability(
    scenario: Scenario | str | os.PathLike[str] = "paper/depth-classical",
    x: Axis = "scaling.force=0.1:10:200",
    y: Axis = "tissue.stiffness_n_per_m=10:2000:200",
    *,
    tissue: tuple[float, float] | None = None,
    tissue_damping: tuple[float, float] | None = None,
    hand: tuple[float, float] | None = None,
    absolute: Axis | None = None,
    locus: Axis | None = None,
    z_width: Range | tuple[float, float, int] | None = None,
    master_response: Response | None = None,
    slave_response: Response | None = None,
    people: int | None = None,
    simulate: bool = False,
    event_limits: bool = False,
    threads: int = 0,
    progress: bool = False,
) -> Stability:
    """Analyses the stability of the loop from its matrices: dominant mode, margins, limits, a map over two parameters, and
    the certificate of events. :func:`margins` has the margins and limits alone, in milliseconds.

    Parameters
    ----------
    scenario
        A scenario or a path.
    x, y
        The axes of the map: ``{"scaling.force": trocar.Range(0.1, 10, 200, log=True)}``, the same with a tuple
        ``(low, high, count)``, or a text ``"KEY=LOW:HIGH:COUNT"``, with a count from 2 to 2000. A tuple or a text is
        logarithmic if the high end is at least 50 times the low one; append ``:log`` or ``:linear`` to a text to choose
        the spacing.
    tissue
        Range of the tissue stiffness, in N/m, for the analysis of events and of bounded hands; the stiffness can
        change within it at any tick. The default is the range of the scenario's tissue.
    tissue_damping
        Range of the tissue damping, in N·s/m, for absolute stability with bounded tissues; the default is the damping
        of the scenario.
    hand
        Range of the damping of hands, in N·s/m, for absolute stability: any passive hand behind dampers of these two
        values, of which the second can be infinite. The default is any passive hand.
    absolute
        An axis over which Llewellyn's parameter and the damping that a hand needs are computed, too.
    locus
        An axis over which the poles of the closed loop are computed, too.
    z_width
        The damping of walls, in N·s/m, over which the Z-width is computed, too: the maximum stiffness of stable and of
        passive walls.
    master_response, slave_response
        Measured frequency responses: of the master from the feedback force (N) to the handle's position in its
        direction (m), with the hand on it; of the slave from its reference (m) to the position of the free needle (m).
        Each is a CSV file, or two arrays: frequencies in Hz, and complex responses. The loop is also analysed with
        them.
    people
        The number of people, drawn at random around the scenario's arm, over whom limits are computed, too. It is short
        for ``population.arm = "people"`` and ``population.size``.
    simulate
        True to simulate every point of the map, too, without the parts that the analysis leaves out.
    event_limits
        True to search for the limits of the certificate of events, such as the largest certified amplification, which
        takes minutes. They are in ``report["event_limits"]``.
    threads
        Number of threads, up to 1024; 0 is one per processor.
    progress
        True to show the number of simulated points.

    Returns
    -------
    Stability
        The verdict for the scenario, the limits of its parameters, and the map.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For an axis with another form, an unknown key or a value out of range, for two axes of the same parameter, for
        a range that does not ascend or is out of range, for a response that is not one, and for ``threads`` out of range.
    TypeError
        If an argument does not have the type above.

    >>> import trocar
    >>> x, y = {"scaling.force": (1, 10, 4)}, {"tissue.stiffness_n_per_m": (100, 1000, 3)}
    >>> stability = trocar.stability("paper/classical", x, y)
    >>> stability.is_stable, stability.stable.shape
    (True, (3, 4))
    """
    threads = whole("threads", threads)
    scenario = scenario_of(scenario)
    if people is not None:
        scenario = scenario.replace(**{"population.arm": "people", "population.size": whole("people", people, 1)})
    options = {
        "tissue": _pair("tissue", tissue),
        "tissue_damping": _pair("tissue_damping", tissue_damping),
        "hand": _pair("hand", hand),
        "absolute": None if absolute is None else axis_text("absolute", absolute),
        "locus": None if locus is None else axis_text("locus", locus),
        "z_width": None if z_width is None else axis_text("z_width", {"tissue.damping_n_s_per_m": z_width}),
        "master_response": _response("master_response", master_response),
        "slave_response": _response("slave_response", slave_response),
        "simulate": bool(simulate),
        "event_limits": bool(event_limits),
    }
    with Progress("points", progress) as bar:
        report, contents, columns, files, data = _core.stability(
            scenario._core, axis_text("x", x), axis_text("y", y), options, threads, bar.tell
        )
    warn(report["warnings"])
    return Stability(report, contents, columns, dict(files), data)


def axis_text(name: str, axis: Any) -> str:
    """Returns an axis in the form of the core."""
    if isinstance(axis, str):
        return axis
    if not isinstance(axis, Mapping) or len(axis) != 1:
        must = f'a dictionary with one key, as in {name}={{"scaling.force": trocar.Range(0.1, 10, 200)}}'
        raise TypeError(f"{name} is {axis!r}, must be {must}")
    ((key, values),) = axis.items()
    spacing = ""
    if isinstance(values, Range):
        if values.points is None:
            raise ValueError(f"{name} has a Range without points, must have a number of points from 2 to 2000")
        low, high, count, spacing = values.start, values.stop, values.points, ":log" if values.log else ":linear"
    elif isinstance(values, tuple) and len(values) == 3:
        low, high, count = values
    else:
        raise TypeError(f"{name} has the values {values!r}, must have a Range or a tuple (low, high, count)")
    low, high = number(f"the low end of {name}", low), number(f"the high end of {name}", high)
    return f"{key}={low!r}:{high!r}:{whole(f'the count of {name}', count)}{spacing}"


def _pair(name: str, given: Any) -> tuple[float, float] | None:
    if given is None:
        return None
    if not isinstance(given, (tuple, list, np.ndarray)) or len(given) != 2:
        raise TypeError(f"{name} is {given!r}, must be two numbers, as in {name}=(50, 600)")
    return number(name, given[0]), number(name, given[1])


def _response(name: str, given: Any) -> str | list[tuple[float, float, float]] | None:
    if given is None or isinstance(given, (str, os.PathLike)):
        return None if given is None else os.fspath(given)
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        raise TypeError(f"{name} must be a path, or two arrays: frequencies in Hz and complex responses")
    frequencies, response = samples(f"the frequencies of {name}", given[0]), np.asarray(given[1], dtype=np.complex128)
    if response.shape != frequencies.shape:
        raise ValueError(f"{name} has {len(frequencies)} frequencies and responses with the shape {response.shape}")
    return list(zip(frequencies.tolist(), np.abs(response).tolist(), np.angle(response).tolist()))


@dataclass(frozen=True)
class Margins:
    """Margins and limits of the loop of a scenario, returned by :func:`margins`. A margin without a limit is infinite; those of
    an unstable loop are ``None``.

    Attributes
    ----------
    is_stable : bool or None
        True if the loop is stable at every stiffness of its tissue and in free motion; ``None`` if the analysis leaves
        out a part that can decide it.
    gain, gain_frequency_hz : float or None
        The gain margin, the smallest factor above 1 that makes the loop unstable, and its frequency in Hz if it is finite.
    gain_below : float or None
        The largest factor below 1 that makes a conditionally stable loop unstable.
    phase_rad, phase_frequency_hz : float or None
        The phase margin in rad, and its frequency in Hz if it is finite.
    delay_s : float or None
        The smallest additional delay around the loop that makes it unstable, in s.
    spectral_radius, mode_frequency_hz, mode_damping_ratio : float
        The dominant mode: the modulus of its pole (stable below 1), its frequency in Hz, and its damping ratio.
    stiffness_n_per_m, damping_n_s_per_m : float
        The tissue for which margins and mode hold: the worst spring and damper that the needle meets.
    tissue_n_per_m : (float, float)
        The smallest and the largest stiffness that the needle meets, on its way back too, in N/m.
    tissue_n_s_per_m : (float, float)
        The smallest and the largest damping that the needle meets, in N·s/m.
    limits : dict of str to float or None
        The maximum stable value of each parameter, in SI units: infinite without a limit in the search range, ``None`` if
        no value is stable.
    left_out : list of str
        The parts of the scenario with which the stability is unknown.
    sentence : str
        The verdict in a sentence.

    >>> import trocar
    >>> margins = trocar.margins("paper/classical", limits=["channel.delay_s"])
    >>> margins.is_stable, list(margins.limits)
    (True, ['channel.delay_s'])
    """

    scenario: str
    is_stable: bool | None
    gain: float | None
    gain_frequency_hz: float | None
    gain_below: float | None
    phase_rad: float | None
    phase_frequency_hz: float | None
    delay_s: float | None
    spectral_radius: float
    mode_frequency_hz: float
    mode_damping_ratio: float
    stiffness_n_per_m: float
    damping_n_s_per_m: float
    tissue_n_per_m: tuple[float, float]
    tissue_n_s_per_m: tuple[float, float]
    limits: dict[str, float | None]
    left_out: list[str]
    sentence: str

    def __str__(self) -> str:
        rows = [f"{name}: {_shown(value)}" for name, value in self._rows()]
        return "\n".join([self.sentence, *rows])

    def _rows(self) -> list[tuple[str, Any]]:
        margins = [(one.name, getattr(self, one.name)) for one in fields(self) if one.name not in ("sentence", "limits", "scenario")]
        return [*margins, *((f"limit of {key}", limit) for key, limit in self.limits.items())]

    def _repr_html_(self) -> str:
        return table(["margin", self.scenario], [[name, _shown(value)] for name, value in self._rows()], self.sentence)


def _shown(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_shown, value))
    if value == np.inf:
        return "unlimited"
    return "—" if value is None else f"{value:.5g}" if isinstance(value, float) else str(value)


def margins(
    scenario: Scenario | str | os.PathLike[str] = "paper/depth-classical", *, limits: bool | Sequence[str] = True
) -> Margins:
    """Returns margins, dominant mode and limits of the loop, without a map and without the certificate of events, in
    milliseconds.

    The tissue is that of :func:`stability`: the margins hold for the worst stiffness that the needle meets.

    Parameters
    ----------
    scenario
        A scenario or a path.
    limits
        True for the maximum stable force scale, position scale, stiffness and delay; a list of keys for other
        parameters; ``False`` for none.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For a key in ``limits`` that is no parameter of the loop.
    TypeError
        If the scenario is neither a ``Scenario`` nor a path.

    >>> import trocar
    >>> margins = trocar.margins("layers/skin-augmented")
    >>> round(margins.gain or 0.0, 3), round(margins.limits["scaling.force"] or 0.0, 3)
    (2.854, 2.854)
    """
    keys = _core.limited_keys() if limits is True else [] if limits is False else [limits] if isinstance(limits, str) else list(limits)
    scenario = scenario_of(scenario)
    found = _core.margins(scenario._core, keys)
    return Margins(scenario=scenario.name, **found)


def verify_certificate(
    certificate: Stability | str | os.PathLike[str], scenario: Scenario | str | os.PathLike[str]
) -> dict[str, int]:
    """Verifies a certificate of events in interval arithmetic, without the search that found it.

    Rebuilds maps and inequalities from the scenario, for the range of the tissue that the certificate states, and takes
    only the functions from the certificate.

    Parameters
    ----------
    certificate
        A result of :func:`stability`, or a file ``certificate.json``.
    scenario
        The scenario of the certificate, or its path.

    Returns
    -------
    dict of int
        The number of verified conditions of each certificate, by name.

    Raises
    ------
    OSError
        For a file that cannot be read.
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For a result or a file without a certificate, for one of another scenario, and for an inequality that is missing
        or does not hold.
    TypeError
        If the scenario is neither a ``Scenario`` nor a path.

    >>> import trocar
    >>> trocar.verify_certificate("certificate.json", "strategies/snap")
    Traceback (most recent call last):
    FileNotFoundError: [Errno 2] No such file or directory: 'certificate.json'
    """
    scenario = scenario_of(scenario)
    if isinstance(certificate, Stability):
        if "certificate.json" not in certificate.files:
            raise ValueError(f"{certificate!r} has no certificate")
        text = certificate.files["certificate.json"]
    else:
        with open(certificate, encoding="utf-8") as file:
            text = file.read()
    return dict(_core.verify_certificate(text, scenario._core))
