"""Shared fixtures: the command line for comparison, and figures without a screen."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import matplotlib
import pytest

matplotlib.use("Agg")

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def binary() -> Path:
    """Returns the command line built from the same sources: $TROCAR_BIN, or the result of `cargo build`."""
    given = os.environ.get("TROCAR_BIN")
    places = [Path(given)] if given else [REPOSITORY / "target" / profile / "trocar" for profile in ("debug", "release")]
    found = [place for place in places if place.is_file()]
    assert found, f"none of {', '.join(map(str, places))} is there: run `cargo build` before, or set TROCAR_BIN"
    # Tests run it in other folders.
    return found[0].resolve()


@pytest.fixture(scope="session")
def cli(binary: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Returns a function that runs the command line."""

    def call(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
        command = [str(binary), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", **options)  # type: ignore[call-overload]

    return call


@pytest.fixture(scope="session")
def recording() -> dict[str, object]:
    """Returns the columns of the shipped in-vivo-like recording, read from its file."""
    import numpy as np

    path = REPOSITORY / "scenarios" / "recordings" / "in_vivo_like.csv"
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: np.ascontiguousarray(table[name]) for name in table.dtype.names}
