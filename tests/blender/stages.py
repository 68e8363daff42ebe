"""Imports USD stages into Blender, and compares every frame with the OBJ frames of the same run.

    python stages.py RUN [RUN ...]      folders of runs with --format obj,usd or obj,usdz; writes blender.png into each

Needs the package bpy. Exits with an error at the first difference.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import bpy
import mathutils
import numpy as np

#: Frames per second of the runs. An import does not set the rate of the scene.
FPS = 30


def read_obj(path: Path) -> tuple[np.ndarray, list[list[int]]]:
    """Return the positions and the polygons of an OBJ file."""
    lines = [line.split() for line in path.read_text().splitlines()]
    positions = np.array([line[1:4] for line in lines if line[:1] == ["v"]], np.float32)
    return positions, [[int(corner.split("/")[0]) - 1 for corner in line[1:]] for line in lines if line[:1] == ["f"]]


def evaluated(found: bpy.types.Object) -> bpy.types.Mesh:
    """Return the mesh of an object in the current frame."""
    return found.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()


def check(run: Path) -> None:
    """Compare the stage of a run with its frames, and render its last frame."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    (stage,) = run.glob("supple.usd*")
    bpy.ops.wm.usd_import(filepath=str(stage))
    frames = sorted({int(path.stem.rpartition("_")[2]) for path in run.glob("*.obj")})
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end) == (frames[0], frames[-1]), "range of frames"
    names = sorted({path.stem.rpartition("_")[0] for path in run.glob("*.obj")})
    meshes = {found.name: found for found in bpy.data.objects if found.type == "MESH"}
    assert sorted(meshes) == [re.sub(r"\W", "_", name) for name in names], "guides are not imported"
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for frame in frames:
        scene.frame_set(frame)
        for name in names:
            positions, faces = read_obj(run / f"{name}_{frame:04}.obj")
            found = meshes[re.sub(r"\W", "_", name)]
            mesh = evaluated(found)
            points = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", points)
            assert np.array_equal(points.reshape(-1, 3), positions), f"points of {name} in frame {frame}"
            assert [list(polygon.vertices) for polygon in mesh.polygons] == faces, f"faces of {name}"
            # Blender's axes: y up of the stage becomes z up.
            world = positions @ np.array(found.matrix_world.to_3x3(), np.float32).T
            turned = np.stack([positions[:, 0], -positions[:, 2], positions[:, 1]], axis=1)
            size = np.abs(turned).max()
            # The matrix has a rotation about x, whose sine and cosine are rounded to f32.
            assert np.abs(world - turned).max() <= 1e-6 * size, f"axes of {name}"
            low, high = np.minimum(low, world.min(axis=0)), np.maximum(high, world.max(axis=0))
    check_surface(run, names, meshes)
    for found in meshes.values():
        check_velocities(found, frames[len(frames) // 2])
    render(run / "blender.png", (low + high) / 2, float(np.linalg.norm(high - low)))
    print(f"{run.name}: {len(frames)} frames of {len(names)} bodies, as in the OBJ frames")


def check_surface(run: Path, names: list[str], meshes: dict[str, bpy.types.Object]) -> None:
    """Compare materials and texture coordinates with those of the OBJ file."""
    for name in names:
        lines = [line.split() for line in next(run.glob(f"{name}_*.obj")).read_text().splitlines()]
        materials = {re.sub(r"\W", "_", " ".join(line[1:])) for line in lines if line[:1] == ["usemtl"]}
        found = meshes[re.sub(r"\W", "_", name)]
        assert {slot.material.name for slot in found.material_slots} == materials, f"materials of {name}"
        coordinates = [line[1:3] for line in lines if line[:1] == ["vt"]]
        if coordinates:
            corners = [corner.split("/")[1] for line in lines if line[:1] == ["f"] for corner in line[1:]]
            expected = np.array([coordinates[int(corner) - 1] for corner in corners], np.float32)
            layer = found.data.uv_layers[0].data
            assert np.array_equal(np.array([corner.uv for corner in layer], np.float32), expected), f"UVs of {name}"


def check_velocities(found: bpy.types.Object, frame: int) -> None:
    """Compare the velocities of a stage that has them with the change of its points, per second."""
    scene = bpy.context.scene
    vectors = {}
    for number in (frame - 1, frame, frame + 1):
        scene.frame_set(number)
        mesh = evaluated(found)
        for name, attribute in mesh.attributes.items():
            if name in ("position", "velocity"):
                values = np.empty(3 * len(mesh.vertices), np.float32)
                attribute.data.foreach_get("vector", values)
                vectors[name, number] = values.reshape(-1, 3)
    velocities = vectors.get(("velocity", frame))
    if velocities is None:
        return
    change = (vectors["position", frame + 1] - vectors["position", frame - 1]) * FPS / 2
    # A choice: the bodies fall freely in the middle of the run, and steps have half of their length of delay.
    error = np.linalg.norm(velocities - change, axis=1).max() / np.linalg.norm(change, axis=1).max()
    assert error < 0.05, f"velocities of {found.name} differ by {error:.0%}"
    print(f"{found.name}: velocities, within {error:.1%} of the change of its points")


def render(path: Path, center: np.ndarray, size: float) -> None:
    """Render the current frame from the front, a little above, and check that the picture is not blank."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    direction = mathutils.Vector((0.5, -1, 0.35)).normalized()
    camera.location = mathutils.Vector(center) + 1.5 * size * direction
    camera.rotation_euler = direction.to_track_quat("Z", "Y").to_euler()
    camera.data.clip_end = 10 * size
    scene.camera = camera
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 3
    sun.rotation_euler = (0.6, 0.3, 0)
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("world")
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 16
    scene.render.resolution_x, scene.render.resolution_y = 480, 360
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.array(image.pixels[:]).reshape(-1, 4)[:, :3]
    different = (np.abs(pixels - pixels[0]).max(axis=1) > 0.05).mean()
    assert 0.02 < different < 0.9, f"the body covers {different:.0%} of the picture"


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        check(Path(argument).resolve())
