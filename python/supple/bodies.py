"""Bodies with fewer arguments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._core import Body

if TYPE_CHECKING:
    from ._core import Lattice

__all__ = ["RigidBody"]


def RigidBody(shape: Any | Lattice, density: float = 1000.0, **arguments: Any) -> Body:  # noqa: N802
    """Return a rigid body: `Body` with rigid=True.

    shape : Mesh, Lattice, path, or a mesh of another library
        As for Body.
    density : float, default 1000
        Mass per volume, > 0.

    Further keyword arguments are those of Body that do not concern soft bodies alone: name, scale, rotate, translate,
    velocity, spin, friction, restitution, rolling_resistance, thickness, ignore, lattice_vertices, cell_size, join,
    refine, skin.
    Raises ValueError for keys of soft bodies, and TypeError for unknown ones.
    """
    return Body(shape, density=density, rigid=True, **arguments)
