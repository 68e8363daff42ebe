"""Bodies with fewer arguments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._core import Body

if TYPE_CHECKING:
    from ._core import Lattice

__all__ = ["RigidBody"]


def RigidBody(shape: Any | Lattice, density: float = 1000.0, **arguments: Any) -> Body:  # noqa: N802
    """Return a rigid body: `Body` with rigid=True.

    shape : as for Body
    density : float, default 1000
        Mass per volume, > 0.
    arguments
        Further arguments of Body: name, scale, rotate, translate, velocity, spin, friction, restitution,
        rolling_resistance, ignore, lattice_vertices, skin and others that soft bodies have too.
    """
    return Body(shape, density=density, rigid=True, **arguments)
