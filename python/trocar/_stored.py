"""Stores results in numpy files, as arrays with a text that describes them."""

from __future__ import annotations

import io
import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import Self

# Suffix of a file that is being written.
PARTIAL = ".partial"


def write_stored(path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]], about: dict[str, Any]) -> None:
    """Writes arrays and a text into a file. The file appears only when it is complete."""
    content = io.BytesIO()
    np.savez_compressed(content, _about=np.array(json.dumps(about)), **arrays)  # type: ignore[arg-type]
    partial = Path(f"{os.fspath(path)}{PARTIAL}")
    partial.write_bytes(content.getvalue())
    partial.replace(path)


def read_stored(path: str | os.PathLike[str], what: str, keys: set[str]) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Reads the arrays and the text ``_about`` of a file. ``what`` names the file in the error for a damaged or
    incomplete file."""
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


class Stored:
    """A result that can be saved to a file and loaded."""

    # The minimum set of keys in the text of such a file.
    _keys: ClassVar[set[str]]

    def _kept(self) -> tuple[Mapping[str, NDArray[Any]], dict[str, Any]]:
        """Returns the arrays and the text that a file stores."""
        raise NotImplementedError

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Self:
        """Returns the result from the content of a file."""
        raise NotImplementedError

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the result into a numpy file (``.npz``), which appears only when it is complete. :meth:`load` reads
        it.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        write_stored(path, *self._kept())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Reads a result that :meth:`save` wrote.

        Raises
        ------
        ValueError
            If :meth:`save` did not write the file.
        OSError
            If the file cannot be opened.
        """
        return cls._of_kept(*read_stored(path, f"a {cls.__name__.lower()} that {cls.__name__}.save wrote", cls._keys))
