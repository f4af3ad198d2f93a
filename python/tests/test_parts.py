"""User-defined parts: copies of built-in parts give identical bits, exceptions end the run, compiled functions
work."""

import copy
import ctypes
import math
import pickle
import shutil
import subprocess
import threading
import time

import numpy as np
import pytest

import trocar

SOFT = "operator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\naugmentation.events_s = [1.5]\n"


def same_bits(run, built_in):
    for name, column in built_in.traces.items():
        assert np.array_equal(run[name], column, equal_nan=True), name


@pytest.fixture
def soft():
    return trocar.Scenario.from_toml(SOFT, "soft")


class Spring:
    """The Kelvin-Voigt tissue."""

    def __init__(self, scenario):
        tissue = scenario["tissue"]
        self.stiffness, self.damping, self.contact = (
            tissue["stiffness_n_per_m"],
            tissue["damping_n_s_per_m"],
            tissue["contact_m"],
        )

    def reset(self):
        """Does nothing: the part has no state."""

    def step(self, tick, position_m, velocity_m_per_s):
        depth = position_m - self.contact
        return self.stiffness * depth + self.damping * velocity_m_per_s if depth > 0.0 else 0.0


class Ramp:
    def __init__(self, scenario):
        operator = scenario["operator"]
        self.start, self.end = operator["start_m"], operator["end_m"]
        self.step_m = operator["speed_m_per_s"] * scenario.tick_s

    def reset(self):
        """Does nothing: the part has no state."""

    def step(self, tick, felt_force_n):
        assert isinstance(tick, int)
        return min(max(self.start + self.step_m * tick, self.start), self.end)


class SquaredResidual:
    """The paper's detector: the CUSUM of the squared residual, with its arming."""

    def __init__(self, scenario):
        detector = scenario["detector"]
        self.threshold, self.drift, self.cap = detector["threshold"], detector["drift"], detector["cap"]
        self.settle = round(detector["settle_s"] / scenario.tick_s)
        self.fastest = detector["withdrawal_speed_m_per_s"]
        self.reset()

    def reset(self):
        self.decision, self.quiet = 0.0, 0

    def step(self, force_n, predicted_force_n, residual_n, depth_m, velocity_m_per_s, in_contact):
        distance = residual_n * residual_n
        self.decision = decision = min(max(self.decision + (distance - self.drift), 0.0), self.cap)
        above = decision > self.threshold
        falls = residual_n < 0.0 and predicted_force_n > 0.0
        alarm = above and in_contact and falls and self.quiet >= self.settle and velocity_m_per_s >= -self.fastest
        self.quiet = self.quiet + 1 if in_contact and not above else 0
        if alarm:
            self.decision = 0.0
        return alarm, decision, distance


class Decay:
    def __init__(self, scenario):
        augmentation = scenario["augmentation"]
        self.ratio = augmentation["decay_ratio"]
        self.keep = math.exp(-scenario.tick_s / augmentation["decay_time_constant_s"])

    def reset(self):
        """Does nothing: the part has no state."""

    def step(self, anchor_n, last_n, measured_n, moved_n, velocity_m_per_s, begins):
        end = self.ratio * anchor_n
        gap = last_n - end
        return end + gap * self.keep, abs(gap) * (1.0 - self.keep)


def test_a_copied_tissue_operator_and_force_law_give_the_same_bits(soft):
    built_in = trocar.run(soft)
    assert len(built_in.events) == 1 and built_in["tissue_force_n"].max() > 1.0
    same_bits(trocar.run(soft, tissue=Spring(soft), operator=Ramp(soft), force_law=Decay(soft)), built_in)


@pytest.mark.parametrize("name", ["paper/augmented", "layers/skin-augmented"])
def test_a_copied_detector_gives_the_same_bits(name):
    scenario = trocar.Scenario.load(name, **{"detector.distance": "squared-residual"})
    built_in = trocar.run(scenario)
    assert built_in.events
    detector = SquaredResidual(scenario)
    for _ in range(2):
        # The detector is reset before each run.
        run = trocar.run(scenario, detector=detector)
        same_bits(run, built_in)
        assert run.events == built_in.events


def test_a_user_defined_estimator_and_motion_law_have_an_effect(soft):
    class Mean:
        mean = 0.0

        def step(self, force_n, depth_m, velocity_m_per_s):
            predicted, self.mean = self.mean, self.mean + 0.1 * (force_n - self.mean)
            return predicted, 123.0, 4.0

    run = trocar.run(soft, estimator=Mean)
    assert (run["stiffness_n_per_m"] == 123.0).all() and (run["damping_n_s_per_m"] == 4.0).all()
    assert abs(run["residual_n"]).max() > 0.01

    modes = set()

    def still(mode, hand_m, slave_m):
        modes.add(mode)
        return 0.001, True

    run = trocar.run(soft, motion_law=still)
    assert (run["slave_reference_m"] == 0.001).all() and modes == {0, 1, 2}


def test_a_tissue_reports_its_rupture(soft):
    def membrane(tick, position_m, velocity_m_per_s):
        return (0.0, tick == 400) if tick >= 400 else (500.0 * max(position_m, 0.0), False)

    run = trocar.run(soft, tissue=membrane)
    assert [rupture["time_s"] for rupture in run.ruptures] == [pytest.approx(0.4)]


def test_an_exception_ends_the_run_with_its_traceback(soft):
    def fails(tick, position_m, velocity_m_per_s):
        if tick == 7:
            raise KeyError("seven")
        return 0.0

    with pytest.raises(KeyError, match="seven") as info:
        trocar.run(soft, tissue=fails)
    assert info.traceback[-1].name == "fails"


@pytest.mark.parametrize(
    ("parts", "exception", "text"),
    [
        ({"tissue": lambda tick, x, v: math.nan}, ValueError, "the tissue returned force_n = NaN, must be finite"),
        ({"tissue": lambda tick, x, v: None}, TypeError, r"must return force_n alone or \(force_n, ruptured\)"),
        ({"tissue": lambda tick, x, v: (1.0, False, 2.0)}, TypeError, "the tissue returned a"),
        ({"tissue": lambda x: 1.0}, TypeError, "positional argument"),
        ({"tissue": 3.0}, TypeError, "the tissue is of the type float, must be a function"),
        ({"force_law": lambda *_: 1.0}, TypeError, r"must return \(force_n, allowed_step_n\)"),
    ],
)
def test_invalid_parts_are_reported(soft, parts, exception, text):
    with pytest.raises(exception, match=text):
        trocar.run(soft, **parts)


@pytest.mark.parametrize("function", ["abs", b"abs", None, True, 1.5, abs])
def test_a_function_that_is_not_compiled_is_reported(function):
    with pytest.raises(TypeError, match="is not a compiled function"):
        trocar.Compiled(function)


@pytest.mark.parametrize("address", [0, -1, 2**70])
def test_an_impossible_address_is_reported(address):
    with pytest.raises(ValueError, match=f"address {address}"):
        trocar.Compiled(address)


def test_an_unknown_role_is_reported(soft):
    with pytest.raises(TypeError, match="there is no role tisue; the roles are tissue, operator"):
        trocar.Simulation(soft, tisue=abs)
    with pytest.raises(TypeError, match="tisue"):
        trocar.run(soft, tisue=abs)


SOURCE = """
void spring(const double *in, double *out, double *state) {
    double depth = in[1] - state[0];
    out[0] = depth > 0.0 ? state[1] * depth + state[2] * in[2] : 0.0;
    state[3] += 1.0;
}
"""


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("compiled")
    (folder / "parts.c").write_text(SOURCE)
    # Disable fused operations, so that the bits equal those of the built-in part.
    command = ["cc", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "parts.c", "-o", "parts.so"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "parts.so"))


def test_a_compiled_tissue_gives_the_same_bits_and_each_run_has_its_own_state(soft, library):
    copied = Spring(soft)
    state = np.array([copied.contact, copied.stiffness, copied.damping, 0.0])
    tissue = trocar.Compiled(library.spring, state)
    built_in = trocar.run(soft)
    runs = [None] * 3

    def run(index):
        runs[index] = trocar.run(soft, tissue=tissue)

    threads = [threading.Thread(target=run, args=(index,)) for index in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for run in runs:
        same_bits(run, built_in)
    assert state[3] == 0.0


def test_a_numba_function_gives_the_same_bits(soft):
    numba = pytest.importorskip("numba")
    pointer = numba.types.CPointer(numba.types.float64)
    copied = Spring(soft)
    stiffness, damping, contact = copied.stiffness, copied.damping, copied.contact

    @numba.cfunc(numba.types.void(pointer, pointer, pointer))
    def spring(inputs, outputs, state):
        depth = inputs[1] - contact
        outputs[0] = stiffness * depth + damping * inputs[2] if depth > 0.0 else 0.0

    same_bits(trocar.run(soft, tissue=spring), trocar.run(soft))

    @numba.cfunc("float64(float64)")
    def wrong(x):
        return x

    with pytest.raises(TypeError, match="has the signature"):
        trocar.Compiled(wrong)


def test_a_stepped_simulation_equals_the_run(soft):
    built_in = trocar.run(soft)
    simulation = trocar.Simulation(soft)
    count = 1
    while simulation.step():
        assert simulation["time_s"] == built_in["time_s"][count - 1] == simulation.signals["time_s"]
        count += 1
    assert count == simulation.ticks == soft.ticks and not simulation.step()
    stepped = simulation.run()
    same_bits(stepped, built_in)
    assert stepped.events == built_in.events
    with pytest.raises(ValueError, match="concluded"):
        simulation.step()


def test_the_caller_can_lead_a_simulation(soft):
    simulation = trocar.Simulation(soft, tissue=Spring(soft))
    ramp = Ramp(soft)
    while simulation.step(ramp.step(simulation.ticks + 1, 0.0)):
        pass
    same_bits(simulation.run(), trocar.run(soft))
    simulation = trocar.Simulation(soft)
    with pytest.raises(ValueError, match="must be finite"):
        simulation.step(math.inf)
    for _ in range(1000):
        simulation.step(-0.004)
    assert simulation["master_position_m"] == pytest.approx(-0.004, abs=1e-6)


def test_a_pickled_simulation_continues(soft):
    """The operator is the scenario's, then led, then released again."""
    simulation = trocar.Simulation(soft)
    others = []
    for tick in range(3000):
        simulation.step(-0.004 if 1000 <= tick < 1100 else None)
        if tick in (0, 1050, 2999):
            others.append(pickle.loads(pickle.dumps(simulation)))
            assert others[-1].signals == simulation.signals and others[-1].ticks == simulation.ticks
    others.append(copy.copy(simulation))
    expected = simulation.run()
    for other, tick in zip(others, (0, 1050, 2999, 2999)):
        for later in range(tick + 1, 3000):
            other.step(-0.004 if 1000 <= later < 1100 else None)
        same_bits(other.run(), expected)
    with pytest.raises(ValueError, match="concluded"):
        pickle.dumps(simulation)
    with pytest.raises(TypeError, match="with user-defined parts cannot be copied or pickled"):
        pickle.dumps(trocar.Simulation(soft, tissue=Spring(soft)))


def test_a_sweep_with_copies_of_built_in_parts_gives_the_same_rows(soft):
    axes = {"scaling.force": [0.5, 1.0], "operator.speed_m_per_s": [0.01, 0.02, 0.03]}
    built_in = trocar.sweep(soft, axes, seeds=2)
    run = trocar.sweep(soft, axes, seeds=2, tissue=Spring(soft), force_law=Decay(soft))
    assert run.hash == built_in.hash and list(run) == list(built_in)
    for name, column in built_in.items():
        assert np.array_equal(run[name], column, equal_nan=column.dtype.kind == "f"), name

    def fails(tick, position_m, velocity_m_per_s):
        raise ArithmeticError("in a case")

    with pytest.raises(ArithmeticError, match="in a case"):
        trocar.sweep(soft, axes, tissue=fails)
    with pytest.raises(TypeError, match="must be an executor"):
        trocar.sweep(soft, axes, tissue=Spring(soft), client=object())


def test_a_part_cannot_use_its_own_simulation(soft):
    def tissue(tick, position_m, velocity_m_per_s):
        return simulation.time_s

    simulation = trocar.Simulation(soft, tissue=tissue)
    with pytest.raises(RuntimeError, match="a part cannot use the simulation that contains it"):
        while simulation.step():
            pass


def test_another_thread_reads_a_simulation_in_a_tick(soft):
    within, read = threading.Event(), []

    def tissue(tick, position_m, velocity_m_per_s):
        within.set()
        time.sleep(1e-3)
        return 0.0

    simulation = trocar.Simulation(soft, tissue=tissue)
    reader = threading.Thread(target=lambda: within.wait() and read.append(simulation.ticks))
    reader.start()
    for _ in range(50):
        simulation.step()
    reader.join(10.0)
    assert read and not reader.is_alive()


def test_a_simulation_ends_with_the_exception_of_a_part(soft):
    def fails(tick, position_m, velocity_m_per_s):
        if tick == 5:
            raise KeyError("five")
        return 0.0

    simulation = trocar.Simulation(soft, tissue=fails)
    with pytest.raises(KeyError, match="five"):
        while simulation.step():
            pass
    assert simulation.ticks == 6
    for again in (simulation.step, simulation.run):
        with pytest.raises(ValueError, match="has ended with an error"):
            again()


def test_compiled_parts_run_in_threads_with_the_same_rows(soft, library):
    copied = Spring(soft)
    tissue = trocar.Compiled(library.spring, [copied.contact, copied.stiffness, copied.damping, 0.0])
    axes = {"scaling.force": [0.5, 1.0], "operator.speed_m_per_s": trocar.Range(0.01, 0.03, 20)}
    built_in = trocar.sweep(soft, axes, seeds=2)
    for threads in (1, 2):
        run = trocar.sweep(soft, axes, seeds=2, tissue=tissue, threads=threads, progress=False)
        assert run.hash == built_in.hash
        for name, column in built_in.items():
            assert np.array_equal(run[name], column, equal_nan=column.dtype.kind == "f"), name
    compared = [trocar.compare(soft, seeds=4, threads=threads, tissue=tissue).report["seeds"] for threads in (1, 2)]
    assert compared[0] == compared[1] == trocar.compare(soft, seeds=4, tissue=Spring(soft)).report["seeds"]
