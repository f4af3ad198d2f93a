"""The command line and the package give identical bits."""

import json

import numpy as np
import pytest

import trocar

SHIPPED = sorted(name for name in trocar.shipped() if "sweeps/" not in name)


def bits(array):
    return np.ascontiguousarray(array, dtype=np.float64).view(np.int64)


@pytest.fixture(scope="session")
def runs_of_cli(cli, tmp_path_factory):
    out = tmp_path_factory.mktemp("runs")
    done = cli("run", *SHIPPED, "--out", out, "--quiet")
    assert done.returncode == 0, done.stderr
    return out


def test_every_shipped_scenario_has_a_question():
    assert len(SHIPPED) >= 34
    assert all("?" in question for question in trocar.shipped().values())


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_scenario_has_the_bits_of_the_command_line(name, runs_of_cli):
    run = trocar.run(name)
    folder = runs_of_cli / run.scenario.name
    with open(folder / "trace.csv") as file:
        heading = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    assert heading == list(run.traces)
    for index, column in enumerate(heading):
        np.testing.assert_array_equal(bits(run[column]), bits(table[:, index]), err_msg=column)
    assert run._core.summary_json() == (folder / "summary.json").read_text(encoding="utf-8")
    assert run.scenario.to_toml() == (folder / "scenario.toml").read_text(encoding="utf-8")
    assert run.summary == json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def test_a_file_on_disk_and_its_echo_are_the_same_scenario(tmp_path):
    echo = trocar.Scenario.load("layers/skin-augmented").to_toml()
    path = tmp_path / "again.toml"
    path.write_text(echo, encoding="utf-8")
    loaded, read = trocar.Scenario.load(path), trocar.Scenario.from_toml(echo)
    assert loaded == read
    assert trocar.run(loaded)._core.summary_json() == trocar.run(read)._core.summary_json()


def test_the_default_recording_is_the_shipped_one(recording):
    made = trocar.record()
    assert list(made) == list(recording)
    for name, column in recording.items():
        np.testing.assert_array_equal(bits(made[name]), bits(column))
    assert not np.array_equal(trocar.record(2)["force_n"], made["force_n"])


def test_compare_equals_the_command_line(cli, tmp_path):
    done = cli("compare", "--json", "--out", tmp_path)
    assert trocar.compare().report == json.loads(done.stdout)


def test_compare_over_seeds_equals_the_command_line(cli, tmp_path):
    pair = ["hand/fast-stab", "layers/skin-augmented"]
    done = cli("compare", *pair, "--seeds", 3, "--json", "--out", tmp_path)
    assert trocar.compare(*pair, seeds=3).report == json.loads(done.stdout)


def test_detect_equals_the_command_line(cli, tmp_path, recording):
    columns = [recording[name] for name in ("time_s", "position_m", "velocity_m_per_s", "force_n")]
    given = ["builtin:in_vivo_like.csv", "--contact-m", "0.012", "--rupture-s", "5.52", "--rupture-s", "8.85"]
    done = cli("detect", *given, "--velocity", "velocity_m_per_s", "--json", "--out", tmp_path)
    found = trocar.detect(*columns, contact_m=0.012, ruptures_s=[5.52, 8.85], name="in_vivo_like")
    assert found.report == json.loads(done.stdout)
    assert len(found.alarms) == 2
    with open(tmp_path / "in_vivo_like" / "detection.csv") as file:
        heading = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",")
    for index, column in enumerate(heading):
        if column in found.columns:
            np.testing.assert_array_equal(bits(found[column]), bits(table[:, index]), err_msg=column)
    assert set(found.columns) <= set(heading)


def test_detect_without_velocities_equals_the_command_line(cli, tmp_path, recording):
    done = cli("detect", "builtin:in_vivo_like.csv", "--set", "detector.threshold=0.05", "--json", "--out", tmp_path)
    columns = recording["time_s"], recording["position_m"], None, recording["force_n"]
    found = trocar.detect(*columns, name="in_vivo_like", **{"detector.threshold": 0.05})
    assert found.report == json.loads(done.stdout)


def test_calibrate_equals_the_command_line(cli, tmp_path, recording):
    given = ["builtin:in_vivo_like.csv", "--velocity", "velocity_m_per_s", "--first-s", 7, "--json", "--out", tmp_path]
    done = cli("calibrate", *given)
    columns = [recording[name] for name in ("time_s", "position_m", "velocity_m_per_s", "force_n")]
    calibration = trocar.calibrate(*columns, first_s=7.0, name="in_vivo_like")
    assert calibration.report == json.loads(done.stdout)
    by_file = trocar.detect(*columns, settings_file=tmp_path / "in_vivo_like" / "calibrated.toml")
    by_settings = trocar.detect(*columns, **calibration.settings)
    np.testing.assert_array_equal(by_file.alarms, by_settings.alarms)
    np.testing.assert_array_equal(bits(by_file["decision"]), bits(by_settings["decision"]))


SMALL = """\
base = "paper/augmented"
seeds = 2
metrics = ["detected_ruptures", "false_alarms", "rupture_1_detection_delay_s"]
[set]
simulation.duration_s = 6.0
[axes]
scaling.force = { from = 0.5, to = 2.0, points = 5, log = true }
augmentation.reengage = ["ramp", "snap"]
"""


def rows_of(path):
    lines = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    return {name: [line[index] for line in lines[1:]] for index, name in enumerate(lines[0])}


def same_as_csv(sweep, rows):
    assert list(rows) == list(sweep.columns)
    for name, cells in rows.items():
        column = sweep[name]
        if column.dtype.kind == "f":
            expected = np.array([float(cell) if cell else np.nan for cell in cells])
            np.testing.assert_array_equal(bits(column), bits(expected), err_msg=name)
        else:
            assert [str(value) for value in column] == cells, name


def test_a_sweep_of_a_file_or_of_arguments_equals_the_command_line(cli, tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    done = cli("sweep", path, "--out", tmp_path, "--quiet")
    assert done.returncode == 0, done.stderr
    rows = rows_of(tmp_path / "small" / "cases.csv")
    of_file = trocar.sweep(path)
    same_as_csv(of_file, rows)
    assert of_file.hash == json.loads((tmp_path / "small" / "manifest.json").read_text())["sweep_sha256"]
    of_arguments = trocar.sweep(
        "paper/augmented",
        {"scaling.force": trocar.Range(0.5, 2.0, 5, log=True), "augmentation.reengage": ["ramp", "snap"]},
        seeds=2,
        metrics=["detected_ruptures", "false_alarms", "rupture_1_detection_delay_s"],
        set={"simulation.duration_s": 6.0},
        threads=1,
    )
    same_as_csv(of_arguments, rows)


def test_stability_equals_the_command_line(cli, tmp_path):
    axes = "scaling.force=0.1:20:12", "tissue.stiffness_n_per_m=10:4000:15"
    done = cli("stability", "--x", axes[0], "--y", axes[1], "--simulate", "--json", "--out", tmp_path)
    stability = trocar.stability(x=axes[0], y=axes[1], simulate=True)
    assert stability.report == json.loads(done.stdout)
    rows = rows_of(tmp_path / "depth-classical" / "stability_map.csv")
    assert stability.stable.shape == (15, 12)
    assert [str(int(stable)) for stable in stability.stable.ravel()] == rows["stable"]
    words = {1: "decays", 0: "grows", -1: "undecided"}
    assert [words[verdict] for verdict in stability.simulated.ravel()] == rows["simulated"]
    assert 0.0 < stability.stable.mean() < 1.0
