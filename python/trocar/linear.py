"""State-space matrices of the loop and of its sides."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import whole
from ._html import table
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    import control
    from scipy import signal


Side = Literal["master", "slave", "loop-gain", "closed-loop"]


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
        """Returns the system as a ``control.StateSpace`` with signal names.

        ``control.stability_margins`` assumes negative feedback, so change the sign of ``"loop-gain"``; it leaves out 0 Hz
        and can miss margins of loops with long delays. :func:`trocar.margins` has the margins of the loop.
        """
        import control

        time = [] if self.tick_s is None else [self.tick_s]
        return control.StateSpace(
            self.A, self.B, self.C, self.D, *time, inputs=self.inputs, outputs=self.outputs, states=self.states, name=self.name
        )

    def to_scipy(self) -> signal.StateSpace:
        """Returns the system as a ``scipy.signal.StateSpace``: continuous for a side, discrete for the loop.

        >>> import trocar
        >>> trocar.state_space("paper/classical", "closed-loop").to_scipy().dt
        0.001
        """
        from scipy import signal

        time = {} if self.tick_s is None else {"dt": self.tick_s}
        return signal.StateSpace(self.A, self.B, self.C, self.D, **time)

    def __reduce__(self) -> tuple[object, ...]:
        return state_space, self._of

    def _repr_html_(self) -> str:
        rows = [["inputs", ", ".join(self.inputs)], ["outputs", ", ".join(self.outputs)], ["states", ", ".join(self.states)]]
        rows.append(["time", "continuous" if self.tick_s is None else f"tick {self.tick_s} s"])
        return table(["state space", self.name], rows)

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
