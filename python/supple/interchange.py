"""Conversion of bodies to the types of other libraries."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._core import Body
from .extras import import_optional

if TYPE_CHECKING:
    from trimesh import Trimesh

__all__ = ["to_trimesh"]


def to_trimesh(body: Body) -> Trimesh:
    """Convert the displayed surface of a body to a trimesh.Trimesh. `Body.to_trimesh` calls this function."""
    surface = body.surface()
    mesh = body.mesh
    assert mesh is not None  # surface() raises for a bare lattice
    trimesh = import_optional("trimesh", "trimesh")
    result: Trimesh = trimesh.Trimesh(vertices=surface, faces=mesh.faces, process=False)
    return result
