"""Conversion of bodies to trimesh, and of meshes from trimesh, meshio, Open3D and PyVista."""

from __future__ import annotations

import copy
import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from ._core import Body
from .extras import import_optional

if TYPE_CHECKING:
    from trimesh import Scene, Trimesh

__all__ = ["arrays", "merged", "read_with_trimesh", "to_trimesh", "visual"]


def to_trimesh(body: Body, uv: bool = False) -> Trimesh:
    """Convert the displayed surface of a body to a trimesh.Trimesh. `Body.to_trimesh` calls this function."""
    surface = body.surface()
    mesh = body.mesh
    assert mesh is not None  # surface() raises for a bare lattice
    trimesh = import_optional("trimesh")
    if body.topology_version > 0:
        if uv:
            raise ValueError("uv=True needs a body that is whole; this one broke: see topology_version")
        broken: Trimesh = trimesh.Trimesh(vertices=surface, faces=mesh.faces, process=False)
        return broken
    appearance = body._appearance() if uv and body._visual is None else None
    if appearance is not None:
        return _textured(trimesh, surface, mesh.faces, *appearance)
    # Colors without a mesh have no working copy().
    kept = copy.deepcopy(body._visual)
    result: Trimesh = trimesh.Trimesh(vertices=surface, faces=mesh.faces, visual=kept, process=False)
    return result


def _textured(
    trimesh: Any,
    surface: NDArray[np.float64],
    faces: NDArray[np.int64],
    coordinates: NDArray[np.float64],
    corners: NDArray[np.int64],
    materials: list[tuple[str, NDArray[np.int64], list[float], Path | bytes | None]],
) -> Trimesh:
    """Return a mesh with texture coordinates: a vertex for each pair of a vertex and coordinates that a face uses."""
    vertex, uv = np.arange(len(surface)), None
    if len(corners) > 0:
        pairs = np.stack([faces.ravel(), corners.ravel()], axis=1)
        used, index = np.unique(pairs, axis=0, return_inverse=True)
        vertex, uv, faces = used[:, 0], coordinates[used[:, 1]], index.reshape(-1, 3)
    made = [_material(trimesh, name, color, image) for name, _, color, image in materials]
    of_face = np.zeros(len(faces), int)
    for number, (_, triangles, _, _) in enumerate(materials):
        of_face[triangles] = number
    several = len(made) > 1
    material = trimesh.visual.material.MultiMaterial(made) if several else made[0] if made else None
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material, face_materials=of_face if several else None)
    result: Trimesh = trimesh.Trimesh(
        vertices=surface[vertex],
        faces=faces,
        visual=visual,
        process=False,
        # GLB files have no 64-bit integers.
        vertex_attributes={"input_vertex": vertex.astype(np.uint32)},
    )
    return result


def _material(trimesh: Any, name: str, color: list[float], image: Path | bytes | None) -> Any:
    """Return a material of trimesh. The image, a file or its contents, is left out if Pillow cannot read it."""
    picture = None
    if image is not None:
        try:
            source = io.BytesIO(image) if isinstance(image, bytes) else image
            with import_optional("PIL.Image").open(source) as file:
                picture = file.copy()
        except (ModuleNotFoundError, OSError):
            pass
    diffuse = np.round(255 * np.array(color)).astype(np.uint8)
    return trimesh.visual.material.SimpleMaterial(name=name, diffuse=diffuse, image=picture)


def read_with_trimesh(path: Path) -> Any:
    """Read a mesh or a scene from a file. Vertices keep the order of the file."""
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    trimesh = import_optional("trimesh")
    return trimesh.load(path, process=False)


def arrays(mesh: Any) -> tuple[NDArray[np.float64], list[list[int]]] | None:
    """Return the vertices and faces of a mesh of meshio, Open3D or PyVista; None for other objects."""
    if hasattr(mesh, "points") and hasattr(mesh, "faces"):
        return _points(mesh.points), _padded_faces(mesh.faces)
    if hasattr(mesh, "points") and hasattr(mesh, "extract_surface"):
        raise TypeError(f"a pyvista.{type(mesh).__name__} has no faces; pass mesh.extract_surface()")
    if hasattr(mesh, "points") and hasattr(mesh, "cells_dict"):
        return _points(mesh.points), _meshio_faces(mesh.cells_dict)
    if hasattr(mesh, "vertices") and hasattr(mesh, "triangles"):
        return _points(mesh.vertices), np.asarray(mesh.triangles, np.int64).reshape(-1, 3).tolist()
    return None


def _points(points: Any) -> NDArray[np.float64]:
    """Return points as an array; meshio has plane points with two coordinates."""
    found = np.asarray(points, np.float64)
    return np.pad(found, ((0, 0), (0, 1))) if found.ndim == 2 and found.shape[1] == 2 else found


def _meshio_faces(cells: Mapping[str, Any]) -> list[list[int]]:
    """Return the triangles, quads and polygons of meshio."""
    faces = [
        face
        for kind, corners in cells.items()
        if kind in ("triangle", "quad") or kind.startswith("polygon")
        for face in np.asarray(corners, np.int64).tolist()
    ]
    if not faces:
        known = ", ".join(cells) or "none"
        raise ValueError(f"the meshio mesh has no triangles, quads or polygons, but cells: {known}; pass its surface")
    return faces


def _padded_faces(faces: Any) -> list[list[int]]:
    """Return faces from an array in which the number of corners precedes the corners of each face, as in PyVista."""
    numbers = np.asarray(faces, np.int64).ravel().tolist()
    found: list[list[int]] = []
    at = 0
    while at < len(numbers):
        end = at + 1 + numbers[at]
        if numbers[at] < 3 or end > len(numbers):
            raise ValueError(
                f"faces[{at}] is {numbers[at]}, which is not the number of corners of a face; pass polygons"
            )
        found.append(numbers[at + 1 : end])
        at = end
    return found


def merged(scene: Scene) -> Trimesh:
    """Join all meshes of a scene, at their places."""
    if not any(hasattr(geometry, "faces") for geometry in scene.geometry.values()):
        raise ValueError("the scene has no meshes")
    # trimesh before 4.5 has no to_mesh.
    result: Any = scene.to_mesh() if hasattr(scene, "to_mesh") else scene.dump(concatenate=True)
    return cast("Trimesh", result)


def visual(mesh: Any) -> Any:
    """Copy the texture coordinates, materials and colors of a trimesh.Trimesh; None if it has none."""
    kept: Any = getattr(mesh, "visual", None)
    return kept.copy() if getattr(kept, "defined", False) else None
