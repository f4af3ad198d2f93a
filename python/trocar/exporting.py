"""Units for other simulation programs."""

from __future__ import annotations

import os
import shutil
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from . import _core
from .scenario import Scenario


def export(
    scenario: Scenario | Mapping[str, Any] | str | os.PathLike[str],
    path: str | os.PathLike[str],
    *,
    model: Literal["simulation", "rig", "tissue"] = "simulation",
    fmi: Literal[2, 3] = 3,
    library: str | os.PathLike[str] | None = None,
    force: bool = False,
) -> Path:
    """Writes a scenario as a functional mock-up unit (FMU) for co-simulation in other programs.

    Parameters
    ----------
    scenario
        A :class:`Scenario`, a dictionary of keys, a file, or the name of a shipped scenario.
    path
        The file to write, with the extension ``.fmu``.
    model
        ``"simulation"``: the whole simulation; ``"rig"``: the controller of a rig; ``"tissue"``: the tissue alone.
    fmi
        The version of the standard: 2 or 3.
    library
        The library inside the unit, which ``cargo build --release`` builds. Without it, the library beside the
        program ``trocar`` on the search path.
    force
        Replace an existing file.

    Returns
    -------
    Path
        The written file. An interrupted export leaves no part of it.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be loaded.
    FileExistsError
        If the file exists and ``force`` is false.
    FileNotFoundError
        If there is no library.
    ValueError
        For another model or version, settings that a rig does not support, and a recording from memory.

    >>> import trocar
    >>> trocar.export("paper/augmented", "augmented.fmu", model="rig")  # doctest: +SKIP
    PosixPath('augmented.fmu')
    """
    out = Path(path)
    if out.exists() and not force:
        raise FileExistsError(f"{out} exists: pass force=True to replace it")
    if isinstance(scenario, Mapping):
        scenario = Scenario(scenario)
    elif not isinstance(scenario, Scenario):
        scenario = Scenario.load(scenario)
    files = _core.fmu_files(scenario._core, model, fmi, _library(library).read_bytes())
    licences = [(f"documentation/licenses/{name}.txt", text.encode()) for name, text in _core.licences()]
    part = out.with_name(f".{out.name}.part")
    try:
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in [*files, *licences]:
                archive.writestr(name, content)
        part.replace(out)
    finally:
        part.unlink(missing_ok=True)
    return out


def _library(given: str | os.PathLike[str] | None) -> Path:
    if given is not None:
        return Path(given)
    name = {"win32": "trocar_fmu.dll", "darwin": "libtrocar_fmu.dylib"}.get(sys.platform, "libtrocar_fmu.so")
    program = shutil.which("trocar")
    beside = Path(program).resolve().with_name(name) if program else None
    if beside is None or not beside.is_file():
        raise FileNotFoundError(
            f"there is no {name} beside the program trocar: build it with cargo build --release and pass its path as library"
        )
    return beside
