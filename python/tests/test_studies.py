"""Studies of the command line in Python: patients, strategies, schemes, identification, margins, measured responses."""

import math

import numpy as np
import polars
import pytest

import trocar


@pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
def test_patients_are_the_points_of_the_shipped_sweep():
    patients = trocar.patients(3)
    few = trocar.sweep(patients, {"scaling.force": [0.5, 1.0]}, seeds=2, metrics=["max_slave_overshoot_m"])
    assert few["patient"].tolist() == [1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]
    data = few.to_xarray()
    assert dict(data.sizes) == {"patient": 3, "scaling.force": 2, "seed": 2} and data["arm.grip"].dims == ("patient",)
    # The same case by hand.
    case = next(at for at in range(len(few)) if few["patient"][at] == 2 and few["scaling.force"][at] == 1.0)
    run = trocar.run(patients[1].replace(**{"scaling.force": 1.0, "simulation.seed": int(few["seed"][case])}))
    assert max(rupture["slave_overshoot_m"] for rupture in run.ruptures) == few["max_slave_overshoot_m"][case]
    assert trocar.patients(2)["operator.movement_s"].tolist() == patients["operator.movement_s"][:2].tolist()
    assert polars.DataFrame(patients).columns == list(patients.keys())
    assert [scenario.name for scenario in patients][2] == "skin-augmented-patient-3"


def test_a_shipped_sweep_runs_by_its_name():
    assert "builtin:sweeps/small.toml" in trocar.shipped()
    assert len(trocar.sweep("builtin:sweeps/small.toml")) == 100
    with pytest.raises(ValueError, match="patients are points"):
        trocar.sweep(trocar.patients(2), points=[{"scaling.force": 1.0}])
    with pytest.raises(ValueError, match="cannot be an axis as well"):
        trocar.sweep(trocar.patients(2), {"arm.grip": ["firm"]})


def test_a_population_is_drawn_or_refused():
    people = trocar.Scenario.load("layers/skin-augmented", **{"population.arm": "people", "population.delay": "uniform"})
    with pytest.raises(ValueError, match="trocar.patients"):
        trocar.sweep(people, {"scaling.force": [1.0]})
    patients = trocar.patients(4, people)
    assert len(set(patients["arm.k_a_n_per_m"])) == 4 and "channel.forward_delay_s" in patients.drawn
    swept = trocar.sweep(patients, {"scaling.force": [1.0]}, metrics=["max_slave_overshoot_m"])
    assert len(set(swept["max_slave_overshoot_m"])) == 4
    with pytest.raises(ValueError, match="not|population.tissue"):
        trocar.patients(4, people.replace(**{"population.tissue": "log-normal"}))
    with pytest.raises(ValueError, match="draws nothing"):
        trocar.patients(4, "layers/skin-augmented")


def test_strategies_are_those_of_the_command_line(cli, tmp_path):
    study = trocar.strategies(seeds=2, persons="attentive")
    said = cli("strategies", "--seeds", 2, "--persons", "attentive", "--json", "--out", tmp_path)
    import json

    assert study.report == json.loads(said.stdout)
    assert study.to_dataframe().loc["none", "ruptures"] == study["none"]["ruptures"]
    with pytest.raises(ValueError, match="there is no person"):
        trocar.strategies(persons=["nobody"])
    with pytest.raises(KeyError, match="the strategies are"):
        study["nothing"]


@pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
def test_passivity_schemes_are_compared():
    comparison = trocar.compare("link/long-delay", schemes=True)
    assert [run.scenario.name for run in comparison.runs][0] == "long-delay-none" and "schemes" in comparison.document.tables
    assert comparison.runs[1].scenario["passivity.scheme"] == "time-domain"
    with pytest.raises(ValueError, match="of one scenario"):
        trocar.compare(schemes=True)
    pair = ["paper/classical", trocar.Scenario.load("paper/augmented")]
    assert repr(trocar.compare(pair)) == repr(trocar.compare(*pair)) == "Comparison(classical, augmented)"
    with pytest.raises(TypeError, match="a scenario is 3"):
        trocar.compare(3)
    with pytest.raises(ValueError, match="no scenario"):
        trocar.compare([])


def moved(rate_hz=1000.0, duration_s=5.0):
    time_s = np.arange(0.0, duration_s, 1.0 / rate_hz)
    return time_s, sum(0.004 * np.sin(2 * np.pi * f * time_s + f) for f in (0.7, 1.9, 4.3))


@pytest.mark.parametrize("machine", ["tissue", "arm", "master", "slave"])
def test_machines_are_identified_from_tables(machine):
    time_s, position_m = moved()
    if machine == "tissue":
        depth_m = 0.01 * (1 - np.cos(np.pi * time_s))
        found = trocar.identify({"t": time_s, "z_mm": 1e3 * depth_m, "f": 250.0 * depth_m}, machine="tissue", time="t", slave="z_mm:mm", force="f")
        assert found.parameters["stiffness_n_per_m"]["value"] == pytest.approx(250.0, rel=0.02)
    elif machine == "arm":
        velocity = np.gradient(position_m, time_s)
        table = polars.DataFrame({"time_s": time_s, "x": position_m, "force_n": -(400.0 * position_m + 6.0 * velocity)})
        found = trocar.identify(table, machine="arm", master="x")
        assert "arm.toml" in found.files
    else:
        # A mass of 0.5 kg with friction, driven by a motor or by a controller.
        mass, friction, force = 0.5, 4.0, sum(np.sin(2 * np.pi * f * time_s) for f in (0.9, 2.3, 5.1))
        x, u, v, master = np.zeros_like(time_s), np.zeros_like(time_s), 0.0, position_m - position_m[0]
        speed = np.gradient(master, time_s)
        for k in range(1, len(time_s)):
            u[k - 1] = force[k - 1] if machine == "master" else 900.0 * (master[k - 1] - x[k - 1]) + 30.0 * (speed[k - 1] - v)
            v += 1e-3 * (u[k - 1] - friction * v) / mass
            x[k] = x[k - 1] + 1e-3 * v
        if machine == "master":
            table = {"time_s": time_s, "x": x, "force_n": 1e-3 * np.sin(7 * time_s), "u": u}
            found = trocar.identify(table, machine="master", master="x", actuator="u")
            assert found.parameters["mass_kg"]["value"] == pytest.approx(mass, rel=0.1)
        else:
            table = {"time_s": time_s, "m": master, "s": x, "force_n": np.zeros_like(x), "u": u}
            found = trocar.identify([table], machine="slave", master="m", slave="s", actuator="u")
            assert found.parameters["mass_kg"]["value"] == pytest.approx(mass, rel=0.1)
    assert found.data and found.document.tables
    assert [fit["recording"] for fit in found.report["fits"]] == ["recording_1.csv"]
    assert trocar.results.Identification._of_kept(*found._kept()).report == found.report


def test_an_error_in_a_table_does_not_name_the_file_that_trocar_writes():
    table = {"time_s": [0.0, 0.1, math.nan], "z": [0.0, 1.0, 2.0], "force_n": [0.0, 1.0, 2.0]}
    with pytest.raises(ValueError, match="^recording_1.csv line 4, column 'time_s': 'nan' is not finite"):
        trocar.identify(table, machine="tissue", slave="z")


def test_a_frame_has_a_number_or_a_word_in_each_cell():
    for frame in (trocar.strategies(seeds=2).to_dataframe(), trocar.roc(detectors=["adaptive"], seeds=2, thresholds=2).to_dataframe()):
        cells = [cell for name in frame.columns for cell in frame[name]]
        assert not any(isinstance(cell, (list, dict)) for cell in cells)
    assert (frame["detection_low"] <= frame["detection"]).all() and (frame["detection"] <= frame["detection_high"]).all()


def test_columns_of_an_identification_are_checked():
    needle = {"time_s": [0.0], "z": [0.0], "force_n": [0.0]}
    for call, text in [
        ({"machine": "tissue", "slave": "z", "master": "z"}, "master is not used"),
        ({"machine": "tissue"}, "needs slave"),
        ({"machine": "wheel"}, "must be \"slave\""),
    ]:
        with pytest.raises(ValueError, match=text):
            trocar.identify(needle, **call)
    with pytest.raises(ValueError, match="no recording"):
        trocar.identify([])
    with pytest.raises(TypeError, match="a path, a table"):
        trocar.identify([3])


@pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
def test_margins_are_those_of_the_analysis():
    axes = {"scaling.force": (0.9, 1.0, 2)}, {"scaling.position": (0.9, 1.0, 2)}
    for name in ("paper/classical", "link/four-channel"):
        margins, report = trocar.margins(name), trocar.stability(name, *axes).report
        gain = float("inf") if report["margins"]["is_gain_unlimited"] else report["margins"]["gain"]
        assert margins.gain == gain and margins.spectral_radius == report["mode"]["spectral_radius"], name
        for limit in report["limits"]:
            expected = limit["largest_stable"]
            found = margins.limits[limit["parameter"]]
            assert found == pytest.approx(float("inf") if expected is None and found == float("inf") else expected, rel=1e-6), (name, limit)
    assert trocar.margins("paper/classical", limits=False).limits == {}
    with pytest.raises(ValueError, match='the loop has no parameter "scaling.forse"'):
        trocar.margins("paper/classical", limits=["scaling.forse"])


def test_axes_are_ranges_tuples_or_texts():
    forms = [
        ({"scaling.force": trocar.Range(1, 10, 4)}, {"tissue.stiffness_n_per_m": (100, 1000, 3)}),
        ("scaling.force=1:10:4", "tissue.stiffness_n_per_m=100:1000:3"),
    ]
    first, second = (trocar.stability("paper/classical", *form) for form in forms)
    assert first.x.tolist() == second.x.tolist() == [1.0, 4.0, 7.0, 10.0] and (first.stable == second.stable).all()
    logarithmic = trocar.stability("paper/classical", {"scaling.force": trocar.Range(1, 4, 3, log=True)}, forms[1][1])
    assert logarithmic.x.tolist() == pytest.approx([1.0, 2.0, 4.0])
    for wrong, error in [({"scaling.force": 3}, TypeError), (3, TypeError), ({"scaling.force": trocar.Range(1, 2)}, ValueError)]:
        with pytest.raises(error, match="^x "):
            trocar.stability("paper/classical", wrong)


def test_a_measured_response_of_the_slave_gives_the_margins_of_its_model(tmp_path):
    frequency_hz = np.geomspace(0.05, 450.0, 600)
    response = trocar.state_space("paper/classical", "slave").frequency_response(frequency_hz)
    axes = {"scaling.force": (1, 10, 2)}, {"tissue.stiffness_n_per_m": (100, 1000, 2)}
    measured = trocar.stability("paper/classical", *axes, slave_response=(frequency_hz, response)).report["measured"]
    path = tmp_path / "slave.csv"
    rows = np.column_stack([frequency_hz, np.abs(response), np.unwrap(np.angle(response))])
    np.savetxt(path, rows, delimiter=",", header="frequency_hz,magnitude,phase_rad", comments="")
    of_file = trocar.stability("paper/classical", *axes, slave_response=path).report["measured"]
    assert of_file["verdict"] == measured["verdict"] == "stable" and of_file["range_hz"] == pytest.approx(measured["range_hz"])
    with pytest.raises(ValueError, match="slave_response must have"):
        trocar.stability("paper/classical", *axes, slave_response=([2.0, 1.0], [1.0, 1.0]))
    with pytest.raises(ValueError, match="frequencies and responses with the shape"):
        trocar.stability("paper/classical", *axes, slave_response=([1.0, 2.0], [1.0]))


DESIGN = {
    "base": "builtin:layers/skin-augmented.toml",
    "set": {"simulation.duration_s": 3.5},
    "patients": {"operator.movement_s": trocar.Range(4.0, 6.0), "tissue.layer.skin.rupture_force_n": {"median": 5.3, "spread": 1.2}},
    "free": {"augmentation.min_hold_s": trocar.Range(0.05, 0.4), "augmentation.reengage": ["ramp", "snap"]},
    "objectives": {"excess": {"minimise": "rupture_excess_advance_m"}},
    "constraints": {"force": {"metric": "max_tissue_force_n", "at_most": 9.0}},
    "training": {"patients": 3},
    "validation": {"patients": 3, "seeds": 2},
    "search": {"candidates": 6, "generations": 2},
}

DESIGN_FILE = """
base = "builtin:layers/skin-augmented.toml"
[set]
simulation.duration_s = 3.5
[patients]
operator.movement_s = { from = 4.0, to = 6.0 }
tissue.layer.skin.rupture_force_n = { median = 5.3, spread = 1.2 }
[free]
augmentation.min_hold_s = { from = 0.05, to = 0.4 }
augmentation.reengage = ["ramp", "snap"]
[objectives.excess]
minimise = "rupture_excess_advance_m"
[constraints.force]
metric = "max_tissue_force_n"
at_most = 9.0
[training]
patients = 3
[validation]
patients = 3
seeds = 2
[search]
candidates = 6
generations = 2
"""


@pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
def test_a_design_is_that_of_the_command_line(cli, tmp_path):
    (tmp_path / "design.toml").write_text(DESIGN_FILE)
    said = cli("design", tmp_path / "design.toml", "--json", "--no-figures", "--out", tmp_path / "out")
    import json

    found = trocar.design(DESIGN, search=tmp_path / "search.json")
    # The dictionary and the file say the same.
    assert found.report == json.loads(said.stdout) and found.files == trocar.design(tmp_path / "design.toml").files
    assert (tmp_path / "search.json").read_text() == (tmp_path / "out/design/search.json").read_text()
    knee = next(one for one in found.designs if one["is_knee"])
    for key, value in knee["settings"].items():
        assert found.scenario[key] == found[knee["name"]][key] == value
    table = found.to_dataframe()
    assert table.loc[knee["name"], "excess"] == knee["validation"][0]["value"]
    found.save(tmp_path / "found.npz")
    assert type(found).load(tmp_path / "found.npz").report == found.report
    # A complete search is not repeated; that of another design is refused.
    assert trocar.design(DESIGN, search=tmp_path / "search.json").report == found.report
    with pytest.raises(ValueError, match="does not hold the search of this design"):
        trocar.design(DESIGN | {"search": {"candidates": 6, "generations": 3}}, search=tmp_path / "search.json")
    with pytest.raises(KeyError, match="the designs are 01"):
        found["99"]
    with pytest.raises(trocar.ScenarioError, match="augmentation.min_hld_s") as refused:
        trocar.design(DESIGN | {"free": {"augmentation.min_hld_s": trocar.Range(0.05, 0.4)}})
    assert "did you mean augmentation.min_hold_s" in str(refused.value)
