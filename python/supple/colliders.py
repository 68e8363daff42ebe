"""Defines colliders: shapes that bodies cannot penetrate, static, moved along keyframes, or driven step by step."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import FrozenInstanceError, dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

__all__ = ["Box", "Capsule", "Collider", "Enabled", "Key", "MeshCollider", "Plane", "Rotate", "RotationLike", "Sphere"]

#: A keyframe: `(time, translate, rotate)`, or a dict with these keys. In seconds, (3,) length and (3,) degrees.
Key: TypeAlias = Sequence[Any] | Mapping[str, Any]


#: Whether something is enabled: True, False, or keyframes `(time, value)`, or dicts with these keys.
Enabled: TypeAlias = bool | Sequence[tuple[float, bool] | Mapping[str, Any]]


class RotationLike(Protocol):
    """An object with a rotation matrix, such as a scipy.spatial.transform.Rotation."""

    def as_matrix(self) -> NDArray[np.float64]:
        """Return the (3, 3) rotation matrix."""


#: A rotation: (3,) degrees about the fixed axes x, then y, then z, (4,) quaternion x, y, z, w, (3, 3) matrix, or a
#: scipy Rotation.
Rotate: TypeAlias = ArrayLike | RotationLike

_NO_ROTATION = (0.0, 0.0, 0.0)

_Self = TypeVar("_Self", bound="Collider")


class Collider:
    """Base class of Plane, Sphere, Box, Capsule and MeshCollider.

    friction : float, default 0.5
        Coulomb coefficient, >= 0. At 0 bodies slide without friction.
    restitution : float, default 0
        Ratio of the speeds of the touching points after and before an impact, in [0, 1]. Impacts slower than two
        steps of free fall do not bounce. A soft body also bounces by its elasticity at 0: see the damping_ratio of
        the body.
    keys : list of (time, translate, rotate), default empty
        Keyframes of the motion of the collider, relative to its given position: time in seconds, displacement, and
        degrees about the fixed axes x, then y, then z through its center. A rotation may also be a quaternion x, y, z,
        w, a rotation matrix or a scipy Rotation; it becomes the angles nearest to those of the keyframe before.
    interpolation : "linear", "smooth" or "cubic", default "linear"
        How translations and angles go from one keyframe to the next: "linear", with constant velocity; "smooth", from
        rest to rest; "cubic", through the keyframes with a continuous velocity and without overshoot.

    rolling_resistance : float, default None
        Coefficient of rolling resistance on the collider, >= 0, in place of that of the bodies: see the
        rolling_resistance of Body. None: that of each body.
    thickness : float, default 0
        Distance outside of the surface at which bodies touch, in scene units, >= 0, added to the thickness of the body.
        An open mesh keeps at least a distance of 0.05 cells of the body.
    enabled : bool or list of (time, value), default True
        Whether the collider is enabled, or keyframes of it: a value holds from its time in seconds until the next one.
        A first keyframe after the time 0 switches: before it, the collider has the other value. A disabled collider
        touches nothing: it has no contacts, limits no displayed surface, and rays do not meet it. Bodies that sleep
        near it wake up when it changes, and a body that is inside of it when it is enabled leaves it whole.

        `sim.colliders[i].enabled = ...` changes it from now on. It is the only field that can be set.

    Raises ValueError for an invalid number.

    The items of `Simulation.colliders` are the colliders of the simulation: move_to moves them, translation, rotation,
    velocity and spin are their current motion, is_enabled tells whether they are enabled now, and force is that of the
    bodies on them. On any other collider, and after `Simulation.colliders` was set, these raise RuntimeError. A pickle
    or a copy of a collider has only the fields that were given.
    """

    shape: ClassVar[str]
    _motion: ClassVar[_core.ColliderMotion | None] = None
    friction: float
    restitution: float
    keys: Sequence[Key]
    interpolation: Literal["linear", "smooth", "cubic"]
    rolling_resistance: float | None
    thickness: float
    enabled: Enabled

    def __post_init__(self) -> None:
        """Check the numbers and replace them by plain copies."""
        for name, value in _core.check_collider(self).items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        """Set `enabled` of a collider of a simulation, or a field for the first time."""
        if name == "enabled" and self._motion is not None:
            value = self._motion.set_enabled(value)
        elif name == "enabled" and name in vars(self):
            raise FrozenInstanceError("enabled can be set for an item of sim.colliders only")
        elif name in vars(self) or self._motion is not None or name not in getattr(self, "__dataclass_fields__", ()):
            raise FrozenInstanceError(f"cannot assign to field {name!r}; set sim.colliders to new colliders")
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        """Raise FrozenInstanceError."""
        raise FrozenInstanceError(f"cannot delete field {name!r}")

    @property
    def is_enabled(self) -> bool:
        """Whether the collider is enabled at the current time of the simulation."""
        return self._in_simulation().is_enabled

    def move_to(self, translate: ArrayLike, rotate: Rotate = _NO_ROTATION, duration: float | None = None) -> None:
        """Move the collider of a simulation linearly from its current pose to another one, from the next step on.

        translate : (3,) float, each at most 1e15 in magnitude
            Displacement from the given position, as in a keyframe.
        rotate : (3,), (4,) or (3, 3) float, or scipy Rotation, default 0
            Rotation from the given orientation in degrees, at most 1e15, about the fixed axes x, then y, then z through
            the center; or a quaternion x, y, z, w, or a matrix, which become the angles nearest to the current ones.
            The angles are interpolated: from 350 to 370 the collider turns forward by 20 degrees, from 350 to 10 back
            by 340. A turn of 180 degrees or more needs a duration of several steps, because contacts see the
            displacement of a point during a step.
        duration : float, > 0, default one step
            Duration of the motion in seconds, rounded up to whole steps. `step(n)` without a duration moves the
            collider in the first of the n steps.

        Bodies in contact feel velocity and spin of the motion, so that friction carries what lies on the collider.
        After the motion the collider stays at rest. Another call replaces a motion that has not ended. The first call
        replaces the keyframes of the collider for good. To put a collider elsewhere without a velocity, set
        `Simulation.colliders`.

        Raises ValueError for an invalid number or shape, TypeError for another type, and RuntimeError for a collider
        that is not an item of `Simulation.colliders`.
        """
        self._in_simulation().move_to(translate, rotate, duration)

    @property
    def translation(self) -> NDArray[np.float64]:
        """Current displacement from the given position: (3,) float64, read-only."""
        return self._in_simulation().translation

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Current rotation in degrees about the fixed axes x, y, z, as for move_to: (3,) float64, read-only."""
        return self._in_simulation().rotation

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity of the center in the next step, in length/s, zero at rest: (3,) float64, read-only."""
        return self._in_simulation().velocity

    @property
    def force(self) -> NDArray[np.float64]:
        """Force of the bodies on the collider in the last step, in mass x length/s^2: (3,) float64, read-only.

        The opposite of the sum of the forces in Simulation.contacts().
        """
        return self._in_simulation().force

    @property
    def spin(self) -> NDArray[np.float64]:
        """Angular velocity in the next step, in rad/s, zero at rest: (3,) float64, read-only."""
        return self._in_simulation().spin

    def _in_simulation(self) -> _core.ColliderMotion:
        """Return the motion of this collider in its simulation."""
        if self._motion is None:
            raise RuntimeError(
                f"this {type(self).__name__} is not a collider of a simulation; use an item of sim.colliders"
            )
        return self._motion

    def _attached(self: _Self, motion: _core.ColliderMotion) -> _Self:
        """Return a copy that moves a collider of a simulation."""
        attached = copy.copy(self)
        object.__setattr__(attached, "_motion", motion)
        return attached

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields, for pickles and copies."""
        return {name: value for name, value in vars(self).items() if name != "_motion"}


@dataclass(unsafe_hash=True)
class Plane(Collider):
    """The half-space behind a plane.

    For friction, restitution, keys, interpolation, rolling_resistance, thickness and enabled see Collider.

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
    interpolation: Literal["linear", "smooth", "cubic"] = "linear"
    rolling_resistance: float | None = None
    thickness: float = 0.0
    enabled: Enabled = field(default=True, hash=False)


@dataclass(unsafe_hash=True)
class Sphere(Collider):
    """A solid sphere.

    For friction, restitution, keys, interpolation, rolling_resistance, thickness and enabled see Collider.

    center : (3,) float
    radius : float, > 0
    """

    shape: ClassVar[str] = "sphere"
    center: ArrayLike
    radius: float
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()
    interpolation: Literal["linear", "smooth", "cubic"] = "linear"
    rolling_resistance: float | None = None
    thickness: float = 0.0
    enabled: Enabled = field(default=True, hash=False)


@dataclass(unsafe_hash=True, init=False)
class Box(Collider):
    """A solid box.

    For friction, restitution, keys, interpolation, rolling_resistance, thickness and enabled see Collider.

    center : (3,) float
    half_extents : (3,) float, > 0
    min, max : (3,) float
        In place of center and half_extents, only by name: two opposite corners before the rotation.
    rotate : (3,), (4,) or (3, 3) float, or scipy Rotation, default 0
        Degrees about the fixed axes x, then y, then z through the center; or a quaternion x, y, z, w, or a rotation
        matrix.

    Raises TypeError for corners beside a center or half extents, or if one of the two is missing.
    """

    shape: ClassVar[str] = "box"
    center: ArrayLike
    half_extents: ArrayLike
    rotate: Rotate = _NO_ROTATION
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()
    interpolation: Literal["linear", "smooth", "cubic"] = "linear"
    rolling_resistance: float | None = None
    thickness: float = 0.0
    enabled: Enabled = field(default=True, hash=False)

    def __init__(
        self,
        center: ArrayLike | None = None,
        half_extents: ArrayLike | None = None,
        rotate: Rotate = _NO_ROTATION,
        friction: float = 0.5,
        restitution: float = 0.0,
        keys: Sequence[Key] = (),
        interpolation: Literal["linear", "smooth", "cubic"] = "linear",
        rolling_resistance: float | None = None,
        thickness: float = 0.0,
        enabled: Enabled = True,
        *,
        min: ArrayLike | None = None,  # noqa: A002
        max: ArrayLike | None = None,  # noqa: A002
    ) -> None:
        """Create a box from its center and half extents, or from two opposite corners."""
        if (min is None, max is None, center is None, half_extents is None) == (False, False, True, True):
            center, half_extents = _between(min, max)
        elif min is not None or max is not None or center is None or half_extents is None:
            raise TypeError("Box() needs either center and half_extents, or min= and max=")
        values = (center, half_extents, rotate, friction, restitution, keys, interpolation, rolling_resistance)
        for known, value in zip(fields(self), (*values, thickness, enabled), strict=True):
            object.__setattr__(self, known.name, value)
        self.__post_init__()


def _between(low: ArrayLike | None, high: ArrayLike | None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return center and half extents of the box between two corners."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    if low.shape != (3,) or high.shape != (3,):
        raise ValueError(f"min and max of a Box have the shapes {low.shape} and {high.shape}; they must be (3,)")
    if not np.all(low < high):
        raise ValueError(f"min of a Box is {low.tolist()} and max {high.tolist()}; min must be less on each axis")
    return (low + high) / 2, (high - low) / 2


@dataclass(unsafe_hash=True)
class Capsule(Collider):
    """All points within `radius` of the segment from `a` to `b`.

    For friction, restitution, keys, interpolation, rolling_resistance, thickness and enabled see Collider.

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
    interpolation: Literal["linear", "smooth", "cubic"] = "linear"
    rolling_resistance: float | None = None
    thickness: float = 0.0
    enabled: Enabled = field(default=True, hash=False)


@dataclass(unsafe_hash=True)
class MeshCollider(Collider):
    """A mesh: a solid if it is closed, a thin shell if it is open.

    For friction, restitution, keys, interpolation, rolling_resistance, thickness and enabled see Collider.

    mesh : Mesh, or another mesh argument, such as that of Body
        Bodies may lie on either side of an open mesh, and do not pass it. Several colliders can share a Mesh.
    scale : float or (3,) float, default 1
        Factor of the lengths of the mesh, > 0, applied first, about its origin; or one for each axis, not 0, of which
        negative ones mirror the mesh.
    rotate : (3,), (4,) or (3, 3) float, or scipy Rotation, default 0
        Degrees about the fixed axes x, then y, then z through the origin; or a quaternion x, y, z, w, or a rotation
        matrix.
    translate : (3,) float, default 0
        Displacement, applied last. Keyframes and move_to turn the mesh about the center of its bounding box.
    inside : bool, default False
        Whether bodies stay inside a closed mesh, as in a room or a globe. Its faces may point inwards or outwards.

    frames : (f, n, 3) float, default None
        Positions of the n vertices of the mesh at f times, in its coordinates. Between two frames the vertices move
        linearly, before the first and after the last frame they are at rest. Bodies in contact feel the velocity of the
        surface at the point of contact. Without frames the mesh is rigid.
    fps : float, > 0, default 30
        Frames per second.
    start : float, default 0
        Time of the first frame in seconds.

    Raises TypeError for an object that is no mesh, and ValueError for a mesh whose triangles have no area, for
    inside=True with an open mesh, or for frames of another shape.
    """

    shape: ClassVar[str] = "mesh"
    mesh: _core.Mesh
    scale: ArrayLike = 1.0
    rotate: Rotate = _NO_ROTATION
    translate: ArrayLike = _NO_ROTATION
    friction: float = 0.5
    restitution: float = 0.0
    keys: Sequence[Key] = ()
    frames: ArrayLike | None = field(default=None, compare=False, repr=False)
    fps: float = 30.0
    start: float = 0.0
    interpolation: Literal["linear", "smooth", "cubic"] = "linear"
    inside: bool = False
    rolling_resistance: float | None = None
    thickness: float = 0.0
    enabled: Enabled = field(default=True, hash=False)

    if TYPE_CHECKING:

        def __init__(
            self,
            mesh: _core._MeshArgument,
            scale: ArrayLike = 1.0,
            rotate: Rotate = _NO_ROTATION,
            translate: ArrayLike = _NO_ROTATION,
            friction: float = 0.5,
            restitution: float = 0.0,
            keys: Sequence[Key] = (),
            frames: ArrayLike | None = None,
            fps: float = 30.0,
            start: float = 0.0,
            interpolation: Literal["linear", "smooth", "cubic"] = "linear",
            inside: bool = False,
            rolling_resistance: float | None = None,
            thickness: float = 0.0,
            enabled: Enabled = True,
        ) -> None:
            """Create the collider. The class has the arguments."""

    def __post_init__(self) -> None:
        """Convert the mesh, check the numbers and replace them by plain copies."""
        object.__setattr__(self, "mesh", _core.Mesh.from_trimesh(self.mesh))
        super().__post_init__()
