"""Reads all frames of the scene."""

from __future__ import annotations

from contextlib import ExitStack

from bpy.types import Context, Object, Scene, ViewLayer

from ..bake import BakeError, Job
from .stack import only_input
from .tracks import BodyTrack, ColliderTrack


def soft_bodies(view_layer: ViewLayer) -> list[Object]:
    """Return the visible objects of a view layer that are soft bodies."""
    return [found for found in _visible_meshes(view_layer) if found.supple.enabled]


def colliders(view_layer: ViewLayer) -> list[Object]:
    """Return the visible objects of a view layer with Blender's collision physics, without soft bodies."""
    return [found for found in _visible_meshes(view_layer) if is_collider(found)]


def is_collider(found: Object) -> bool:
    """Return whether soft bodies collide with an object: it has Blender's collision physics, which is on."""
    if found.supple.enabled or found.collision is None or not found.collision.use:
        return False
    return any(modifier.type == "COLLISION" and modifier.show_viewport for modifier in found.modifiers)


class Sampler:
    """Reads soft bodies, colliders and what moves them, in one frame of the scene after another.

    While it is open, the scene is in the frame that was read last, and bakes and the modifiers after them are off.
    """

    def __init__(self, context: Context) -> None:
        """Check the scene. Raises BakeError."""
        scene = context.scene
        self._context, self._scene, self._open = context, scene, ExitStack()
        if scene.frame_end <= scene.frame_start:
            raise BakeError(
                f"the frame range of the scene, {scene.frame_start} to {scene.frame_end}, has no motion; "
                "set a later end frame in the Output properties"
            )
        self._found = soft_bodies(context.view_layer)
        if not self._found:
            raise BakeError("no visible object is a soft body; add Supple in the Physics properties of a mesh")
        for found in self._found:
            _check(found)
        self._bodies = [BodyTrack(found, scene, self._found) for found in self._found]
        self._colliders = [ColliderTrack(found) for found in colliders(context.view_layer)]
        self.frames: int = scene.frame_end - scene.frame_start + 1
        self.read_frames = 0

    def open(self) -> None:
        """Prepare to read, until `close`."""
        self._before = (self._scene.frame_current, self._scene.frame_subframe)
        self._open.enter_context(only_input(self._found))

    def read(self) -> None:
        """Read the next frame. Raises BakeError."""
        self._scene.frame_set(self._scene.frame_start + self.read_frames)
        depsgraph = self._context.evaluated_depsgraph_get()
        for body in self._bodies:
            body.read(depsgraph)
        for collider in self._colliders:
            collider.read(depsgraph)
        self.read_frames += 1

    def close(self) -> None:
        """Restore the modifiers and the frame of the scene. A second call does nothing."""
        if hasattr(self, "_before"):
            self._open.close()
            frame, subframe = self._before
            del self._before
            self._scene.frame_set(frame, subframe=subframe)

    def job(self) -> Job:
        """Return the data of the bake, after all frames were read."""
        scene = self._scene
        settings, render = scene.supple, scene.render
        read = (track.collider() for track in self._colliders)
        return Job(
            bodies=[track.body() for track in self._bodies],
            colliders=[collider for collider in read if collider is not None],
            frames=self.frames,
            fps=render.fps / render.fps_base,
            gravity=tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0),
            first_frame=scene.frame_start,
            substeps=settings.substeps if settings.use_substeps else None,
            contact=settings.contact,
        )


def time_scale(scene: Scene) -> float:
    """Return the frames of the animation per frame of the scene, which time remapping changes."""
    return float(scene.render.frame_map_old / scene.render.frame_map_new)


def _visible_meshes(view_layer: ViewLayer) -> list[Object]:
    """Return the mesh objects that Blender evaluates."""
    return [found for found in view_layer.objects if found.type == "MESH" and found.visible_get(view_layer=view_layer)]


def _check(found: Object) -> None:
    """Raise an error for an object that cannot get a bake."""
    if found.mode == "EDIT":
        raise BakeError(f'object "{found.name}" is in Edit Mode; leave it with Tab, then bake')
    if found.library is not None:
        raise BakeError(
            f'object "{found.name}" is linked from another file; make a library override (Object, Library Override)'
        )
