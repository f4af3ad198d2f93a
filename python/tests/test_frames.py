"""Tables of other libraries, as inputs and as outputs."""

import gc
import threading

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import trocar

duckdb = pytest.importorskip("duckdb")


@pytest.fixture(scope="module")
def run():
    return trocar.run("layers/skin-augmented")


@pytest.fixture(scope="module")
def sweep():
    axes = {"scaling.force": [0.5, 1.0], "detector.threshold": [5.0, 6.0, 7.0]}
    return trocar.sweep("layers/skin-augmented", axes, seeds=2, metrics=["max_slave_overshoot_m"])


def test_a_run_is_a_table_without_copies(run):
    table = pyarrow.table(run)
    assert table.column_names == list(run)
    for name in ("slave_position_m", "mode"):
        column = table[name].chunk(0).to_numpy(zero_copy_only=True)
        assert column.__array_interface__["data"][0] == run[name].__array_interface__["data"][0], name
        assert np.array_equal(column, run[name])
    assert table.schema.field("slave_position_m").metadata[b"unit"] == b"m"
    frame = polars.DataFrame(run)
    assert frame.columns == list(run) and frame["mode"].dtype == polars.UInt8
    assert np.array_equal(frame["tissue_force_n"].to_numpy(), run["tissue_force_n"])
    assert duckdb.sql("SELECT count(*), max(slave_position_m) FROM run").fetchall() == [(9000, run["slave_position_m"].max())]


def test_a_table_outlives_its_result_and_is_released_in_any_thread():
    table = pyarrow.table(trocar.run("layers/skin-augmented"))
    expected = trocar.run("layers/skin-augmented")["slave_position_m"]
    gc.collect()
    assert np.array_equal(table["slave_position_m"].to_numpy(), expected)
    held = [table]
    del table
    thread = threading.Thread(target=held.clear)
    thread.start()
    thread.join()
    # A capsule that nobody reads, and one that is read twice.
    trocar.run("layers/skin-augmented").__arrow_c_stream__()
    gc.collect()


def test_a_sweep_is_a_table(sweep):
    frame = polars.DataFrame(sweep)
    assert frame.columns == list(sweep) and frame.height == 12
    assert frame["outcome"].to_list() == ["completed"] * 12
    assert pandas.DataFrame(pyarrow.table(sweep).to_pandas())["seed"].tolist() == sweep["seed"].tolist()


def test_tables_of_documents_and_recordings_are_tables(run, tmp_path):
    main = trocar.compare(["layers/through-the-skin", "layers/skin-augmented"]).document.tables["main"]
    assert polars.DataFrame(main).equals(main.to_polars())
    path = tmp_path / "mine.csv"
    run.to_dataframe().to_csv(path)
    recording = trocar.read_recording(path, position="slave_position_m", force="measured_force_n")
    assert polars.DataFrame(recording).columns == ["time_s", "position_m", "force_n"]
    assert recording.to_dataframe().shape == (9000, 2)
    assert len(trocar.detect(**recording).alarms) == len(trocar.detect(polars.DataFrame(recording)).alarms)


def test_undefined_cells_are_null():
    stream = trocar._core.arrow_stream

    class Two:
        def __arrow_c_stream__(self, requested_schema=None):
            return stream([("a", [1.0, None], []), ("b", [None, True], []), ("c", ["ä", None], [("unit", "m")]), ("d", [], [])][:3])

    table = pyarrow.table(Two())
    assert table.to_pylist() == [{"a": 1.0, "b": None, "c": "ä"}, {"a": None, "b": True, "c": None}]
    with pytest.raises(ValueError, match="has 1 values, not 2"):
        stream([("a", [1.0, 2.0], []), ("b", [1.0], [])])
    with pytest.raises(TypeError, match="values of other types"):
        stream([("a", [object()], [])])


@pytest.mark.parametrize("library", ["pandas", "polars", "lazy", "arrow", "duckdb"])
def test_tables_of_every_library_are_accepted(library):
    def table_of(columns):
        frame = pandas.DataFrame(columns)
        if library == "pandas":
            return frame
        if library == "duckdb":
            return duckdb.from_df(frame)
        if library == "arrow":
            return pyarrow.table(columns)
        return polars.DataFrame(columns) if library == "polars" else polars.LazyFrame(columns)

    recording = trocar.record()
    expected = trocar.detect(recording, contact_m=0.012).alarms
    assert np.array_equal(trocar.detect(table_of(recording), contact_m=0.012).alarms, expected)
    scenario = trocar.Scenario.load("paper/classical").replace(**{"recording.file": table_of(recording)})
    assert scenario.ticks == trocar.Scenario.load("paper/classical").ticks
    points = table_of({"site": ["a", "b"], "scaling.force": [0.5, 1.0]})
    swept = trocar.sweep("layers/skin-augmented", points=points, seeds=2, metrics=["detected_ruptures"])
    assert list(swept)[:4] == ["case", "site", "scaling.force", "seed"]
    assert swept["site"].tolist() == ["a", "a", "b", "b"] and swept.labels == ["site"] and swept.axes == ["scaling.force"]


def test_labels_survive_a_file_and_shards(tmp_path):
    points = {"site": ["a", "b", "c"], "scaling.force": [0.5, 0.75, 1.0]}
    whole = trocar.sweep("layers/skin-augmented", points=points, metrics=["detected_ruptures"])
    whole.save(tmp_path / "sweep.npz")
    assert trocar.Sweep.load(tmp_path / "sweep.npz")["site"].tolist() == ["a", "b", "c"]
    call = {"points": points, "metrics": ["detected_ruptures"]}
    parts = [trocar.sweep("layers/skin-augmented", shard=f"{part}/2", **call) for part in (2, 1)]
    assert trocar.Sweep.merge(parts)["site"].tolist() == ["a", "b", "c"]
    with pytest.raises(ValueError, match="the label seed|the label outcome"):
        trocar.sweep("layers/skin-augmented", points={"outcome": ["x"], "scaling.force": [1.0]})
    with pytest.raises(ValueError, match="labels site only"):
        trocar.sweep("layers/skin-augmented", points={"site": ["a"]})
    with pytest.raises(trocar.ScenarioError, match="did you mean scaling.force"):
        trocar.sweep("layers/skin-augmented", points={"scaling.forse": [1.0]})


def test_a_grid_has_its_dimensions(sweep):
    data = sweep.to_xarray()
    assert dict(data.sizes) == {"scaling.force": 2, "detector.threshold": 3, "seed": 2}
    assert data["max_slave_overshoot_m"].attrs["units"] == "m"
    for case in (0, 5, 11):
        at = {"scaling.force": sweep["scaling.force"][case], "detector.threshold": sweep["detector.threshold"][case], "seed": sweep["seed"][case]}
        assert float(data["max_slave_overshoot_m"].sel(at)) == sweep["max_slave_overshoot_m"][case]
    single = trocar.sweep("layers/skin-augmented", {"scaling.force": [1.0], "detector.threshold": [6.0, 7.0]}, metrics=["ruptures"])
    assert dict(single.to_xarray().sizes) == {"scaling.force": 1, "detector.threshold": 2}
    drawn = trocar.sweep(
        "layers/skin-augmented",
        {"scaling.force": trocar.Range(0.5, 1.0), "detector.threshold": trocar.Range(5.0, 7.0)},
        design="random",
        points=4,
        metrics=["ruptures"],
    )
    assert dict(drawn.to_xarray().sizes) == {"case": 4}


def test_arrays_of_results_are_read_only(run, sweep):
    for array in (run["slave_position_m"], run.traces["excitation"], sweep["seed"], trocar.detect(trocar.record())["residual_n"]):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0
    import pickle

    with pytest.raises(ValueError, match="read-only"):
        pickle.loads(pickle.dumps(run))["slave_position_m"][:] = 0
    assert run["slave_position_m"].copy().flags.writeable


def test_a_state_space_is_one_of_scipy():
    signal = pytest.importorskip("scipy.signal")
    loop = trocar.state_space("paper/classical", "closed-loop").to_scipy()
    assert loop.dt == 1e-3
    slave = trocar.state_space("paper/classical", "slave")
    _, response = signal.freqresp(signal.StateSpace(slave.A, slave.B, slave.C[:1], slave.D[:1]), [2 * np.pi])
    assert response[0] == pytest.approx(slave.frequency_response(1.0)[0])
    assert slave.to_scipy().A.shape == slave.A.shape
