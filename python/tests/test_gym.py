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
    plain = trocar.run(info["run"].scenario)
    assert np.array_equal(info["run"]["slave_position_m"], plain["slave_position_m"])
    assert reward == pytest.approx(-1e3 * sum(rupture["excess_advance_m"] for rupture in plain.ruptures))


def test_the_rule_holds_after_every_rupture():
    _, info = episode(trocar.gym.Supervisor("layers/skin-augmented"), trocar.gym.hold_after_alarm)
    assert info["ruptures"] == 3 and info["held_s"] == pytest.approx(1.5)
    _, weak = episode(trocar.gym.Supervisor("layers/skin-augmented"), lambda observation: [0.0, 0.5])
    assert weak["run"]["feedback_force_n"].max() < info["run"]["feedback_force_n"].max()


class Commanded:
    """The architecture of the environment, as a part in Python."""

    def __init__(self, step_m):
        self.holds, self.force_scale, self.target_m, self.step_m, self.was_held = False, 1.0, None, step_m, False

    def reset(self):
        """Does nothing: each simulation has a new object."""

    def slave_target(self, position_m, velocity_m_per_s, hand_force_n, slave_m, slave_m_per_s, force_n):
        if self.holds and not self.was_held:
            self.target_m = slave_m
        if not self.holds and self.target_m is not None:
            self.target_m += min(max(position_m - self.target_m, -self.step_m), self.step_m)
            if abs(position_m - self.target_m) <= self.step_m:
                self.target_m = None
        self.was_held = self.holds
        return position_m if self.target_m is None else self.target_m

    def master_force(self, force_n, *others):
        return self.force_scale * force_n


def test_a_run_equals_a_simulation_with_the_same_architecture_in_python():
    generator = np.random.default_rng(2)
    actions = [(bool(generator.random() < 0.3), 2.0 * generator.random()) for _ in range(2000)]
    environment = trocar.gym.Supervisor("layers/skin-augmented")
    environment.reset(seed=1)
    used, is_over = iter(actions), False
    while not is_over:
        holds, force_scale = next(used)
        _, _, is_over, _, info = environment.step([float(holds), force_scale])
    scenario = info["run"].scenario
    assert scenario["scaling.position"] == 1.0
    commanded = Commanded(scenario.tick_s * trocar.Scenario.load("layers/skin-augmented")["augmentation.catch_up_speed_m_per_s"])
    simulation = trocar.Simulation(scenario, architecture=commanded)
    goes_on, ticks = simulation.step(), 1
    while goes_on:
        commanded.holds, commanded.force_scale = actions[(ticks - 1) // 10]
        goes_on, ticks = simulation.step(), ticks + 1
    expected = simulation.run()
    for column in ("slave_position_m", "feedback_force_n", "master_position_m"):
        assert np.array_equal(info["run"][column], expected[column])


def test_vectorised_environments_give_what_single_ones_do():
    together = trocar.gym.make_vec(3, scenario="layers/skin-augmented")
    alone = [trocar.gym.Supervisor("layers/skin-augmented") for _ in range(3)]
    observations, _ = together.reset(seed=1)
    expected = np.stack([environment.reset(seed=1 + index)[0] for index, environment in enumerate(alone)])
    over = np.zeros(3, bool)
    while not over.all():
        assert np.array_equal(observations, expected)
        actions = trocar.gym.hold_after_alarm(observations)
        observations, rewards, over, _, infos = together.step(actions)
        steps = [environment.step(action) for environment, action in zip(alone, actions)]
        expected = np.stack([step[0] for step in steps])
        assert rewards.tolist() == [step[1] for step in steps] and over.tolist() == [step[2] for step in steps]
    assert infos["held_s"].tolist() == [step[4]["held_s"] for step in steps]
    # The next step begins new episodes.
    _, rewards, over, _, _ = together.step(actions)
    assert not rewards.any() and not over.any()
    together.close()


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
