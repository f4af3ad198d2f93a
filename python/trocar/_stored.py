"""Files of numpy with arrays and a text about them."""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray


def read_stored(path: str | os.PathLike[str], what: str) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Reads the arrays and the text ``_about`` of a file; ``what`` names it in the error if it has none or is damaged."""
    try:
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        return arrays, json.loads(str(arrays.pop("_about")))
    except (AttributeError, EOFError, KeyError, TypeError, ValueError, NotImplementedError, zipfile.BadZipFile, zlib.error):
        raise ValueError(f"{os.fspath(path)} is not {what}") from None
