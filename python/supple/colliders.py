"""Defines colliders: shapes that bodies cannot penetrate, static or moved along keyframes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

from numpy.typing import ArrayLike

from . import _core

__all__ = ["Box", "Capsule", "Collider", "Key", "Plane", "Sphere"]

#: A keyframe: `(time, translate, rotate)`, or a dict with these keys. In seconds, (3,) length and (3,) degrees.
Key: TypeAlias = Sequence[Any] | Mapping[str, Any]

_NO_ROTATION = (0.0, 0.0, 0.0)


class Collider:
    """Base class of Plane, Sphere, Box and Capsule.

    friction : float, default 0.5
        Coulomb coefficient, >= 0. At 0 bodies slide without friction.
    restitution : float, default 0
        Ratio of the speeds after and before an impact, in [0, 1]. Impacts slower than two steps of free fall do not
        bounce.
    keys : list of (time, translate, rotate), default empty
        Keyframes of the motion of the collider, relative to its given position: time in seconds, displacement, and
        degrees about the fixed axes x, then y, then z through its center. Translations and angles are interpolated
        linearly.

    Raises ValueError for an invalid number.
    """

    shape: ClassVar[str]
    friction: float
    restitution: float
    keys: Sequence[Key]

    def __post_init__(self) -> None:
        """Check the numbers and replace them by plain copies."""
        for name, value in _core.check_collider(self).items():
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Plane(Collider):
    """The half-space behind a plane. For friction, restitution and keys see Collider.

    point : (3,) float
        Any point of the plane.
    normal : (3,) float
        Vector to the free side of the plane, of any length except zero.
    """

    shape: ClassVar[str] = "plane"
    point: ArrayLike
    normal: ArrayLike
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()


@dataclass(frozen=True)
class Sphere(Collider):
    """A solid sphere. For friction, restitution and keys see Collider.

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
    """A solid box. For friction, restitution and keys see Collider.

    center : (3,) float
    half_extents : (3,) float, > 0
    rotate : (3,) float, default 0
        Degrees about the fixed axes x, then y, then z.
    """

    shape: ClassVar[str] = "box"
    center: ArrayLike
    half_extents: ArrayLike
    rotate: ArrayLike = _NO_ROTATION
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()


@dataclass(frozen=True)
class Capsule(Collider):
    """All points within `radius` of the segment from `a` to `b`. For friction, restitution and keys see Collider.

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
