"""The document of a result agrees with the command line, the report and copies of the result."""

import html
import pickle

import pytest

import trocar

PAIR = ["layers/through-the-skin", "layers/skin-augmented"]
AXES = {"x": "scaling.force=0.1:10:3", "y": "tissue.stiffness_n_per_m=10:2000:4"}


def words(text):
    """Joins the lines of a text, which the terminal wraps."""
    return " ".join(text.split())


@pytest.fixture(scope="module")
def results():
    recorded = trocar.record()
    return {
        "run": trocar.run(PAIR[1]),
        "compare": trocar.compare(*PAIR, seeds=2),
        "detect": trocar.detect(recorded, contact_m=0.012, ruptures_s=[5.52, 8.85]),
        "calibrate": trocar.calibrate(recorded, contact_m=0.012),
        "roc": trocar.roc(detectors={"never": lambda *_: False, "adaptive": None}, seeds=2, thresholds=3),
        "sweep": trocar.sweep("layers/skin-augmented", {"scaling.force": [0.5, 1.0], "scaling.position": [0.9, 1.0]}, seeds=2),
        "stability": trocar.stability(**AXES, simulate=True),
    }


KINDS = ["run", "compare", "detect", "calibrate", "roc", "sweep", "stability"]


def described(document):
    return {name: figure.description for name, figure in document.figures.items()}


def test_python_terminal_and_report_say_the_same_sentences(cli, tmp_path):
    """The Rust tests compare the sentences of `trocar explore`, whose page answers over a WebSocket."""
    done = cli("compare", *PAIR, "--report", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    report = words(html.unescape((tmp_path / "compare" / "report.html").read_text(encoding="utf-8")))
    document = trocar.compare(*PAIR).document
    assert document.sentences and document.verdict == " ".join(document.sentences)
    assert f"{document.title}: {document.verdict}" in words(done.stdout)
    for sentence in document.sentences + document.left_out:
        assert sentence in words(done.stdout) and sentence in report, sentence


def test_the_text_equals_that_of_the_command_line(cli, tmp_path, results):
    calls = {"run": ["run", PAIR[1]], "compare": ["compare", *PAIR, "--seeds", 2, "--all"]}
    calls["stability"] = ["stability", "--x", AXES["x"], "--y", AXES["y"], "--simulate"]
    for kind, call in calls.items():
        done = cli(*call, "--out", tmp_path)
        assert done.returncode == 0, done.stderr
        assert str(results[kind].document) in done.stdout, kind


def test_a_sweep_has_the_document_of_the_command_line(cli, tmp_path):
    path = tmp_path / "forces.toml"
    path.write_text('base = "layers/skin-augmented"\nseeds = 2\n[axes]\nscaling.force = [0.5, 1.0]\nscaling.position = [0.9, 1.0]\n')
    done = cli("sweep", path, "--out", tmp_path, "--quiet")
    assert done.returncode == 0, done.stderr
    printed = (tmp_path / "forces" / "summary.txt").read_text(encoding="utf-8")
    assert str(trocar.sweep(path).document) == str(trocar.sweep(path)) == printed


@pytest.mark.parametrize("kind", KINDS)
def test_every_result_has_a_document(kind, results):
    document = results[kind].document
    assert document.title in repr(document) and document.tables
    assert all(isinstance(warning, trocar.warnings.TrocarWarning) for warning in document.warnings)
    for key, table in document.tables.items():
        assert table.key == key and table.caption in html.unescape(table._repr_html_())
        assert {len(row) for row in table.rows + table.texts} <= {len(table.columns)}
        assert len(table.labels) == len(table.columns) and len(table.meanings) == len(table.texts) == len(table)
        for row, texts in zip(table.rows, table.texts):
            assert all(value is None or isinstance(value, (str, float, bool)) for value in row)
            assert all(text == value for value, text in zip(row, texts) if isinstance(value, str))
    if document.sentences:
        assert document.verdict in str(document).replace("\n  ", " ")


@pytest.mark.parametrize("kind", KINDS)
def test_tables_become_frames(kind, results):
    for key, table in results[kind].document.tables.items():
        frame = table.to_dataframe()
        assert frame.shape == (len(table), len(table.columns) - 1) and frame.index.name == table.columns[0], key
        assert frame.equals(table.to_pandas())


def test_numbers_in_frames_are_in_si_units(results):
    table = results["run"].document.tables["metrics"]
    frame = table.to_dataframe()
    delay_s = results["run"].ruptures[0]["detection_delay_s"]
    assert frame.loc["rupture 1: detection delay", "skin-augmented"] == delay_s > 0.0
    row = [texts[0] for texts in table.texts].index("rupture 1: detection delay")
    assert table.texts[row][1] == f"{1e3 * delay_s:.3f} ms" and table.meanings[row].endswith(".")
    change = results["compare"].document.tables["main"].to_dataframe()["change"]
    assert any(text.endswith("%") for text in change.dropna())


def test_tables_become_frames_of_polars(results):
    polars = pytest.importorskip("polars")
    for kind in KINDS:
        for table in results[kind].document.tables.values():
            frame = table.to_polars()
            assert frame.columns == table.columns and frame.height == len(table)
    assert results["run"].document.tables["metrics"].to_polars()["skin-augmented"].dtype == polars.Float64
    same = trocar.compare(PAIR[0], PAIR[0]).document.tables["main"]
    assert same.to_dataframe().shape == (len(same), 3)
    with pytest.raises(ValueError, match="polars needs different names"):
        same.to_polars()


@pytest.mark.parametrize("kind", KINDS)
def test_figures_are_drawn_from_their_descriptions(kind, results):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    figures = results[kind].document.figures
    # A calibration has no figure without a detection.
    assert len(figures) >= (kind != "calibrate")
    for name, figure in figures.items():
        panels = [panel for row in figure.description["rows"] for panel in row["panels"]]
        assert figure.name == name and len(figure.plot().axes) == len(panels) == len(figure.to_matplotlib().axes)
        pyplot.close("all")


def test_figures_have_the_names_of_the_files_of_the_command_line(cli, tmp_path, results):
    done = cli("compare", *PAIR, "--out", tmp_path, "--quiet")
    assert done.returncode == 0, done.stderr
    assert {f"{name}.svg" for name in results["compare"].document.figures} == {path.name for path in (tmp_path / "compare").glob("*.svg")}
    assert {f"{name}.svg" for name in results["run"].document.figures} == {
        path.name for path in (tmp_path / "compare" / "skin-augmented").glob("*.svg")
    }


@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_and_a_file_have_the_same_document(kind, results, tmp_path):
    result = results[kind]
    result.save(tmp_path / "kept.npz")
    kept = type(result).load(tmp_path / "kept.npz")
    document = result.document
    for other in (kept.document, pickle.loads(pickle.dumps(result)).document, pickle.loads(pickle.dumps(document))):
        assert str(other) == str(document) and other.sentences == document.sentences and other.left_out == document.left_out
        assert [str(warning) for warning in other.warnings] == [str(warning) for warning in document.warnings]
        assert {key: table.rows for key, table in other.tables.items()} == {key: table.rows for key, table in document.tables.items()}
        assert described(other) == described(document)


def test_a_pickled_result_is_not_larger_for_its_figures(results):
    run = results["run"]
    columns = sum(column.nbytes for column in run.values())
    assert run.document.figures and len(pickle.dumps(run)) < 1.2 * columns


def test_the_document_has_the_issued_warnings():
    scenario = trocar.Scenario.load("paper/classical", **{"detector.threshold": 1e3})
    with pytest.warns(trocar.warnings.MissedRuptureWarning) as issued:
        run = trocar.run(scenario)
    assert [str(warning.message) for warning in issued] == [str(warning) for warning in run.document.warnings]


def test_user_defined_detectors_have_a_document(results):
    tables = results["roc"].document.tables
    assert [row[0] for row in tables["own"].rows] == ["never", "adaptive"]
    own, built_in = tables["own"].rows
    assert own[1] is None and built_in[1] > 0.0 and own[2] == 0.0
    # The reason why a user-defined detector misses ruptures is unknown.
    assert "misses" not in tables or [row[0] for row in tables["misses"].rows] == ["adaptive"]
    legend = [entry["text"] for entry in results["roc"].document.figures["roc"].description["legend"]]
    assert legend == ["never", "adaptive"]
    alone = trocar.roc(detectors={"never": lambda *_: False}, seeds=2)
    assert alone.document.title.startswith("2 runs") and alone.report["characteristics"]["cases"] == 2


def test_parts_of_a_sweep_have_a_document_when_merged():
    axes = {"scaling.force": trocar.Range(0.5, 1.0, 16)}
    parts = [trocar.sweep("layers/skin-augmented", axes, shard=f"{part}/2") for part in (1, 2)]
    with pytest.raises(ValueError, match="8 of 16 cases have no document; merge the parts"):
        parts[0].document
    assert parts[0]._repr_html_() is None and str(parts[0]) == repr(parts[0])
    whole = trocar.sweep("layers/skin-augmented", axes)
    assert str(trocar.Sweep.merge(parts)) == str(whole) and described(trocar.Sweep.merge(parts).document) == described(whole.document)
