"""Builds scenes for the tests of the extension in Blender, and reads them.

Settings and extensions of Blender are in a temporary directory: import this module before bpy.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

SCRATCH = Path(tempfile.mkdtemp(prefix="supple_"))
os.environ["BLENDER_USER_RESOURCES"] = str(SCRATCH / "resources")

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402

#: Rounding of 32-bit numbers, relative to the size of the scene, in a chain of a few transformations.
ROUNDING = 1e-6


def install(path: str) -> None:
    """Install the extension from its file, with the wheel that it bundles."""
    file = str(Path(path).resolve())
    bpy.ops.extensions.package_install_files(filepath=file, repo="user_default", enable_on_install=True)
    import supple

    assert SCRATCH in Path(supple.__file__).parents, f"{supple.__file__} is not the wheel of the extension"


def module(name: str) -> Any:
    """Return a module of the extension."""
    return sys.modules[f"bl_ext.user_default.supple.{name}"]


def new_scene(frames: int = 12) -> bpy.types.Scene:
    """Return an empty scene of frames 1 to `frames`, in a saved file of its own."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.supple")
    folder = Path(tempfile.mkdtemp(dir=SCRATCH))
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.render.fps = 24
    return scene


def added(kind: Callable[..., object], name: str, **options: Any) -> bpy.types.Object:
    """Add a primitive and return its object."""
    kind(**options)
    found = bpy.context.object
    found.name = name
    return found


def cube(name: str, size: float = 1.0, cuts: int = 5, **options: Any) -> bpy.types.Object:
    """Add a cube of small faces."""
    found = added(bpy.ops.mesh.primitive_cube_add, name, size=size, **options)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=cuts)
    bpy.ops.object.mode_set(mode="OBJECT")
    return found


def soft(found: bpy.types.Object, **settings: Any) -> bpy.types.Object:
    """Make an object a soft body."""
    found.supple.enabled = True
    for name, value in {"lattice_vertices": 200, **settings}.items():
        setattr(found.supple, name, value)
    return found


def collider(found: bpy.types.Object) -> bpy.types.Object:
    """Give an object Blender's collision physics."""
    found.modifiers.new("Collision", "COLLISION")
    return found


def group(found: bpy.types.Object, name: str, is_in: Callable[[mathutils.Vector], bool]) -> None:
    """Add a vertex group of the vertices whose own position fulfills a condition."""
    vertices = [vertex.index for vertex in found.data.vertices if is_in(vertex.co)]
    found.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")


def attach(found: bpy.types.Object, vertex_group: str, **settings: Any) -> None:
    """Hold or move a vertex group."""
    attachment = found.supple.attachments.add()
    attachment.vertex_group = vertex_group
    for name, value in settings.items():
        setattr(attachment, name, value)


def local(found: bpy.types.Object) -> np.ndarray:
    """Return the evaluated vertices in the space of the object, in the current frame: (n, 3)."""
    current = found.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = current.to_mesh()
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    current.to_mesh_clear()
    return points.reshape(-1, 3)


def matrix(found: bpy.types.Object) -> np.ndarray:
    """Return the world matrix in the current frame: (4, 4)."""
    current = found.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array(current.matrix_world, float)


def world(found: bpy.types.Object) -> np.ndarray:
    """Return the evaluated vertices in world space, in the current frame: (n, 3)."""
    placed = matrix(found)
    return local(found).astype(float) @ placed[:3, :3].T + placed[:3, 3]


def faces(found: bpy.types.Object) -> list[list[int]]:
    """Return the polygons of the mesh."""
    return [list(polygon.vertices) for polygon in found.data.polygons]


def frames() -> Iterator[int]:
    """Go through the frames of the scene; the index is that of the bake."""
    scene = bpy.context.scene
    for index, frame in enumerate(range(scene.frame_start, scene.frame_end + 1)):
        scene.frame_set(frame)
        yield index


def surfaces(sim: Any) -> list[list[np.ndarray]]:
    """Return the surfaces of all bodies in all frames of the scene."""
    result = [sim.surfaces()]
    for _ in range(bpy.context.scene.frame_end - bpy.context.scene.frame_start):
        sim.advance()
        result.append(sim.surfaces())
    return result


def refused(*parts: str) -> None:
    """Check that a bake is refused with a message that has all parts, and leaves no modifier."""
    message = ""
    try:
        bpy.ops.supple.bake()
    except RuntimeError as error:
        message = str(error)
    assert all(part in message for part in parts), f'"{message}" lacks one of {parts}'
    assert not any(modifier.type == "MESH_CACHE" for found in bpy.data.objects for modifier in found.modifiers)
    assert module("session").Session.current is None
