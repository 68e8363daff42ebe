"""Pictures of volumes and of studies, with matplotlib."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .extras import need
from .reports import BodyReport, VolumeReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_study", "plot_volume"]

_BEFORE, _AFTER = "tab:orange", "tab:blue"

#: The errors of a study, from those of a point; None where they are not known.
_ERRORS: dict[str, Callable[[Mapping[str, Any]], float | None]] = {
    "surface": lambda errors: errors["surface_rms"],
    "volume": lambda errors: errors["cells_volume"] if errors["mesh_volume"] is None else errors["mesh_volume"],
    "cells": lambda errors: errors["cell_volumes"],
    "path": lambda errors: errors["path"] and errors["path"]["rms_cells"],
}
_LABELS = {
    "surface": "surface, rms distance / diagonal",
    "volume": "volume, greatest relative error",
    "cells": "volumes of cells, rms relative error",
    "path": "path, rms distance from naive sums [cells]",
}


def plot_volume(
    report: VolumeReport | BodyReport | Iterable[VolumeReport | BodyReport],
    times: Sequence[float] | None = None,
    *,
    ax: Axes | None = None,
) -> Axes:
    """Plot volumes relative to those at rest, before and after the correction.

    report : VolumeReport or BodyReport
        As bars, by each measure.
    report : list of them
        As lines over time, by the measure that is kept.
    times : (k,) float, optional
        Seconds, one for each report of a list; by default the reports are counted.
    ax : matplotlib Axes, optional
        Where to draw; by default a figure of its own.

    Returns the Axes. Needs matplotlib (`pip install "supple[plot]"`).
    """
    single = isinstance(report, (VolumeReport, BodyReport))
    given = [report] if isinstance(report, (VolumeReport, BodyReport)) else list(report)
    reports = [_volume(one) for one in given]
    if not reports:
        raise ValueError("report is an empty list; there is nothing to plot")
    if times is not None and (single or len(times) != len(reports)):
        expected = "no times for a single report" if single else f"{len(reports)}, one for each report"
        raise ValueError(f"times has {len(times)} entries; it must be {expected}")
    if ax is None:
        ax = need("matplotlib.pyplot", "plot").subplots()[1]
    if single:
        _bars(ax, reports[0])
    else:
        _lines(ax, reports, times)
    ax.axhline(1.0, color="gray", linewidth=0.8, zorder=0)
    ax.set_ylabel("volume / volume at rest")
    ax.legend()
    return ax


def _volume(report: VolumeReport | BodyReport) -> VolumeReport:
    volume = report.volume if isinstance(report, BodyReport) else report
    if not isinstance(volume, VolumeReport):
        raise TypeError(f"report must be a VolumeReport, or a list of them, not {type(report).__name__}")
    return volume


def _bars(ax: Axes, report: VolumeReport) -> None:
    names = list(report.volumes)
    places = range(len(names))
    for shift, color, label, column in [(-0.2, _BEFORE, "before", 1), (0.2, _AFTER, "after", 2)]:
        shares = [volumes[column] / volumes[0] for volumes in report.volumes.values()]
        ax.bar([place + shift for place in places], shares, width=0.4, color=color, label=label)
    ax.set_xticks(list(places), [f"{name} (kept)" if name == report.measure else name for name in names])


def _lines(ax: Axes, reports: list[VolumeReport], times: Sequence[float] | None) -> None:
    along = list(range(len(reports))) if times is None else list(times)
    measure = reports[0].measure
    ax.plot(along, [one.before / one.rest for one in reports], color=_BEFORE, label=f"{measure}, before")
    ax.plot(along, [one.after / one.rest for one in reports], color=_AFTER, label=f"{measure}, after")
    ax.set_xlabel("report" if times is None else "time [s]")


def plot_study(
    study: str | os.PathLike[str] | Mapping[str, Any],
    error: Literal["surface", "volume", "cells", "path"] = "surface",
    *,
    ax: Axes | None = None,
) -> Axes:
    """Plot error against run time, as `supple study` measured them: a point for each setting, the front as a line.

    study : str, os.PathLike or dict
        A study.json, the folder that it lies in, or what it holds.
    error : "surface", "volume", "cells" or "path"
        "surface": rms distance of the mesh from that on the finest lattice, as a share of the diagonal; "volume":
        greatest relative error of the volume; "cells": rms of the relative errors of single cells' volumes; "path": rms
        distance of lattice vertices from where naive sums take them, in cells.
    ax : matplotlib Axes, optional
        Where to draw; by default a figure of its own.

    On the front is what nothing in the study is both faster and better than. Points whose error is not known, or zero,
    which has no place on the logarithmic axis, are left out. Returns the Axes. Needs matplotlib
    (`pip install "supple[plot]"`).
    """
    if error not in _ERRORS:
        known = " or ".join(f'"{name}"' for name in _ERRORS)
        raise ValueError(f'error is "{error}"; it must be {known}')
    points = _points(study)
    if ax is None:
        ax = need("matplotlib.pyplot", "plot").subplots()[1]
    of_method: dict[str, list[tuple[float, float]]] = {}
    front: list[tuple[float, float]] = []
    for point in points:
        wrong = _ERRORS[error](point["errors"])
        if not wrong or (error == "surface" and point["finest"]):
            continue
        place = (point["timing"]["total"]["median"], wrong)
        of_method.setdefault(point["method"], []).append(place)
        if error in point["front"]:
            front.append(place)
    for method, places in of_method.items():
        times, errors = zip(*places, strict=True)
        ax.scatter(times, errors, s=18, label=method, zorder=2)
    if front:
        times, errors = zip(*sorted(front), strict=True)
        ax.plot(times, errors, color="gray", linewidth=0.8, label="front", zorder=1)
    ax.set(xscale="log", yscale="log", xlabel="run time a frame [ms]", ylabel=_LABELS[error])
    if of_method:
        ax.legend()
    return ax


def _points(study: str | os.PathLike[str] | Mapping[str, Any]) -> list[Any]:
    if isinstance(study, Mapping):
        found = study
    else:
        path = Path(study)
        found = json.loads((path / "study.json" if path.is_dir() else path).read_text(encoding="utf-8"))
    points = found.get("points") if isinstance(found, Mapping) else None
    if not isinstance(points, list):
        raise ValueError("study has no points: it must be what `supple study` writes as study.json")
    return points
