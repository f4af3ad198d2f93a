"""What a result says: the answer, warnings, tables and figures, as terminal, report and page show them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

from ._html import table
from ._warnings import TrocarWarning, warning_of

if TYPE_CHECKING:
    import matplotlib.figure
    import pandas
    import polars

Cell = float | str | bool | None
"""The value of a cell: a number in SI units, a text, yes or no, or ``None`` for an undefined one."""


class Table:
    """A table of a :class:`Document`. The first column names the rows.

    Attributes
    ----------
    key : str
        Its key, which stays the same from version to version.
    caption : str
        Its caption.
    columns : list of str, length columns
        The keys of the columns, which stay the same from version to version; those of runs are their names.
    labels : list of str, length columns
        The headings of the columns.
    rows : list of list, lengths rows and columns
        The values of the cells: numbers in SI units, texts, ``True`` and ``False``, or ``None`` where undefined. Of a number with an
        interval, the number alone.
    texts : list of list of str, lengths rows and columns
        The cells as every surface shows them, with units and intervals.
    meanings : list of str, length rows
        What each row means, in a sentence; empty if its name says it.

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
        """The values of a column that has only numbers or only flags, otherwise its texts."""
        values = [row[at] for row in self.rows]
        kinds = {type(value) for value in values if value is not None}
        if kinds <= {float} or kinds <= {bool}:
            return values
        return [None if value is None else row[at] for value, row in zip(values, self.texts)]

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns a pandas DataFrame, indexed by the first column. A column with only numbers has them in SI units, NaN where undefined;
        others have the texts.

        Raises
        ------
        ImportError
            Without pandas.
        """
        import pandas

        # A comparison of two runs of the same name has two columns of this name.
        columns = [pandas.Series(self._column(at), name=key) for at, key in enumerate(self.columns[1:], 1)]
        index = pandas.Index(self._column(0), name=self.columns[0])
        frame = pandas.concat(columns, axis="columns") if columns else pandas.DataFrame(index=range(len(index)))
        return frame.set_index(index)

    def to_pandas(self) -> pandas.DataFrame:
        """The same as :meth:`to_dataframe`, as polars and pyarrow name it."""
        return self.to_dataframe()

    def to_polars(self) -> polars.DataFrame:
        """Returns a polars DataFrame. A column with only numbers has them in SI units, null where undefined; others have the texts.

        Raises
        ------
        ImportError
            Without polars.
        ValueError
            For two columns of the same name, as of two runs of the same name.
        """
        import polars

        if len({*self.columns}) < len(self.columns):
            raise ValueError(f"the columns are {', '.join(self.columns)}, and polars needs different names")
        return polars.DataFrame({key: self._column(at) for at, key in enumerate(self.columns)})

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
        Its name, as that of its file: ``loop`` for ``loop.svg``.
    description : dict
        ``name``, ``legend``, and ``rows`` of ``panels`` with their axes, lines, fills, levels, notes and events. Places are in the
        coordinates of the axes, exponents of ten on a logarithmic one; ``None`` is a gap. Long lines are reduced to minima and maxima.

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
        """The same as :meth:`plot`."""
        return self.plot(**options)

    def __repr__(self) -> str:
        panels = sum(len(row["panels"]) for row in self.description["rows"])
        return f"Figure({self.name!r}, {panels} panel{'' if panels == 1 else 's'})"


class Document:
    """What a result says, in the words of the command line. ``print`` shows its text.

    Every result has one: ``trocar.run(...).document``. Nothing in it is worded or computed in Python.

    Attributes
    ----------
    title : str
        What was studied: a scenario, a recording, a sweep.
    sentences : list of str
        The answer, with the numbers it rests on. Empty if the tables are the answer.
    left_out : list of str
        What the answer leaves out, as further sentences.
    warnings : list of TrocarWarning
        The warnings, which were issued when the result was computed.
    tables : dict of str to Table
        The tables by their keys, in the order in which they are shown.

    >>> import trocar
    >>> document = trocar.stability("paper/classical", "scaling.force=1:2:2", "tissue.stiffness_n_per_m=100:200:2").document
    >>> document.title, document.verdict == " ".join(document.sentences)
    ('classical', True)
    >>> list(document.tables)[:2], list(document.figures)[:3]
    (['loop', 'limits'], ['stability', 'ports', 'loop'])
    """

    def __init__(self, contents: dict[str, Any], further_figures: Callable[[], dict[str, Any]] = dict) -> None:
        self._contents = contents
        # They show every sample, and are described when they are asked for.
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
        """The figures by their names, in the order in which they are drawn."""
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

    # What the core has told of the document.
    _contents: dict[str, Any]

    @cached_property
    def document(self) -> Document:
        """What the result says: the answer, warnings, tables and figures."""
        return Document(self._contents, self._further_figures)

    def _further_figures(self) -> dict[str, Any]:
        """The descriptions of the figures that show every sample."""
        return {}

    def __getstate__(self) -> Any:
        # The document is made again from what the result has.
        return {name: value for name, value in self.__dict__.items() if name != "document"}

    def __str__(self) -> str:
        return str(self.document)

    def _repr_html_(self) -> str | None:
        return self.document._repr_html_()
