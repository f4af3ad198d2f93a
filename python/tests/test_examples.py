"""The examples run unchanged."""

import doctest
import inspect
import os
import subprocess
import sys

import pytest
from conftest import REPOSITORY

import trocar

EXAMPLES = REPOSITORY / "python" / "examples"


def example(name, folder):
    command = [sys.executable, "-W", "error::DeprecationWarning", str(EXAMPLES / name)]
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8", timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_example_draws_the_figures_of_the_paper(tmp_path):
    said = example("paper_figures.py", tmp_path)
    figures = ["figure_13.png", "figure_15.png", "figure_16.png"]
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in figures)
    assert said.count("yes  ") == 14 and "NO" not in said


def test_the_example_evaluates_a_recording(tmp_path):
    said = example("your_recording.py", tmp_path)
    assert "1 alarm" in said and "alarm at 1.7795 s: 0.5 ms after the rupture" in said


@pytest.mark.parametrize("name", ["paper_figures.py", "your_recording.py"])
def test_every_cell_of_an_example_compiles(name):
    cells = (EXAMPLES / name).read_text(encoding="utf-8").split("# %%")
    assert len(cells) > 4
    for cell in cells[1:]:
        compile(cell.removeprefix(" [markdown]"), name, "exec")


def public():
    """Yields the classes and functions of the package, except the types of dictionaries, which need no example."""
    for module in (trocar, trocar.results):
        for name in module.__all__:
            found = getattr(module, name)
            is_dictionary = inspect.isclass(found) and issubclass(found, dict)
            if callable(found) and not is_dictionary:
                yield pytest.param(name, found, id=name)


@pytest.mark.parametrize(("name", "found"), list(public()))
def test_every_public_name_has_an_example(name, found):
    text = inspect.getdoc(found) or ""
    assert ">>> " in text, f"trocar.{name} has no example"
    if found.__module__ == "trocar._core":
        # `pytest --doctest-modules` does not read compiled modules.
        example = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
        assert doctest.DocTestRunner().run(example).failed == 0
