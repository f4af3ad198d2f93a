"""User-defined parts in the loop, and simulations stepped tick by tick.

``trocar.run(scenario, tissue=f)`` replaces the scenario's tissue by ``f``. A part is a function, a compiled function
(see :class:`Compiled`), an object with the methods ``step`` and ``reset``, which is called before a run, or a class of
objects with a method ``step``, of which every run makes a new one. An object with ``step`` and without ``reset`` is
refused, because a second run would begin in the state of the first. An exception of a part ends the run. A part is
called once per tick with these numbers, in SI units:

=============== ========================================================================= =============================================
role            arguments                                                                 returns
=============== ========================================================================= =============================================
``tissue``      tick, position_m, velocity_m_per_s                                        force_n; or (force_n, ruptured)
``operator``    tick, felt_force_n (of the tick before); or also master_position_m (of    desired_position_m; or (desired_position_m,
                the tick before; NaN at tick 0) and has_cue                               notices); or (desired_position_m, notices,
                                                                                          intended_position_m)
``estimator``   force_n, depth_m, velocity_m_per_s                                        predicted_force_n, before this sample; or
                                                                                          (predicted_force_n, stiffness_n_per_m,
                                                                                          damping_n_s_per_m)
``detector``    force_n, predicted_force_n, residual_n, depth_m, velocity_m_per_s,        alarm; or (alarm, decision); or (alarm,
                in_contact                                                                decision, distance)
``distance``    the same as ``detector``                                                  distance, which the scenario's detector
                                                                                          accumulates
``force_law``   anchor_n (before the alarm), last_n (tick before), measured_n, moved_n    (force_n, allowed_step_n)
                (its change), velocity_m_per_s (of the master), begins; while frozen
``motion_law``  mode (0 teleoperation, 1 augmented, 2 re-engaging), hand_m, slave_m       (reference_m, is_blended)
=============== ========================================================================= =============================================

The force of a tissue is positive when it resists insertion. ``ruptured`` is the true rupture with which the metrics
compare alarms. ``notices`` is true at a tick at which the operator notices a change of the felt force, and
``intended_position_m`` is the desired position without involuntary motion; both are for the metrics. ``has_cue`` is the
cue on the operator's skin. The force law returns the feedback force and its maximum allowed change per tick. The motion
law returns the slave's reference, and true if re-engaging may end. An estimator can have a method ``skip``, called at a
gap in its samples, and a distance a method ``after_alarm``.

Two roles are objects with other methods than ``step``. An ``architecture`` has both of these:

- ``slave_target(position_m, velocity_m_per_s, hand_force_n, slave_position_m, slave_velocity_m_per_s, slave_force_n)``:
  returns the target of the slave's reference in m, on the slave's scale, from the master's sample that has arrived.
- ``master_force(force_n, position_m, velocity_m_per_s, mode, master_position_m, master_velocity_m_per_s, hand_force_n)``:
  returns the feedback force in N, from the slave's sample that has arrived, whose force is scaled to the master.

A ``passivity`` scheme has any of these methods; the link does without the others. A payload is a list of up to 4 numbers,
and a port is the tuple (force_n, cost_j_per_m, work_j, position_m, velocity_m_per_s) of the slave, on the master's scale.

- ``master_sends(displacement_m)`` and ``slave_sends()`` return a payload.
- ``receive_position(position_m, payload, is_fresh, port)`` and ``receive_force(force_n, payload, is_fresh,
  velocity_m_per_s)`` return the position or force in place of the one that has arrived.
- ``limit_reference(reference_m, port)`` and ``limit_force(force_n, velocity_m_per_s)`` return the limited command.
- ``energies()`` returns (promised_j or ``None``, dissipated_j, refused_j).

>>> import trocar
>>> def spring(tick: int, position_m: float, velocity_m_per_s: float) -> float:
...     return 200.0 * max(position_m, 0.0)
>>> run = trocar.run("layers/skin-augmented", tissue=spring)
>>> run.ruptures
[]
"""

from __future__ import annotations

import copy
import math
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import number
from ._parts import Compiled, Part, Parts, core_parts
from ._settings import key_of, settings
from .running import Run
from .scenario import Scenario, scenario_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Compiled", "Part", "Simulation"]


class Simulation:
    """A simulation that is stepped tick by tick, for use inside another loop, such as another program's controller or
    a user's input.

    ``simulation.copy()`` saves its state, which :meth:`restore` returns to; unpickling and copying repeat the ticks, at a
    fraction of a microsecond per tick.

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
        # The changes of keys: the number of ticks before each, and its keys.
        self._changes: list[tuple[int, dict[str, Any]]] = []
        self._changed = self.scenario
        self._stiffness_n_per_m: float | None = None

    def step(self, desired_position_m: float | None = None, *, hand_force_n: float | None = None) -> bool:
        """Runs a tick: records its signals, then moves both machines to the next tick.

        ``desired_position_m`` is the desired position of the master at the next tick, in m, interpolated linearly
        between ticks. Without it, the scenario's operator moves on. ``hand_force_n`` is the force with which the
        muscles push forwards instead, in N: the desired position is ahead of the master by this force divided by the
        stiffness of the arm. At rest it is the force on the handle; in motion, the mass and the damping of the arm take
        their part. Returns true if more ticks follow; after the last tick, nothing happens.

        Raises
        ------
        ValueError
            For a position or force that is not finite, or both, for an arm without stiffness, after :meth:`run`, after an error of a part, and for a part's result
            that is not finite.
        TypeError
            For a position that is not a number, and for a part's result that its role does not allow.
        Exception
            Any exception of a part; it ends the simulation.
        """
        if hand_force_n is not None:
            if desired_position_m is not None:
                raise ValueError("step has a desired position and a force of the hand: give one of them")
            desired_position_m = self._pushed_m(number("hand_force_n", hand_force_n))
        self._signals = None
        return self._core.step(desired_position_m)

    def _pushed_m(self, force_n: float) -> float | None:
        """Returns the desired position at which the arm pushes with a force; ``None`` for the operator's at the first
        tick, before which no position of the master is known."""
        if not math.isfinite(force_n):
            raise ValueError(f"hand_force_n is {force_n}, must be finite")
        if self._stiffness_n_per_m is None:
            self._stiffness_n_per_m = _core.arm_stiffness(self.scenario._core)
        if not self._stiffness_n_per_m > 0.0:
            raise ValueError("the arm has no stiffness, so no desired position gives a force of the hand")
        return self.signals["master_position_m"] + force_n / self._stiffness_n_per_m if self.ticks else None

    def change(self, **keys: Any) -> None:
        """Changes keys of the running simulation, from the next tick on: of ``scaling`` (of a link without delay),
        ``tissue`` (a spring and damper), ``estimator``, ``detector`` and ``augmentation`` (outside an event).

        A changed estimator, detector or supervisor begins anew. The metrics describe the scenario at the beginning.

        Raises
        ------
        ScenarioError
            For a key that cannot change, and for an invalid value. The simulation is then unchanged.

        >>> import trocar
        >>> simulation = trocar.Simulation("layers/skin-augmented")
        >>> _ = simulation.step()
        >>> simulation.change(**{"scaling.force": 0.5})
        """
        changed = self._changed.replace(**keys)
        names = [key_of(setting) for setting in settings(keys)[0]]
        sections = sorted({name.partition(".")[0] for name in names})
        self._core.change(changed._core, sections)
        self._changed = changed
        self._changes.append((self.ticks, dict(keys)))

    def copy(self) -> Simulation:
        """Returns a simulation in the same state, by repeating its ticks.

        Raises
        ------
        TypeError
            With user-defined parts, as they have states.

        >>> import trocar
        >>> simulation = trocar.Simulation("layers/skin-augmented")
        >>> _ = [simulation.step() for _ in range(100)]
        >>> saved = simulation.copy()
        >>> pushed = simulation.step(0.0)
        >>> simulation.restore(saved)
        >>> simulation.ticks
        100
        """
        return copy.copy(self)

    def restore(self, saved: Simulation) -> None:
        """Returns to the state of a :meth:`copy`, which stays as it is.

        Raises
        ------
        TypeError
            If ``saved`` is not a simulation, or has user-defined parts.
        """
        if not isinstance(saved, Simulation):
            raise TypeError(f"saved is {saved!r}, must be a copy of a Simulation")
        self.__dict__.update(saved.copy().__dict__)

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
        # Faster than all signals for one of them at every tick.
        return self._core.signal(column) if self._signals is None else self._signals[column]

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
        return _repeated, (self.scenario, self._core.led_m(), self._changes)

    def __repr__(self) -> str:
        return f"Simulation({self.scenario.name!r}, {self.ticks} of {self.scenario.ticks} ticks)"


def _repeated(scenario: Scenario, led_m: NDArray[np.float64], changes: list[tuple[int, dict[str, Any]]]) -> Simulation:
    simulation = Simulation(scenario)
    begin = 0
    for ticks, keys in changes:
        simulation._core.repeat(led_m[begin:ticks])
        simulation.change(**keys)
        begin = ticks
    simulation._core.repeat(led_m[begin:])
    return simulation
