"""The notebooks of the documentation run unchanged, and draw their figures."""

import time

import pytest
from conftest import REPOSITORY

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

NOTEBOOKS = REPOSITORY / "docs" / "notebooks"


@pytest.mark.parametrize(("name", "figures"), [("paper", 7), ("user_defined_detector", 4), ("train_a_supervisor", 3)])
def test_a_notebook_runs(name, figures, tmp_path, capsys):
    if name == "train_a_supervisor":
        pytest.importorskip("gymnasium")
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "notebooks are kept without outputs"
    begun = time.monotonic()
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()
    with capsys.disabled():
        print(f"\n{name}.ipynb: {time.monotonic() - begun:.1f} s")
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert not [output for output in outputs if output.get("name") == "stderr"], outputs
    pictures = [output.data["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == figures, "one figure a cell"
    printed = "".join(output["text"] for output in outputs if output.output_type == "stream")
    assert "NO " not in printed
