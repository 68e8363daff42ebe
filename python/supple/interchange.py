"""Bodies as other libraries have them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._core import Body
from .extras import need

if TYPE_CHECKING:
    from trimesh import Trimesh

__all__ = ["to_trimesh"]


def to_trimesh(body: Body) -> Trimesh:
    """The mesh as it is shown: what `Body.to_trimesh` calls."""
    surface = body.surface()
    mesh = body.mesh
    assert mesh is not None  # surface() has refused a bare lattice
    made: Trimesh = need("trimesh", "trimesh").Trimesh(vertices=surface, faces=mesh.faces, process=False)
    return made
