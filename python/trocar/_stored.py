"""Files of numpy with arrays and a text about them."""

from __future__ import annotations

import io
import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


# The end of the name of a file that is being written.
PARTIAL = ".partial"


def write_stored(path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]], about: dict[str, Any]) -> None:
    """Writes arrays and a text into a file, which is there whole or not at all."""
    content = io.BytesIO()
    np.savez_compressed(content, _about=np.array(json.dumps(about)), **arrays)  # type: ignore[arg-type]
    partial = Path(f"{os.fspath(path)}{PARTIAL}")
    partial.write_bytes(content.getvalue())
    partial.replace(path)


def read_stored(path: str | os.PathLike[str], what: str, keys: set[str]) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Reads the arrays and the text ``_about`` of a file; ``what`` names it in the error if it has none, lacks keys, or is damaged."""
    try:
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        about = json.loads(str(arrays.pop("_about")))
        is_whole = keys <= about.keys()
    except (AttributeError, EOFError, KeyError, TypeError, ValueError, NotImplementedError, zipfile.BadZipFile, zlib.error):
        is_whole = False
    if not is_whole:
        raise ValueError(f"{os.fspath(path)} is not {what}")
    return arrays, about
