"""Render a stretch, a drop and a squeeze without volume correction, with global and with regional correction.

Also plots the volumes over time.

    pip install ".[plot]"
    python examples/python/compare_volume.py docs/images

Writes volume.png and volume_over_time.svg to the given directory. This takes approximately two minutes and needs no
display.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from render_frames import Surface, bounds, draw, save

import supple

SCENES = Path(__file__).resolve().parents[1] / "scenes"
SETTINGS: dict[str, Any] = {"off": "off", "global": {"scope": "global"}, "regional": {"scope": "regional"}}
COLORS = {"off": "#b03a2e", "global": "#2471a3", "regional": "#1e8449"}


@dataclass(frozen=True)
class Event:
    """A frame of a scene, rendered as one column."""

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
    """Surfaces and volumes by measure of a scene: one entry per frame."""

    surfaces: list[Surface]
    volumes: list[dict[str, float]]


def run(scene: str, setting: str) -> Run:
    """Simulate a scene, and store the surface and all volumes relative to rest for every frame."""
    overrides = {"body.bust.volume": SETTINGS[setting], "body.bust.poisson_ratio": 0}
    simulation = supple.load_scene(SCENES / f"{scene}.toml", overrides=overrides)
    body = simulation.bodies[0]
    substeps = round(1 / (FRAMES_PER_SECOND * simulation.dt))
    assert body.mesh is not None
    surfaces, volumes = [], []
    for frame in range(FRAMES[scene] + 1):
        if frame > 0:
            simulation.step(substeps)
        surfaces.append(Surface(body.surface(), body.mesh.faces))
        report = body.volume_report()
        volumes.append({name: after / rest for name, (rest, _, after) in report.volumes.items()})
    return Run(surfaces, volumes)


def picture(runs: dict[tuple[str, str], Run], path: Path) -> None:
    """Draw one row per setting and one column per event."""
    meshes = {
        (setting, event): runs[event.scene, setting].surfaces[event.frame] for setting in SETTINGS for event in EVENTS
    }
    low, high = bounds(list(meshes.values()))
    figure, grid = plt.subplots(len(SETTINGS), len(EVENTS), figsize=(2.3 * len(EVENTS), 7.2), layout="constrained")
    for setting, row in zip(SETTINGS, grid, strict=True):
        for event, cell in zip(EVENTS, row, strict=True):
            cell.imshow(draw(meshes[setting, event], low, high, ground=0), interpolation="none")
            cell.set(xticks=[], yticks=[])
            cell.spines[:].set_visible(False)
            cell.set_xlabel(f"volume {runs[event.scene, setting].volumes[event.frame]['mesh']:.1%}", fontsize=10)
        row[0].set_ylabel({"off": "no correction"}.get(setting, setting), fontsize=12)
    for event, cell in zip(EVENTS, grid[0], strict=True):
        cell.set_title(event.title, fontsize=12)
    save(figure, path)


def plot(runs: dict[tuple[str, str], Run], path: Path) -> None:
    """Plot the enclosed volume and the cell volume over time, one panel per scene."""
    figure, panels = plt.subplots(1, len(FRAMES), figsize=(10, 3.6), sharey=True, layout="constrained")
    for scene, panel in zip(FRAMES, panels, strict=True):
        seconds = np.arange(FRAMES[scene] + 1) / FRAMES_PER_SECOND
        for setting, color in COLORS.items():
            for measure, style in {"mesh": "-", "cells": ":"}.items():
                percentages = [100 * volumes[measure] for volumes in runs[scene, setting].volumes]
                panel.plot(seconds, percentages, style, color=color, label=f"{setting}: {measure}")
        panel.set(title=scene.replace("_", " "), xlabel="seconds")
        panel.grid(alpha=0.3)
    panels[0].set_ylabel("displayed volume, % of rest")
    panels[-1].legend(fontsize=8)
    figure.savefig(path)


def main() -> None:
    """Run every scene with every setting, and draw the picture and the plot."""
    if len(sys.argv) != 2:
        raise SystemExit("usage: python examples/python/compare_volume.py DIRECTORY")
    directory = Path(sys.argv[1])
    directory.mkdir(parents=True, exist_ok=True)
    runs = {(scene, setting): run(scene, setting) for scene in FRAMES for setting in SETTINGS}
    picture(runs, directory / "volume.png")
    plot(runs, directory / "volume_over_time.svg")


if __name__ == "__main__":
    main()
