"""The place of the bake among the modifiers of an object.

Modifiers before the bake shape the body: the bake begins with their result. Modifiers after it stay live: they act on
the baked mesh.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from bpy.types import Modifier, Object

#: Modifiers that act on the baked mesh, unless others follow them: they refine or shade a surface, and the body needs
#: none of their vertices. Physics of Blender that follows the surface belongs here, too.
FINISHING = {
    "BEVEL",
    "COLLISION",
    "EDGE_SPLIT",
    "LAPLACIANSMOOTH",
    "MULTIRES",
    "NORMAL_EDIT",
    "PARTICLE_SYSTEM",
    "SMOOTH",
    "SUBSURF",
    "SURFACE",
    "TRIANGULATE",
    "UV_PROJECT",
    "UV_WARP",
    "WEIGHTED_NORMAL",
}


def bake_of(found: Object) -> Modifier | None:
    """Return the modifier that plays the bake of an object, or None.

    It is the Mesh Cache whose file is the cache of the object, so that other caches are never taken for a bake. The
    name of the file is compared, because Blender adapts the folder when the scene is saved elsewhere.
    """
    name = found.supple.cache
    for modifier in found.modifiers:
        # A path from another system may have its separators.
        if name and modifier.type == "MESH_CACHE" and re.split(r"[/\\]", modifier.filepath)[-1] == name:
            return modifier
    return None


def place_of(found: Object) -> int:
    """Return the index of the bake among the modifiers of an object, or that which a first bake gets."""
    modifiers = list(found.modifiers)
    bake = bake_of(found)
    if bake is not None:
        return modifiers.index(bake)
    place = len(modifiers)
    while place > 0 and (modifiers[place - 1].type in FINISHING or modifiers[place - 1].use_pin_to_last):
        place -= 1
    return place


@contextmanager
def only_input(objects: Iterable[Object]) -> Iterator[None]:
    """Switch off the bakes of objects and all modifiers after them, within the `with` block."""
    following = [modifier for found in objects for modifier in list(found.modifiers)[place_of(found) :]]
    shown = [modifier for modifier in following if modifier.show_viewport]
    for modifier in shown:
        modifier.show_viewport = False
    try:
        yield
    finally:
        for modifier in shown:
            modifier.show_viewport = True
