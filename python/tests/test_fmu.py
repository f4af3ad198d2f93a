"""Functional mock-up units: FMPy validates and simulates each, and their commands equal those of Rust bit for bit."""

import csv
import io
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

import trocar

fmpy = pytest.importorskip("fmpy")
from fmpy.fmi2 import FMU2Slave  # noqa: E402
from fmpy.fmi3 import FMU3Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[2]
LEVER_M = 0.075
SAMPLE = ["master_position_m", "slave_position_m", "slave_velocity_m_per_s", "force_n"]
KINDS = [(kind, version) for kind in ("rig", "simulation", "tissue") for version in (2, 3)]

# The scenario of each recording; its commands depend on the samples alone.
RECORDED = """
simulation.tick_s = 5e-4
operator.kind = "ramp"
tissue.kind = "kelvin-voigt"
estimator.contact_m = {contact_m}
detector.distance = "squared-residual"
"""


@pytest.fixture(scope="module")
def library(binary):
    """Returns the FMU library: beside the command line, or in the test build's folder."""
    names = [f"{prefix}trocar_fmu{ending}" for prefix, ending in (("lib", ".so"), ("lib", ".dylib"), ("", ".dll"))]
    places = [folder / name for folder in (binary.parent, binary.parent / "deps") for name in names]
    found = [place for place in places if place.is_file()]
    assert found, f"none of {', '.join(map(str, places))} is there: run `cargo build` before"
    return found[0]


@pytest.fixture(scope="module")
def export(cli, library, tmp_path_factory):
    """Returns a function that exports a scenario and returns its FMU."""
    folder = tmp_path_factory.mktemp("units")
    made = {}

    def make(scenario, kind, version):
        unit = folder / f"{len(made)}.fmu"
        if (scenario, kind, version) not in made:
            which = [] if kind == "simulation" else [f"--{kind}"]
            run = cli("export", "fmu", scenario, "--fmi", version, "--library", library, "--out", unit, *which)
            assert run.returncode == 0, run.stderr
            made[scenario, kind, version] = unit
        return made[scenario, kind, version]

    return make


class Slave:
    """An instance of an FMU in FMPy, with the same interface for both versions of the standard."""

    def __init__(self, unit, start=None):
        self.description = fmpy.read_model_description(str(unit))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.folder = fmpy.extract(str(unit))
        self.is_2 = self.description.fmiVersion == "2.0"
        kind, token = (FMU2Slave, "guid") if self.is_2 else (FMU3Slave, "instantiationToken")
        self.messages = []
        self.fmu = kind(
            guid=getattr(self.description, token),
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.fmu.instantiate()
        for name, value in (start or {}).items():
            self.set(name, value)
        if self.is_2:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = 0.0

    def _call(self, action, name, *values):
        variable = self.variables[name]
        kind = {"Real": "Real", "Float64": "Float64", "Boolean": "Boolean"}.get(variable.type)
        kind = kind or ("Integer" if self.is_2 else "Int64")
        return getattr(self.fmu, action + kind)([variable.valueReference], *([value] for value in values))

    def set(self, name, value):
        self._call("set", name, value)

    def get(self, name):
        return self._call("get", name)[0]

    def step(self, step_s):
        self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=step_s)
        self.time += step_s

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


def columns(text):
    """The columns of a CSV text."""
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}


def commands(unit, samples, tick_s, outputs):
    """Steps a rig's FMU through samples. Returns its outputs; the outputs after a step belong to the sample before
    it."""
    slave = Slave(unit)
    references = [slave.variables[f"sample.{name}"].valueReference for name in SAMPLE]
    set_numbers = slave.fmu.setReal if slave.is_2 else slave.fmu.setFloat64
    found = {name: [] for name in outputs}
    for row in zip(*(samples[name] for name in SAMPLE), strict=True):
        set_numbers(references, list(row))
        slave.step(tick_s)
        for name in outputs:
            found[name].append(slave.get(f"command.{name}"))
    slave.close()
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize(("kind", "version"), KINDS)
def test_fmpy_finds_no_problem_in_an_exported_unit(export, kind, version):
    unit = export("layers/skin-augmented" if kind == "tissue" else "paper/augmented", kind, version)
    assert validate_fmu(str(unit)) == []
    description = fmpy.read_model_description(str(unit))
    assert description.fmiVersion == f"{version}.0" and description.license == "MIT OR Apache-2.0"
    parameters = {v.name: v for v in description.modelVariables if v.causality == "parameter"}
    if kind == "tissue":
        stiffness = parameters["tissue.layer.skin.stiffness_n_per_m"]
        assert float(stiffness.start) > 0 and stiffness.description and stiffness.unit == "N/m"
        assert not [name for name in parameters if not name.startswith("tissue.") and name != "simulation.tick_s"]
    else:
        quiet = parameters["detector.quiet_std_n"]
        assert float(quiet.start) == 0.02 and float(quiet.min) == 1e-12 and quiet.description and quiet.unit == "N"
    with zipfile.ZipFile(unit) as files:
        names = files.namelist()
    assert f"resources/{kind}.toml" in names and "documentation/licenses/LICENSE-MIT.txt" in names


@pytest.mark.parametrize(("kind", "version"), KINDS)
def test_fmpy_simulates_an_exported_unit(export, kind, version):
    unit = export("layers/skin-augmented", kind, version)
    outputs = {"rig": "command.slave_reference_m", "simulation": "slave_position_m", "tissue": "reaction.force_n"}
    output = outputs[kind]
    result = fmpy.simulate_fmu(str(unit), stop_time=1.0, output_interval=1e-3, output=[output])
    assert len(result) == 1001 and np.isfinite(result[output]).all()
    assert (result[output].max() > 1e-3) == (kind == "simulation")


@pytest.fixture(scope="module")
def augmented(cli, tmp_path_factory):
    """Returns the trace of the augmented insertion, written by the command line."""
    folder = tmp_path_factory.mktemp("augmented")
    made = cli("run", "paper/augmented", "--out", folder, "--quiet")
    assert made.returncode == 0, made.stderr
    (trace,) = folder.glob("*/trace.csv")
    return columns(trace.read_text(encoding="utf-8"))


@pytest.mark.parametrize("version", [2, 3])
def test_a_rig_gives_the_commands_of_the_augmented_insertion(export, augmented, version):
    samples = {name: augmented[name] for name in SAMPLE[:3]} | {"force_n": augmented["measured_force_n"]}
    names = {"slave_reference_m": "slave_reference_m", "master_force_n": "feedback_force_n", "mode": "mode"}
    names |= {name: name for name in ("stiffness_n_per_m", "damping_n_s_per_m", "residual_n", "distance", "decision")}
    found = commands(export("paper/augmented", "rig", version), samples, 1e-3, [*names, "alarm_taken"])
    assert found["alarm_taken"].sum() == 2
    for output, column in names.items():
        assert np.array_equal(found[output], augmented[column]), output


@pytest.mark.parametrize("version", [2, 3])
def test_a_simulation_with_the_scenarios_operator_equals_the_run(export, augmented, version):
    slave = Slave(export("paper/augmented", "simulation", version))
    names = ["master_position_m", "slave_position_m", "tissue_force_n", "feedback_force_n", "decision", "mode"]
    for k in range(6000):
        slave.step(1e-3)
        assert [slave.get(name) for name in names] == [augmented[name][k] for name in names], k
    slave.close()


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("path", "torque", "contact_m", "alarms"),
    [
        ("scenarios/recordings/own_ctrl_pop.csv", "env_out_Nm_derived", 6.3e-3, 1),
        ("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm", -9e-3, 0),
        ("tests/data/teleop_1dof/m2_d_free_motion.csv", "tau_e_Nm", 0.0, 0),
    ],
)
def test_a_rig_gives_the_estimates_of_detect_on_recordings(
    export, cli, tmp_path, path, torque, contact_m, alarms, version
):
    recorded = columns((REPOSITORY / path).read_text(encoding="utf-8"))
    slave = LEVER_M * recorded["xs_rad"]
    master = LEVER_M * recorded["xm_rad"] if "xm_rad" in recorded else slave
    samples = dict(zip(SAMPLE, (master, slave, LEVER_M * recorded["vs_rad_s"], recorded[torque] / LEVER_M), strict=True))
    scenario = tmp_path / "recorded.toml"
    scenario.write_text(RECORDED.format(contact_m=contact_m), encoding="utf-8")
    names = ["stiffness_n_per_m", "residual_n", "decision"]
    found = commands(export(scenario, "rig", version), samples, 5e-4, [*names, "alarm"])
    assert found["alarm"].sum() == alarms

    # Detect in the same samples on the command line, which prints every digit.
    lines = [f"{k * 5e-4!r},{position!r},{velocity!r},{force!r}" for k, (position, velocity, force) in enumerate(
        zip(samples["slave_position_m"].tolist(), samples["slave_velocity_m_per_s"].tolist(), samples["force_n"].tolist(), strict=True)
    )]
    text = "\n".join(["time_s,position_m,velocity_m_per_s,force_n", *lines, ""])
    arguments = ["--velocity", "velocity_m_per_s", "--interval-s", "5e-4", "--every", "1"]
    settings = [f"--set=estimator.contact_m={contact_m}", "--set=detector.distance=squared-residual"]
    printed = cli("detect", "-", *arguments, *settings, input=text)
    assert printed.returncode == 0, printed.stderr
    # The first column names the kind of row.
    rows = [line.split(",", 1)[1] for line in printed.stdout.splitlines() if not line.startswith("alarm,")]
    expected = columns("\n".join(rows))
    for name in names:
        assert np.array_equal(found[name], expected[name]), name


@pytest.mark.parametrize("version", [2, 3])
def test_a_wrong_parameter_is_refused(export, version, capfd):
    unit = export("paper/augmented", "rig", version)
    with pytest.raises(Exception, match="exitInitializationMode|ExitInitializationMode"):
        Slave(unit, {"detector.quiet_std_n": -1.0})
    assert "detector.quiet_std_n" in "".join(capfd.readouterr())


@pytest.mark.parametrize(("kind", "version"), KINDS)
def test_a_state_is_saved_and_restored(export, kind, version):
    slave = Slave(export("layers/skin-augmented", kind, version))
    signals = {
        "rig": ("sample.slave_position_m", "command.stiffness_n_per_m"),
        "simulation": ("person.position_m", "feedback_force_n"),
        "tissue": ("needle.position_m", "reaction.force_n"),
    }
    into, out = signals[kind]

    def push(first, ticks):
        found = []
        for k in range(first, first + ticks):
            slave.set(into, 2e-5 * k)
            if kind == "rig":
                slave.set("sample.force_n", 0.01 * k + 0.1 * np.sin(k))
            slave.step(1e-3)
            found.append(slave.get(out))
        return found

    push(0, 100)
    time = slave.time
    state = slave.fmu.getFMUState() if not slave.is_2 else slave.fmu.getFMUstate()
    expected = push(100, 100)
    assert len(set(expected)) > 10
    for _ in range(2):
        (slave.fmu.setFMUstate if slave.is_2 else slave.fmu.setFMUState)(state)
        slave.time = time
        assert push(100, 100) == expected
    (slave.fmu.freeFMUstate if slave.is_2 else slave.fmu.freeFMUState)(state)
    slave.close()


def test_without_a_library_the_remedy_is_named(cli: object, tmp_path: Path) -> None:
    made: subprocess.CompletedProcess[str] = cli("export", "fmu", "paper/augmented", "--library", tmp_path / "none")  # type: ignore[operator]
    assert made.returncode == 2 and "run `cargo build --release`, which builds" in made.stderr


@pytest.mark.parametrize(("kind", "version"), KINDS)
def test_python_exports_the_unit_of_the_command(export, library, tmp_path, kind, version):
    scenario = "layers/skin-augmented" if kind == "tissue" else "paper/augmented"
    unit = trocar.export(scenario, tmp_path / "unit.fmu", model=kind, fmi=version, library=library)
    with zipfile.ZipFile(unit) as found, zipfile.ZipFile(export(scenario, kind, version)) as expected:
        assert sorted(found.namelist()) == sorted(expected.namelist())
        for name in found.namelist():
            assert found.read(name) == expected.read(name), name
    assert [path.name for path in tmp_path.iterdir()] == ["unit.fmu"]


def test_python_exports_the_changes_of_a_scenario(library, tmp_path):
    scenario = trocar.Scenario.load("paper/augmented").replace(scaling={"force": 0.75})
    unit = trocar.export(scenario, tmp_path / "unit.fmu", model="rig", library=library)
    description = fmpy.read_model_description(str(unit))
    starts = {variable.name: variable.start for variable in description.modelVariables}
    assert float(starts["scaling.force"]) == 0.75


def test_invalid_exports_are_refused(library, tmp_path, monkeypatch):
    unit = tmp_path / "unit.fmu"
    with pytest.raises(ValueError, match='model is "robot", must be "simulation", "rig" or "tissue"'):
        trocar.export("paper/augmented", unit, model="robot", library=library)
    with pytest.raises(ValueError, match="fmi is 4, must be 2 or 3"):
        trocar.export("paper/augmented", unit, fmi=4, library=library)
    with pytest.raises(trocar.ScenarioError):
        trocar.export({"base": "paper/augmented", "scaling.force": -1.0}, unit, library=library)
    recorded = trocar.Scenario.load("paper/augmented").replace(**{"recording.file": trocar.record(2)})
    with pytest.raises(ValueError, match="cannot contain a recording from memory"):
        trocar.export(recorded, unit, library=library)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileNotFoundError, match="beside the program trocar"):
        trocar.export("paper/augmented", unit)
    assert not unit.exists()
    unit.write_text("kept")
    with pytest.raises(FileExistsError, match="force=True"):
        trocar.export("paper/augmented", unit, library=library)
    assert unit.read_text() == "kept"
    trocar.export("paper/augmented", unit, model="rig", library=library, force=True)
    assert zipfile.is_zipfile(unit)
