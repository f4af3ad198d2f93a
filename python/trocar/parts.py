"""User-defined parts in the loop, and simulations stepped tick by tick.

``trocar.run(scenario, tissue=f)`` replaces the scenario's tissue by ``f``. A part is a function, a compiled function
(see :class:`Compiled`), or an object with a method ``step``. The object can also have the methods ``reset``, called
before a run, and ``skip``, called at a gap in the samples of an estimator. An exception of a part ends the run. A
part is called once per tick with these numbers, in SI units:

=============== ========================================================================= =============================================
role            arguments                                                                 returns
=============== ========================================================================= =============================================
``tissue``      tick, position_m, velocity_m_per_s                                        force_n; or (force_n, ruptured)
``operator``    tick, felt_force_n (of the tick before)                                   desired_position_m
``estimator``   force_n, depth_m, velocity_m_per_s                                        predicted_force_n, before this sample; or
                                                                                          (predicted_force_n, stiffness_n_per_m,
                                                                                          damping_n_s_per_m)
``detector``    force_n, predicted_force_n, residual_n, depth_m, velocity_m_per_s,        alarm; or (alarm, decision); or (alarm,
                in_contact                                                                decision, distance)
``force_law``   anchor_n (before the alarm), last_n (tick before), measured_n, moved_n    (force_n, allowed_step_n)
                (its change), velocity_m_per_s (of the master), begins; while frozen
``motion_law``  mode (0 teleoperation, 1 augmented, 2 re-engaging), hand_m, slave_m       (reference_m, is_blended)
=============== ========================================================================= =============================================

The force of a tissue is positive when it resists insertion. ``ruptured`` is the true rupture with which the metrics
compare alarms. The force law returns the feedback force and its maximum allowed change per tick. The motion law
returns the slave's reference, and true if re-engaging may end.

>>> import trocar
>>> def spring(tick: int, position_m: float, velocity_m_per_s: float) -> float:
...     return 200.0 * max(position_m, 0.0)
>>> run = trocar.run("layers/skin-augmented", tissue=spring)
>>> run.ruptures
[]
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._parts import Compiled, Part, Parts, core_parts
from .running import Run
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Compiled", "Part", "Simulation"]


class Simulation:
    """A simulation that is stepped tick by tick, for use inside another loop, such as another program's controller or
    a user's input. Unpickling or copying it repeats its ticks.

    Parameters
    ----------
    scenario
        A scenario or a path. A tissue from a recording follows the time of the recording, unless ``tissue.index`` is
        ``"depth"``.
    **parts
        User-defined parts, as for :func:`trocar.run`.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    TypeError
        If the scenario is neither a ``Scenario`` nor a path, for an unknown role, and for a part that is neither a
        function, a compiled function, nor an object with a method ``step``. Also for copying or pickling a simulation
        with user-defined parts.

    >>> import trocar
    >>> simulation = trocar.Simulation("layers/skin-augmented")
    >>> while simulation.step():
    ...     if simulation["tissue_force_n"] > 1.0:
    ...         break
    >>> here_m = simulation["master_position_m"]
    >>> while simulation.step(here_m):
    ...     pass
    >>> simulation.run().ruptures
    []
    """

    def __init__(self, scenario: Scenario | str | os.PathLike[str], **parts: Unpack[Parts]) -> None:
        self.scenario = scenario_of(scenario)
        user_defined = core_parts(parts)
        self._core = _core.Simulation(self.scenario._core, user_defined)
        self._has_user_defined_parts = bool(user_defined)
        self._signals: dict[str, float] | None = None

    def step(self, desired_position_m: float | None = None) -> bool:
        """Runs a tick: records its signals, then moves both machines to the next tick.

        ``desired_position_m`` is the desired position of the master at the next tick, in m, interpolated linearly
        between ticks. Without it, the scenario's operator moves on. Returns true if more ticks follow; after the last
        tick, nothing happens.

        Raises
        ------
        ValueError
            For a position that is not finite, after :meth:`run`, after an error of a part, and for a part's result
            that is not finite.
        TypeError
            For a position that is not a number, and for a part's result that its role does not allow.
        Exception
            Any exception of a part; it ends the simulation.
        """
        self._signals = None
        return self._core.step(desired_position_m)

    @property
    def signals(self) -> dict[str, float]:
        """The signals of the last tick, by the names of :func:`trocar.trace_columns`; ``None`` before the first tick.

        ``simulation["tissue_force_n"]`` is one of them; an unknown name raises a ``KeyError``.

        Raises
        ------
        ValueError
            After :meth:`run`, for signals that were not read before it, and after an error of a part.
        """
        if self._signals is None:
            self._signals = self._core.signals()
        return self._signals

    def __getitem__(self, column: str) -> float:
        return self.signals[column]

    @property
    def ticks(self) -> int:
        """The number of ticks so far."""
        return self._core.ticks

    @property
    def time_s(self) -> float:
        """Time of the next tick, in s."""
        return self._core.ticks * self.scenario.tick_s

    def run(self) -> Run:
        """Ends the simulation and returns the result so far.

        Raises
        ------
        ValueError
            If :meth:`run` or an error of a part has already ended the simulation.
        """
        core, traces = self._core.conclude()
        return Run(self.scenario, core, traces)

    def __reduce__(self) -> tuple[object, ...]:
        if self._has_user_defined_parts:
            raise TypeError(
                "a Simulation with user-defined parts cannot be copied or pickled, as the parts have states; "
                "run() returns a Run, which can"
            )
        return _repeated, (self.scenario, self._core.led_m())

    def __repr__(self) -> str:
        return f"Simulation({self.scenario.name!r}, {self.ticks} of {self.scenario.ticks} ticks)"


def _repeated(scenario: Scenario, led_m: NDArray[np.float64]) -> Simulation:
    simulation = object.__new__(Simulation)
    simulation.scenario, simulation._has_user_defined_parts, simulation._signals = scenario, False, None
    simulation._core = _core.Simulation.repeated(scenario._core, led_m)
    return simulation
