"""Plots volumes and studies with matplotlib."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .extras import import_optional
from .reports import BodyReport, VolumeReport
from .types import PathLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_study", "plot_volume"]

_BEFORE, _AFTER = "tab:orange", "tab:blue"

#: Functions that read an error from the errors of a point in a study. They return None if the error is not known.
_ERRORS: dict[str, Callable[[Mapping[str, Any]], float | None]] = {
    "surface": lambda errors: errors["surface_rms"],
    "volume": lambda errors: errors["cells_volume"] if errors["mesh_volume"] is None else errors["mesh_volume"],
    "cells": lambda errors: errors["cell_volumes"],
    "path": lambda errors: errors["path"] and errors["path"]["rms_cells"],
}
_LABELS = {
    "surface": "surface, rms distance / diagonal",
    "volume": "volume, maximum relative error",
    "cells": "volumes of cells, rms relative error",
    "path": "path, rms distance from naive sums [cells]",
}


def plot_volume(
    report: VolumeReport | BodyReport | Iterable[VolumeReport | BodyReport],
    times: Sequence[float] | None = None,
    *,
    ax: Axes | None = None,
) -> Axes:
    """Plot volumes relative to the rest volume, before and after the correction.

    report : VolumeReport or BodyReport, or a list of them
        One report gives bars, one pair per measure. A list gives lines over time, by the measure of the correction.
    times : (k,) float, optional
        Times in seconds, one per report of a list. Default: the index of the report.
    ax : matplotlib Axes, optional
        Axes to draw on. Default: a new figure.

    Returns the Axes. Needs matplotlib (`pip install matplotlib`).
    """
    single = isinstance(report, (VolumeReport, BodyReport))
    if not isinstance(report, (VolumeReport, BodyReport, Iterable)):
        raise TypeError(f"report must be a VolumeReport, a BodyReport, or a list of them, not {type(report).__name__}")
    given = [report] if isinstance(report, (VolumeReport, BodyReport)) else list(report)
    reports = [_volume_report(item) for item in given]
    if not reports:
        raise ValueError("report is an empty list; it must have at least one report")
    if times is not None and not hasattr(times, "__len__"):
        raise TypeError(f"times must be a list of numbers, not {type(times).__name__}")
    if times is not None and (single or len(times) != len(reports)):
        expected = "a single report has no times" if single else f"it must have {len(reports)}, one per report"
        raise ValueError(f"times has {len(times)} entries; {expected}")
    if ax is None:
        ax = import_optional("matplotlib.pyplot").subplots()[1]
    if single:
        _bars(ax, reports[0])
    else:
        _lines(ax, reports, times)
    ax.axhline(1.0, color="gray", linewidth=0.8, zorder=0)
    ax.set_ylabel("volume / volume at rest")
    ax.legend()
    return ax


def _volume_report(report: VolumeReport | BodyReport) -> VolumeReport:
    """Return the report itself, or the volume report of a BodyReport."""
    volume = report.volume if isinstance(report, BodyReport) else report
    if not isinstance(volume, VolumeReport):
        raise TypeError(f"report must be a VolumeReport, or a list of them, not {type(report).__name__}")
    return volume


def _bars(ax: Axes, report: VolumeReport) -> None:
    """Draw the volumes of one report as a pair of bars for each measure."""
    names = list(report.volumes)
    ticks = range(len(names))
    for offset, color, label, column in [(-0.2, _BEFORE, "before", 1), (0.2, _AFTER, "after", 2)]:
        ratios = [volumes[column] / volumes[0] for volumes in report.volumes.values()]
        ax.bar([tick + offset for tick in ticks], ratios, width=0.4, color=color, label=label)
    ax.set_xticks(list(ticks), [f"{name} (kept)" if name == report.measure else name for name in names])


def _lines(ax: Axes, reports: list[VolumeReport], times: Sequence[float] | None) -> None:
    """Draw the volumes of several reports as lines over time."""
    x = list(range(len(reports))) if times is None else list(times)
    measure = reports[0].measure
    ax.plot(x, [report.before / report.rest for report in reports], color=_BEFORE, label=f"{measure}, before")
    ax.plot(x, [report.after / report.rest for report in reports], color=_AFTER, label=f"{measure}, after")
    ax.set_xlabel("report" if times is None else "time [s]")


def plot_study(
    study: PathLike | Mapping[str, Any],
    error: Literal["surface", "volume", "cells", "path"] = "surface",
    *,
    ax: Axes | None = None,
) -> Axes:
    """Plot error against run time from `supple study`: one point per setting, and the Pareto front as a line.

    study : str, os.PathLike or dict
        A file study.json, its directory, or its content.
    error : "surface", "volume", "cells" or "path"
        "surface": rms distance of the mesh from the mesh on the finest lattice, as a fraction of the diagonal of the
        mesh; "volume": maximum relative error of the volume; "cells": rms of the relative errors of the cell volumes;
        "path": rms distance of the lattice vertices from their positions in a motion with naive sums, in cells.
    ax : matplotlib Axes, optional
        Axes to draw on. Default: a new figure.

    The Pareto front consists of the points for which no other point of the study has both a shorter run time and a
    smaller error. Points whose error is unknown are omitted, and so are points whose error is zero, because the
    logarithmic axis cannot show zero. Returns the Axes. Needs matplotlib (`pip install matplotlib`).
    """
    if error not in _ERRORS:
        known = " or ".join(f'"{name}"' for name in _ERRORS)
        raise ValueError(f'error is "{error}"; it must be {known}')
    points = _points(study)
    if ax is None:
        ax = import_optional("matplotlib.pyplot").subplots()[1]
    by_method: dict[str, list[tuple[float, float]]] = {}
    front: list[tuple[float, float]] = []
    for point in points:
        value = _ERRORS[error](point["errors"])
        if not value or (error == "surface" and point["finest"]):
            continue
        coordinates = (point["timing"]["total"]["median"], value)
        by_method.setdefault(point["method"], []).append(coordinates)
        if error in point["front"]:
            front.append(coordinates)
    for method, coordinates_of_method in by_method.items():
        times, errors = zip(*coordinates_of_method, strict=True)
        ax.scatter(times, errors, s=18, label=method, zorder=2)
    if front:
        times, errors = zip(*sorted(front), strict=True)
        ax.plot(times, errors, color="gray", linewidth=0.8, label="front", zorder=1)
    ax.set(xscale="log", yscale="log", xlabel="run time per frame [ms]", ylabel=_LABELS[error])
    if by_method:
        ax.legend()
    return ax


def _points(study: PathLike | Mapping[str, Any]) -> list[Any]:
    """Return the points of a study."""
    if isinstance(study, Mapping):
        content = study
    else:
        path = Path(study)
        content = json.loads((path / "study.json" if path.is_dir() else path).read_text(encoding="utf-8"))
    points = content.get("points") if isinstance(content, Mapping) else None
    if not isinstance(points, list):
        raise ValueError("study has no points; it must be a study.json written by `supple study`")
    return points
