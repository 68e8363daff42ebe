"""Stretch, drop and squeeze in a picture: without the volume correction, with the global one, with the regional one.

Beside the picture of all nine there is a plot of the volumes over time.

    pip install . pyvista
    python examples/python/compare_volume.py docs/images

It writes volume.png and volume_over_time.svg to the folder named, in about two minutes. On a machine without a display
that has no software renderer of its own, run it under `xvfb-run -a`.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from matplotlib import pyplot as plt
from render_frames import bounds, draw

import supple

SCENES = Path(__file__).resolve().parents[1] / "scenes"
SETTINGS: dict[str, Any] = {"off": "off", "global": {"scope": "global"}, "regional": {"scope": "regional"}}
COLOURS = {"off": "#b03a2e", "global": "#2471a3", "regional": "#1e8449"}


@dataclass(frozen=True)
class Event:
    """A frame of a scene that is shown."""

    title: str
    scene: str
    frame: int


EVENTS = [
    Event("rest", "stretch_and_drop", 0),
    Event("stretch", "stretch_and_drop", 48),
    Event("drop", "stretch_and_drop", 75),
    Event("squeeze", "squeeze", 48),
]
FRAMES = {"stretch_and_drop": 120, "squeeze": 90}
FRAMES_PER_SECOND = 30


@dataclass(frozen=True)
class Run:
    """What a scene gave: one entry per frame."""

    surfaces: list[pyvista.PolyData]
    volumes: list[dict[str, float]]


def run(scene: str, setting: str) -> Run:
    """Steps a scene and keeps the surfaces, and the volumes by each measure in parts of those at rest."""
    simulation = supple.load_scene(SCENES / f"{scene}.toml", overrides={"body.bust.volume": SETTINGS[setting]})
    body = simulation.bodies[0]
    substeps = round(1 / (FRAMES_PER_SECOND * simulation.dt))
    assert body.mesh is not None
    faces = np.insert(body.mesh.faces, 0, 3, axis=1)
    surfaces, volumes = [], []
    for frame in range(FRAMES[scene] + 1):
        if frame > 0:
            simulation.step(substeps)
        surfaces.append(pyvista.PolyData(body.surface(), faces))
        report = body.volume_report()
        volumes.append({name: after / rest for name, (rest, _, after) in report.volumes.items()})
    return Run(surfaces, volumes)


def picture(runs: dict[tuple[str, str], Run], path: Path) -> None:
    """One row a setting, one column an event."""
    shown = {
        (setting, event): runs[event.scene, setting].surfaces[event.frame] for setting in SETTINGS for event in EVENTS
    }
    low, high = bounds(list(shown.values()))
    figure, grid = plt.subplots(len(SETTINGS), len(EVENTS), figsize=(2.3 * len(EVENTS), 7.2), layout="constrained")
    for setting, row in zip(SETTINGS, grid, strict=True):
        for event, cell in zip(EVENTS, row, strict=True):
            cell.imshow(draw(shown[setting, event], low, high), interpolation="none")
            cell.set(xticks=[], yticks=[])
            cell.spines[:].set_visible(False)
            cell.set_xlabel(f"volume {runs[event.scene, setting].volumes[event.frame]['mesh']:.1%}", fontsize=10)
        row[0].set_ylabel({"off": "no correction"}.get(setting, setting), fontsize=12)
    for event, cell in zip(EVENTS, grid[0], strict=True):
        cell.set_title(event.title, fontsize=12)
    figure.savefig(path, dpi=130)


def plot(runs: dict[tuple[str, str], Run], path: Path) -> None:
    """One panel a scene: what the surface encloses, and what the cells do."""
    figure, panels = plt.subplots(1, len(FRAMES), figsize=(10, 3.6), sharey=True, layout="constrained")
    for scene, panel in zip(FRAMES, panels, strict=True):
        seconds = np.arange(FRAMES[scene] + 1) / FRAMES_PER_SECOND
        for setting, colour in COLOURS.items():
            for measure, style in {"mesh": "-", "cells": ":"}.items():
                shares = [100 * volumes[measure] for volumes in runs[scene, setting].volumes]
                panel.plot(seconds, shares, style, color=colour, label=f"{setting}: {measure}")
        panel.set(title=scene.replace("_", " "), xlabel="seconds")
        panel.grid(alpha=0.3)
    panels[0].set_ylabel("volume shown, % of that at rest")
    panels[-1].legend(fontsize=8)
    figure.savefig(path)


def main() -> None:
    """Runs the scenes in each setting, and draws."""
    if len(sys.argv) != 2:
        raise SystemExit("usage: python examples/python/compare_volume.py FOLDER")
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    runs = {(scene, setting): run(scene, setting) for scene in FRAMES for setting in SETTINGS}
    picture(runs, folder / "volume.png")
    plot(runs, folder / "volume_over_time.svg")


if __name__ == "__main__":
    main()
