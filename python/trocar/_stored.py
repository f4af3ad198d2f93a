"""Results in files of numpy, with arrays and a text about them."""

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


class Stored:
    """A result that is written into a file, and read back."""

    # The names that the text of a file about such a result has at least.
    _keys: ClassVar[set[str]]

    def _kept(self) -> tuple[Mapping[str, NDArray[Any]], dict[str, Any]]:
        """What a file has of the result: arrays, and what there is to tell about them."""
        raise NotImplementedError

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Self:
        """Returns the result from what a file has of it."""
        raise NotImplementedError

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the result into a file of numpy (``.npz``), which is there whole or not at all. :meth:`load` reads it.

        Raises
        ------
        OSError
            For a file that cannot be written.
        """
        write_stored(path, *self._kept())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Reads a result that :meth:`save` wrote.

        Raises
        ------
        ValueError
            For a file that :meth:`save` did not write.
        OSError
            For a file that cannot be opened.
        """
        return cls._of_kept(*read_stored(path, f"a {cls.__name__.lower()} that {cls.__name__}.save wrote", cls._keys))
