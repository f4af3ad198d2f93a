"""Figures with matplotlib, which is imported when a figure is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .comparing import Comparison
    from .detection import Detection
    from .judging import Roc
    from .linear import Stability
    from .running import Run

# Colours of Okabe and Ito, which differ for the common forms of colour blindness.
_MASTER, _SLAVE, _REFERENCE, _ALARM = "#0072B2", "#D55E00", "#009E73", "#CC79A7"


def _panels(rows: int, options: dict[str, Any]) -> tuple[Figure, Any]:
    """Returns a new figure with its axes, or the given axes with theirs."""
    from matplotlib import pyplot

    given = options.pop("ax", None)
    if given is not None:
        axes = np.atleast_1d(np.asarray(given, dtype=object)).ravel()
        if len(axes) != rows:
            raise ValueError(f"ax has {len(axes)} axes, must have {rows}")
        if options:
            raise TypeError(f"with ax, {', '.join(options)} would have no effect")
        return axes[0].figure, axes
    options = {"sharex": True, "layout": "constrained", "figsize": (8, 2.4 * rows), **options}
    figure, axes = pyplot.subplots(rows, 1, squeeze=False, **options)
    if "inline" in pyplot.get_backend().lower():
        # A notebook shows the figure that a cell returns; an open one would be shown a second time.
        pyplot.close(figure)
    return figure, axes.ravel()


def _shade_events(axes: Any, run: Run) -> None:
    """Shades the intervals in which the slave is frozen or re-engaging."""
    time_s, mode = run["time_s"], run["mode"]
    for axis in axes:
        for value, shade in ((1, "0.8"), (2, "0.92")):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], (mode == value).astype(int), [0]])))
            for start, stop in edges.reshape(-1, 2):
                axis.axvspan(time_s[start], time_s[min(stop, len(time_s) - 1)], color=shade, zorder=0)


def run_figure(run: Run, **options: Any) -> Figure:
    figure, axes = _panels(3, options)
    time_s = run["time_s"]
    positions, forces, decision = axes
    for column, color, label in (
        ("master_position_m", _MASTER, "master"),
        ("slave_reference_m", _REFERENCE, "slave reference"),
        ("slave_position_m", _SLAVE, "slave"),
    ):
        positions.plot(time_s, 1e3 * run[column], color=color, label=label)
    for column, color, label in (
        ("operator_force_n", _MASTER, "operator"),
        ("feedback_force_n", _REFERENCE, "feedback"),
        ("tissue_force_n", _SLAVE, "tissue"),
    ):
        forces.plot(time_s, run[column], color=color, label=label)
    decision.plot(time_s, run["decision"], color=_MASTER, label="decision")
    decision.axhline(run.scenario["detector.threshold"], color="0.4", linestyle="--", label="threshold")
    for alarm_s in run.alarms_s:
        decision.axvline(alarm_s, color=_ALARM, linewidth=1)
    positions.set_ylabel("Position (mm)")
    forces.set_ylabel("Force (N)")
    decision.set_ylabel("Decision (N²)")
    decision.set_xlabel("Time (s)")
    _shade_events(axes, run)
    for axis in axes:
        axis.legend(loc="upper left")
    positions.set_title(run.scenario.name)
    return figure


def comparison_figure(comparison: Comparison, **options: Any) -> Figure:
    figure, axes = _panels(2, options)
    positions, forces = axes
    for run in comparison.runs:
        positions.plot(run["time_s"], 1e3 * run["slave_position_m"], label=run.scenario.name)
        forces.plot(run["time_s"], run["feedback_force_n"], label=run.scenario.name)
    positions.set_ylabel("Slave position (mm)")
    forces.set_ylabel("Feedback force (N)")
    forces.set_xlabel("Time (s)")
    for axis in axes:
        axis.legend(loc="upper left")
    return figure


def detection_figure(detection: Detection, **options: Any) -> Figure:
    figure, axes = _panels(3, options)
    time_s = detection["time_s"]
    for axis, column, label in zip(
        axes, ("measured_force_n", "residual_n", "decision"), ("Force (N)", "Residual (N)", "Decision")
    ):
        axis.plot(time_s, detection[column], color=_MASTER)
        axis.set_ylabel(label)
        for alarm_s in detection.alarms_s:
            axis.axvline(alarm_s, color=_ALARM, linewidth=1)
        for rupture_s in detection.report["labelled_ruptures_s"]:
            axis.axvline(rupture_s, color="0.4", linewidth=1, linestyle="--")
    threshold = detection.report["settings"]["detector"]["threshold"]
    axes[2].axhline(threshold, color="0.4", linestyle="--")
    axes[2].set_xlabel("Time (s)")
    axes[0].set_title(detection.name)
    return figure


def stability_figure(stability: Stability, **options: Any) -> Figure:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import ListedColormap

    figure, (axis,) = _panels(1, {"figsize": (6.4, 4.8), **options} if "ax" not in options else options)
    colors = ListedColormap(["#f2d7c7", "#d3e7f3"])
    axis.pcolormesh(stability.x, stability.y, stability.stable, shading="nearest", cmap=colors, vmin=0, vmax=1)
    axis.add_collection(LineCollection(list(stability.boundary), colors="0.2"))
    for name, set_scale, set_label in (("x", axis.set_xscale, axis.set_xlabel), ("y", axis.set_yscale, axis.set_ylabel)):
        about = stability.report["map"][name]
        set_scale("log" if about["spacing"] == "log" else "linear")
        set_label(about["parameter"])
    axis.set_title(f"{stability.report['scenario']}: stable where blue")
    return figure


def roc_figure(roc: Roc, **options: Any) -> Figure:
    """Each detector's curve, and its own threshold as a dot."""
    figure, (axis,) = _panels(1, {"figsize": (6.4, 4.8), **options} if "ax" not in options else options)
    at_own = roc.at_own_threshold()

    def place(point: dict[str, Any]) -> tuple[float, float]:
        return point["false_alarms_per_minute"] or 0.0, 100 * point["detection"]

    for name, points in roc.curves.items():
        # The best that any threshold reaches: a lower one that finds fewer ruptures is left out.
        front: list[tuple[float, float]] = []
        for rate, share in sorted(place(point) for point in points if point["detection"] is not None):
            if not front or share > front[-1][1]:
                front.append((rate, share))
        (line,) = axis.plot([rate for rate, _ in front], [share for _, share in front], drawstyle="steps-post", label=name)
        if at_own[name]["detection"] is not None:
            axis.plot(*place(at_own[name]), "o", color=line.get_color())
    axis.set_xscale("symlog", linthresh=0.01)
    axis.set_xlabel("False alarms (1/min)")
    axis.set_ylabel("Detected in time (%)")
    axis.legend(loc="center right")
    return figure
