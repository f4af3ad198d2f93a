"""Typical use in notebooks."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import trocar


@pytest.fixture(scope="module")
def run():
    return trocar.run("paper/augmented")


def test_a_scenario_reads_like_a_dictionary():
    scenario = trocar.Scenario.from_dict({"base": "paper/classical", "scaling": {"force": 2}, "slave.numerator": np.array([7.0, 650.0])})
    assert scenario["scaling.force"] == 2.0
    assert scenario["slave"]["numerator"] == [7.0, 650.0]
    assert trocar.Scenario.load("layers/skin-augmented")["tissue.layer.skin.thickness_m"] == 0.002
    assert scenario.to_dict()["scaling"]["force"] == 2.0
    with pytest.raises(KeyError):
        scenario["scaling.colour"]
    assert trocar.Scenario.from_dict(scenario.to_dict()) == scenario
    assert scenario.duration_s == pytest.approx(17.0)
    assert trocar.Scenario.load("paper/classical").rupture_times_s == [5.52, 8.85]
    with pytest.raises(AttributeError):
        scenario.name = "other"


def test_a_scenario_reports_which_keys_it_has():
    scenario = trocar.Scenario.load("paper/classical")
    assert "scaling.force" in scenario and "scaling" in scenario
    assert "scaling.forces" not in scenario and 3 not in scenario
    with pytest.raises(TypeError, match="not iterable"):
        iter(scenario)


def test_replacing_keeps_the_original_and_updates_derived_defaults():
    first = trocar.Scenario.load("paper/classical")
    second = first.replace(**{"scaling.force": 2.0}).replace(**{"scaling.force": np.float32(0.5)})
    assert (first["scaling.force"], second["scaling.force"]) == (1.0, 0.5)
    assert first.replace(**{"simulation.duration_s": 2.0}).ticks == 2000


@pytest.mark.parametrize("name", ["paper/augmented", "text"])
def test_scenarios_can_be_pickled(name):
    scenario = trocar.Scenario.from_dict({"base": "paper/augmented"}) if name == "text" else trocar.Scenario.load(name)
    changed = scenario.replace(**{"scaling.force": 0.5})
    again = pickle.loads(pickle.dumps(changed))
    assert again == changed and hash(again) == hash(changed)
    assert again.replace(**{"scaling.force": 1.0})["scaling.force"] == 1.0


def test_a_later_change_may_switch_off_what_an_earlier_one_sets():
    amplified = trocar.Scenario.load("paper/augmented").replace(**{"augmentation.force_law": "amplify"})
    classical = amplified.replace(**{"augmentation.enabled": False})
    again = pickle.loads(pickle.dumps(classical)).replace(**{"augmentation.enabled": True})
    assert again == amplified
    with pytest.raises(trocar.ScenarioError, match="augmentation.force_law has no effect"):
        classical.replace(**{"augmentation.force_law": "amplify"})


def test_traces_are_arrays_without_a_copy(run):
    assert all(column.shape == (17000,) for column in run.traces.values())
    kinds = {name: column.dtype for name, column in run.traces.items()}
    assert kinds.pop("mode") == kinds.pop("estimate_flags") == np.uint8 and set(kinds.values()) == {np.dtype(np.float64)}
    # numpy does not own this memory: it belongs to the computed vector.
    assert all(not column.flags.owndata and not column.flags.writeable for column in run.traces.values())


def test_the_columns_of_a_trace_are_listed(run):
    assert list(trocar.trace_columns()) == list(run.traces)
    assert trocar.trace_columns()["slave_position_m"][0] == "m" and run["mode"].dtype == np.uint8


def test_a_run_is_shown_as_a_frame_a_figure_and_a_table(run):
    frame = run.to_dataframe()
    assert frame.shape == (17000, 24) and frame.index.name == "time_s"
    assert len(run.plot(figsize=(4, 6)).axes) == 2
    assert run._repr_html_().startswith("<table>") and "detection delay" in run._repr_html_()
    assert "detection delay" in str(run) and repr(run) == "Run('augmented', 17000 ticks)"
    assert [event["frozen_motion_m"] < 1e-4 for event in run.events] == [True, True]
    assert len(run.ruptures) == 2 and run.alarms_s.shape == (2,)


def test_some_shipped_scenarios_have_an_extra_column():
    run = trocar.run(trocar.Scenario.load("paper/classical", **{"estimator.parameters": "stiffness-damping-friction"}))
    assert run["friction_n"].shape == run["time_s"].shape
    assert run.summary["further_estimate"]["column"] == "friction_n"


def test_a_run_that_diverges_is_a_result():
    run = trocar.run(trocar.Scenario.load("paper/classical", **{"scaling.force": 1000.0}))
    assert run.metrics["outcome"]["kind"] == "diverged"
    assert len(run["time_s"]) < 17000


def test_a_comparison_is_shown_as_a_table_and_a_figure():
    comparison = trocar.compare()
    assert [fact["holds"] for fact in comparison.facts] == [True] * len(comparison.facts)
    frame = comparison.to_dataframe()
    assert list(frame.columns) == ["unit", "classical", "augmented"]
    assert frame.index[0] == "rupture_1_slave_travel_m"
    assert len(comparison.plot().axes) == 2
    assert "<table>" in comparison._repr_html_() and "augmented" in str(comparison)
    assert trocar.compare("paper/classical").facts is None
    with pytest.raises(ValueError, match="seeds is 1"):
        trocar.compare(seeds=1)


def test_a_detection_and_a_calibration_are_shown_as_tables_and_figures(recording):
    columns = [recording[name] for name in ("time_s", "position_m", "velocity_m_per_s", "force_n")]
    found = trocar.detect(*columns, contact_m=0.012, ruptures_s=[5.52, 8.85])
    frame = found.to_dataframe()
    assert frame["alarm"].sum() == 2 and len(found.plot().axes) == 2
    assert found.report["missed_ruptures"] == 0 and "5.527" in found._repr_html_()
    calibration = trocar.calibrate(*columns)
    assert "<table>" in calibration._repr_html_() and "[detector]" in calibration.toml
    with pytest.raises(ValueError, match="first_s|first-s"):
        trocar.calibrate(*columns, first_s=-1.0)


def test_a_sweep_is_a_frame_and_its_settings_override_the_scenario():
    base = trocar.Scenario.load("paper/augmented", **{"scaling.force": 3.0, "simulation.duration_s": 9.0})
    sweep = trocar.sweep(base, {"scaling.force": np.array([0.5, 1.0])}, set={"simulation.duration_s": 6.0})
    assert list(sweep["scaling.force"]) == [0.5, 1.0]
    frame = sweep.to_dataframe()
    assert frame.index.name == "case" and set(frame["outcome"]) == {"completed"}
    assert "2 cases" in sweep._repr_html_() and len(sweep) == 2
    alone = trocar.run(base.replace(**{"scaling.force": 0.5, "simulation.duration_s": 6.0}))
    assert sweep["tissue_energy_j"][0] == alone.metrics["tissue_energy_j"]
    spread = trocar.sweep(base, {"scaling.position": trocar.Range(0.5, 1.0)}, design="sobol", points=4, threads=2)
    assert len(set(spread["scaling.position"])) == 4


def test_the_boundary_of_a_map_separates_decaying_from_growing_loops():
    stability = trocar.stability(x="scaling.force=0.1:20:8", y="tissue.stiffness_n_per_m=10:4000:9")
    assert stability.is_stable and stability.plot().axes
    assert stability.boundary.shape[1:] == (2, 2) and stability.simulated is None
    assert "<table>" in stability._repr_html_() and "gain margin" in str(stability)
    # A loop in a softer spring decays, and a loop in a stiffer spring grows. The recorded force has no damping.
    largest = stability.largest_stable["tissue.stiffness_n_per_m"]
    for stiffness, is_stable in (((1 - 1e-6) * largest, True), ((1 + 1e-6) * largest, False)):
        spring = {"tissue.kind": "kelvin-voigt", "tissue.stiffness_n_per_m": stiffness, "tissue.damping_n_s_per_m": 0.0}
        poles = trocar.state_space(trocar.Scenario.load("paper/depth-classical", **spring), "closed-loop").poles()
        assert (np.abs(poles).max() < 1) == is_stable


def test_the_lock_is_released_while_computing():
    """Another thread continues while a sweep runs."""
    ticks, done = [], threading.Event()

    def count():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begun = time.monotonic()
    trocar.sweep("layers/through-the-skin", {"scaling.force": trocar.Range(0.5, 2.0, 2000)}, threads=1)
    lasted = time.monotonic() - begun
    done.set()
    thread.join()
    within = [tick for tick in ticks if begun <= tick <= begun + lasted]
    assert len(within) > 5 and max(np.diff([begun, *within, begun + lasted])) < max(0.5 * lasted, 0.05)


INTERRUPTED = """
import signal, sys, time, trocar
# A test run started in the background ignores Ctrl-C, and this process inherits that.
signal.signal(signal.SIGINT, signal.default_int_handler)
def long():
    kind = sys.argv[1]
    if kind == "run":
        trocar.run(trocar.Scenario.load("layers/through-the-skin", **{
            "simulation.engine": "dop853", "simulation.tick_s": 1e-4, "simulation.duration_s": 190.0}))
    elif kind == "sweep":
        trocar.sweep("layers/through-the-skin", {"scaling.force": trocar.Range(0.5, 2.0, 1000000)})
    elif kind == "compare":
        trocar.compare("layers/through-the-skin", seeds=100000)
    else:
        trocar.stability(x="scaling.force=0.1:10:2000", y="tissue.stiffness_n_per_m=10:2000:2000")
print("begun", flush=True)
begun = time.monotonic()
try:
    long()
except KeyboardInterrupt:
    print("interrupted", flush=True)
    # Remaining computations must not keep the process alive.
    sys.exit(7)
print("not interrupted")
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize("kind", ["run", "sweep", "compare", "stability"])
def test_control_c_ends_a_long_call(kind):
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTED, kind], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    out, _ = process.communicate(timeout=60)
    assert (out, process.returncode) == ("interrupted\n", 7)
    assert time.monotonic() - begun < 10


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_computes_too():
    """The threads of a pool do not exist after a fork, so no call may wait for them."""
    text = (
        "import os, trocar\n"
        "trocar.compare()\n"
        "child = os.fork()\n"
        "if child == 0:\n"
        "    trocar.compare()\n"
        "    trocar.stability(x='scaling.force=1:2:3', y='tissue.stiffness_n_per_m=10:20:3')\n"
        "    trocar.sweep('paper/augmented', {'scaling.force': [1.0]})\n"
        "    os._exit(3)\n"
        "raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    assert subprocess.run([sys.executable, "-W", "ignore", "-c", text], timeout=120).returncode == 3


def test_keys_and_metrics_are_listed():
    kind, default, meaning = trocar.keys()["scaling.force"]
    assert default == "1.0" and "number" in kind and meaning
    assert "false_alarms" in list(trocar.metrics())
    scope, label, unit, better, meaning = trocar.metrics()["rupture_1_detection_delay_s"]
    assert (scope, label, unit, better) == ("rupture", "rupture 1: detection delay", "s", "lower") and meaning.endswith(".")
    assert trocar.__version__


@pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
def test_a_run_has_the_metrics_of_a_sweep_by_their_names(tmp_path):
    names = ["max_slave_overshoot_m", "rupture_2_excess_advance_m", "false_alarms"]
    run = trocar.run("layers/skin-augmented")
    seeds = [run.scenario["simulation.seed"]]
    sweep = trocar.sweep("layers/skin-augmented", {"scaling.force": [1.0]}, seeds=seeds, metrics=names)
    assert [run.metric(name) for name in names] == [sweep[name][0] for name in names]
    run.save(tmp_path / "run.npz")
    assert trocar.load(tmp_path / "run.npz").metric(names[0]) == run.metric(names[0])
    with pytest.raises(KeyError, match="this run has 3 ruptures"):
        run.metric("rupture_7_excess_advance_m")


@pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
def test_a_class_of_parts_is_reset_like_its_objects():
    class Gel:
        def reset(self):
            self.broken = False

        def step(self, tick, position_m, velocity_m_per_s):
            force_n = 0.0 if self.broken else 400.0 * max(position_m, 0.0)
            self.broken |= force_n > 2.0
            return force_n

    of_class, of_object = (trocar.run("layers/skin-augmented", tissue=part) for part in (Gel, Gel()))
    assert (of_class["tissue_force_n"] == of_object["tissue_force_n"]).all()


def test_margins_print_what_they_are():
    text = str(trocar.margins("layers/skin-augmented"))
    assert "gain: 2.85" in text and "delay_s: " in text and "limit of scaling.force: " in text
