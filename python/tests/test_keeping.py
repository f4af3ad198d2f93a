"""Results are mappings of their columns, can be pickled and saved, and draw on given axes."""

import copy
import json
import multiprocessing
import pickle

import numpy as np
import pytest

import trocar

SHORT = {"simulation.duration_s": 6.5}


@pytest.fixture(scope="module")
def run():
    return trocar.run(trocar.Scenario.load("paper/augmented", **SHORT))


def again(value):
    return pickle.loads(pickle.dumps(value))


def same_run(one, other):
    assert list(one) == list(other) and all(np.array_equal(one[name], other[name]) for name in one)
    assert one.summary == other.summary and str(one) == str(other) and one.events == other.events
    assert one.scenario == other.scenario and one._repr_html_() == other._repr_html_()


def test_a_result_is_a_mapping_of_its_columns(run):
    found = trocar.detect(**{name.partition("_")[0]: column for name, column in trocar.record().items()}, contact_m=0.012)
    sweep = trocar.sweep("paper/augmented", {"scaling.force": [0.5, 1.0]}, set=SHORT)
    for result in (run, found, sweep):
        names = list(result)
        assert names == list(result.keys()) and all(name in result for name in names) and "x" not in result
        assert all(column is result[name] for name, column in result.items())
        with pytest.raises(KeyError, match="no column 'x'; the columns are"):
            result["x"]
    assert dict(run) == run.traces and len(run) == len(run.traces) and len(sweep) == 2


def test_everything_can_be_pickled_and_copied(run):
    same_run(again(run), run)
    same_run(again(again(run)), run)
    same_run(copy.deepcopy(run), run)
    comparison = trocar.compare(run.scenario)
    other = again(comparison)
    assert other.report == comparison.report and str(other) == str(comparison)
    same_run(other.runs[0], comparison.runs[0])
    for side in ("master", "closed-loop"):
        system = trocar.state_space(run.scenario, side)
        assert np.array_equal(again(system).A, system.A) and np.array_equal(copy.copy(system).poles(), system.poles())
    step = trocar.Detector(0.001).step(0.01, 0.02, 0.3)
    assert repr(again(step)) == repr(step) and again(step).depth_m == step.depth_m
    command = trocar.HapticController("paper/augmented").step(0.01, None, 0.0, 1.0)
    assert repr(again(command)) == repr(command) and again(command).faults == command.faults == ["slave_position"]
    assert copy.copy(command).mode == command.mode
    stability = trocar.stability(x="scaling.force=0.1:10:3", y="tissue.stiffness_n_per_m=10:2000:3")
    assert np.array_equal(again(stability).stable, stability.stable)


def test_a_copied_detector_continues_from_the_same_state():
    data = trocar.record()
    part = [data[name] for name in ("position_m", "velocity_m_per_s", "force_n")]
    detector = again(trocar.Detector(0.001, contact_m=0.012))
    detector.steps(*(column[:5000] for column in part))
    others = [copy.copy(detector), again(detector), again(again(detector))]
    results = [one.steps(*(column[5000:9000] for column in part)) for one in (detector, *others)]
    for columns, alarms in results:
        assert np.array_equal(columns["decision"], results[0][0]["decision"]) and len(alarms) >= 1
    assert [one.samples for one in others] == [9000] * 3


@pytest.mark.parametrize("velocity", ["measured", "filtered"])
@pytest.mark.parametrize("estimator", ["stiffness-and-damping", "stiffness-damping-friction", "hunt-crossley", "least-residual"])
def test_a_pickled_detector_continues_with_every_estimator(estimator, velocity):
    data = trocar.record()
    position, force = data["position_m"], data["force_n"] + 0.01 * np.random.default_rng(1).standard_normal(len(data["force_n"]))
    speed = data["velocity_m_per_s"] if velocity == "measured" else None
    settings = {"estimator.parameters": estimator, "detector.distance": "squared-residual"}
    goes_on_when_pickled(trocar.Detector(0.001, contact_m=0.012, velocity=velocity, **settings), position, speed, force)


@pytest.mark.parametrize("forgetting", ["exponential", "resetting"])
def test_a_pickled_detector_continues_with_either_forgetting(forgetting):
    data = trocar.record()
    settings = {"estimator.forgetting": forgetting, "detector.distance": "squared-residual"}
    detector = trocar.Detector(0.001, contact_m=0.012, **settings)
    goes_on_when_pickled(detector, data["position_m"], data["velocity_m_per_s"], data["force_n"])


def test_a_pickled_detector_continues_with_every_distance(cli):
    data = trocar.record()
    schema = json.loads(cli("schema").stdout)
    distances = schema["properties"]["detector"]["properties"]["distance"]["enum"]
    assert "adaptive" in distances and len(distances) >= 10
    for distance in distances:
        detector = trocar.Detector(0.001, contact_m=0.012, **{"detector.distance": distance})
        goes_on_when_pickled(detector, data["position_m"], data["velocity_m_per_s"], data["force_n"])


def goes_on_when_pickled(detector, position, velocity, force):
    """Pickles a detector in free motion, in contact, and at and after a rupture; it must continue with identical
    bits."""
    begun = 0
    for end in (100, 4001, 5523, 5530, 8853, len(position)):
        part = slice(begun, end)
        other = again(detector)
        columns = [
            one.steps(position[part], None if velocity is None else velocity[part], force[part])[0] for one in (detector, other)
        ]
        for name, column in columns[0].items():
            assert column.tobytes() == columns[1][name].tobytes(), (name, end)
        detector, begun = other, end


def test_processes_return_runs(run):
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        runs = pool.map(trocar.run, [run.scenario] * 2)
    for one in runs:
        same_run(one, run)


def test_joblib_caches_runs(run, tmp_path):
    joblib = pytest.importorskip("joblib")
    kept = joblib.Memory(tmp_path, verbose=0).cache(trocar.run)
    kept(run.scenario)
    assert kept.check_call_in_cache(run.scenario)
    same_run(kept(run.scenario), run)


def test_a_saved_run_is_loaded_again(run, tmp_path):
    path = tmp_path / "run.npz"
    run.save(path)
    same_run(trocar.load(path), run)
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(ValueError, match="other.npz is not a run that Run.save wrote"):
        trocar.load(tmp_path / "other.npz")


def test_every_result_is_saved_and_loaded_again(tmp_path):
    def kept(result):
        path = tmp_path / "kept.npz"
        result.save(path)
        found = type(result).load(path)
        assert found.report == result.report and str(found) == str(result) and repr(found) == repr(result)
        assert found._repr_html_() == result._repr_html_() and not list(tmp_path.glob("*.partial"))
        return found

    given = trocar.record()
    mine = trocar.Scenario({"operator": {"kind": "ramp"}, "tissue": {"kind": "recording"}, "recording": {"file": given}})
    comparison = trocar.compare("paper/augmented", mine)
    found = kept(comparison)
    for one, other in zip(found.runs, comparison.runs, strict=True):
        same_run(one, other)
    assert found.to_dataframe().equals(comparison.to_dataframe())
    axes = {"x": "scaling.force=0.1:10:3", "y": "tissue.stiffness_n_per_m=10:2000:4"}
    for simulate in (False, True):
        stability = trocar.stability(**axes, simulate=simulate)
        found = kept(stability)
        for name in ("x", "y", "stable", "boundary", "simulated"):
            one, other = getattr(found, name), getattr(stability, name)
            assert np.array_equal(one, other) and getattr(one, "dtype", None) == getattr(other, "dtype", None)
    judged = trocar.roc(detectors={"never": lambda *_: False, "adaptive": None}, seeds=2, thresholds=3)
    assert kept(judged).curves == judged.curves
    calibration = trocar.calibrate(given, contact_m=0.012)
    found = kept(calibration)
    assert found.settings == calibration.settings and found.toml == calibration.toml
    for kind in (trocar.results.Roc, trocar.results.Stability, trocar.results.Comparison, trocar.results.Detection, trocar.Sweep):
        with pytest.raises(ValueError, match=f"kept.npz is not a {kind.__name__.lower()} that {kind.__name__}.save wrote"):
            kind.load(tmp_path / "kept.npz")


def test_a_trace_is_an_xarray_with_units(run):
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert data["slave_position_m"].attrs["units"] == "m" and data["slave_position_m"].dims == ("time_s",)
    assert np.array_equal(data["tissue_force_n"].values, run["tissue_force_n"])


def test_a_detection_and_a_sweep_have_units_and_can_be_saved(tmp_path):
    pytest.importorskip("xarray")
    found = trocar.detect(trocar.record(), contact_m=0.012)
    assert found.to_xarray()["residual_n"].attrs["units"] == "N" and found.to_xarray()["position_m"].attrs["units"] == "m"
    found.save(tmp_path / "found.npz")
    again = trocar.results.Detection.load(tmp_path / "found.npz")
    assert again.report == found.report and str(again) == str(found) and list(again) == list(found)
    assert np.array_equal(again.alarms, found.alarms) and np.array_equal(again["decision"], found["decision"])
    sweep = trocar.sweep("paper/augmented", {"scaling.force": [0.5, 1.0]}, set=SHORT)
    data = sweep.to_xarray()
    assert data["tracking_rmse_m"].attrs["units"] == "m" and data["scaling.force"].values.tolist() == [0.5, 1.0]


def test_figures_are_drawn_on_given_axes(run):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    figure, axes = pyplot.subplots(2)
    assert run.plot("parameters", ax=axes) is figure and axes[0].get_ylabel() == "Stiffness (N/m)"
    with pytest.raises(ValueError, match="ax has 1 axes, must have 2"):
        run.plot("parameters", ax=axes[0])
    with pytest.raises(ValueError, match='figure is "stiffness", must be one of comparison, overlay, estimation'):
        run.plot("stiffness")
    with pytest.raises(TypeError, match="with ax, figsize would have no effect"):
        run.plot(ax=axes, figsize=(1, 1))
    pyplot.close("all")


def test_figures_equal_those_of_the_command_line(run, tmp_path):
    """Each line of a figure has the data of the run, and the colours and captions of the command line."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    from trocar import _core

    for name in _core.figure_names()[0]:
        figure = run.plot(name)
        drawn = [axis for axis in figure.axes if axis.lines or axis.patches]
        assert drawn and all(axis.get_ylabel() for axis in drawn), name
    figure = run.plot("decision", window=(0.0, 1.0))
    (line,) = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 100]
    at = np.searchsorted(run["time_s"], line.get_xdata())
    assert np.array_equal(run["decision"][at], line.get_ydata())
    # Decimation keeps the extremes.
    assert line.get_ydata().max() == run["decision"].max()
    assert [level for level in figure.axes[0].lines if level.get_color() == "#cc79a7"], "the threshold"
    loaded = tmp_path / "run.npz"
    run.save(loaded)
    assert len(trocar.load(loaded).plot("comparison").axes) == len(run.plot().axes)
    pyplot.close("all")


def test_alarms_are_scored_in_any_order():
    scores = trocar.score([5.0, 1.1, 9.0], [9.9, 1.0, 4.9], within_s=0.2, recorded_s=30.0)
    assert scores["matches"] == [(1, 1), (2, 0)] and scores["found"] == 2 and scores["missed"] == 1
    assert scores["false_alarms_per_minute"] == 2.0 and scores["max_delay_s"] == pytest.approx(0.1)
    assert trocar.score([], [])["precision"] is None
    for wrong in ({"within_s": -1.0}, {"recorded_s": 0.0}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            trocar.score([1.0], [1.0], **wrong)
    with pytest.raises(ValueError, match="alarms_s has NaN"):
        trocar.score([np.nan], [1.0])


def test_a_scenario_is_created_from_a_dictionary_and_changed_by_nested_keywords():
    scenario = trocar.Scenario({"base": "paper/augmented", "scaling": {"force": 0.8}}, "soft")
    assert scenario == trocar.Scenario.from_dict({"base": "paper/augmented", "scaling.force": 0.8}, "soft")
    changed = scenario.replace(scaling={"force": 0.9}, tissue={"index": "depth"})
    assert (changed["scaling.force"], changed["tissue.index"], changed.name) == (0.9, "depth", scenario.name)
    with pytest.raises(TypeError, match="created from a dictionary, not from 'paper/augmented'"):
        trocar.Scenario("paper/augmented")


@pytest.mark.parametrize("load", [trocar.load, trocar.Sweep.load])
def test_a_damaged_file_is_reported(load, run, tmp_path):
    path = tmp_path / "whole.npz"
    if load is trocar.load:
        run.save(path)
    else:
        trocar.sweep("paper/classical", {"scaling.force": [1.0, 2.0]}).save(path)
    content = path.read_bytes()
    changed = tmp_path / "changed.npz"
    for bad in [b"", b"text", content[: len(content) // 2], content[:50] + b"\0" * 30 + content[80:], b"PK\3\4" + bytes(100)]:
        changed.write_bytes(bad)
        with pytest.raises(ValueError, match="changed.npz is not a"):
            load(changed)
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "nothing.npz")
