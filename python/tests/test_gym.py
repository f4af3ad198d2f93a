"""The Gymnasium environment."""

import numpy as np
import pytest

import trocar

gymnasium = pytest.importorskip("gymnasium")

import trocar.gym  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore")


def episode(environment, policy, seed=1):
    observation, _ = environment.reset(seed=seed)
    rewards, is_over = 0.0, False
    while not is_over:
        observation, reward, is_over, _, info = environment.step(policy(observation))
        rewards += reward
    return rewards, info


def test_the_environment_satisfies_gymnasium():
    from gymnasium.utils.env_checker import check_env

    check_env(trocar.gym.Supervisor("layers/skin-augmented"), skip_render_check=True)
    made = gymnasium.make("trocar/Supervisor-v0", patients=3)
    first, second = made.reset(seed=4)[1]["patient"], made.reset(seed=4)[1]["patient"]
    assert first == second and made.reset(options={"patient": 2})[1]["patient"] == 2


def test_a_held_needle_costs_time_and_never_exceeds():
    environment = trocar.gym.Supervisor("layers/skin-augmented", hold_cost=2.0)
    reward, info = episode(environment, lambda observation: [1.0, 1.0])
    assert info["excess_m"] == 0.0 and info["ruptures"] == 0 and reward == pytest.approx(-18.0, abs=0.05)
    with pytest.raises(ValueError, match="call reset"):
        environment.step([0.0, 1.0])


def test_without_a_hold_the_run_is_that_of_the_scenario_without_augmentation():
    environment = trocar.gym.Supervisor("layers/skin-augmented")
    reward, info = episode(environment, lambda observation: np.array([0.0, 1.0], np.float32))
    scenario = environment._simulation.scenario
    plain = trocar.run(scenario)
    assert np.array_equal(info["run"]["slave_position_m"], plain["slave_position_m"])
    assert reward == pytest.approx(-1e3 * sum(rupture["excess_advance_m"] for rupture in plain.ruptures))


def test_the_rule_holds_after_every_rupture():
    _, info = episode(trocar.gym.Supervisor("layers/skin-augmented"), trocar.gym.hold_after_alarm)
    assert info["ruptures"] == 3 and info["held_s"] == pytest.approx(1.5)
    _, weak = episode(trocar.gym.Supervisor("layers/skin-augmented"), lambda observation: [0.0, 0.5])
    assert weak["run"]["feedback_force_n"].max() < info["run"]["feedback_force_n"].max()


def test_environments_are_vectorised():
    environments = trocar.gym.make_vec(2, scenario="layers/skin-augmented")
    observations, _ = environments.reset(seed=1)
    actions = trocar.gym.hold_after_alarm(observations)
    assert actions.shape == (2, 2) and environments.step(actions)[0].shape == (2, 8)
    environments.close()


@pytest.mark.parametrize(
    ("options", "text"),
    [({"scenario": "paper/classical", "patients": 3}, "not both"), ({"scenario": "paper/classical", "hold_cost": -1.0}, "hold_cost is"), ({"patients": 0}, "patients is 0")],
)
def test_invalid_options_are_refused(options, text):
    with pytest.raises(ValueError, match=text):
        trocar.gym.Supervisor(**options)


def test_an_invalid_action_is_refused():
    environment = trocar.gym.Supervisor("layers/skin-augmented")
    environment.reset(seed=1)
    for action in ([0.0], [np.nan, 1.0]):
        with pytest.raises(ValueError, match="the action is"):
            environment.step(action)
