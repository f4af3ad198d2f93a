from collections.abc import Callable
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Detector",
    "Recording",
    "Run",
    "Scenario",
    "Simulation",
    "StateSpace",
    "Step",
    "__version__",
    "calibrate",
    "compare",
    "detect",
    "detection_figure",
    "detectors",
    "figure_names",
    "keys",
    "list_signals",
    "metrics",
    "read_recording",
    "record",
    "roc",
    "roc_figure",
    "run",
    "run_figure",
    "run_with",
    "score",
    "seconds_of_run",
    "shipped",
    "stability",
    "stability_figure",
    "state_space",
    "sweep",
    "sweep_plan",
    "sweep_with",
    "toml_value",
    "trace_columns",
    "trial",
]

__version__: str

_Floats = NDArray[np.float64]
_Traces = dict[str, NDArray[Any]]

@final
class Scenario:
    @staticmethod
    def load(path: str, settings: list[list[str]], recordings: list[Recording]) -> Scenario: ...
    @staticmethod
    def from_text(name: str, text: str, settings: list[list[str]], recordings: list[Recording]) -> Scenario: ...
    def replace(self, settings: list[str], recordings: list[Recording]) -> Scenario: ...
    def origin(self) -> tuple[str | None, str, str | None, list[list[str]], list[Recording]]: ...
    def to_toml(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    @property
    def name(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def tick_s(self) -> float: ...
    @property
    def ticks(self) -> int: ...
    @property
    def rupture_times_s(self) -> list[float]: ...

@final
class Recording:
    def __new__(
        cls, time_s: _Floats, position_m: _Floats, velocity_m_per_s: _Floats | None, force_n: _Floats
    ) -> Recording: ...
    def __getnewargs__(self) -> tuple[_Floats, _Floats, _Floats | None, _Floats]: ...
    @property
    def name(self) -> str: ...

@final
class Run:
    def summary(self) -> dict[str, Any]: ...
    def warnings(self) -> list[dict[str, Any]]: ...
    def summary_json(self) -> str: ...
    def text(self) -> str: ...
    def rows(self) -> list[tuple[str, str, str, float | None]]: ...
    @property
    def name(self) -> str: ...

@final
class Simulation:
    def __new__(cls, scenario: Scenario, parts: dict[str, Any]) -> Simulation: ...
    def step(self, desired_position_m: float | None) -> bool: ...
    def signals(self) -> dict[str, float]: ...
    @property
    def ticks(self) -> int: ...
    def conclude(self) -> tuple[Run, _Traces]: ...

@final
class Step:
    """The results of one sample. ``alarm`` is whether the detector raises an alarm; quantities are in SI units."""

    def __new__(
        cls,
        alarm: bool,
        velocity_m_per_s: float,
        depth_m: float,
        predicted_force_n: float,
        residual_n: float,
        stiffness_n_per_m: float,
        damping_n_s_per_m: float,
        distance: float,
        decision: float,
    ) -> Step: ...
    def __getnewargs__(self) -> tuple[bool, float, float, float, float, float, float, float, float]: ...
    @property
    def alarm(self) -> bool: ...
    @property
    def velocity_m_per_s(self) -> float: ...
    @property
    def depth_m(self) -> float: ...
    @property
    def predicted_force_n(self) -> float: ...
    @property
    def residual_n(self) -> float: ...
    @property
    def stiffness_n_per_m(self) -> float: ...
    @property
    def damping_n_s_per_m(self) -> float: ...
    @property
    def distance(self) -> float: ...
    @property
    def decision(self) -> float: ...

@final
class Detector:
    def __new__(cls, interval_s: float, is_filtered: bool, settings: list[str], settings_file: str | None) -> Detector: ...
    def copy(self) -> Detector: ...
    def reset(self) -> None: ...
    def step(self, position_m: float, velocity_m_per_s: float | None, force_n: float) -> Step: ...
    def steps(
        self, position_m: _Floats, velocity_m_per_s: _Floats | None, force_n: _Floats
    ) -> tuple[dict[str, _Floats], NDArray[np.int64]]: ...
    @property
    def samples(self) -> int: ...
    @property
    def is_filtered(self) -> bool: ...

@final
class StateSpace:
    def poles(self) -> list[tuple[float, float]]: ...
    def step_response(self, input: int, tick_s: float, samples: int) -> tuple[_Floats, _Floats]: ...
    def frequency_response(self, frequency_hz: list[float], input: int, output: int) -> list[tuple[float, float]]: ...
    @property
    def tick_s(self) -> float | None: ...
    @property
    def a(self) -> _Floats: ...
    @property
    def b(self) -> _Floats: ...
    @property
    def c(self) -> _Floats: ...
    @property
    def d(self) -> _Floats: ...
    @property
    def name(self) -> str: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def states(self) -> list[str]: ...

def run(scenario: Scenario) -> tuple[Run, _Traces]: ...
def run_with(scenario: Scenario, parts: dict[str, Any]) -> tuple[Run, _Traces]: ...
def score(alarms_s: _Floats, ruptures_s: _Floats, window_s: float, recorded_s: float) -> tuple[dict[str, Any], list[tuple[int, int]]]: ...
def seconds_of_run(scenario: Scenario, times: int) -> float: ...
def compare(
    scenarios: list[Scenario],
    seeds: int | None,
    is_paper_pair: bool,
    threads: int,
    parts: dict[str, Any],
    tell: Callable[[int, int], None] | None,
) -> tuple[dict[str, Any], str, list[tuple[str, str, str, list[float | None]]], list[tuple[Run, _Traces]]]: ...
def detect(
    name: str,
    time_s: _Floats,
    position_m: _Floats,
    velocity_m_per_s: _Floats | None,
    force_n: _Floats,
    settings: list[str],
    settings_file: str | None,
) -> tuple[dict[str, _Floats], NDArray[np.int64], dict[str, Any], str]: ...
def calibrate(
    name: str,
    time_s: _Floats,
    position_m: _Floats,
    velocity_m_per_s: _Floats | None,
    force_n: _Floats,
    settings: list[str],
    *,
    first_s: float | None,
    quiet_s: tuple[float, float] | None,
    keeps_contact: bool,
    false_alarm_s: float | None,
    slowest_rupture_s: float | None,
    fastest_harmless_s: float | None,
    variance_ratio: float | None,
    threads: int,
) -> tuple[dict[str, Any], str, str]: ...
def sweep(
    path: str | None, text: str, base: Scenario | None, settings: list[str], shard: str, threads: int, tell: Callable[[int, int], None] | None
) -> tuple[dict[str, Any], str, int, list[tuple[str, str]]]: ...
def stability(
    scenario: Scenario, x: str, y: str, tissue: tuple[float, float], simulate: bool, threads: int
) -> tuple[dict[str, Any], str, dict[str, NDArray[Any]]]: ...
def state_space(scenario: Scenario, side: str) -> StateSpace: ...
def shipped() -> list[tuple[str, str]]: ...
def keys() -> list[tuple[str, str, str | None, str]]: ...
def record(seed: int, drop_n: float | None, fall_s: float | None, depth_m: float | None) -> str: ...
def detectors() -> list[str]: ...
def trial(number: int) -> tuple[dict[str, _Floats], dict[str, Any]]: ...
def roc(
    name: str,
    scenario: Scenario | None,
    recording: Recording | None,
    is_trials: bool,
    settings: list[str],
    kinds: list[str],
    own: list[Any],
    noise_std_n: list[float],
    seeds: int,
    thresholds: int,
    within_s: float,
    threads: int,
    tell: Callable[[int, int], None] | None,
) -> tuple[dict[str, Any], list[dict[str, Any]]]: ...
def metrics() -> list[tuple[str, str, str, str, str, str]]: ...
def trace_columns() -> list[tuple[str, str, str]]: ...
def sweep_with(
    path: str | None, text: str, base: Scenario | None, settings: list[str], parts: dict[str, Any], tell: Callable[[int, int], None] | None
) -> tuple[dict[str, Any], str, int, list[tuple[str, str]]]: ...
def sweep_plan(path: str | None, text: str, base: Scenario | None, settings: list[str]) -> tuple[str, int]: ...
def toml_value(value: Any) -> str: ...
def list_signals(path: str) -> dict[str, Any]: ...
def read_recording(path: str, time: str, position: str, velocity: str | None, force: str) -> dict[str, Any]: ...

def figure_names() -> tuple[list[str], list[str]]: ...
def run_figure(
    figure: str,
    runs: list[tuple[Scenario, _Traces, list[float], list[float]]],
    window: tuple[float, float] | None,
) -> dict[str, Any]: ...
def detection_figure(
    figure: str,
    name: str,
    columns: _Traces,
    sampling: tuple[float, float],
    threshold: float,
    distance: str,
    ruptures_s: list[float],
    alarms_s: list[float],
) -> dict[str, Any]: ...
def stability_figure(
    name: str,
    x: tuple[str, _Floats, bool, float],
    y: tuple[str, _Floats, bool, float],
    stable: NDArray[np.bool_],
    boundary: _Floats,
    simulated: NDArray[np.int8] | None,
) -> dict[str, Any]: ...
def roc_figure(
    name: str,
    curves: list[tuple[str, list[float], list[float], list[float]]],
    min_per_minute: float,
) -> dict[str, Any]: ...
