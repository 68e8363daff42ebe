"""The folder, the files and the modifiers of bakes."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path

import bpy
from bpy.types import Object, Scene

from ..bake import BakeError
from .stack import bake_of, place_of

#: Name of the modifier of a bake.
NAME = "Supple"


def is_temporary(scene: Scene) -> bool:
    """Return whether the caches of a scene are lost when Blender ends, because the file is not saved."""
    return not bpy.data.is_saved and (not scene.supple.directory or scene.supple.directory.startswith("//"))


def cache_path(scene: Scene, found: Object) -> Path:
    """Return the path of the cache that a bake of an object writes."""
    name = bpy.path.clean_name(found.name)
    if name != found.name or any(
        other is not found and other.name.casefold() == found.name.casefold() for other in bpy.data.objects
    ):
        # Names that differ in characters that not all file systems distinguish get files of their own.
        name += "-" + hashlib.sha1(found.name.encode(), usedforsecurity=False).hexdigest()[:8]
    return _folder(scene) / f"{name}.pc2"


def apply(found: Object, path: Path, first_frame: int, time_scale: float) -> None:
    """Play a cache on an object, at the place of its bake among its modifiers.

    first_frame : int
        Frame of the first sample of the cache.
    time_scale : float
        Frames of the animation per frame of the scene, which the time remapping of the render settings changes.
    """
    place = place_of(found)
    modifier = bake_of(found)
    if modifier is None:
        name = found.modifiers.new(NAME, "MESH_CACHE").name
        # Blender has inserted it before modifiers that are pinned to the end.
        found.modifiers.move(found.modifiers.find(name), place)
        modifier = found.modifiers[place]
    before = Path(bpy.path.abspath(modifier.filepath)) if modifier.filepath else path
    modifier.cache_format = "PC2"
    modifier.filepath = bpy.path.relpath(str(path)) if bpy.data.is_saved else str(path)
    modifier.interpolation, modifier.deform_mode = "LINEAR", "OVERWRITE"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    # A set of axes up to Blender 4.5, and flags from 5.0 on.
    modifier.flip_axis = set() if isinstance(modifier.flip_axis, set) else (False, False, False)
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    # The sample in a frame of the scene is frame * time_scale * frame_scale - frame_start.
    modifier.frame_start, modifier.frame_scale = first_frame, 1.0 / time_scale
    found.supple.cache = path.name
    found.update_tag()
    if before != path:
        # The object, the scene or the folder was renamed since the last bake.
        _remove(found, before)


def clear(found: Object) -> bool:
    """Remove the bake of an object: its modifier, and its file unless another object plays it.

    Returns whether there was one. Raises BakeError for a file that cannot be removed.
    """
    modifier = bake_of(found)
    if modifier is None:
        found.supple.cache = ""
        return False
    path = Path(bpy.path.abspath(modifier.filepath))
    found.modifiers.remove(modifier)
    found.supple.cache = ""
    _remove(found, path)
    return True


def _remove(found: Object, path: Path) -> None:
    """Remove the file of a bake of an object, unless an object plays it, and its folder, if nothing else is in it."""
    modifiers = (modifier for other in bpy.data.objects for modifier in other.modifiers)
    played = (modifier.filepath for modifier in modifiers if modifier.type == "MESH_CACHE")
    if any(Path(bpy.path.abspath(file)) == path for file in played):
        return
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        message = f'the file of the bake of object "{found.name}" stays: {error}; remove it yourself'
        raise BakeError(message) from error
    with suppress(OSError):  # other files are in the folder
        if path.parent.name.startswith("supple_"):
            path.parent.rmdir()


def _folder(scene: Scene) -> Path:
    """Return the folder of the caches: that of the settings, or one beside the file, or a temporary one."""
    if scene.supple.directory and not is_temporary(scene):
        return Path(bpy.path.abspath(scene.supple.directory)).absolute()
    if bpy.data.is_saved:
        file = Path(bpy.data.filepath)
        return file.parent / f"supple_{file.stem}"
    return Path(bpy.app.tempdir) / "supple_bakes"
