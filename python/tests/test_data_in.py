"""A recording may be arrays or a DataFrame wherever a file is accepted, with the same results."""

import gc
import multiprocessing
import copy
import pickle

import numpy as np
import pandas as pd
import pytest

import trocar

@pytest.fixture(scope="module")
def frame():
    return pd.DataFrame(trocar.record())


@pytest.fixture
def of_arrays(frame):
    return trocar.Scenario.load("paper/augmented").replace(**{"recording.file": frame})


def same_run(one, other):
    assert list(one) == list(other)
    for name, column in other.items():
        assert column.tobytes() == one[name].tobytes(), name
    assert one.metrics == other.metrics


def test_a_scenario_with_the_samples_of_its_file_is_the_same(of_arrays, frame):
    expected = trocar.run("paper/augmented")
    same_run(trocar.run(of_arrays), expected)
    # Other forms: no units in the names, a list, the times as the index, and nested keys.
    short = {name.partition("_")[0]: column for name, column in trocar.record().items()}
    for recording in (short, frame.set_index("time_s")):
        same_run(trocar.run(trocar.Scenario.load("paper/augmented", recording={"file": recording})), expected)
    values = trocar.Scenario.load("paper/augmented").to_dict()
    values["recording"]["file"] = frame
    same_run(trocar.run(trocar.Scenario(values, "augmented")), expected)


def test_the_samples_are_part_of_the_scenario(tmp_path):
    data = trocar.record(seed=5)
    scenario = trocar.Scenario.load("paper/augmented", **{"recording.file": data})
    louder = scenario.replace(scaling={"force": 0.9})
    assert louder["recording.file"] == scenario["recording.file"]
    # The scenario holds a copy of the content.
    data["force_n"][:] = 0.0
    run = trocar.run(scenario)
    assert run["tissue_force_n"].max() > 1.0
    run.save(tmp_path / "run.npz")
    pickled, toml, expected = pickle.dumps(scenario), scenario.to_toml(), (dict(run), run.metrics)
    del scenario, louder, run
    gc.collect()
    with pytest.raises(trocar.ScenarioError, match="there is no recording memory:[0-9a-f]+ in memory"):
        trocar.Scenario.from_toml(toml)
    again = trocar.run(pickle.loads(pickled))
    assert again.metrics == expected[1] and all(np.array_equal(again[name], expected[0][name]) for name in again)
    gc.collect()
    same_run(trocar.run(trocar.load(tmp_path / "run.npz").scenario), again)


def test_the_samples_go_to_other_processes(of_arrays):
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        (run,) = pool.map(trocar.run, [of_arrays])
        axes = {"scaling.force": trocar.Range(0.5, 1.0, 16)}
        here, there = trocar.sweep(of_arrays, axes), trocar.sweep(of_arrays, axes, executor=pool, shards=2)
    same_run(run, trocar.run("paper/augmented"))
    assert here.hash == there.hash == trocar.sweep("paper/augmented", axes).hash
    assert all(here[name].tobytes() == there[name].tobytes() for name in here)


def test_detect_and_calibrate_accept_a_frame(frame):
    data = trocar.record()
    apart = trocar.detect(data["time_s"], data["position_m"], data["velocity_m_per_s"], data["force_n"], contact_m=0.012)
    together = trocar.detect(frame, contact_m=0.012)
    assert apart.report == together.report and all(np.array_equal(apart[name], together[name]) for name in apart)
    assert trocar.calibrate(frame, contact_m=0.012).toml == trocar.calibrate(*data.values(), contact_m=0.012).toml
    without = trocar.detect(frame.drop(columns="velocity_m_per_s"), contact_m=0.012)
    assert not np.array_equal(without["velocity_m_per_s"], together["velocity_m_per_s"])


@pytest.mark.parametrize(
    ("recording", "exception", "text"),
    [
        ([1.0, 2.0], TypeError, "a table or a dictionary of arrays, not list"),
        ({"time_s": [0.0, 1.0], "force_n": [0.0, 1.0]}, ValueError, "the recording has no position_m; its columns are time_s, force_n"),
        ({"time": [0.0, 0.0], "position": [0.0, 1.0], "force": [0.0, 1.0]}, ValueError, r"time_s\[1\] is 0.0 s, must be later"),
    ],
)
def test_invalid_recordings_are_reported(recording, exception, text):
    with pytest.raises(exception, match=text):
        trocar.Scenario.load("paper/augmented", **{"recording.file": recording})
    with pytest.raises(exception, match=text):
        trocar.detect(recording)


def test_a_gap_is_reported_and_the_scenario_limits_the_samples():
    data = trocar.record()
    gap = {name: np.delete(column, slice(3000, 3100)) for name, column in data.items()}
    with pytest.raises(trocar.ScenarioError, match="no sample for 0.101"):
        trocar.Scenario.load("paper/augmented", **{"recording.file": gap})
    trocar.Scenario.load("paper/augmented", **{"recording.file": gap, "recording.max_gap_s": 0.2})
    with pytest.raises(TypeError, match="^force missing"):
        trocar.detect(data["time_s"], data["position_m"])


def test_a_scenario_keeps_the_files_that_it_was_loaded_from(tmp_path):
    frame = trocar.record(2)
    table = tmp_path / "recording.csv"
    rows = zip(frame["time_s"], frame["position_m"], frame["force_n"])
    table.write_text("time_s,position_m,force_n\n" + "".join(f"{t!r},{x!r},{f!r}\n" for t, x, f in ((*map(float, row),) for row in rows)))
    file = tmp_path / "mine.toml"
    file.write_text('base = "builtin:paper/augmented"\n[recording]\nfile = "recording.csv"\nruptures_s = []\n[recording.columns]\nvelocity_m_per_s = ""\n')
    scenario = trocar.Scenario.load(file)
    expected = trocar.run(scenario.replace(**{"scaling.force": 0.5})).metrics
    table.write_text("time_s,position_m,force_n\n0,0,0\n1,1,1\n")
    file.unlink()
    assert trocar.run(scenario.replace(**{"scaling.force": 0.5})).metrics == expected
    with pytest.raises(trocar.ScenarioError):
        trocar.Scenario.load(file)


def test_a_pickled_scenario_has_the_content_of_its_files(tmp_path):
    frame = trocar.record(2)
    table, base, file = (tmp_path / name for name in ("recording.csv", "base.toml", "mine.toml"))
    rows = zip(frame["time_s"], frame["position_m"], frame["force_n"])
    table.write_text("time_s,position_m,force_n\n" + "".join(f"{t!r},{x!r},{f!r}\n" for t, x, f in ((*map(float, row),) for row in rows)))
    base.write_text(
        'base = "builtin:paper/augmented"\n[recording]\nfile = "recording.csv"\nruptures_s = []\n[recording.columns]\nvelocity_m_per_s = ""\n'
    )
    file.write_text('base = "base.toml"\n[scaling]\nforce = 0.8\n')
    scenario = trocar.Scenario.load(file)
    expected = trocar.run(scenario)
    kept = tmp_path / "run.npz"
    expected.save(kept)
    rows = trocar.sweep(scenario, {"scaling.position": [0.5, 1.0]})
    sent = pickle.dumps(scenario)
    file.write_text('base = "base.toml"\n[scaling]\nforce = 2.0\n')
    changed = trocar.Scenario.load(file)
    assert changed != scenario and pickle.dumps(changed) != sent
    for path in (table, base, file):
        path.unlink()
    for again in (pickle.loads(sent), copy.copy(scenario), copy.deepcopy(scenario), trocar.load(kept).scenario):
        assert again == scenario and again["scaling.force"] == 0.8
        assert trocar.run(again).metrics == expected.metrics
    assert pickle.loads(sent).replace(scaling={"force": 0.5})["scaling.force"] == 0.5
    for again in (scenario, pickle.loads(sent)):
        swept = trocar.sweep(again, {"scaling.position": [0.5, 1.0]})
        assert swept.hash == rows.hash and np.array_equal(swept["tracking_rmse_m"], rows["tracking_rmse_m"])


def test_a_sweep_takes_recordings_in_memory():
    frames = [trocar.record(seed) for seed in (2, 3)]
    alone = [trocar.run(trocar.Scenario.load("paper/augmented", **{"recording.file": frame})).metrics for frame in frames]
    of_set = trocar.sweep("paper/augmented", {"scaling.force": [1.0]}, set={"recording": {"file": frames[0]}})
    assert of_set["tracking_rmse_m"].tolist() == [alone[0]["tracking_rmse_m"]]
    assert trocar.sweep("paper/augmented", {"scaling.force": [1.0]}, set={"recording.file": frames[0]}).hash == of_set.hash
