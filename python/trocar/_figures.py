"""Draws the command line's figures with matplotlib, from their descriptions. Imports matplotlib only when a figure is
drawn."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Height of an axis on a page, in points, per inch of a figure in a notebook.
_POINTS_PER_INCH = 62.0


def window_of(window: tuple[float, float] | None) -> tuple[float, float] | None:
    """Returns a window of time in s, whose ends must ascend."""
    if window is None:
        return None
    first_s, last_s = (number("window", end) for end in window)
    if not -math.inf < first_s < last_s < math.inf:
        raise ValueError(f"window is ({first_s}, {last_s}), must be two times in s, the second one later")
    return first_s, last_s


def draw(description: dict[str, Any], **options: Any) -> Figure:
    """Draws a figure of the command line from its description, on the axes ``ax`` if given. Passes other options to
    ``matplotlib.pyplot.subplots``."""
    rows = description["rows"]
    panels = [panel for row in rows for panel in row["panels"]]
    is_new = options.get("ax") is None
    figure, axes = _axes(rows, len(panels), options)
    columns = _columns(rows)
    for k, (axis, panel) in enumerate(zip(axes, panels)):
        below = panels[k + columns] if len(panels) == columns * len(rows) and k + columns < len(panels) else None
        _panel(axis, panel, is_labelled=below is None or below["x"] != panel["x"])
    entries: dict[tuple[str, str], dict[str, Any]] = {}
    for entry in [*description["legend"], *(entry for panel in panels for entry in panel["legend"])]:
        if entry["kind"] != "title":
            entries.setdefault((entry["kind"], entry["text"]), entry)
    if entries and is_new:
        # Place the legend above the axes, where it hides no line.
        samples = zip(*map(_sample, entries.values()))
        look: dict[str, Any] = {"fontsize": "small", "frameon": False, "alignment": "left", "title_fontsize": "medium"}
        figure.legend(*samples, title=description["name"], loc="outside upper left", ncols=min(len(entries), 5), **look)
    elif entries:
        axes[0].legend(*zip(*map(_sample, entries.values())), fontsize="small")
        axes[0].set_title(description["name"])
    for row, first in zip(rows, np.cumsum([0, *(len(row["panels"]) for row in rows)])):
        if row["title"]:
            axes[first].set_title(row["title"], loc="left", fontsize="small")
    return figure


def _columns(rows: list[dict[str, Any]]) -> int:
    return max(len(row["panels"]) for row in rows)


def _axes(rows: list[dict[str, Any]], panels: int, options: dict[str, Any]) -> tuple[Figure, Any]:
    """Returns a new figure with its axes, or the given axes with their figure."""
    from matplotlib import pyplot

    given = options.pop("ax", None)
    if given is not None:
        axes = np.atleast_1d(np.asarray(given, dtype=object)).ravel()
        if len(axes) != panels:
            raise ValueError(f"ax has {len(axes)} axes, must have {panels}")
        if options:
            raise TypeError(f"with ax, {', '.join(options)} would have no effect")
        return axes[0].figure, axes
    columns = _columns(rows)
    heights = [max(row["height"], 60.0) for row in rows]
    size = (8, sum(heights) / _POINTS_PER_INCH + 0.6)
    options = {"layout": "constrained", "figsize": size, "height_ratios": heights, **options}
    figure, axes = pyplot.subplots(len(rows), columns, squeeze=False, **options)
    if "inline" in pyplot.get_backend().lower():
        # Close the figure, because a notebook shows the figure that a cell returns and would show an open one twice.
        pyplot.close(figure)
    drawn = []
    for row, of_row in zip(rows, axes):
        for axis in of_row[len(row["panels"]) :]:
            axis.remove()
        drawn += list(of_row[: len(row["panels"])])
    return figure, np.array(drawn, dtype=object)


def _style(style: dict[str, Any]) -> dict[str, Any]:
    """Returns the options of a line. Converts dashes from points to matplotlib's line widths."""
    dashes = [length / style["width"] for length in style["dashes"]]
    return {"color": style["color"], "linewidth": style["width"], "linestyle": (0, tuple(dashes)) if dashes else "-"}


def _sample(entry: dict[str, Any]) -> tuple[Any, str]:
    """Returns the sample and the text of a legend's entry."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    style = entry["style"]
    samples: dict[str, Callable[[], Any]] = {
        "line": lambda: Line2D([], [], **_style(style)),
        "dot": lambda: Line2D([], [], color=style["color"], marker="o", linestyle="", markersize=style["width"] + 1),
        "shade": lambda: Patch(color=style["color"]),
        "alarm": lambda: Line2D([], [], color="#1a1a1a", marker="v", linestyle=""),
        "rupture": lambda: Line2D([], [], color="#6e6e6e", linestyle="--", linewidth=0.8),
    }
    return samples[entry["kind"]](), entry["text"]


def _values(axis: dict[str, Any], places: list[float | None]) -> Any:
    """Returns values from positions on an axis, which are exponents of ten on a logarithmic axis; gaps are NaN."""
    values = np.array(places, dtype=np.float64)
    return 10.0**values if axis["log"] else values


def _panel(axis: Any, panel: dict[str, Any], *, is_labelled: bool) -> None:
    x, y = panel["x"], panel["y"]
    for start, end, color in panel["shades"]:
        axis.axvspan(start, end, color=color, linewidth=0, zorder=0)
    for rupture in panel["ruptures"]:
        axis.axvline(rupture, color="#6e6e6e", linestyle="--", linewidth=0.8)
    for fill in panel["fills"]:
        axis.fill(_values(x, fill["points"][0]), _values(y, fill["points"][1]), color=fill["color"], linewidth=0)
    for line in panel["lines"]:
        xs, ys = _values(x, line["points"][0]), _values(y, line["points"][1])
        if len(xs) == 1:
            axis.plot(xs, ys, "o", color=line["style"]["color"], markersize=line["style"]["width"] + 1)
        else:
            axis.plot(xs, ys, **_style(line["style"]))
    for level in panel["levels"]:
        axis.axhline(_values(y, [level["at"]])[0], **_style(level["style"]))
    for across, up, text in panel["notes"]:
        axis.text(_values(x, [across])[0], _values(y, [up])[0], text, ha="center", va="center", fontsize="small")
    for name, of in (("x", x), ("y", y)):
        getattr(axis, f"set_{name}scale")("log" if of["log"] else "linear")
        getattr(axis, f"set_{name}lim")(*_values(of, [of["low"], of["high"]]))
        if not of["ticks"]:
            getattr(axis, f"set_{name}ticks")([])
    for alarm in panel["alarms"]:
        if x["low"] <= alarm <= x["high"]:
            axis.plot(alarm, 1.0, "v", color="#1a1a1a", transform=axis.get_xaxis_transform(), clip_on=False)
    axis.set_ylabel(y["caption"])
    if is_labelled:
        axis.set_xlabel(x["caption"])
    if panel["is_bare"]:
        axis.set_axis_off()
