#!/usr/bin/env python3
"""Renders docs/images/hero.webp: the bust of stretch_and_drop.toml without and with the volume correction.

target/tools/blender/bin/python scripts/hero.py [PROGRAM]      PROGRAM is target/release/supple by default

Needs the packages bpy, which scripts/test-tools installs in target/tools/blender, and Pillow, which
`target/tools/blender/bin/pip install pillow` adds. The stretch is shown at its speed, the drop at half of its speed. At
the end the bust is lifted to where it began, so that the pictures loop.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import mathutils
import numpy as np
from PIL import Image, ImageChops, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parents[1]
SCENES = ROOT / "examples" / "scenes"
PLAIN = ["--set", 'body.bust.volume="off"', "--set", "body.bust.poisson_ratio=0"]
RUNS = {"without correction": PLAIN, "with volume correction": []}
SIMULATED, SHOWN = 50, 25
"""Frames per second of the simulation and of the animation."""
STRETCHED, DROPPED, LIFTED = (10, 70), (91, 130), 10
"""First and last frame of the stretch and of the drop, and the number of pictures in which the bust is lifted."""
WIDTH, HEIGHT = 880, 440
UNITS = 13.5
"""Width of a picture in units of the scene."""
VIEW = mathutils.Vector((0.42, -1.0, 0.26)).normalized()
"""Direction from the bust to the camera; z is up, as in Blender."""
CLAY, RED = np.array([0.20, 0.31, 0.45]), np.array([0.55, 0.05, 0.04])
"""Linear colors of a bust with its rest volume, and of one with a relative error of REDDEST."""
REDDEST = 0.2
BACKGROUND, INK, WRONG = (246, 246, 244), (60, 66, 74), (184, 40, 28)


def run(program: str, options: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Run the scene; return the points, (frames, n, 3), z up, and the volumes relative to rest, (frames,)."""
    with tempfile.TemporaryDirectory() as folder:
        stats = Path(folder) / "stats.csv"
        command = [program, "run", SCENES / "stretch_and_drop.toml", "-o", folder, "--format", "pc2", "--stats", stats]
        options = [*options, "--quiet", "--set", f"simulation.fps={SIMULATED}", "--frames", str(DROPPED[1])]
        subprocess.run([*command, *options], check=True)
        with stats.open(newline="") as file:
            volumes = [float(row["volume_after"]) / float(row["volume_rest"]) for row in csv.DictReader(file)]
        # A header of 32 bytes, then x, y, z of all vertices for each frame.
        points = np.fromfile(Path(folder) / "bust.pc2", "<f4", offset=32).reshape(len(volumes), -1, 3)
    return points[:, :, [0, 2, 1]] * [1, -1, 1], np.array(volumes)


def timeline() -> list[tuple[int, float, int]]:
    """Return for each picture its frame, the share of the lift back to the start, and its duration in ms."""
    duration = 1000 // SHOWN
    shown = [(frame, 0.0, duration) for frame in range(STRETCHED[0], STRETCHED[1] + 1, SIMULATED // SHOWN)]
    shown[0], shown[-1] = (STRETCHED[0], 0.0, 300), (STRETCHED[1], 0.0, 500)
    shown += [(frame, 0.0, duration) for frame in range(DROPPED[0], DROPPED[1])] + [(DROPPED[1], 0.0, 700)]
    shares = np.linspace(0, 1, LIFTED + 2)[1:-1]
    return shown + [(DROPPED[1], share * share * (3 - 2 * share), duration) for share in shares]


def paint(found: bpy.types.Object, color: np.ndarray) -> None:
    """Give an object a color."""
    if not found.data.materials:
        found.data.materials.append(bpy.data.materials.new("Clay"))
    surface = found.data.materials[0].node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*color, 1)


def new_scene() -> None:
    """Add the ground, lights and the camera. The ground is white except in shadows."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=100)
    paint(bpy.context.object, np.full(3, 0.8))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", UNITS
    camera.location = mathutils.Vector((0, 0, 2.3)) + 30 * VIEW
    camera.rotation_euler = VIEW.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    for energy, angle, turn in ((4.0, 0.45, (0.7, 0.1, -0.6)), (0.6, 0.6, (0.9, -0.3, 1.2))):
        sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
        sun.data.energy, sun.data.angle, sun.rotation_euler = energy, angle, turn
        scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("World")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.55, 0.55, 0.55, 1)
    # Few samples with the fast denoiser: other settings take many times as long.
    scene.render.engine, scene.cycles.samples, scene.cycles.max_bounces = "CYCLES", 8, 1
    scene.cycles.denoising_quality = scene.cycles.denoising_prefilter = "FAST"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.use_persistent_data = True
    scene.view_settings.view_transform = "Standard"


def add_bust(side: int) -> bpy.types.Object:
    """Add the bust at the left, -1, or at the right, 1."""
    lines = (SCENES / "bust.obj").read_text().splitlines()
    faces = [[int(corner.split("/")[0]) - 1 for corner in line.split()[1:]] for line in lines if line.startswith("f ")]
    mesh = bpy.data.meshes.new("Bust")
    mesh.from_pydata(np.zeros((1 + max(map(max, faces)), 3)), [], faces)
    mesh.shade_smooth()
    bust = bpy.data.objects.new("Bust", mesh)
    bust.modifiers.new("Subdivision", "SUBSURF").render_levels = 1
    bust.location = side * UNITS / 4 * VIEW.cross((0, 0, -1)).normalized()
    bpy.context.scene.collection.objects.link(bust)
    return bust


def pose(bust: bpy.types.Object, points: np.ndarray, volume: float) -> None:
    """Move the vertices of a bust, and color it by the error of its volume."""
    bust.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    bust.data.update()
    paint(bust, CLAY + min(abs(volume - 1) / REDDEST, 1) * (RED - CLAY))


def render() -> Image.Image:
    """Render the scene."""
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        bpy.context.scene.render.filepath = file.name
        bpy.ops.render.render(write_still=True)
        return Image.open(file.name).convert("RGB")


def compose(layer: Image.Image, volumes: list[float]) -> Image.Image:
    """Put a rendered picture on the background, with titles and volumes, and round its corners."""
    picture = ImageChops.multiply(layer, Image.new("RGB", layer.size, BACKGROUND))
    draw = ImageDraw.Draw(picture)
    title, number = ImageFont.load_default(24), ImageFont.load_default(32)
    for center, name, volume in zip((WIDTH // 4, 3 * WIDTH // 4), RUNS, volumes, strict=True):
        color = INK if abs(volume - 1) < 0.0005 else WRONG
        draw.text((center, 18), name, INK, title, "mt")
        draw.text((center + 5, HEIGHT - 22), "volume", color, number, "rs")
        draw.text((center + 125, HEIGHT - 22), f"{100 * volume:.1f} %", color, number, "rs")
    corners = Image.new("L", (4 * WIDTH, 4 * HEIGHT))
    ImageDraw.Draw(corners).rounded_rectangle((0, 0, 4 * WIDTH - 1, 4 * HEIGHT - 1), 56, 255)
    picture.putalpha(corners.resize(picture.size, Image.Resampling.BOX))
    return picture


def save(pictures: list[Image.Image]) -> None:
    """Write the animation."""
    durations = [duration for _, _, duration in timeline()]
    path = ROOT / "docs" / "images" / "hero.webp"
    # Key frames only: other frames keep blocks of the one before where the color changes little.
    options = {"duration": durations, "loop": 0, "quality": 80, "method": 6, "kmin": 0, "kmax": 1}
    pictures[0].save(path, save_all=True, append_images=pictures[1:], **options)


def main(program: str) -> None:
    """Run the scene twice, and render all pictures."""
    runs = [run(program, options) for options in RUNS.values()]
    new_scene()
    busts = [add_bust(-1), add_bust(1)]
    pictures = []
    for frame, lift, _ in timeline():
        volumes = [ratios[frame] + lift * (1 - ratios[frame]) for _, ratios in runs]
        for bust, (points, _), volume in zip(busts, runs, volumes, strict=True):
            pose(bust, points[frame] + lift * (points[0] - points[frame]), volume)
        pictures.append(compose(render(), volumes))
    save(pictures)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target" / "release" / "supple"))
