"""Colliders: shapes that bodies cannot enter, at rest or moved along keys."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

from numpy.typing import ArrayLike

from . import _core

__all__ = ["Box", "Capsule", "Collider", "Key", "Plane", "Sphere"]

#: `(time, translate, rotate)`, or a dict with these names: seconds, (3,) length, (3,) degrees.
Key: TypeAlias = Sequence[Any] | Mapping[str, Any]

_NO_TURN = (0.0, 0.0, 0.0)


class Collider:
    """Any of Plane, Sphere, Box, Capsule.

    friction : float, default 0.5
        Coulomb coefficient, >= 0; at 0 bodies slide freely.
    restitution : float, default 0
        Speed after over speed before an impact, in [0, 1]. Impacts slower than two steps of free fall do not bounce.
    keys : list of (time, translate, rotate), default none
        Moves the collider about its center: seconds, length, degrees about the fixed axes x, then y, then z.
        Linear in time, angles too.

    ValueError for a number that makes no sense.
    """

    shape: ClassVar[str]
    friction: float
    restitution: float
    keys: Sequence[Key]

    def __post_init__(self) -> None:
        """Refuses numbers that make no sense, and keeps plain copies of the others."""
        for name, value in _core.check_collider(self).items():
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Plane(Collider):
    """The half space below a plane. friction, restitution and keys are those of Collider.

    point : (3,) float
        Any point of the plane.
    normal : (3,) float
        The side that is free, of any length but zero.
    """

    shape: ClassVar[str] = "plane"
    point: ArrayLike
    normal: ArrayLike
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()


@dataclass(frozen=True)
class Sphere(Collider):
    """A ball. friction, restitution and keys are those of Collider.

    center : (3,) float
    radius : float, > 0
    """

    shape: ClassVar[str] = "sphere"
    center: ArrayLike
    radius: float
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()


@dataclass(frozen=True)
class Box(Collider):
    """A box. friction, restitution and keys are those of Collider.

    center : (3,) float
    half_extents : (3,) float, > 0
    rotate : (3,) float, default 0
        Degrees about the fixed axes x, then y, then z.
    """

    shape: ClassVar[str] = "box"
    center: ArrayLike
    half_extents: ArrayLike
    rotate: ArrayLike = _NO_TURN
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()


@dataclass(frozen=True)
class Capsule(Collider):
    """All points within `radius` of the segment from `a` to `b`. friction, restitution and keys are those of Collider.

    a, b : (3,) float
    radius : float, > 0
    """

    shape: ClassVar[str] = "capsule"
    a: ArrayLike
    b: ArrayLike
    radius: float
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()
