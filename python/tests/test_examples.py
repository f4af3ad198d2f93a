"""The examples run as they stand."""

import os
import subprocess
import sys

import pytest
from conftest import REPOSITORY

EXAMPLES = REPOSITORY / "python" / "examples"


def example(name, folder):
    command = [sys.executable, "-W", "error::DeprecationWarning", str(EXAMPLES / name)]
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8", timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_papers_figures(tmp_path):
    said = example("paper_figures.py", tmp_path)
    figures = ["figure_13.png", "figure_15.png", "figure_16.png"]
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in figures)
    assert said.count("yes  ") == 14 and "NO" not in said


def test_ones_own_recording(tmp_path):
    said = example("own_recording.py", tmp_path)
    assert "1 alarm" in said and "alarm at 1.7795 s: 0.5 ms after the rupture" in said


@pytest.mark.parametrize("name", ["paper_figures.py", "own_recording.py"])
def test_every_cell_is_python(name):
    cells = (EXAMPLES / name).read_text(encoding="utf-8").split("# %%")
    assert len(cells) > 4
    for cell in cells[1:]:
        compile(cell.removeprefix(" [markdown]"), name, "exec")
