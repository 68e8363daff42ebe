"""Evaluated meshes and vertex groups as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from bpy.types import Depsgraph, Mesh, Object
from numpy.typing import NDArray


@contextmanager
def evaluated(found: Object, depsgraph: Depsgraph, with_groups: bool = False) -> Iterator[Mesh]:
    """Return the mesh of an object in the current frame, with the effect of all modifiers that are on.

    with_groups : bool
        Whether vertex groups are needed, for which Blender evaluates the modifiers once more.
    """
    current = found.evaluated_get(depsgraph)
    try:
        yield current.to_mesh(preserve_all_data_layers=with_groups, depsgraph=depsgraph)
    finally:
        current.to_mesh_clear()


def matrix_of(found: Object, depsgraph: Depsgraph) -> NDArray[np.float64]:
    """Return the world matrix of an object in the current frame: (4, 4)."""
    return np.array(found.evaluated_get(depsgraph).matrix_world, np.float64)


def positions_of(mesh: Mesh) -> NDArray[np.float32]:
    """Return the positions of the vertices in the space of the object: (n, 3)."""
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def faces_of(mesh: Mesh, mirrored: bool) -> list[list[int]] | NDArray[np.int64]:
    """Return the polygons as vertex indices, counter-clockwise seen from outside.

    mirrored : bool
        Whether the object mirrors the mesh, by a negative scale.
    """
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    sizes = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", sizes)
    if len(sizes) and sizes[0] in (3, 4) and (sizes == sizes[0]).all():
        array = corners.reshape(-1, sizes[0]).astype(np.int64)
        return array[:, ::-1] if mirrored else array
    ends = np.cumsum(sizes)
    faces = [corners[end - size : end].tolist() for size, end in zip(sizes.tolist(), ends.tolist(), strict=True)]
    return [face[::-1] for face in faces] if mirrored else faces


def weights_of(mesh: Mesh, groups: set[int]) -> dict[int, NDArray[np.float64]]:
    """Return the weights of all vertices in vertex groups, given as indices: (n,) for each; 0 outside of a group."""
    weights = {group: np.zeros(len(mesh.vertices)) for group in groups}
    if weights:
        for vertex in mesh.vertices:
            for entry in vertex.groups:
                if entry.group in weights:
                    weights[entry.group][vertex.index] = entry.weight
    return weights
