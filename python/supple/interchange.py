"""Conversion of meshes and bodies from and to trimesh."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from ._core import Body
from .extras import import_optional

if TYPE_CHECKING:
    from trimesh import Scene, Trimesh

__all__ = ["merged", "read_with_trimesh", "to_trimesh", "visual"]


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
    materials: list[tuple[str, NDArray[np.int64], list[float], Path | None]],
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


def _material(trimesh: Any, name: str, color: list[float], image: Path | None) -> Any:
    """Return a material of trimesh. The image is left out if Pillow is not installed or cannot read it."""
    picture = None
    if image is not None:
        try:
            with import_optional("PIL.Image").open(image) as file:
                picture = file.copy()
        except (ModuleNotFoundError, OSError):
            pass
    diffuse = np.round(255 * np.array(color)).astype(np.uint8)
    return trimesh.visual.material.SimpleMaterial(name=name, diffuse=diffuse, image=picture)


def read_with_trimesh(path: Path) -> Any:
    """Read a mesh or a scene from a file. Vertices keep the order of the file, but those of an STL file are merged."""
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    trimesh = import_optional("trimesh")
    # In an STL file every triangle has vertices of its own.
    return trimesh.load(path, process=path.suffix.lower() == ".stl")


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
