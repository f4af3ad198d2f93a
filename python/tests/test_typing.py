"""The examples of the docstrings, the book and the front pages satisfy `mypy --strict`."""

import doctest
import importlib
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import trocar

ROOT = Path(__file__).parents[2]

# Names that the pages assume: user-defined samples, and variables of earlier examples.
GIVEN = """
from typing import Any
import numpy as np, pandas
import trocar
time = position = velocity = force = np.zeros(10)
depth = frequency_hz = np.zeros(10)
frame: pandas.DataFrame = pandas.DataFrame()
points: pandas.DataFrame = pandas.DataFrame()
scenario = trocar.Scenario.load("paper/augmented")
executor: Any = None
class Mine:
    def __init__(self, threshold: float = 0.1) -> None: ...
    def reset(self) -> None: ...
    def step(self, *evidence: float) -> bool: return False
"""


def docstrings():
    modules = [f"trocar.{module.name}" for module in pkgutil.iter_modules(trocar.__path__) if module.name[0] != "_"]
    for module in map(importlib.import_module, ["trocar", *modules]):
        for found in doctest.DocTestFinder().find(module):
            if found.examples:
                yield found.name, "".join(example.source for example in found.examples)


def pages():
    for page in [ROOT / "README.md", ROOT / "python/README.md", *sorted((ROOT / "docs/src").rglob("*.md"))]:
        for number, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL), 1):
            yield f"{page.relative_to(ROOT)} {number}", GIVEN + block


@pytest.mark.parametrize(("examples", "least"), [(docstrings, 15), (pages, 5)])
def test_examples_satisfy_mypy(examples, least, tmp_path):
    pytest.importorskip("mypy")
    if not (ROOT / "docs/src").is_dir():
        pytest.skip("without the source")
    names = {}
    for number, (name, source) in enumerate(dict(examples()).items()):
        names[f"example_{number}.py"] = name
        # Each example is a module, because they reuse names with other types.
        (tmp_path / f"example_{number}.py").write_text(source)
    assert len(names) >= least
    # Stubs of other packages are the reader's responsibility.
    others = ["--ignore-missing-imports", "--disable-error-code=import-untyped", "--allow-untyped-calls"]
    command = [sys.executable, "-m", "mypy", "--strict", *others, *names]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    output = re.sub(r"example_\d+\.py", lambda file: names[file[0]], done.stdout)
    assert done.returncode == 0, output + done.stderr
