"""Tables for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

# Displayed units, and their number per SI unit.
_DISPLAYED = {"m": ("mm", 1e3), "m/s": ("mm/s", 1e3), "s": ("ms", 1e3), "J": ("mJ", 1e3)}


def quantity(value: float | None, unit: str) -> str:
    """Returns a value in SI units with its displayed unit, or a dash if it is undefined."""
    if value is None:
        return "—"
    name, factor = _DISPLAYED.get(unit, (unit, 1.0))
    number = f"{value * factor:.4g}"
    return number if name == "1" else f"{number} {name}"


def table(heading: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> str:
    """Returns an HTML table whose first column names the rows."""
    cells = "".join(f"<th style='text-align:right'>{escape(cell)}</th>" for cell in heading[1:])
    lines = [f"<tr><th style='text-align:left'>{escape(heading[0])}</th>{cells}</tr>"]
    for first, *rest in rows:
        cells = "".join(f"<td style='text-align:right'>{escape(cell)}</td>" for cell in rest)
        lines.append(f"<tr><td style='text-align:left'>{escape(first)}</td>{cells}</tr>")
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f"<table>{title}{''.join(lines)}</table>"
