"""Conversion of meshes and bodies from and to trimesh."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ._core import Body
from .extras import import_optional

if TYPE_CHECKING:
    from trimesh import Scene, Trimesh

__all__ = ["merged", "read_with_trimesh", "to_trimesh", "visual"]


def to_trimesh(body: Body) -> Trimesh:
    """Convert the displayed surface of a body to a trimesh.Trimesh. `Body.to_trimesh` calls this function."""
    surface = body.surface()
    mesh = body.mesh
    assert mesh is not None  # surface() raises for a bare lattice
    trimesh = import_optional("trimesh")
    # Colors without a mesh have no working copy().
    kept = copy.deepcopy(body._visual)
    result: Trimesh = trimesh.Trimesh(vertices=surface, faces=mesh.faces, visual=kept, process=False)
    return result


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
