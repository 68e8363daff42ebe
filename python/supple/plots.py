"""Pictures of volumes, with matplotlib."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from .extras import need
from .reports import BodyReport, VolumeReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_volume"]

_BEFORE, _AFTER = "tab:orange", "tab:blue"


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
