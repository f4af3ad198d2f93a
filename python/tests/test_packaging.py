"""The wheel contains the required files and no unwanted dependency."""

import os
import shutil
import subprocess
import sys
import tomllib

import pytest
from conftest import REPOSITORY

PYTHON = REPOSITORY / "python"
# Servers, terminals and command lines, which a package for computation does not need.
UNWANTED = {"axum", "hyper", "tokio", "tungstenite", "clap", "indicatif", "console", "crossterm", "ctrlc", "open"}


def test_the_wheel_contains_no_server_and_no_terminal():
    if shutil.which("cargo") is None:
        pytest.skip("no cargo")
    command = ["cargo", "tree", "--package", "trocar-python", "--edges", "normal", "--prefix", "none", "--format", "{p}"]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=True)
    crates = {line.split()[0] for line in done.stdout.splitlines() if line}
    assert {"trocar-python", "trocar-studies", "pyo3"} <= crates
    assert not crates & UNWANTED


def test_the_wheel_has_the_licences_of_the_repository():
    project = tomllib.loads((PYTHON / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    files = sorted(path for pattern in project["license-files"] for path in PYTHON.glob(pattern))
    assert [path.name for path in files] == ["LICENSE-APACHE", "LICENSE-MIT"]
    assert all(path.read_bytes() == (REPOSITORY / path.name).read_bytes() for path in files)


def test_the_source_folder_alone_reports_the_missing_core(tmp_path):
    shutil.copytree(PYTHON / "trocar", tmp_path / "trocar", ignore=shutil.ignore_patterns("*.so", "*.pyd", "__pycache__"))
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-c", "import trocar"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    assert f"trocar is imported from its source folder {tmp_path / 'trocar'}, which has no compiled part" in done.stderr
    assert "circular" not in done.stderr
