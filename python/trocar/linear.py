"""The linear loop: stability analysis, and state-space matrices of the loop and its sides."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import whole
from ._progress import Progress
from ._stored import Stored
from ._warnings import warn
from .documents import Documented
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import control
    from matplotlib.figure import Figure


Side = Literal["master", "slave", "loop-gain", "closed-loop"]


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

    >>> import trocar
    >>> classical = trocar.Scenario.load("paper/classical", **{"tissue.stiffness_n_per_m": 200.0})
    >>> stability = trocar.stability(classical, "scaling.force=5:20:3", "tissue.stiffness_n_per_m=500:2000:2")
    >>> stability
    Stability('classical', stable)
    >>> stability.stable
    array([[ True, False, False],
           [False, False, False]])
    >>> round(stability.largest_stable["scaling.force"] or 0.0, 1)
    15.8
    """

    def __init__(self, report: dict[str, Any], contents: dict[str, Any], columns: dict[str, NDArray[Any]]) -> None:
        self.report = report
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
        return arrays | simulated, {"stability": self.report, "document": self._contents}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Stability:
        return cls(about["stability"], about["document"], arrays)

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
    x: str = "scaling.force=0.1:10:200",
    y: str = "tissue.stiffness_n_per_m=10:2000:200",
    *,
    tissue: tuple[float, float] | None = None,
    simulate: bool = False,
    event_limits: bool = False,
    threads: int = 0,
    progress: bool = False,
) -> Stability:
    """Analyses the stability of the loop from its matrices: dominant mode, margins, limits, and a map over two parameters.

    Parameters
    ----------
    scenario
        A scenario or a path.
    x, y
        The axes of the map, ``KEY=LOW:HIGH:COUNT``, with a count from 2 to 2000. Append ``:log`` or ``:linear`` to
        choose the spacing.
    tissue
        Range of the tissue stiffness, in N/m, for the analysis of events and of bounded hands; the stiffness can
        change within it at any tick. The default is the range of the scenario's tissue.
    simulate
        True to simulate every point of the map, too.
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
        a ``tissue`` that does not ascend or is out of range, and for ``threads`` out of range.
    TypeError
        If an argument does not have the type above.

    >>> import trocar
    >>> stability = trocar.stability("paper/classical", "scaling.force=1:10:4", "tissue.stiffness_n_per_m=100:1000:3")
    >>> stability.is_stable, stability.stable.shape
    (True, (3, 4))
    """
    threads = whole("threads", threads)
    with Progress("points", progress) as bar:
        report, contents, columns = _core.stability(
            scenario_of(scenario)._core, x, y, tissue, simulate, event_limits, threads, bar.tell
        )
    warn(report["warnings"])
    return Stability(report, contents, columns)


def verify_certificate(path: str | os.PathLike[str]) -> dict[str, int]:
    """Verifies a file ``certificate.json`` in interval arithmetic, without the search that found it.

    Parameters
    ----------
    path
        The file, which ``trocar stability`` writes.

    Returns
    -------
    dict of int
        The number of verified conditions of each certificate, by name.

    Raises
    ------
    OSError
        For a file that cannot be read.
    ValueError
        For a file without a certificate, for one that was changed, and for an inequality that does not hold.

    >>> import trocar
    >>> trocar.verify_certificate("certificate.json")
    Traceback (most recent call last):
    FileNotFoundError: [Errno 2] No such file or directory: 'certificate.json'
    """
    with open(path, encoding="utf-8", newline="") as file:
        return dict(_core.verify_certificate(file.read()))


class StateSpace:
    """A linear system in SI units, returned by :func:`state_space`: one side of the teleoperator in continuous time,
    ``x' = A x + B u``, or the loop from tick to tick, ``x_{k+1} = A x_k + B u_k``; both with ``y = C x + D u``.

    Attributes
    ----------
    A, B, C, D : array, float64
        Matrices with the shapes (states, states), (states, inputs), (outputs, states) and (outputs, inputs).
    inputs, outputs, states : list of str
        Names of the signals, with their units.
    name : str
        Name of the side.
    tick_s : float or None
        Time between two states, in s; ``None`` in continuous time.

    >>> import trocar
    >>> slave = trocar.state_space("paper/classical", "slave")
    >>> slave.inputs, slave.outputs
    (['slave_reference_m'], ['slave_position_m', 'slave_velocity_m_per_s'])
    >>> slave.A.shape, slave.B.shape, slave.C.shape, slave.D.shape
    ((3, 3), (3, 1), (2, 3), (2, 1))
    >>> bool(slave.poles().real.max() < 0.0)
    True
    """

    def __init__(self, core: _core.StateSpace, scenario: Scenario, side: Side) -> None:
        self._core = core
        self._of = scenario, side
        self.A, self.B, self.C, self.D = core.a, core.b, core.c, core.d
        self.inputs, self.outputs, self.states = core.inputs, core.outputs, core.states
        self.name = core.name
        self.tick_s: float | None = core.tick_s

    def poles(self) -> NDArray[np.complex128]:
        """Returns the poles, shape (states,), in 1/s; for the loop, in the z plane."""
        return np.array([complex(real, imaginary) for real, imaginary in self._core.poles()], dtype=np.complex128)

    def step_response(
        self, input: int = 0, tick_s: float = 1e-3, samples: int = 1000
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Returns times in s, shape (samples,), and outputs, shape (outputs, samples), after a unit step of an input
        from rest.

        Parameters
        ----------
        input
            Index of the input, from 0.
        tick_s
            Time between two samples, in s. The loop uses its own tick instead.
        samples
            Number of samples.

        Raises
        ------
        ValueError
            For an input that does not exist, a negative number of samples, and a ``tick_s`` that is not positive and
            finite.
        TypeError
            If an argument is not a number.
        """
        return self._core.step_response(whole("input", input), tick_s, whole("samples", samples))

    def frequency_response(self, frequency_hz: Any, input: int = 0, output: int = 0) -> NDArray[np.complex128]:
        """Returns the response from an input to an output at frequencies in Hz, shape (frequencies,).

        Raises
        ------
        ValueError
            For an input or output that does not exist, and for a frequency that is not finite or equals a pole.
        TypeError
            If ``input`` or ``output`` is not an integer.
        """
        input, output = whole("input", input), whole("output", output)
        frequencies = [float(value) for value in np.atleast_1d(frequency_hz)]
        pairs = self._core.frequency_response(frequencies, input, output)
        return np.array([complex(real, imaginary) for real, imaginary in pairs], dtype=np.complex128)

    def to_control(self) -> control.StateSpace:
        """Returns the system as a ``control.StateSpace`` with signal names."""
        import control

        time = [] if self.tick_s is None else [self.tick_s]
        return control.StateSpace(
            self.A, self.B, self.C, self.D, *time, inputs=self.inputs, outputs=self.outputs, states=self.states, name=self.name
        )

    def __reduce__(self) -> tuple[object, ...]:
        return state_space, self._of

    def __repr__(self) -> str:
        return f"StateSpace({self.name}: {', '.join(self.inputs)} -> {', '.join(self.outputs)}; {len(self.states)} states)"


def state_space(scenario: Scenario | str | os.PathLike[str], side: Side) -> StateSpace:
    """Returns the matrices of one side of a scenario's teleoperator, or of its loop.

    The master includes the arm and the force controller (eq. 28, 29, 32 to 35); the slave includes its position
    controller (eq. 30, 31). With ``simulation.control = "sampled"``, both are the plants without controllers.

    ``"loop-gain"`` is the loop in permanent contact from tick to tick, with all delays, opened where the slave's
    signal arrives at the master. The poles of the closed loop are where its response is 1; for negative feedback,
    change its sign. ``"closed-loop"`` has the desired position as input, and both positions and the feedback force as
    outputs.

    Parameters
    ----------
    scenario
        A scenario or a path.
    side
        ``"master"``, ``"slave"``, ``"loop-gain"`` or ``"closed-loop"``.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For an unknown ``side``.
    TypeError
        If the scenario is neither a ``Scenario`` nor a path.

    >>> import trocar
    >>> trocar.state_space("paper/classical", "slave").A.shape
    (3, 3)
    """
    scenario = scenario_of(scenario)
    return StateSpace(_core.state_space(scenario._core, side), scenario, side)
