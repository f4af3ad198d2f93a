"""A Gymnasium environment in which the agent is the supervisor of the slave. Needs ``gymnasium``.

Every 10 ms the agent decides whether the slave holds its position or follows the hand, and how the measured force is
scaled for the hand. The scenario's own augmentation is off; its estimator and detector run, and the agent sees them.

>>> import gymnasium
>>> import trocar.gym
>>> environment = gymnasium.make("trocar/Supervisor-v0", patients=5)
>>> observation, info = environment.reset(seed=1)
>>> environment.action_space.shape, observation.shape
((2,), (8,))
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

try:
    import gymnasium
except ImportError as error:
    raise ImportError("trocar.gym needs gymnasium: pip install gymnasium") from error

from . import _core
from ._arrays import number, whole
from .people import Patients
from .people import patients as drawn_patients
from .running import Run
from .scenario import Scenario, scenario_of

__all__ = ["Supervisor", "hold_after_alarm", "make_vec"]

Observation = NDArray[np.float32]
Action = NDArray[np.float32]

# Time of a decision, in s.
_DECISION_S = 0.01

# The speed of the slave after a hold in m/s, for a scenario without augmentation.
_CATCH_UP_M_PER_S = 0.03

# The observations, each with the unit that is 1.
OBSERVED = (
    "measured force (N)",
    "change of the measured force (N)",
    "residual (N)",
    "largest decision of the detector since the last observation, relative to its threshold",
    "distance of the needle behind the hand (mm)",
    "velocity of the hand (cm/s)",
    "velocity of the needle (cm/s)",
    "time in hold (s)",
)

# The largest magnitude of an observation.
_BOUND = 1e3


class Supervisor(gymnasium.Env[Observation, Action]):
    """An insertion into a patient. The agent is the supervisor of the slave, once every 10 ms.

    An action has two numbers: hold the slave (0.5 or more) or let it follow the hand (less), and the factor from 0 to 2 of
    the force for the hand, on top of ``scaling.force``. After a hold, the slave catches up at
    ``augmentation.catch_up_speed_m_per_s``. :data:`OBSERVED` lists the 8 numbers of an observation.

    The reward is minus ``hold_cost`` per second in hold; the last step of an episode also has minus the excess of the
    needle beyond the intended motion, in mm, summed over all ruptures. ``info`` of the last step has ``excess_m``,
    ``ruptures``, ``held_s`` and ``run``, the :class:`trocar.Run`.

    Parameters
    ----------
    scenario
        A scenario or a path; without it, patients.
    patients
        :func:`trocar.patients` or their number; each episode has one of them, chosen by the seed of ``reset``. The
        default is 200.
    hold_cost
        The cost of a hold, per second.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For a scenario together with patients, and for a negative ``hold_cost``.

    >>> import trocar.gym
    >>> environment = trocar.gym.Supervisor("layers/skin-augmented")
    >>> observation, info = environment.reset(seed=1)
    >>> observation, reward, is_terminated, is_truncated, info = environment.step(trocar.gym.hold_after_alarm(observation))
    >>> reward, is_terminated
    (0.0, False)
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        scenario: Scenario | str | os.PathLike[str] | None = None,
        *,
        patients: Patients | int | None = None,
        hold_cost: float = 1.0,
    ) -> None:
        if scenario is not None and patients is not None:
            raise ValueError("give a scenario or patients, not both: trocar.patients(200, scenario) draws patients of a scenario")
        self._hold_cost = number("hold_cost", hold_cost)
        if self._hold_cost < 0.0:
            raise ValueError(f"hold_cost is {hold_cost}, must be at least 0")
        self._scenario = None if scenario is None else scenario_of(scenario)
        self._patients: Patients | None = None
        if self._scenario is None:
            self._patients = patients if isinstance(patients, Patients) else drawn_patients(whole("patients", 200 if patients is None else patients, 1))
        self.observation_space = gymnasium.spaces.Box(-_BOUND, _BOUND, (len(OBSERVED),), np.float32)
        self.action_space = gymnasium.spaces.Box(np.array([0.0, 0.0], np.float32), np.array([1.0, 2.0], np.float32))
        self._core: _core.SupervisedRun | None = None
        self._is_over = True
        # The outcome of an action whose ticks have run together with those of other environments.
        self._advanced: tuple[bool, float] | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode with another patient and other noise. ``options={"patient": 7}`` chooses the patient, from
        1."""
        super().reset(seed=seed)
        info: dict[str, Any] = {}
        chosen = self._scenario
        if self._patients is not None:
            given = (options or {}).get("patient")
            patient = int(self.np_random.integers(1, len(self._patients) + 1)) if given is None else whole("patient", given, 1)
            chosen, info["patient"] = self._patients[patient - 1], patient
        assert chosen is not None
        key = "augmentation.catch_up_speed_m_per_s"
        catch_up_m_per_s = chosen[key] if key in chosen else _CATCH_UP_M_PER_S
        noise = int(self.np_random.integers(1, 2**31))
        chosen = chosen.replace(**{"augmentation.enabled": False, "simulation.seed": noise})
        self._chosen, self._position_scale, self._threshold = chosen, chosen["scaling.position"], chosen["detector.threshold"]
        self._ticks = max(1, round(_DECISION_S / chosen.tick_s))
        self._core = _core.SupervisedRun(chosen._core, catch_up_m_per_s)
        self._held_s = self._in_hold_s = self._last_n = 0.0
        self._advanced = None
        self._is_over, self._decision = not self._core.advance(False, 1.0, 1)[0], 0.0
        return self._observed(self._core), info

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Applies an action for 10 ms.

        Raises
        ------
        ValueError
            Before ``reset`` and after the end of an episode, and for an action that is not two finite numbers.
        """
        core, holds, force_scale, ticks = self._command(action)
        goes_on, self._decision = self._advanced or core.advance(holds, force_scale, ticks)
        self._is_over, self._advanced = not goes_on, None
        decision_s = self._ticks * self._chosen.tick_s
        self._in_hold_s = self._in_hold_s + decision_s if holds else 0.0
        self._held_s += decision_s if holds else 0.0
        reward = -self._hold_cost * decision_s if holds else 0.0
        observed, info = self._observed(core), {}
        if self._is_over:
            run = Run(self._chosen, *core.conclude())
            excess_m = [rupture["excess_advance_m"] or 0.0 for rupture in run.ruptures]
            reward -= 1e3 * sum(excess_m)
            info = {"excess_m": sum(excess_m), "ruptures": len(excess_m), "held_s": self._held_s, "run": run}
        return observed, reward, self._is_over, False, info

    def _command(self, action: Action) -> tuple[_core.SupervisedRun, bool, float, int]:
        """Returns the run and the arguments of its ``advance`` for an action."""
        if self._core is None or self._is_over:
            raise ValueError("the episode has not begun or is over: call reset()")
        given = np.asarray(action, dtype=np.float64).reshape(-1)
        if given.shape != (2,) or not np.isfinite(given).all():
            raise ValueError(f"the action is {action!r}, must be two finite numbers: hold, and the factor of the force")
        return self._core, bool(given[0] >= 0.5), float(min(max(given[1], 0.0), 2.0)), self._ticks

    def _observed(self, core: _core.SupervisedRun) -> Observation:
        force_n, residual_n, master_m, slave_m, master_m_per_s, slave_m_per_s = core.observed()
        change_n, self._last_n = force_n - self._last_n, force_n
        behind_m = self._position_scale * master_m - slave_m
        velocities = 1e2 * master_m_per_s, 1e2 * slave_m_per_s
        decision = self._decision / self._threshold
        found = (force_n, change_n, residual_n, decision, 1e3 * behind_m, *velocities, self._in_hold_s)
        return np.array(found, dtype=np.float32).clip(-_BOUND, _BOUND)


def hold_after_alarm(observation: Observation, hold_s: float = 0.5) -> Action:
    """Returns the action of a simple rule: hold for a time after an alarm of the detector, and leave the force unscaled.

    It is the hold of a strategy that freezes the slave, without the other parts of an augmented event.

    Parameters
    ----------
    observation
        An observation of :class:`Supervisor`, or several, one per row.
    hold_s
        The time in hold, in s.

    >>> import numpy as np, trocar.gym
    >>> trocar.gym.hold_after_alarm(np.array([1, 0, 0, 1.2, 0, 0, 0, 0], dtype=np.float32))
    array([1., 1.], dtype=float32)
    """
    decision, in_hold_s = observation[..., 3], observation[..., 7]
    holds = (decision >= 1.0) | ((in_hold_s > 0.0) & (in_hold_s < hold_s))
    action = np.ones((*decision.shape, 2), dtype=np.float32)
    action[..., 0] = holds
    return action


class _Together(gymnasium.vector.SyncVectorEnv):
    """Environments whose ticks run together, in threads, before each of them reports its step."""

    def step(self, actions: NDArray[np.float32]) -> tuple[Any, ...]:
        """Steps all environments."""
        # A vector resets an environment that is over instead of stepping it.
        pairs = zip(cast(Sequence[Supervisor], self.envs), actions)
        stepped = [(environment, environment._command(action)) for environment, action in pairs if not environment._is_over]
        outcomes = _core.advance_all([command for _, command in stepped])
        for (environment, _), outcome in zip(stepped, outcomes):
            environment._advanced = outcome
        return super().step(actions)


def make_vec(count: int, **options: Any) -> gymnasium.vector.SyncVectorEnv:
    """Returns several environments :class:`Supervisor`, which step side by side in threads.

    Parameters
    ----------
    count
        The number of environments.
    **options
        The parameters of :class:`Supervisor`.

    >>> import trocar.gym
    >>> environments = trocar.gym.make_vec(3, scenario="layers/skin-augmented")
    >>> environments.reset(seed=1)[0].shape
    (3, 8)
    """
    return _Together([lambda: Supervisor(**options) for _ in range(whole("count", count, 1))])


gymnasium.register(id="trocar/Supervisor-v0", entry_point="trocar.gym:Supervisor")
