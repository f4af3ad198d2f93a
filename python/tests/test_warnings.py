"""Warnings of the package: the same as those of the command line."""

import subprocess
import warnings

import pytest

import trocar
from trocar import _warnings


def test_a_class_for_each_code(binary):
    listed = subprocess.run([binary, "explain"], capture_output=True, text=True, check=True).stdout
    meanings: dict[str, list[str]] = {}
    for line in listed.splitlines():
        if line.startswith(" "):
            meanings[list(meanings)[-1]].append(line.strip())
        elif line:
            meanings[line] = []
    classes = {code: kind.__doc__ for code, kind in _warnings.BY_CODE.items()}
    assert classes == {code: " ".join(lines) for code, lines in meanings.items()}


def test_a_missed_rupture_is_told_with_key_and_remedy():
    with pytest.warns(trocar.MissedRuptureWarning, match="below the drift") as found:
        run = trocar.run("sensing/wrong-detector-settings")
    assert {one.message.place for one in found} == {"detector.drift"}
    assert run.ruptures[0]["miss"]["reason"] == "below-drift"
    assert [one["code"] for one in run.summary["warnings"]] == ["missed-rupture"] * 2


def test_a_swing_is_an_outcome_and_a_warning():
    with pytest.warns(trocar.OscillatingWarning):
        run = trocar.run("passivity/late-wall")
    assert run.metrics["outcome"]["kind"] == "oscillating"


def test_no_warning_without_a_reason():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        trocar.run("paper/augmented")
        trocar.compare()


def test_stability_is_unknown_where_something_is_left_out():
    scenario = trocar.Scenario.load("paper/classical").replace(**{"channel.loss": 0.3})
    with pytest.warns(trocar.UnmodelledWarning, match="channel.loss"):
        stability = trocar.stability(scenario, "scaling.force=0.5:2:2", "scaling.position=0.5:2:2")
    assert stability.is_stable is None and "unknown" in repr(stability)
