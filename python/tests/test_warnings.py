"""The warnings of the package are those of the command line."""

import subprocess
import warnings

import numpy as np
import pytest

import trocar


def test_each_code_has_a_class(binary):
    listed = subprocess.run([binary, "explain"], capture_output=True, text=True, check=True).stdout
    meanings: dict[str, list[str]] = {}
    for line in listed.splitlines():
        if line.startswith(" "):
            meanings[list(meanings)[-1]].append(line.strip())
        elif line:
            meanings[line] = []
    classes = {code: kind.__doc__ for code, kind in trocar.warnings.BY_CODE.items()}
    assert classes == {code: " ".join(lines) for code, lines in meanings.items()}


def test_a_missed_rupture_is_reported_with_key_and_remedy():
    with pytest.warns(trocar.warnings.MissedRuptureWarning, match="below the drift") as found:
        run = trocar.run("sensing/wrong-detector-settings")
    assert {one.message.place for one in found} == {"detector.drift"}
    assert run.ruptures[0]["miss"]["reason"] == "below-drift"
    assert [one["code"] for one in run.summary["warnings"]] == ["missed-rupture"] * 2


def test_an_oscillation_is_an_outcome_and_a_warning():
    with pytest.warns(trocar.warnings.OscillatingWarning):
        run = trocar.run("passivity/late-wall")
    assert run.metrics["outcome"]["kind"] == "oscillating"


def test_correct_inputs_give_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        trocar.run("paper/augmented")
        trocar.compare()


def test_stability_is_unknown_if_a_part_is_left_out():
    scenario = trocar.Scenario.load("paper/classical").replace(**{"channel.loss": 0.3})
    with pytest.warns(trocar.warnings.UnmodelledWarning, match="channel.loss"):
        stability = trocar.stability(scenario, "scaling.force=0.5:2:2", "scaling.position=0.5:2:2")
    assert stability.is_stable is None and "unknown" in repr(stability)


def insertion(offset_n=0.0):
    """Returns free motion, a spring from 0 on, and a rupture at 2.5 s."""
    time_s = np.arange(5000) * 1e-3
    position_m = -0.01 + 0.01 * time_s
    force_n = np.where(position_m <= 0, 0.0, 300 * position_m)
    force_n = np.where(position_m > 0.015, 1 + 100 * (position_m - 0.015), force_n)
    return time_s, position_m, force_n + offset_n + 0.005 * np.random.default_rng(7).standard_normal(5000)


@pytest.mark.parametrize("command", [trocar.detect, trocar.calibrate])
def test_mistakes_in_a_recording_are_reported(command):
    time_s, position_m, force_n = insertion()
    with warnings.catch_warnings():
        warnings.simplefilter("error", trocar.warnings.ForceOffsetWarning)
        warnings.simplefilter("error", trocar.warnings.ForceMagnitudeWarning)
        warnings.simplefilter("error", trocar.warnings.KeyWithoutEffectWarning)
        command(time=time_s, position=position_m, force=force_n)
    with pytest.warns(trocar.warnings.ForceMagnitudeWarning, match="at least 0.1 N"):
        command(time=time_s, position=position_m, force=1e-3 * force_n)
    untared = dict(zip(("time", "position", "force"), insertion(0.35), strict=True))
    with pytest.warns(trocar.warnings.ForceOffsetWarning, match="which is not 0"):
        command(**untared)
    with warnings.catch_warnings():
        warnings.simplefilter("error", trocar.warnings.ForceOffsetWarning)
        command(**untared, **{"recording.tare_s": 0.5})
    with pytest.warns(trocar.warnings.KeyWithoutEffectWarning, match="sensor.force_bias_n changes nothing here"):
        command(time=time_s, position=position_m, force=force_n, **{"sensor.force_bias_n": -0.35})


def test_a_run_that_is_too_short_is_reported():
    scenario = trocar.Scenario.load("layers/through-the-skin")
    with pytest.warns(trocar.warnings.TissueNotTouchedWarning, match="never touches the tissue"):
        trocar.run(scenario.replace(**{"tissue.contact_m": 25.0}))
    with pytest.warns(trocar.warnings.LayerNotRupturedWarning, match="the layer capsule does not rupture"):
        trocar.run(scenario.replace(**{"operator.end_m": 0.05}))
    with pytest.warns(trocar.warnings.MotionBeyondRunWarning, match="takes 5000 s"):
        trocar.run(scenario.replace(**{"operator.movement_s": 5000.0}))
