#!/usr/bin/env python3
"""Renders the pictures of docs/blender.md with the extension for Blender.

python scripts/blender_pictures.py ZIP      ZIP of scripts/blender-extension; needs the package bpy
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "blender"))

# Before bpy, because it gives Blender a temporary directory for settings and extensions.
from scenes import SCRATCH, added, attach, collider, group, install, new_scene, soft  # noqa: E402  # isort: skip

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402

IMAGES = ROOT / "docs" / "images"


def paint(found: bpy.types.Object, *color: float) -> None:
    """Give an object a color."""
    material = bpy.data.materials.new(found.name)
    if material.node_tree is None:  # up to Blender 4.5
        material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*color, 1)
    surface.inputs["Roughness"].default_value = 0.45
    found.data.materials.append(material)


def smooth(found: bpy.types.Object) -> None:
    """Shade an object smoothly, and add a subdivision, which stays live after the bake."""
    found.data.shade_smooth()
    found.modifiers.new("Subdivision", "SUBSURF").render_levels = 2


def ground() -> bpy.types.Object:
    """Add a ground that is a collider."""
    found = collider(added(bpy.ops.mesh.primitive_plane_add, "Ground", size=40))
    found.supple_collider.shape = "PLANE"
    paint(found, 0.55, 0.6, 0.65)
    return found


def look(at: tuple[float, float, float], direction: tuple[float, float, float], width: float) -> None:
    """Add light and a camera that shows a width of the scene."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    towards = mathutils.Vector(direction).normalized()
    camera.location = mathutils.Vector(at) + 1.45 * width * towards
    camera.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    scene.camera = camera
    for energy, turn in ((3.0, (0.7, 0.25, 0.3)), (0.6, (0.9, -0.5, -1.0))):
        sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
        sun.data.energy, sun.data.angle, sun.rotation_euler = energy, 0.2, turn
        scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.5, 0.5, 0.5)
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 24, True
    scene.view_settings.view_transform = "Standard"


def render(frame: int, width: int, height: int) -> np.ndarray:
    """Render a frame: (height, width, 4)."""
    scene = bpy.context.scene
    scene.frame_set(frame)
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.filepath = str(SCRATCH / "frame.png")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels[:]).reshape(height, width, 4)
    bpy.data.images.remove(image)
    return pixels


def save(name: str, pictures: list[list[np.ndarray]]) -> None:
    """Save rows of pictures, the first row on top. The first row of pixels is the lowest one."""
    pixels = np.vstack([np.hstack(row) for row in reversed(pictures)])
    image = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0])
    image.pixels = pixels.ravel().tolist()
    image.filepath_raw, image.file_format = str(IMAGES / f"{name}.png"), "PNG"
    image.save()


def first_minute() -> None:
    """Suzanne falls on two balls on a ground."""
    new_scene(60)
    monkey = soft(added(bpy.ops.mesh.primitive_monkey_add, "Suzanne", location=(0.1, 0, 3.1)), material="JELLY")
    monkey.supple.lattice_vertices = 2000
    smooth(monkey)
    paint(monkey, 0.75, 0.25, 0.12)
    for x in (-0.95, 0.95):
        ball = collider(added(bpy.ops.mesh.primitive_uv_sphere_add, "Ball", radius=0.7, location=(x, 0, 0.7)))
        ball.data.shade_smooth()
        paint(ball, 0.1, 0.25, 0.5)
    ground()
    bpy.ops.supple.bake()
    look((0, 0, 1.9), (0.35, -1, 0.2), 4.8)
    save("blender_fall", [[render(frame, 300, 330) for frame in (1, 13, 17, 60)]])


def attachments() -> None:
    """A beam is pinned at one end, turned and pulled at the other by an empty, and pressed by a ball."""
    scene = new_scene(40)
    beam = added(bpy.ops.mesh.primitive_cube_add, "Beam", size=1, location=(0, 0, 1.5))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=15)
    bpy.ops.object.mode_set(mode="OBJECT")
    beam.scale = (4, 0.8, 0.8)
    soft(beam, lattice_vertices=2000, material="FLESH")
    smooth(beam)
    paint(beam, 0.75, 0.25, 0.12)
    for name, color in (("pinned", (0.1, 0.25, 0.5)), ("driven", (0.9, 0.6, 0.05))):
        paint(beam, *color)
        side = -1 if name == "pinned" else 1
        group(beam, name, lambda point, side=side: side * point.x > 0.42)
        for polygon in beam.data.polygons:
            if side * polygon.center.x > 0.42:
                polygon.material_index = len(beam.data.materials) - 1
    empty = added(bpy.ops.object.empty_add, "Empty", location=(2, 0, 1.5))
    for frame, turn, place in ((1, 0.0, (2, 0, 1.5)), (30, 2.6, (2.4, 0, 2.1))):
        empty.rotation_euler.x, empty.location = turn, place
        empty.keyframe_insert("rotation_euler", frame=frame)
        empty.keyframe_insert("location", frame=frame)
    attach(beam, "pinned", motion="PIN")
    attach(beam, "driven", motion="OBJECT", target=empty)
    ball = collider(added(bpy.ops.mesh.primitive_uv_sphere_add, "Ball", radius=0.6, location=(-0.4, 0, 2.7)))
    ball.data.shade_smooth()
    paint(ball, 0.3, 0.45, 0.3)
    for frame, z in ((1, 2.7), (30, 1.7)):
        ball.location.z = z
        ball.keyframe_insert("location", frame=frame)
    floor = added(bpy.ops.mesh.primitive_plane_add, "Floor", size=40)
    paint(floor, 0.55, 0.6, 0.65)
    bpy.ops.supple.bake()
    look((0.2, 0, 1.7), (0.3, -1, 0.35), 5.8)
    save("blender_attachments", [[render(frame, 400, 280) for frame in (scene.frame_start, 18, 34)]])


def animation() -> None:
    """Suzanne turns as she is animated, and her ears swing."""
    new_scene(30)
    pictures = []
    for is_baked in (False, True):
        if is_baked:
            bpy.ops.supple.bake()
        else:
            monkey = soft(added(bpy.ops.mesh.primitive_monkey_add, "Suzanne", location=(0, 0, 1.3)), material="JELLY")
            monkey.supple.lattice_vertices = 6000
            smooth(monkey)
            paint(monkey, 0.75, 0.25, 0.12)
            group(monkey, "head", lambda point: abs(point.x) < 0.85)
            group(monkey, "ears", lambda point: abs(point.x) > 0.85)
            attach(monkey, "head", motion="ANIMATION")
            monkey.supple.stiffness_group, monkey.supple.stiffness_factor = "ears", 0.3
            for frame, turn in ((1, 0.0), (6, 0.0), (11, 0.8), (16, -0.8), (21, 0.8), (26, -0.8), (30, 0.0)):
                monkey.rotation_euler.z = turn
                monkey.keyframe_insert("rotation_euler", frame=frame)
            floor = added(bpy.ops.mesh.primitive_plane_add, "Floor", size=40)
            paint(floor, 0.55, 0.6, 0.65)
            look((0, 0, 1.3), (0.0, -1, 0.3), 3.1)
        pictures.append([render(frame, 300, 230) for frame in (11, 13, 16, 18)])
    save("blender_animation", pictures)


if __name__ == "__main__":
    install(sys.argv[1])
    chosen: list[str] = sys.argv[2:]
    for draw in (first_minute, attachments, animation):
        if not chosen or draw.__name__ in chosen:
            draw()
