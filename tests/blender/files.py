"""Checks the files of bakes: names of objects, files that are saved under other names, library overrides."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from scenes import attach, cube, group, local, new_scene, refused, soft


def cache_of(found: bpy.types.Object) -> Path:
    """Return the file that the bake of an object plays."""
    return Path(bpy.path.abspath(found.modifiers["Supple"].filepath))


def check_names() -> None:
    """Objects that exchange their names exchange their files, and names that are no file names get others."""
    new_scene(4)
    left, right = soft(cube("left")), soft(cube("right", location=(3, 0, 0)))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    earlier = {found: cache_of(found) for found in (left, right)}
    left.name, right.name, left.name = "moved", "left", "right"
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert [cache_of(found) for found in (left, right)] == [earlier[right], earlier[left]]
    assert all(path.exists() for path in earlier.values())
    folder = earlier[left].parent
    right.name = "L" * 63
    left.name = "NUL"  # a device of Windows
    assert bpy.ops.supple.bake() == {"FINISHED"}
    names = sorted(path.name for path in folder.iterdir())
    assert sorted(cache_of(found).name for found in (left, right)) == names, "files of earlier names are removed"
    assert names[0].startswith("L" * 50 + "-")
    assert names[1].startswith("NUL-")


def check_versions() -> None:
    """A file that is saved under another name leaves the bakes of the first file alone."""
    new_scene(4)
    found = soft(cube("box"))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    bpy.ops.wm.save_mainfile()
    first = cache_of(found)
    contents = first.read_bytes()
    bpy.ops.wm.save_as_mainfile(filepath=str(first.parents[1] / "scene_v2.blend"))
    assert cache_of(found) == first
    assert bpy.ops.supple.clear() == {"FINISHED"}
    assert not found.modifiers
    assert first.read_bytes() == contents, "Clear leaves it alone"
    bpy.ops.wm.open_mainfile(filepath=str(first.parents[1] / "scene.blend"))
    bpy.ops.wm.save_as_mainfile(filepath=str(first.parents[1] / "scene_v3.blend"))
    found = bpy.data.objects["box"]
    found.supple.material = "JELLY"
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert cache_of(found).parent.name == "supple_scene_v3"
    assert first.read_bytes() == contents, "another bake leaves it alone"


def check_overrides() -> None:
    """An object of another file is baked as a library override, which keeps its settings and its bake."""
    new_scene(6)
    found = soft(cube("box"), material="FLESH")
    group(found, "top", lambda point: point.z > 0.4)
    found.modifiers.new("Subdivision", "SUBSURF").levels = 0
    library = Path(bpy.data.filepath)
    bpy.ops.wm.save_mainfile()
    scene = new_scene(6)
    with bpy.data.libraries.load(str(library), link=True) as (_, chosen):
        chosen.objects = ["box"]
    scene.collection.objects.link(chosen.objects[0])
    refused('"box" is linked from another file', "library override")
    found = chosen.objects[0].override_create(remap_local_usages=True)
    found.supple.material = "JELLY"
    attach(found, "top", motion="PIN")
    assert bpy.ops.supple.bake() == {"FINISHED"}
    scene.frame_set(6)
    moved = local(found)
    file = bpy.data.filepath
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=file)
    found = next(found for found in bpy.data.objects if found.library is None)
    assert (found.supple.material, found.supple.attachments[0].vertex_group) == ("JELLY", "top")
    assert np.array_equal(local(found), moved)
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert [modifier.name for modifier in found.modifiers] == ["Supple", "Subdivision"]
    assert bpy.ops.supple.clear() == {"FINISHED"}
    assert [modifier.name for modifier in found.modifiers] == ["Subdivision"]


CHECKS = (check_names, check_versions, check_overrides)
