"""The folder, the files and the modifiers of bakes."""

from __future__ import annotations

import hashlib
import re
import unicodedata
from contextlib import suppress
from pathlib import Path

import bpy
from bpy.types import Object, Scene

from ..bake import BakeError
from .stack import bake_of, place_of

#: Name of the modifier of a bake.
NAME = "Supple"

#: Greatest number of characters of an object's name in the name of its file. File systems allow 255 bytes, of which a
#: character needs up to 4.
LENGTH = 50

#: Names that Windows reserves for devices.
RESERVED = re.compile(r"con|prn|aux|nul|(com|lpt)\d", re.IGNORECASE)


def is_temporary(scene: Scene) -> bool:
    """Return whether the caches of a scene are lost when Blender ends, because the file is not saved."""
    return not bpy.data.is_saved and (not scene.supple.directory or scene.supple.directory.startswith("//"))


def cache_path(scene: Scene, found: Object) -> Path:
    """Return the path of the cache that a bake of an object writes."""
    name = bpy.path.clean_name(found.name)[:LENGTH]
    folded = _folded(found.name)
    is_shared = any(other is not found and _folded(other.name) == folded for other in bpy.data.objects)
    if name != found.name or is_shared or RESERVED.fullmatch(name):
        # Names that differ in characters that not all file systems distinguish get files of their own.
        name += "-" + hashlib.sha1(found.name.encode(), usedforsecurity=False).hexdigest()[:8]
    return _folder(scene) / f"{name}.pc2"


def apply(found: Object, path: Path, first_frame: int, time_scale: float) -> Path | None:
    """Play a cache on an object, at the place of its bake among its modifiers.

    Returns the file of the earlier bake if it is another one, because the object, the scene or the folder was renamed.
    Remove it with `remove_file` when all objects have their caches: objects may have exchanged their names.

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
    before = _absolute(modifier.filepath) if modifier.filepath else path.resolve()
    modifier.cache_format = "PC2"
    modifier.filepath = _stored(path)
    modifier.interpolation, modifier.deform_mode = "LINEAR", "OVERWRITE"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    # A set of axes up to Blender 4.5, and flags from 5.0 on.
    modifier.flip_axis = set() if isinstance(modifier.flip_axis, set) else (False, False, False)
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    # The sample in a frame of the scene is frame * time_scale * frame_scale - frame_start.
    modifier.frame_start, modifier.frame_scale = first_frame, 1.0 / time_scale
    found.supple.cache = path.name
    found.update_tag()
    return None if before == path.resolve() else before


def clear(found: Object) -> bool:
    """Remove the bake of an object: its modifier, and its file as `remove_file` does.

    Returns whether there was one. Raises BakeError for a file that cannot be removed.
    """
    modifier = bake_of(found)
    if modifier is None:
        found.supple.cache = ""
        return False
    path = _absolute(modifier.filepath)
    found.modifiers.remove(modifier)
    found.supple.cache = ""
    remove_file(path)
    return True


def remove_file(path: Path) -> None:
    """Remove the file of a bake, and its folder if nothing else is in it.

    A file that an object plays stays. So does a file outside of the folders of this blend file: it belongs to the blend
    file from which this one was saved. Raises BakeError for a file that cannot be removed.
    """
    modifiers = (modifier for found in bpy.data.objects for modifier in found.modifiers)
    played = (modifier.filepath for modifier in modifiers if modifier.type == "MESH_CACHE")
    folders = [_default_folder(), *(_folder(scene) for scene in bpy.data.scenes)]
    if path.parent not in (folder.resolve() for folder in folders) or path in map(_absolute, played):
        return
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise BakeError(f"the file of a bake cannot be removed: {error}; remove it yourself") from error
    with suppress(OSError):  # other files are in the folder
        if path.parent.name.startswith("supple_"):
            path.parent.rmdir()


def _folder(scene: Scene) -> Path:
    """Return the folder of the caches: that of the settings, or one beside the file, or a temporary one."""
    if scene.supple.directory and not is_temporary(scene):
        return _absolute(scene.supple.directory)
    return _default_folder()


def _default_folder() -> Path:
    """Return the folder of the caches of scenes without a setting: one beside the file, or a temporary one."""
    if bpy.data.is_saved:
        file = Path(bpy.data.filepath)
        return file.parent / f"supple_{file.stem}"
    return Path(bpy.app.tempdir) / "supple_bakes"


def _absolute(path: str) -> Path:
    """Return a path of Blender, which may be relative to the file, in the one form that can be compared."""
    return Path(bpy.path.abspath(path)).resolve()


def _stored(path: Path) -> str:
    """Return a path as a modifier has it: relative to the file, if there is a way from there."""
    if bpy.data.is_saved:
        with suppress(ValueError):  # on another drive of Windows
            return str(bpy.path.relpath(str(path)))
    return str(path)


def _folded(name: str) -> str:
    """Return a name without the differences that some file systems ignore: case, and composed characters."""
    return unicodedata.normalize("NFC", name.casefold())
