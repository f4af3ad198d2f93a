"""Results that are the content of a JSON file with its document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from numpy.typing import NDArray

from ._stored import Stored
from .documents import Documented

if TYPE_CHECKING:
    from typing_extensions import Self


class Reported(Documented, Stored):
    """The content of a command's JSON file, and its document."""

    # Name of the report in a saved file.
    _name: ClassVar[str]

    def __init__(self, report: dict[str, Any], contents: dict[str, Any]) -> None:
        self.report = report
        self._contents = contents

    def __init_subclass__(cls) -> None:
        cls._keys = {cls._name, "document"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        return {}, {self._name: self.report, "document": self._contents}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Self:
        return cls(about[cls._name], about["document"])
