"""The time and the memory that Python adds."""

import subprocess
import sys
import time
import warnings

import pytest

import trocar
from trocar import _core


def least_seconds(work, times):
    """Returns the minimum time of some work, without the time to drop its result."""

    def once():
        begun = time.perf_counter()
        outcome = work()
        seconds = time.perf_counter() - begun
        del outcome
        return seconds

    return min(once() for _ in range(times))


@pytest.mark.parametrize(("duration_s", "times"), [(0.01, 2000), (17.0, 400)])
def test_a_run_takes_little_longer_than_in_rust(capsys, duration_s, times):
    """Under 50 µs and one copy per trace, for a run without warnings. The calls alternate and the minimum counts, because
    other processes only add time."""
    values = {"operator": {"kind": "sine"}, "tissue.kind": "kelvin-voigt", "simulation.duration_s": duration_s}
    scenario = trocar.Scenario.from_dict(values)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        traces = trocar.run(scenario).traces
    copies_s = least_seconds(lambda: [column.copy() for column in traces.values()], 50)
    rust_s = python_s = float("inf")
    for _ in range(times):
        rust_s = min(rust_s, _core.seconds_of_run(scenario._core, 1))
        python_s = min(python_s, least_seconds(lambda: trocar.run(scenario), 1))
    overhead_s = python_s - rust_s
    with capsys.disabled():
        print(
            f"\n{scenario.ticks} ticks: {1e6 * python_s:.1f} µs in Python, {1e6 * rust_s:.1f} µs in Rust: {1e6 * overhead_s:+.1f} µs; "
            f"a copy of the traces would take {1e6 * copies_s:.0f} µs"
        )
    assert overhead_s < 50e-6 + copies_s


def test_a_tick_with_a_user_defined_part_is_fast(capsys):
    """The calls alternate, each with the whole trace of the run."""
    numba = pytest.importorskip("numba")
    scenario = trocar.Scenario.from_toml('operator.kind = "ramp"\ntissue.kind = "kelvin-voigt"\nsimulation.duration_s = 17.0\n', "soft")
    tissue = scenario["tissue"]
    contact, stiffness, damping = tissue["contact_m"], tissue["stiffness_n_per_m"], tissue["damping_n_s_per_m"]
    pointer = numba.types.CPointer(numba.types.float64)

    @numba.cfunc(numba.types.void(pointer, pointer, pointer))
    def compiled(inputs, outputs, state):
        depth = inputs[1] - contact
        outputs[0] = stiffness * depth + damping * inputs[2] if depth > 0.0 else 0.0

    def interpreted(tick, position_m, velocity_m_per_s):
        depth = position_m - contact
        return stiffness * depth + damping * velocity_m_per_s if depth > 0.0 else 0.0

    tissues = {"built in": {}, "compiled": {"tissue": compiled}, "interpreted": {"tissue": interpreted}}
    least_s = dict.fromkeys(tissues, float("inf"))
    for _ in range(50):
        for name, parts in tissues.items():
            least_s[name] = min(least_s[name], least_seconds(lambda parts=parts: trocar.run(scenario, **parts), 1))
    with capsys.disabled():
        print("\nA tick with a tissue that is " + ", ".join(f"{name}: {1e9 * s / scenario.ticks:.0f} ns" for name, s in least_s.items()))
    # The limit is a thousandth of a tick at 1 kHz.
    assert max(least_s.values()) < 1e-6 * scenario.ticks


@pytest.mark.parametrize("samples", [1000, 20000])
def test_a_step_of_a_detector_is_fast(capsys, samples):
    detector = trocar.Detector(1e-3)

    def steps():
        step = detector.step
        for _ in range(samples):
            step(0.01, 0.02, 1.0)

    each_s = least_seconds(steps, 3) / samples
    with capsys.disabled():
        print(f"\nDetector.step: {1e9 * each_s:.0f} ns")
    # The limit is a hundredth of a tick at 1 kHz.
    assert each_s < 1e-5


MEMORY = """
import resource, warnings
import numpy as np
import trocar

samples = 2_000_000
time_s = np.arange(samples) * 1e-3
position_m = 0.01 * (1.0 - np.cos(2.0 * np.pi * time_s / 5.0))
force_n = 300.0 * position_m + 0.02 * np.random.default_rng(1).standard_normal(samples)
velocity_m_per_s = np.gradient(position_m, 1e-3)
warnings.simplefilter("ignore")
# The first call loads modules, whose memory must not count.
trocar.detect(time_s[:100], position_m[:100], velocity_m_per_s[:100], force_n[:100])
peak = lambda: 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
resident = lambda: 4096 * int(open("/proc/self/statm").read().split()[1])
# Use up the memory that the arrays above needed temporarily, so that the peak is that of the detection.
held = np.ones(max(peak() - resident(), 0) // 8)
before = peak()
found = trocar.detect(time_s, position_m, velocity_m_per_s, force_n)
results = sum(column.nbytes for column in found.values())
print((peak() - before - results) / samples, results / samples)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_a_detection_needs_little_memory_beyond_its_results(capsys):
    """At most 250 MB above the columns for 1e7 samples."""
    done = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True, check=True)
    above, results = map(float, done.stdout.split())
    with capsys.disabled():
        print(f"\ndetect: {results:.0f} bytes of results per sample, and {above:.1f} bytes besides while it runs")
    assert results == 72.0 and above < 25.0
