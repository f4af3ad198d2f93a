"""Prints what Python adds to the time of a run, and what its short calls cost.

    python python/benches/speed.py

The package must be a release build; `numba` adds the row of a compiled tissue.
"""

import time
import warnings

import trocar
from trocar import _core

try:
    import numba
except ImportError:
    numba = None


def least_s(*works, times):
    """Returns the minimum times of some works, which alternate; the time to drop a result does not count."""
    least = [float("inf")] * len(works)
    for _ in range(times):
        for index, work in enumerate(works):
            begun = time.perf_counter()
            result = work()
            least[index] = min(least[index], time.perf_counter() - begun)
            del result
    return least


def call_s(call, calls=1000):
    """Returns the minimum time of a short call."""

    def repeated():
        for _ in range(calls):
            call()

    return least_s(repeated, times=20)[0] / calls


def row(name, seconds, note=""):
    unit, scale = ("ms", 1e3) if seconds >= 1e-3 else ("µs", 1e6) if seconds >= 1e-6 else ("ns", 1e9)
    print(f"| {name} | {scale * seconds:.3g} {unit} | {note} |")


def runs():
    for duration_s, times in ((0.01, 2000), (17.0, 300)):
        scenario = trocar.Scenario(
            {"operator": {"kind": "sine"}, "tissue.kind": "kelvin-voigt", "simulation.duration_s": duration_s}
        )
        in_rust = []
        python_s, _ = least_s(
            lambda: trocar.run(scenario), lambda: in_rust.append(_core.seconds_of_run(scenario._core)), times=times
        )
        traces = trocar.run(scenario).traces
        (copy_s,) = least_s(lambda: [column.copy() for column in traces.values()], times=100)
        note = f"{python_s / min(in_rust):.2f} times Rust; a copy of the columns takes {1e6 * copy_s:.0f} µs"
        row(f"`run` of {scenario.ticks} ticks", python_s, note)


def ticks():
    scenario = trocar.Scenario({"operator.kind": "ramp", "tissue.kind": "kelvin-voigt", "simulation.duration_s": 17.0})
    tissue = scenario["tissue"]
    contact, stiffness, damping = tissue["contact_m"], tissue["stiffness_n_per_m"], tissue["damping_n_s_per_m"]

    def interpreted(tick, position_m, velocity_m_per_s):
        depth = position_m - contact
        return stiffness * depth + damping * velocity_m_per_s if depth > 0.0 else 0.0

    tissues = {"built in": {}, "in Python": {"tissue": interpreted}}
    if numba:
        pointer = numba.types.CPointer(numba.types.float64)

        @numba.cfunc(numba.types.void(pointer, pointer, pointer))
        def compiled(inputs, outputs, state):
            depth = inputs[1] - contact
            outputs[0] = stiffness * depth + damping * inputs[2] if depth > 0.0 else 0.0

        tissues["compiled"] = {"tissue": compiled}
    times = least_s(*(lambda parts=parts: trocar.run(scenario, **parts) for parts in tissues.values()), times=50)
    for name, seconds in zip(tissues, times):
        row(f"a tick of `run` with its trace, tissue {name}", seconds / scenario.ticks, f"{seconds / times[0]:.2f} times built in")


def calls():
    scenario = trocar.Scenario.load("paper/augmented")
    detector, controller = trocar.Detector(1e-3), trocar.HapticController(scenario)
    row("`Detector.step`", call_s(lambda: detector.step(0.01, 0.02, 1.0)))
    row("`HapticController.step`", call_s(lambda: controller.step(0.015, 0.0149, 0.01, 1.2)))
    row("`scenario[...]`", call_s(lambda: scenario["scaling.force"]))
    row("`scenario.replace(...)`", call_s(lambda: scenario.replace({"scaling.force": 0.8}), 100))
    row("`margins`", call_s(lambda: trocar.margins("paper/classical"), 1))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    print("| call | time | |\n|---|---|---|")
    runs()
    ticks()
    calls()
