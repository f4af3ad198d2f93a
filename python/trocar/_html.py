"""HTML tables for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def table(heading: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> str:
    """Returns an HTML table whose first column names the rows."""
    cells = "".join(f"<th style='text-align:right'>{escape(cell)}</th>" for cell in heading[1:])
    lines = [f"<tr><th style='text-align:left'>{escape(heading[0])}</th>{cells}</tr>"]
    for first, *rest in rows:
        cells = "".join(f"<td style='text-align:right'>{escape(cell)}</td>" for cell in rest)
        lines.append(f"<tr><td style='text-align:left'>{escape(first)}</td>{cells}</tr>")
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f"<table>{title}{''.join(lines)}</table>"
