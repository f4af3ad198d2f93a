"""The controller of a rig."""

import copy
import itertools
import math
import pickle

import numpy as np
import pytest

import trocar


def samples(run):
    names = "master_position_m", "slave_position_m", "slave_velocity_m_per_s", "measured_force_n"
    return [column.tolist() for column in (run[name] for name in names)]


def test_the_commands_equal_those_of_the_simulation():
    run = trocar.run("paper/augmented")
    controller = trocar.HapticController(run.scenario)
    commands = [controller.step(*sample) for sample in zip(*samples(run))]
    assert [command.slave_reference_m for command in commands] == run["slave_reference_m"].tolist()
    assert [command.master_force_n for command in commands] == run["feedback_force_n"].tolist()
    assert [command.mode for command in commands] == run["mode"].tolist()
    times_s = run["time_s"][[command.alarm_taken for command in commands]]
    np.testing.assert_array_equal(times_s, run.alarms_s)
    assert [command.residual_n for command in commands] == run["residual_n"].tolist()


def test_a_missing_sample_is_a_fault_and_the_last_sample_is_held():
    controller = trocar.HapticController("paper/augmented", **{"rig.force_limit_n": 20.0})
    controller.step(0.015, 0.0149, 0.01, 1.2)
    before = copy.copy(controller)
    command = controller.step(None, 0.0149, 0.01, 25.0)
    assert command.faults == ["master_position", "force"] and command.faulty_samples == 1
    assert (command.slave_reference_m, command.master_force_n) == (0.015, 1.2)
    again = before.step(math.nan, 0.0149, 0.01, math.inf)
    assert (again.slave_reference_m, again.faults) == (command.slave_reference_m, command.faults)
    controller.reset()
    assert controller.step(0.02, 0.02, 0.0, 0.5).faulty_samples == 0


def test_lost_and_stale_samples_are_counted_and_a_few_do_not_hide_a_rupture():
    run = trocar.run("paper/augmented")
    controller = trocar.HapticController(run.scenario)
    alarms = []
    for k, sample in enumerate(zip(*samples(run))):
        if k % 50 == 10:
            sample = (None,) * 4
        # Every 100th sample arrives twice.
        number = k if k % 100 == 30 else k + 1
        command = controller.step(*sample, number=number)
        if command.alarm_taken:
            alarms.append(k)
    ruptures = [round(rupture["time_s"] / run.scenario.tick_s) for rupture in run.ruptures]
    assert len(alarms) == len(ruptures) == 2
    assert all(0 <= alarm - rupture <= 30 for alarm, rupture in zip(alarms, ruptures))
    counts = controller.counts
    assert counts["repeated"] == len(run["time_s"]) // 100 and counts["gaps"] == 0
    assert command.detection in {"armed", "settling"} and command.state == "active" and command.fault is None


def test_a_long_loss_is_blind_and_a_fault_and_the_force_decays():
    controller = trocar.HapticController("paper/augmented", **{"safety.decay_s": 0.05})
    controller.step(0.015, 0.0149, 0.01, 1.2)
    commands = [controller.step(None, None, None, None) for _ in range(70)]
    assert commands[8].detection == "settling" and commands[9].detection == "blind"
    assert commands[9].state == "fault" and commands[9].fault == "bad-samples"
    assert commands[-1].master_force_n == 0.0 and commands[-1].detection_ticks == 60
    assert controller.counts["faults"] == 1
    assert pickle.loads(pickle.dumps(commands[-1])).__getnewargs__() == commands[-1].__getnewargs__()


def test_commands_keep_their_limits():
    scenario = trocar.Scenario.load("paper/augmented", **{"scaling.force": 1000.0})
    controller = trocar.HapticController(scenario, **{"safety.force_limit_n": 8.0})
    commands = [controller.step(0.015, 0.0149, 0.01, 99.0) for _ in range(100)]
    assert commands[-1].master_force_n == 8.0 and "force" in commands[-1].limited
    assert controller.counts["force_limited"] == 100


LAWS = ["decay", "amplify", "damp", "guide"]
HOLDS = ["freeze", "none", "speed-limit", "forbidden-region", "yielding"]
RETURNS = ["ramp", "ramp-until-load", "fade", "when-still", "clutch", "snap"]


@pytest.mark.parametrize("law, hold, reengage", list(zip(itertools.cycle(LAWS), HOLDS, RETURNS)))
def test_a_pickled_controller_continues(law, hold, reengage):
    """Pickles a controller in teleoperation, frozen, re-engaging, and without samples; it must continue with
    identical bits."""
    words = {"augmentation.force_law": law, "augmentation.hold": hold}
    if hold != "none":
        words["augmentation.reengage"] = reengage
    if reengage == "clutch":
        words["sensor.position_resolution_m"] = 1e-6
    run = trocar.run(trocar.Scenario.load("paper/augmented", **words))
    alarm = round(run.alarms_s[0] / run.scenario.tick_s)
    given = list(zip(*samples(run)))
    given[alarm + 300] = given[alarm + 301] = (None, 0.0149, math.nan, 1.0)
    controller = trocar.HapticController(run.scenario, **{"rig.recovery_speed_m_per_s": 0.1})
    modes, begun = set(), 0
    for end in (100, alarm, *range(alarm + 1, alarm + 1600, 100), alarm + 1600):
        other = pickle.loads(pickle.dumps(controller))
        for sample in given[begun:end]:
            one, same = controller.step(*sample), other.step(*sample)
            assert one.__getnewargs__() == same.__getnewargs__()
            modes.add(one.mode)
        controller, begun = other, end
    # Without a hold, only the force returns.
    assert modes == {0, 1, 2}


def test_invalid_settings_are_reported():
    with pytest.raises(ValueError, match="there is no rig.force"):
        trocar.HapticController("paper/augmented", **{"rig.force": 20.0})
    with pytest.raises(ValueError, match="rig.force_limit_n"):
        trocar.HapticController("paper/augmented", **{"rig.force_limit_n": -1.0})
    with pytest.raises(ValueError, match="safety.decay_s"):
        trocar.HapticController("paper/augmented", **{"safety.decay_s": 0.0})
    for key, word in (("estimator.parameters", "hunt-crossley"), ("estimator.forgetting", "exponential")):
        with pytest.raises(ValueError, match=f"^{key} is ., must be the word .*: a rig runs no other estimator"):
            trocar.HapticController(trocar.Scenario.load("paper/augmented", **{key: word}))
