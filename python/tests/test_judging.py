"""User-defined detectors are evaluated beside the built-in ones; comparisons and synthetic recordings."""

import json

import numpy as np
import pytest
from test_parts import SquaredResidual

import trocar

PAPER = {"detector.distance": "squared-residual"}


@pytest.fixture(scope="module")
def copied():
    return SquaredResidual(trocar.Scenario.load("paper/classical"))


def test_a_copied_detector_gives_the_same_counts_as_the_built_in_one(copied):
    judged = trocar.roc(detectors={"mine": copied, "squared-residual": None}, seeds=8, noise_std_n=[0.0, 0.025], thresholds=2)
    points = judged.at_own_threshold()
    mine, built_in = points["mine"], points["squared-residual"]
    assert built_in["ruptures"] == 32 and built_in["detected"] > 0
    for key in ("cases", "clean_cases", "ruptures", "detected", "late", "false_alarms", "hours", "delay_median_s", "detection_interval"):
        assert mine[key] == built_in[key], key
    frame = judged.to_dataframe()
    assert set(frame["detector"]) == {"mine", "squared-residual"} and set(frame["signal"]) == {"all", "in_vivo_like"}
    assert "mine" in str(judged) and "mine" in judged._repr_html_() and len(judged.plot().axes[0].lines) == 2


def test_compiled_detectors_run_in_threads_with_the_same_counts():
    numba = pytest.importorskip("numba")
    pointer = numba.types.CPointer(numba.types.float64)

    @numba.cfunc(numba.types.void(pointer, pointer, pointer))
    def compiled(inputs, outputs, state):
        # The state counts the samples since the last alarm.
        state[0] += 1.0
        if inputs[5] != 0.0 and -inputs[2] > 0.2 and state[0] > 50.0:
            outputs[0] = 1.0
            state[0] = 0.0

    class Same:
        def reset(self):
            self.count = 0.0

        def step(self, force, predicted, residual, depth, velocity, contact):
            self.count += 1.0
            alarm = contact and -residual > 0.2 and self.count > 50.0
            if alarm:
                self.count = 0.0
            return alarm

    detector = trocar.Compiled(compiled, state=[0.0])
    settings = {"seeds": 4, "noise_std_n": [0.0, 0.025]}
    expected = trocar.roc(detectors={"mine": Same()}, **settings)
    assert expected.at_own_threshold()["mine"]["detected"] > 0
    for threads in (1, 2):
        assert trocar.roc(detectors={"mine": detector}, threads=threads, **settings).report == expected.report


def test_the_report_equals_that_of_the_command_line(cli, tmp_path):
    done = cli("roc", "--seeds", 3, "--detectors", "adaptive", "--thresholds", 4, "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    assert trocar.roc(detectors=["adaptive"], seeds=3, thresholds=4, threads=1).report == json.loads(done.stdout)


def test_detectors_by_threshold_are_a_curve(copied):
    def steep(threshold):
        return lambda force, predicted, residual, depth, velocity, contact: contact and -residual > threshold

    judged = trocar.roc(detectors={"steep": {level: steep(level) for level in (0.1, 0.3, 3.0)}}, seeds=3)
    points = judged.curves["steep"]
    assert [point["threshold"] for point in points] == [0.1, 0.3, 3.0]
    alarms = [point["false_alarms"] for point in points]
    assert alarms == sorted(alarms, reverse=True) and alarms[0] > alarms[2]


def test_detectors_are_evaluated_on_recordings_loops_and_trials(copied):
    data = trocar.record(drop_n=2.0)
    of_data = trocar.roc(data, detectors={"mine": copied}, ruptures_s=[5.52, 8.85], contact_m=0.012, seeds=2)
    assert of_data.at_own_threshold()["mine"]["ruptures"] == 4
    of_loop = trocar.roc("layers/through-the-skin", detectors={"mine": copied, "adaptive": None}, seeds=2)
    assert of_loop.at_own_threshold()["mine"]["ruptures"] == of_loop.at_own_threshold()["adaptive"]["ruptures"] > 0
    of_trials = trocar.roc(trials=True, detectors={"mine": copied, "adaptive": None}, seeds=5)
    ruptures = sum(sum(trial.is_above_noise) for trial in trocar.trials(5))
    assert of_trials.at_own_threshold()["mine"]["ruptures"] == ruptures > 0


@pytest.mark.parametrize(
    ("arguments", "exception", "text"),
    [
        ({"detectors": ["beauty"]}, ValueError, "there is no detector beauty; the built-in ones are"),
        ({"seeds": 0}, ValueError, "seeds is 0, must be at least 1"),
        ({"noise_std_n": -1.0}, ValueError, "noise_std_n is -1, must be from 0 to 100"),
        ({"within_s": 2.0}, ValueError, "within_s is 2, must be from 0 to 0.5"),
        ({"trials": True, "signal": "paper/classical"}, ValueError, "give either trials or a signal"),
        ({"signal": "paper/classical", "contact_m": 0.01}, ValueError, "a scenario contains its settings"),
        ({"detectors": {"mine": lambda *_: None}}, TypeError, "the detector returned a"),
    ],
)
def test_invalid_studies_are_reported(arguments, exception, text):
    with pytest.raises(exception, match=text):
        trocar.roc(**{"seeds": 2, **arguments})


def test_an_exception_of_a_detector_ends_the_study():
    def fails(*evidence):
        raise ArithmeticError("in a case")

    with pytest.raises(ArithmeticError, match="in a case"):
        trocar.roc(detectors={"mine": fails}, seeds=2)


def test_trials_are_recordings():
    all_of_them = list(trocar.trials(40))
    assert [trial.number for trial in all_of_them] == list(range(1, 41))
    assert any(len(trial.ruptures_s) == 0 for trial in all_of_them) and any(len(trial.ruptures_s) > 1 for trial in all_of_them)
    (trial,) = trocar.trials([7])
    assert all(np.array_equal(trial[name], all_of_them[6][name]) for name in trial)
    ruptures = [trial for trial in all_of_them if any(trial.is_above_noise)]
    found = 0
    for trial in ruptures:
        alarms_s = trocar.detect(trial, contact_m=trial.contact_m).alarms_s
        found += trocar.score(alarms_s, trial.ruptures_s)["found"]
    assert found > len(ruptures) / 2


def test_a_synthetic_insertion_has_the_requested_drop():
    shipped, small = trocar.record(), trocar.record(drop_n=1.0, sharpness_s=0.02)
    fall = lambda data: data["force_n"][5500:5520].mean() - data["force_n"][5600:5620].mean()
    assert fall(shipped) > 3.0 and 0.3 < fall(small) < 1.2
    deep = trocar.record(depth_m=0.05)
    assert deep["position_m"][5520] - shipped["position_m"][5520] > 0.02
    with pytest.raises(ValueError, match="sharpness_s is 0, must be from 0.0001 to 10"):
        trocar.record(sharpness_s=0.0)


def test_a_comparison_with_copied_parts_equals_the_built_in_one(copied):
    scenarios = [trocar.Scenario.load(name, **PAPER) for name in ("paper/classical", "paper/augmented")]
    built_in = trocar.compare(*scenarios, seeds=2)
    user_defined = trocar.compare(*scenarios, seeds=2, detector=copied)
    assert user_defined.report["seeds"] == built_in.report["seeds"] and user_defined.report["noise"] == []
    for one, other in zip(user_defined.runs, built_in.runs):
        assert all(np.array_equal(one[name], column, equal_nan=True) for name, column in other.items())
    names = user_defined.to_dataframe().index
    assert user_defined.to_dataframe().equals(built_in.to_dataframe().loc[names])
    with pytest.raises(ValueError, match="seeds is 1"):
        trocar.compare(seeds=1, detector=copied)


def test_the_progress_counts_every_detector(monkeypatch):
    reported = []
    monkeypatch.setattr("trocar._progress.Progress.tell", lambda self, done, all: reported.append((done, all)))
    trocar.roc(detectors={"mine": lambda force, predicted, residual, depth, velocity, contact: False, "adaptive": None}, seeds=2, noise_std_n=[0.0, 0.02], progress=True)
    assert reported[:4] == [(1, 8), (2, 8), (3, 8), (4, 8)] and reported[-1] == (8, 8)
