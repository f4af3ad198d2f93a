"""The controller of a real rig: estimator, detector and supervisor, one sample at a time."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import number
from .scenario import Scenario, scenario_of


class HapticController:
    """The controller of a rig with the settings of a scenario: computes a command for every sample.

    It runs the code of the simulation in the same order, without the delay of a link, so the same samples give the
    same commands bit for bit. It omits the architecture and the passivity scheme of the scenario's link. A rig in
    real time uses the controller from C or Rust; the Python class is for tests, replays and slow rigs.

    Parameters
    ----------
    scenario
        A scenario or a path. Its ``estimator.parameters`` must be ``"stiffness-and-damping"`` or ``"stiffness"``, and
        its ``estimator.forgetting`` must be ``"resetting"``. If ``sensor.position_resolution_m`` is above 0, the
        velocity is estimated from the slave's positions.
    **limits
        Numbers for the keys ``rig.…`` and ``safety.…``, as in ``**{"safety.force_limit_n": 8.0}``. ``rig.start_m`` is
        the position of the master, in m, before the first valid sample. The others are also keys of a scenario:
        ``rig.…`` are the maximum magnitudes of a valid sample and the rates at which the commands return after
        invalid samples, and ``safety.…`` are the limits of the commands. Words, flags and counts, such as
        ``safety.acts`` and ``rig.bridged_samples``, are keys of the scenario only.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For an estimator that a rig does not support, an unknown key, and a number out of range.
    TypeError
        If the scenario is neither a ``Scenario`` nor a path, or a limit is not a number.

    >>> import trocar
    >>> controller = trocar.HapticController("paper/augmented")
    >>> command = controller.step(0.015, 0.0149, 0.01, 1.2)
    >>> command.slave_reference_m, command.master_force_n, command.alarm
    (0.015, 1.2, False)
    """

    def __init__(self, scenario: Scenario | str | os.PathLike[str], **limits: float) -> None:
        self.scenario = scenario_of(scenario)
        self._limits = [(key, number(key, value)) for key, value in limits.items()]
        self._core = _core.HapticController(self.scenario._core, self._limits)

    def step(
        self,
        master_position_m: float | None,
        slave_position_m: float | None,
        slave_velocity_m_per_s: float | None,
        force_n: float | None,
        *,
        number: int | None = None,
    ) -> _core.Command:
        """Processes the sample of a tick: positions of master and slave in m, velocity of the slave in m/s, force in
        N.

        ``None`` marks a missing number. A missing or impossible number is a fault of its channel, and the last valid
        number replaces it. ``number`` is the sample's number, counted from 1 by its source: a repeated sample and a
        late one count as missing, and skipped numbers are lost samples.

        Returns the command. ``slave_reference_m`` is for the slave's position controller, and ``master_force_n`` for
        the master's force controller. The other attributes are intermediate results: ``mode`` (0 teleoperation, 1
        augmented, 2 re-engaging), ``alarm``, ``alarm_taken``, ``stiffness_n_per_m``, ``damping_n_s_per_m``,
        ``predicted_force_n``, ``residual_n``, ``distance``, ``decision``, ``slave_velocity_m_per_s`` as used,
        ``faults`` (names of the faulty channels), ``faulty_samples`` (number of consecutive faulty samples),
        ``detection`` (``"armed"``, ``"settling"`` or ``"blind"``) for ``detection_ticks`` ticks, ``state`` of the
        commands (``"disabled"``, ``"aligning"``, ``"active"`` or ``"fault"``), ``fault`` (cause of the last fault, or
        ``None``) and ``limited`` (names of the limits ``safety.…`` that acted).

        Raises
        ------
        TypeError
            If an argument is neither a number nor ``None``.
        OverflowError
            If the number of the sample is negative or above 2⁶⁴ - 1.
        """
        return self._core.step(master_position_m, slave_position_m, slave_velocity_m_per_s, force_n, number)

    def stop(self) -> None:
        """Stops: the force decays within ``safety.decay_s``, and the reference holds until :meth:`enable`.

        >>> import trocar
        >>> controller = trocar.HapticController("paper/augmented")
        >>> controller.stop()
        >>> controller.step(0.015, 0.0149, 0.01, 1.2).state
        'disabled'
        >>> controller.enable()
        >>> controller.step(0.015, 0.0149, 0.01, 1.2).state
        'active'
        """
        self._core.stop()

    def enable(self) -> None:
        """Ends a stop or a fault: the reference moves to the hand, and then the force returns."""
        self._core.enable()

    @property
    def counts(self) -> dict[str, int]:
        """The numbers of bad, repeated, late and bridged samples, of gaps, of ticks at which each limit acted, of
        alignments and of faults."""
        return dict(self._core.counts())

    def reset(self) -> None:
        """Resets the controller to its initial state."""
        self._core.reset()

    def __copy__(self) -> HapticController:
        other = object.__new__(HapticController)
        other.scenario, other._limits, other._core = self.scenario, self._limits, self._core.copy()
        return other

    def __deepcopy__(self, memo: dict[int, Any]) -> HapticController:
        return self.__copy__()

    def __reduce__(self) -> tuple[object, ...]:
        return _controller, (self.scenario, self._limits, self._core.state())

    def __repr__(self) -> str:
        return f"HapticController({self.scenario.name!r})"


def _controller(scenario: Scenario, limits: list[tuple[str, float]], state: NDArray[np.uint64]) -> HapticController:
    controller = HapticController(scenario, **dict(limits))
    controller._core.restore(state)
    return controller
