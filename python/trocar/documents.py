"""Documents of results: the answer, warnings, tables and figures that terminal, report and page show."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

from ._frames import stream
from ._html import table
from .warnings import TrocarWarning, warning_of

if TYPE_CHECKING:
    import matplotlib.figure
    import pandas
    import polars

Cell = float | str | bool | None
"""The value of a cell: a number in SI units, a text, a boolean, or ``None`` if undefined."""


class Table:
    """A table of a :class:`Document`. The first column names the rows.

    Attributes
    ----------
    key : str
        The key, which is the same in every version.
    caption : str
        The caption.
    columns : list of str, length columns
        The keys of the columns, which are the same in every version; columns of runs have the names of the runs.
    labels : list of str, length columns
        The headings of the columns.
    rows : list of list, lengths rows and columns
        The values of the cells: numbers in SI units, texts, ``True`` and ``False``, or ``None`` if undefined. For a
        number with an interval, only the number.
    texts : list of list of str, lengths rows and columns
        The cells as texts, with units and intervals, as every surface shows them.
    meanings : list of str, length rows
        The meaning of each row in a sentence; empty if the name of the row suffices.

    >>> import trocar
    >>> table = trocar.compare("layers/through-the-skin", "layers/skin-augmented").document.tables["main"]
    >>> table.columns
    ['metric', 'through-the-skin', 'skin-augmented', 'change']
    >>> len(table.rows) == len(table.texts), table.texts[0][0]
    (True, 'rupture 1: overshoot at 0.3 s')
    """

    def __init__(self, contents: dict[str, Any]) -> None:
        self._contents = contents
        self.key: str = contents["key"]
        self.caption: str = contents["caption"]
        self.columns: list[str] = contents["columns"]
        self.labels: list[str] = contents["labels"]
        self.rows: list[list[Cell]] = contents["rows"]
        self.texts: list[list[str]] = contents["texts"]
        self.meanings: list[str] = contents["meanings"]

    def _column(self, at: int) -> list[Cell]:
        """Returns the values of a column if all are numbers or all are booleans, otherwise the texts."""
        values = [row[at] for row in self.rows]
        kinds = {type(value) for value in values if value is not None}
        if kinds <= {float} or kinds <= {bool}:
            return values
        return [None if value is None else row[at] for value, row in zip(values, self.texts)]

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns a pandas DataFrame, indexed by the first column. Columns of numbers are in SI units, with NaN for
        undefined values; other columns are texts.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        # Two runs with the same name give two columns with this name.
        columns = [pandas.Series(self._column(at), name=key) for at, key in enumerate(self.columns[1:], 1)]
        index = pandas.Index(self._column(0), name=self.columns[0])
        frame = pandas.concat(columns, axis="columns") if columns else pandas.DataFrame(index=range(len(index)))
        return frame.set_index(index)

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the same as :meth:`to_dataframe`, under the method name of polars and pyarrow."""
        return self.to_dataframe()

    def to_polars(self) -> polars.DataFrame:
        """Returns a polars DataFrame. Columns of numbers are in SI units, with null for undefined values; other
        columns are texts.

        Raises
        ------
        ImportError
            If polars is not installed.
        ValueError
            For two columns with the same name, which two runs with the same name give.
        """
        import polars

        if len({*self.columns}) < len(self.columns):
            raise ValueError(f"the columns are {', '.join(self.columns)}, and polars needs different names")
        return polars.DataFrame({key: self._column(at) for at, key in enumerate(self.columns)})

    def __arrow_c_stream__(self, requested_schema: object = None) -> Any:
        """Returns the columns as in :meth:`to_polars` for a library that reads Arrow. A repeated name gets a number."""
        names: list[str] = []
        for key in self.columns:
            names.append(key if key not in names else f"{key} ({self.columns[: len(names)].count(key) + 1})")
        return stream({name: self._column(at) for at, name in enumerate(names)})

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return f"Table({self.key!r}, {len(self.rows)} rows, columns {', '.join(self.columns)})"

    def _repr_html_(self) -> str:
        return table(self.labels, self.texts, self.caption)


class Figure:
    """A figure of a :class:`Document`, as data.

    Attributes
    ----------
    name : str
        The name, which is also the name of its file: ``loop`` for ``loop.svg``.
    description : dict
        ``name``, ``legend``, and ``rows`` of ``panels`` with their axes, lines, fills, levels, notes and events.
        Positions are in the coordinates of the axes, which are exponents of ten on a logarithmic axis; ``None`` is a
        gap. Long lines are reduced to minima and maxima.

    >>> import trocar
    >>> figure = trocar.run("layers/skin-augmented").document.figures["energy"]
    >>> figure
    Figure('energy', 2 panels)
    >>> [panel["x"]["caption"] for row in figure.description["rows"] for panel in row["panels"]]
    ['Time (s)', 'Time (s)']
    """

    def __init__(self, name: str, description: dict[str, Any]) -> None:
        self.name = name
        self.description = description

    def plot(self, **options: Any) -> matplotlib.figure.Figure:
        """Draws the figure with matplotlib. Options and errors as for :meth:`Run.plot`."""
        from ._figures import draw

        return draw(self.description, **options)

    def to_matplotlib(self, **options: Any) -> matplotlib.figure.Figure:
        """Draws the figure like :meth:`plot`."""
        return self.plot(**options)

    def __repr__(self) -> str:
        panels = sum(len(row["panels"]) for row in self.description["rows"])
        return f"Figure({self.name!r}, {panels} panel{'' if panels == 1 else 's'})"


class Document:
    """The document of a result, in the words of the command line. ``print`` shows its text.

    Every result has one: ``trocar.run(...).document``. Python neither words nor computes any of its content.

    Attributes
    ----------
    title : str
        The studied scenario, recording or sweep.
    sentences : list of str
        The answer, with the numbers that support it. Empty if the tables are the answer.
    left_out : list of str
        Further sentences about limits of the answer.
    warnings : list of TrocarWarning
        The warnings, which were issued when the result was computed.
    tables : dict of str to Table
        The tables by their keys, in the displayed order.

    >>> import trocar
    >>> document = trocar.stability("paper/classical", "scaling.force=1:2:2", "tissue.stiffness_n_per_m=100:200:2").document
    >>> document.title, document.verdict == " ".join(document.sentences)
    ('classical', True)
    >>> list(document.tables)[:2], list(document.figures)[:3]
    (['loop', 'limits'], ['stability', 'ports', 'loop'])
    """

    def __init__(self, contents: dict[str, Any], further_figures: Callable[[], dict[str, Any]] = dict) -> None:
        self._contents = contents
        # These figures show every sample, so they are described on demand.
        self._further_figures = further_figures
        self.title: str = contents["title"]
        self.sentences: list[str] = contents["sentences"]
        self.left_out: list[str] = contents["left_out"]
        self.warnings: list[TrocarWarning] = [warning_of(one) for one in contents["warnings"]]
        self.tables: dict[str, Table] = {one["key"]: Table(one) for one in contents["tables"]}

    @property
    def verdict(self) -> str:
        """The sentences of the answer as one paragraph."""
        return " ".join(self.sentences)

    @cached_property
    def figures(self) -> dict[str, Figure]:
        """The figures by their names, in the order of drawing."""
        described = {**self._further_figures(), **self._contents["figures"]}
        return {name: Figure(name, description) for name, description in described.items()}

    def __reduce__(self) -> tuple[object, ...]:
        described = {name: figure.description for name, figure in self.figures.items()}
        return Document, ({**self._contents, "figures": described},)

    def __str__(self) -> str:
        text: str = self._contents["text"]
        return text

    def __repr__(self) -> str:
        return f"Document({self.title!r}, tables {', '.join(self.tables) or 'none'})"

    def _repr_html_(self) -> str:
        answer = ": ".join(filter(None, [self.title, " ".join([*self.sentences, *self.left_out])]))
        shown = [one for one in self.tables.values() if one._contents["is_short"]]
        captions = [answer, *(one.caption for one in shown[1:])]
        return "".join(table(one.labels, one.texts, caption) for one, caption in zip(shown, captions)) or f"<p>{escape(answer)}</p>"


class Documented:
    """A result with a document."""

    # The content of the document, from the core.
    _contents: dict[str, Any]

    @cached_property
    def document(self) -> Document:
        """The document of the result: the answer, warnings, tables and figures."""
        return Document(self._contents, self._further_figures)

    def _further_figures(self) -> dict[str, Any]:
        """Returns the descriptions of the figures that show every sample."""
        return {}

    def __getstate__(self) -> Any:
        # The document can be made again from the result.
        return {name: value for name, value in self.__dict__.items() if name != "document"}

    def __str__(self) -> str:
        return str(self.document)

    def _repr_html_(self) -> str | None:
        return self.document._repr_html_()
