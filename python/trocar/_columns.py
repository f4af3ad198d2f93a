"""Results with named columns."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, ValuesView
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from . import _core
from ._frames import stream

if TYPE_CHECKING:
    import xarray


class Columns:
    """A result that is a mapping of its columns: ``result["time_s"]``, ``"time_s" in result``, ``result.keys()``.

    polars, pyarrow, pandas and DuckDB read it as a table: ``polars.DataFrame(result)``, ``pyarrow.table(result)``.
    """

    _columns: dict[str, NDArray[Any]]

    def __arrow_c_stream__(self, requested_schema: object = None) -> Any:
        """Returns the columns for a library that reads Arrow, with units and meanings as metadata. Columns of numbers
        are not copied."""
        return stream(self._columns, self._units())

    def _units(self) -> dict[str, tuple[str, str]]:
        """Returns the units and the meanings of columns."""
        return {name: (unit, meaning) for name, unit, meaning in _core.trace_columns()}

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
        """Returns the names of the columns."""
        return self._columns.keys()

    def values(self) -> ValuesView[NDArray[Any]]:
        """Returns the columns."""
        return self._columns.values()

    def items(self) -> ItemsView[str, NDArray[Any]]:
        """Returns the names and the columns."""
        return self._columns.items()

    def _to_xarray(self, over: str, units: dict[str, tuple[str, str]]) -> xarray.Dataset:
        """Returns the columns as a Dataset over the column ``over``; ``units`` maps column names to units and
        meanings."""
        import xarray

        data = xarray.Dataset({name: (over, column) for name, column in self._columns.items()})
        for name, variable in data.variables.items():
            unit, meaning = units.get(str(name), ("", ""))
            variable.attrs.update({"units": unit, "long_name": meaning})
        return data

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)
