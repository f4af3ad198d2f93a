"""Errors have the text and the place of the command line."""

import numpy as np
import pytest

import trocar

CLASSICAL = "paper/classical"


def in_python(said):
    """Returns an error of the command line in Python's words."""
    words = {
        "--> --set:": "--> changes:",
        "`trocar init --all` writes a scenario with every key": "`trocar.keys()` lists every key",
        "`trocar scenarios` lists": "`trocar.shipped()` lists",
    }
    for option, word in words.items():
        said = said.replace(option, word)
    return said.rstrip()


@pytest.mark.parametrize(
    ("key", "value", "setting"),
    [
        ("scaling.force", -2, "scaling.force=-2"),
        ("scaling.forse", 2, "scaling.forse=2"),
        ("scaling.force", "two", 'scaling.force="two"'),
        ("scaling.force", float("nan"), "scaling.force=nan"),
        ("simulation.engine", "exakt", "simulation.engine=exakt"),
        ("estimator.dead_zone_n", -1.0, "estimator.dead_zone_n=-1.0"),
        ("slave.denominator", [1.0, 2.0], "slave.denominator=[1.0, 2.0]"),
        ("recording.file", "/nowhere.csv", "recording.file=/nowhere.csv"),
        ("recording.ruptures_s", [3.0, 2.0], "recording.ruptures_s=[3.0, 2.0]"),
    ],
)
def test_a_changed_key_fails_as_on_the_command_line(cli, key, value, setting):
    with pytest.raises(ValueError) as caught:
        trocar.Scenario.load(CLASSICAL).replace(**{key: value})
    said = cli("check", CLASSICAL, "--set", setting)
    assert said.returncode == 2
    assert str(caught.value).rstrip() == in_python(said.stderr)
    assert isinstance(caught.value, trocar.ScenarioError)


def test_a_file_fails_as_on_the_command_line(cli, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text('base = "paper/classical"\n\n[slave]\nvelocity_gain = -2\n')
    with pytest.raises(trocar.ScenarioError) as caught:
        trocar.Scenario.load(path)
    said = cli("check", path)
    error = caught.value
    assert str(error).rstrip() == in_python(said.stderr)
    assert (error.file, error.line, error.column) == (str(path), 4, 17)
    assert error.message.startswith("slave.velocity_gain is -2, must be")


def test_a_missing_file_is_an_error(cli):
    with pytest.raises(trocar.ScenarioError) as caught:
        trocar.Scenario.load("/nowhere.toml")
    assert str(caught.value).rstrip() == in_python(cli("check", "/nowhere.toml").stderr)
    assert caught.value.line is None


def test_a_dictionary_points_into_its_text():
    with pytest.raises(trocar.ScenarioError) as caught:
        trocar.Scenario.from_dict({"base": CLASSICAL, "scaling": {"position": 1.0, "force": -2.0}}, name="mine")
    error = caught.value
    assert (error.file, error.line, error.column) == ("mine", 3, 17)
    assert "scaling.force = -2.0" in str(error)


@pytest.mark.parametrize("value", [None, object(), {1}, 1j, b"bytes"])
def test_a_value_without_a_toml_type_is_a_type_error(value):
    with pytest.raises(TypeError, match=r"scaling\.force is a value of the type"):
        trocar.Scenario.load(CLASSICAL, **{"scaling.force": value})


@pytest.mark.parametrize("value", [2**70, "\ud800"])
def test_a_value_out_of_range_for_toml_is_a_value_error(value):
    with pytest.raises(ValueError, match="cannot represent"):
        trocar.Scenario.load(CLASSICAL, **{"name": value})


@pytest.mark.parametrize("key", ["a=b", "", ".", "a\nb", "scaling.", 'x"y', "[scaling]"])
def test_invalid_keys_are_refused(key):
    with pytest.raises(ValueError):
        trocar.Scenario.load(CLASSICAL, **{key: 1})


def test_deeply_nested_values_are_refused():
    value = []
    for _ in range(10_000):
        value = [value]
    with pytest.raises(ValueError, match="nesting"):
        trocar.Scenario.load(CLASSICAL, **{"slave.numerator": value})


def test_errors_can_be_pickled():
    import pickle

    with pytest.raises(trocar.ScenarioError) as caught:
        trocar.Scenario.load(CLASSICAL, **{"scaling.force": -2})
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.line, again.remedy) == (str(caught.value), caught.value.line, caught.value.remedy)


@pytest.mark.parametrize("shard", ["", "0/1", "3/2", "x"])
def test_an_invalid_shard_is_refused(shard):
    with pytest.raises(ValueError, match="must be i/n"):
        trocar.sweep(CLASSICAL, {"scaling.force": [1.0]}, shard=shard)


def test_sweeps_report_invalid_arguments():
    with pytest.raises(trocar.ScenarioError, match="each must be a number") as caught:
        trocar.sweep(CLASSICAL, {"scaling.force": [1.0, -1.0]})
    assert caught.value.file == "sweep"
    with pytest.raises(trocar.ScenarioError, match="there is no metric"):
        trocar.sweep(CLASSICAL, {"scaling.force": [1.0]}, metrics=["beauty"])
    with pytest.raises(ValueError, match="without axes"):
        trocar.sweep(CLASSICAL, seeds=3)


def test_stability_reports_invalid_arguments():
    with pytest.raises(ValueError, match="did you mean scaling.force"):
        trocar.stability(x="scaling.forse=1:2:3")
    with pytest.raises(ValueError, match="name two different ones"):
        trocar.stability(x="scaling.force=1:2:3", y="scaling.force=1:2:3")
    for tissue in [(-1.0, 2.0), (2.0, 1.0), (0.0, float("nan")), (0.0, 1e7)]:
        with pytest.raises(ValueError, match="tissue is"):
            trocar.stability(tissue=tissue)
    with pytest.raises(ValueError, match="side is"):
        trocar.state_space(CLASSICAL, "left")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: trocar.compare(threads=-1), "threads is -1, must be at least 0"),
        (lambda: trocar.compare(threads=2000), "threads = 2000, must be at most 1024"),
        (lambda: trocar.compare(seeds=-1), "seeds is -1, must be at least 2"),
        (lambda: trocar.roc(seeds=0), "seeds is 0, must be at least 1"),
        (lambda: trocar.roc(trials=True, ruptures_s=[1.0]), "trials contain their ruptures"),
        (lambda: trocar.roc(noise_std_n=[]), "noise_std_n is empty"),
        (lambda: trocar.roc(detectors={"mine": {float("nan"): bool}}), "a threshold of mine is nan, must be finite"),
        (lambda: trocar.record(-1), "seed is -1, must be at least 0"),
        (lambda: list(trocar.trials([0])), "number is 0, must be at least 1"),
        (lambda: trocar.state_space(CLASSICAL, "slave").step_response(-1), "input is -1, must be at least 0"),
        (lambda: trocar.score([1.0], [1.0], recorded_s=float("nan")), "recorded_s is nan, must be above 0"),
        (lambda: trocar.sweep(CLASSICAL, {"scaling.force": [1.0]}, shards=0), "shards is 0, must be at least 1"),
        (lambda: trocar.detect(trocar.record(), ruptures_s=1.0), "ruptures_s has the shape"),
        (lambda: trocar.detect(trocar.record(), scaling={"force": 2.0}), "scaling.force has no effect on a recording"),
    ],
)
def test_invalid_numbers_are_named(call, text):
    with pytest.raises(ValueError, match=text):
        call()


@pytest.mark.parametrize("threads", [1.5, "2", True, None])
def test_the_number_of_threads_must_be_whole(threads):
    with pytest.raises(TypeError, match="threads is .*, must be a whole number"):
        trocar.compare(threads=threads)


@pytest.mark.parametrize(
    ("call", "error", "remedy"),
    [
        (lambda: trocar.sweep(CLASSICAL, {"scaling.force": (1, 10, 3)}), TypeError, "a list of values or trocar.Range"),
        (lambda: trocar.sweep(CLASSICAL, ["scaling.force"]), TypeError, "a dictionary of keys"),
        (lambda: trocar.sweep(CLASSICAL, points=np.ones((2, 2))), TypeError, "dict[(]zip[(]keys, array.T[)][)]"),
        (lambda: trocar.stability(CLASSICAL, {"scaling.force": [1, 2, 3]}), TypeError, "a Range or a tuple"),
        (lambda: trocar.design({"base": CLASSICAL, "patients": 20}), TypeError, "patients is 20, must be a dictionary of keys"),
        (lambda: trocar.design({"base": CLASSICAL, "free": {"scaling.force": (0.5, 1)}}), TypeError, "free has the tuple"),
        (lambda: trocar.patients(3)[10], IndexError, "no patient .10. of 3"),
        (lambda: trocar.run({"base": CLASSICAL}), TypeError, "trocar.Scenario.from_dict"),
        (lambda: trocar.run(CLASSICAL, **{"scaling.force": 2.0}), TypeError, "changed in the scenario, as in trocar.Scenario.load"),
        (lambda: trocar.Scenario.load(CLASSICAL)["scaling.forse"], KeyError, "did you mean scaling.force"),
        (lambda: trocar.detect("trial.mat"), TypeError, "trocar.read_recording[(]'trial.mat'[)]"),
        (lambda: trocar.detect([0.0, 0.1], [0.0, 0.1], [0.0, 0.1]), TypeError, "^force missing"),
    ],
)
def test_what_a_newcomer_tries_is_answered_with_a_remedy(call, error, remedy):
    with pytest.raises(error, match=remedy):
        call()
