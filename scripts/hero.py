#!/usr/bin/env python3
"""Renders docs/images/hero.webp: the bust of stretch_and_drop.toml without and with the volume correction.

python scripts/hero.py [PROGRAM]      PROGRAM is target/release/supple by default

The film of one scene with two busts, colored by the error of their volumes, with titles and volumes. It needs Pillow,
which the extra `plot` has. The stretch is shown at its speed, the drop at half of its speed; at the end the
picture fades to the first one.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont, ImageSequence

ROOT = Path(__file__).resolve().parents[1]
TITLES = {"plain": "without correction", "kept": "with volume correction"}
PLAIN = 'volume = "off"\npoisson_ratio = 0'
SIMULATED, SHOWN = 50, 25
"""Frames per second of the simulation and of the animation."""
STRETCHED, DROPPED, FADED = (10, 70), (91, 130), 8
"""First and last frame of the stretch and of the drop, and the number of pictures that fade to the first one."""
WIDTH, HEIGHT = 880, 440
BACKGROUND, INK, WRONG = (240, 240, 238), (60, 66, 74), (184, 40, 28)

SCENE = """
[simulation]
frames = {frames}
fps = {fps}
contact = false

[output]
format = "film"
film_size = [{width}, {height}]
film_view = [0.16, 0.24, 1]
film_color = "volume"

[[collider]]
plane = {{ point = [0, 0, 0], normal = [0, 1, 0] }}
friction = 0.6
"""
BODY = """
[[body]]
name = "{name}"
mesh = "{mesh}"
translate = [{x}, -5.3, 0]
lattice_vertices = 2500
{options}

[[body.pin]]
box = {{ min = [{low}, 0, -2], max = [{high}, 0.55, 2] }}
end = 1.8

[[body.handle]]
box = {{ min = [{low}, 3.35, -2], max = [{high}, 5, 3] }}
keys = [ {{ time = 0.2 }}, {{ time = 1.4, translate = [0, 1.25, 0] }} ]
end = 1.8
"""


def run(program: str) -> tuple[list[Image.Image], dict[str, list[float]]]:
    """Run the scene; return the pictures of all frames, and the volumes of each bust relative to rest."""
    scene = SCENE.format(frames=DROPPED[1], fps=SIMULATED, width=WIDTH, height=HEIGHT)
    mesh = (ROOT / "examples" / "scenes" / "bust.obj").as_posix()
    for name, x, options in (("plain", -3.3, PLAIN), ("kept", 3.3, 'volume = "mesh"')):
        scene += BODY.format(name=name, mesh=mesh, x=x, low=x - 3, high=x + 3, options=options)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "hero.toml").write_text(scene)
        command = [program, "run", folder / "hero.toml", "-o", folder, "--stats", folder / "stats.csv", "--quiet"]
        subprocess.run(command, check=True)
        volumes: dict[str, list[float]] = {name: [] for name in TITLES}
        with (folder / "stats.csv").open(newline="") as file:
            for row in csv.DictReader(file):
                volumes[row["body"]].append(float(row["volume_after"]) / float(row["volume_rest"]))
        with Image.open(folder / "supple.webp") as film:
            return [picture.convert("RGB") for picture in ImageSequence.Iterator(film)], volumes


def timeline() -> list[tuple[int, int]]:
    """Return for each picture its frame and its duration in ms."""
    duration = 1000 // SHOWN
    shown = [(frame, duration) for frame in range(STRETCHED[0], STRETCHED[1] + 1, SIMULATED // SHOWN)]
    shown[0], shown[-1] = (STRETCHED[0], 300), (STRETCHED[1], 500)
    return shown + [(frame, duration) for frame in range(DROPPED[0], DROPPED[1])] + [(DROPPED[1], 700)]


def label(picture: Image.Image, volumes: list[float]) -> Image.Image:
    """Add titles and volumes to a picture, and round its corners."""
    draw = ImageDraw.Draw(picture)
    title, number = ImageFont.load_default(24), ImageFont.load_default(32)
    for center, name, volume in zip((WIDTH // 4, 3 * WIDTH // 4), TITLES.values(), volumes, strict=True):
        color = INK if abs(volume - 1) < 0.0005 else WRONG
        draw.text((center, 18), name, INK, title, "mt")
        draw.text((center + 5, HEIGHT - 18), "volume", color, number, "rs")
        draw.text((center + 125, HEIGHT - 18), f"{100 * volume:.1f} %", color, number, "rs")
    corners = Image.new("L", (4 * WIDTH, 4 * HEIGHT))
    ImageDraw.Draw(corners).rounded_rectangle((0, 0, 4 * WIDTH - 1, 4 * HEIGHT - 1), 56, 255)
    picture.putalpha(corners.resize(picture.size, Image.Resampling.BOX))
    return picture


def main(program: str) -> None:
    """Run the scene, label the pictures and write the animation."""
    frames, volumes = run(program)
    shown = timeline()
    pictures = [label(frames[frame].copy(), [volumes[name][frame] for name in TITLES]) for frame, _ in shown]
    durations = [duration for _, duration in shown] + [1000 // SHOWN] * FADED
    shares = [(k + 1) / (FADED + 1) for k in range(FADED)]
    pictures += [Image.blend(pictures[-1], pictures[0], share) for share in shares]
    path = ROOT / "docs" / "images" / "hero.webp"
    # Key frames only: other frames keep blocks of the one before where the color changes little.
    options = {"duration": durations, "loop": 0, "quality": 80, "method": 6, "kmin": 0, "kmax": 1}
    pictures[0].save(path, save_all=True, append_images=pictures[1:], **options)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target" / "release" / "supple"))
