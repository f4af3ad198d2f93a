"""Every example of the manual's page runs."""

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import trocar

PAGE = Path(__file__).parents[2] / "docs/src/howto/python.md"
BLOCKS = re.findall(r"\n## ([^\n]*)\n|```python\n(.*?)```", "\n## Beginning\n" + PAGE.read_text(encoding="utf-8"), re.DOTALL) if PAGE.is_file() else []


def examples():
    heading, found = "", []
    for title, code in BLOCKS:
        heading = title or heading
        if code:
            found.append(pytest.param(code, id=f"{heading} {len(found)}"))
    return found


class Mine:
    """A detector of a reader."""

    def __init__(self, threshold=0.1):
        self.threshold = threshold

    def reset(self):
        pass

    def step(self, force_n, predicted_n, residual_n, *others):
        return residual_n < -self.threshold


@pytest.fixture
def given(tmp_path, monkeypatch):
    """Returns what the page assumes: samples, a table, points, an executor, and the file of a trial."""
    pandas, scipy_io = pytest.importorskip("pandas"), pytest.importorskip("scipy.io")
    monkeypatch.chdir(tmp_path)
    recording = trocar.record()
    time, position, velocity, force = recording.values()
    scipy_io.savemat("trial.mat", {"t": time, "x": 1e3 * position, "f": force})
    with ThreadPoolExecutor(2) as executor:
        yield {
            "trocar": trocar,
            "scenario": trocar.Scenario.load("paper/augmented"),
            "time": time,
            "position": position,
            "velocity": velocity,
            "force": force,
            "depth": 0.01 * (1.0 - np.cos(np.pi * time)),
            "frame": pandas.DataFrame(recording),
            "points": pandas.DataFrame({"scaling.force": [0.5, 1.0]}),
            "frequency_hz": np.geomspace(0.05, 450.0, 300),
            "executor": executor,
            "Mine": Mine,
        }


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("code", examples())
def test_an_example_runs(code, given):
    if "polars" in code:
        pytest.importorskip("duckdb")
    if "gymnasium" in code:
        pytest.importorskip("gymnasium")
    exec(compile(code, str(PAGE), "exec"), given)
