"""Roles of user-defined parts beyond those of the slave: operator, distance, architecture, passivity; and their states."""

import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import trocar

pytestmark = pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
SKIN = "layers/skin-augmented"


class Seeing:
    """An operator who records what it sees."""

    def reset(self):
        self.seen = []

    def step(self, tick, felt_force_n, master_position_m, has_cue):
        self.seen.append((felt_force_n, master_position_m, has_cue))
        return 1e-5 * tick, tick == 100, 2e-5 * tick


def test_an_operator_sees_its_hand_and_reports_what_it_notices():
    operator = Seeing()
    run = trocar.run(SKIN, operator=operator)
    felt, position, cue = (np.array(column) for column in zip(*operator.seen))
    assert np.isnan(position[0]) and np.array_equal(position[1:], run["master_position_m"][: len(position) - 1])
    assert np.array_equal(felt[1:], run["operator_force_n"][: len(felt) - 1]) and not cue.any()
    # The intended motion is twice as fast as the desired one, so the needle stays behind it.
    assert run.metrics["final_excess_m"] < -0.05
    plain = trocar.run(SKIN, operator=lambda tick, felt_force_n: 1e-5 * tick)
    assert np.array_equal(plain["slave_position_m"], run["slave_position_m"])


def test_an_operator_feels_the_cue():
    operator = Seeing()
    trocar.run("strategies/cue", operator=operator)
    assert any(has_cue for _, _, has_cue in operator.seen)


def squared(force_n, predicted_n, residual_n, depth_m, velocity_m_per_s, in_contact):
    return residual_n * residual_n


def test_a_distance_is_accumulated_by_the_scenarios_detector():
    scenario = trocar.Scenario.load("paper/augmented", **{"detector.distance": "squared-residual"})
    built_in, mine = trocar.run(scenario), trocar.run(scenario, distance=squared)
    assert np.array_equal(mine["decision"], built_in["decision"]) and len(mine.events) == len(built_in.events) > 0


def test_a_distance_is_told_of_alarms():
    class Counting:
        def reset(self):
            self.alarms = 0

        def step(self, *evidence):
            return squared(*evidence)

        def after_alarm(self):
            self.alarms += 1

    counting = Counting()
    run = trocar.run("paper/augmented", distance=counting)
    assert counting.alarms >= len(run.events) > 0


class Forward:
    """The paper's architecture."""

    def __init__(self, share=1.0):
        self.share = share

    def reset(self):
        pass

    def slave_target(self, position_m, velocity_m_per_s, hand_force_n, slave_m, slave_m_per_s, slave_n):
        return position_m

    def master_force(self, force_n, position_m, velocity_m_per_s, mode, hand_m, hand_m_per_s, hand_n):
        return self.share * force_n


@pytest.mark.parametrize("name", ["layers/skin-augmented", "link/long-delay"])
def test_an_architecture_in_python_is_that_of_the_paper(name):
    built_in, mine = trocar.run(name), trocar.run(name, architecture=Forward())
    for column in ("slave_reference_m", "feedback_force_n", "mode"):
        assert np.array_equal(mine[column], built_in[column]), column
    weak = trocar.run(name, architecture=Forward(0.5))
    assert weak["feedback_force_n"].max() < built_in["feedback_force_n"].max()


def test_a_passivity_scheme_limits_the_force():
    class Limited:
        def limit_force(self, force_n, velocity_m_per_s):
            return min(max(force_n, -0.5), 0.5)

        def master_sends(self, displacement_m):
            return [displacement_m, 2.0]

        def receive_position(self, position_m, payload, is_fresh, port):
            assert len(payload) == 4 and len(port) == 5
            return position_m

        def energies(self):
            return 0.25, 0.0, 0.0

    run = trocar.run("link/long-delay", passivity=Limited)
    assert run["feedback_force_n"].max() == 0.5 and run.metrics["link"]["promised_energy_j"] == 0.25


@pytest.mark.parametrize(
    ("parts", "error", "text"),
    [
        ({"architecture": object()}, TypeError, "has no method slave_target"),
        ({"passivity": object()}, TypeError, "one of the methods master_sends"),
        ({"architecture": type("A", (Forward,), {"master_force": lambda self, *given: float("nan")})}, ValueError, "must be finite"),
        ({"architecture": type("A", (Forward,), {"master_force": lambda self, *given: "1"})}, TypeError, "must return a number"),
        ({"passivity": type("P", (), {"master_sends": lambda self, moved: [1, 2, 3, 4, 5]})}, TypeError, "up to 4 numbers"),
        ({"passivity": type("P", (), {"energies": lambda self: 3})}, TypeError, "energies of the passivity"),
        ({"wheel": squared}, TypeError, "architecture, passivity"),
    ],
)
def test_a_wrong_part_of_the_link_is_refused(parts, error, text):
    with pytest.raises(error, match=text):
        trocar.run("link/long-delay", **parts)


class Spring:
    """A spring that gets softer with every tick, in all of its life."""

    def __init__(self):
        self.ticks = 0

    def step(self, tick, position_m, velocity_m_per_s):
        self.ticks += 1
        return 200.0 * max(position_m, 0.0) / (1.0 + 1e-4 * self.ticks)


def test_a_part_without_reset_is_made_anew_or_refused():
    with pytest.raises(TypeError, match="no method reset, .* pass the class Spring itself"):
        trocar.run(SKIN, tissue=Spring())
    first, second = trocar.run(SKIN, tissue=Spring), trocar.run(SKIN, tissue=Spring)
    assert np.array_equal(first["tissue_force_n"], second["tissue_force_n"])
    assert trocar.compare([SKIN, SKIN], tissue=Spring, seeds=2).runs[1].metrics == first.metrics


def test_picklable_parts_run_on_the_workers_of_an_executor():
    axes = {"scaling.force": [0.5, 0.75, 1.0]}
    here = trocar.sweep(SKIN, axes, seeds=2, metrics=["max_tissue_force_n"], tissue=Spring)
    with ProcessPoolExecutor(2) as executor:
        there = trocar.sweep(SKIN, axes, seeds=2, metrics=["max_tissue_force_n"], tissue=Spring, executor=executor, shards=3)
    assert all(np.array_equal(here[name], there[name]) for name in here)
    parts = [trocar.sweep(SKIN, axes, seeds=2, metrics=["max_tissue_force_n"], tissue=Spring, shard=f"{part}/2") for part in (1, 2)]
    assert np.array_equal(trocar.Sweep.merge(parts)["max_tissue_force_n"], here["max_tissue_force_n"])
    with pytest.raises(TypeError, match="cannot be sent to the workers"):
        trocar.sweep(SKIN, axes, tissue=lambda *given: 0.0, executor=executor)
    with pytest.raises(ValueError, match="leave out folder"):
        trocar.sweep(SKIN, axes, tissue=Spring, folder="out")


def test_the_hand_of_a_simulation_pushes_with_a_force():
    scenario = trocar.Scenario.load("paper/depth-classical", **{"tissue.kind": "kelvin-voigt", "tissue.stiffness_n_per_m": 300.0})
    simulation = trocar.Simulation(scenario)
    for _ in range(4000):
        simulation.step(hand_force_n=1.0)
    assert simulation["operator_force_n"] == pytest.approx(1.0, rel=0.02)
    assert simulation["tissue_force_n"] == pytest.approx(1.0, rel=0.05)
    for wrong in (float("nan"), "1"):
        with pytest.raises((ValueError, TypeError), match="hand_force_n"):
            simulation.step(hand_force_n=wrong)
    with pytest.raises(ValueError, match="give one of them"):
        simulation.step(0.0, hand_force_n=1.0)


def test_keys_change_while_a_simulation_runs_and_come_back():
    simulation = trocar.Simulation(SKIN)
    for _ in range(1000):
        simulation.step()
    saved = simulation.copy()
    simulation.change(**{"scaling.force": 0.5})
    simulation.step()
    simulation.step()
    assert simulation["feedback_force_n"] == pytest.approx(0.5 * simulation["measured_force_n"])
    again = pickle.loads(pickle.dumps(simulation))
    assert again.signals == simulation.signals
    simulation.step(), again.step()
    assert again.signals == simulation.signals
    simulation.restore(saved)
    assert simulation.ticks == 1000 and simulation.signals == saved.signals
    simulation.step(), simulation.step()
    assert simulation["feedback_force_n"] == simulation["measured_force_n"]
    assert saved.ticks == 1000


@pytest.mark.parametrize(
    ("name", "key", "value", "text"),
    [
        (SKIN, "master.mass_kg", 0.5, "keys of master cannot change"),
        (SKIN, "tissue.layer.skin.thickness_m", 0.003, "has layers or other memory"),
        ("link/long-delay", "scaling.force", 0.5, "whose link has a delay"),
        (SKIN, "scaling.force", -1.0, "must be a number"),
    ],
)
def test_a_key_that_cannot_change_is_refused(name, key, value, text):
    simulation = trocar.Simulation(name)
    simulation.step()
    with pytest.raises(trocar.ScenarioError, match=text):
        simulation.change(**{key: value})
    simulation.step()
    with pytest.raises(TypeError, match="must be a copy"):
        simulation.restore(3)
