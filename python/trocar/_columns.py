"""Results with named columns."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, ValuesView
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray


class Columns:
    """A result whose columns are read as those of a mapping: ``result["time_s"]``, ``"time_s" in result``, ``result.keys()``."""

    _columns: dict[str, NDArray[Any]]

    def __getitem__(self, column: str) -> NDArray[Any]:
        try:
            return self._columns[column]
        except KeyError:
            raise KeyError(f"no column {column!r}; the columns are {', '.join(self._columns)}") from None

    def __contains__(self, column: object) -> bool:
        return column in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def keys(self) -> KeysView[str]:
        """The names of the columns."""
        return self._columns.keys()

    def values(self) -> ValuesView[NDArray[Any]]:
        """The columns."""
        return self._columns.values()

    def items(self) -> ItemsView[str, NDArray[Any]]:
        """The names and the columns."""
        return self._columns.items()

    def _to_xarray(self, over: str, units: dict[str, tuple[str, str]]) -> xarray.Dataset:
        """Returns the columns as a Dataset over one of them; ``units`` has the unit and the meaning of a column by its name."""
        import xarray

        data = xarray.Dataset({name: (over, column) for name, column in self._columns.items()})
        for name, variable in data.variables.items():
            unit, meaning = units.get(str(name), ("", ""))
            variable.attrs.update({"units": unit, "long_name": meaning})
        return data

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)
