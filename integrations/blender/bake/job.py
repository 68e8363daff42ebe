"""The data of a bake, as plain arrays: no types of Blender, and no links to its scene.

Positions and matrices are in world space, in Blender's units of length. Frames are those of the bake, from 0 on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


class BakeError(Exception):
    """A bake that cannot be done. The message names the object and the way out."""


@dataclass
class Attachment:
    """A vertex group that is held in place, or that moves with something. Without a motion it is held in place."""

    #: Name of the vertex group, for messages.
    group: str
    #: Whether each vertex of the mesh is in the group: (n,) bool. Or how strongly it is held: (n,) float in [0, 1].
    vertices: NDArray[np.bool_] | NDArray[np.float64]
    #: World matrices of the object or bone that moves the group: (f, 4, 4).
    driver: NDArray[np.float64] | None = None
    #: Positions of all vertices of the animated mesh: (f, n, 3).
    animation: NDArray[np.float32] | None = None
    #: Frame of the bake from which on the group is free, or None.
    release: int | None = None


@dataclass
class Stiffness:
    """A vertex group with another stiffness."""

    #: Weight of each vertex of the mesh: (n,), in [0, 1].
    weights: NDArray[np.float64]
    #: Factor of Young's modulus at weight 1, in (0, 100]. At weight w it is factor ** w.
    factor: float


@dataclass
class Inflation:
    """A vertex group whose rest volume changes beside that of the body."""

    #: Weight of each vertex of the mesh: (n,), in [0, 1].
    weights: NDArray[np.float64]
    #: Ratio of the rest volume at weight 1 in each frame: (f,), in [0.1, 10]. At weight w it is ratio ** w.
    ratios: NDArray[np.float64]


@dataclass
class Body:
    """A mesh that becomes a soft body."""

    #: Name of the object.
    name: str
    #: Positions in frame 0, which are the rest shape: (n, 3).
    vertices: NDArray[np.float64]
    #: Polygons: vertex indices.
    faces: Sequence[Sequence[int]] | NDArray[np.int64]
    #: World matrices of the object, in whose space the cache is: (f, 4, 4).
    matrices: NDArray[np.float64]
    #: The point cache to write.
    path: Path
    #: Keyword arguments of supple.Body.
    options: dict[str, Any] = field(default_factory=dict)
    attachments: list[Attachment] = field(default_factory=list)
    stiffness: Stiffness | None = None
    #: Ratio of the rest volume to that of the mesh in each frame: (f,), in [0.1, 10]; None: always 1.
    inflate: NDArray[np.float64] | None = None
    inflation: Inflation | None = None


#: The settings of a collider that are keywords of the colliders of supple.
SURFACE_SETTINGS = ("friction", "restitution", "thickness")


@dataclass
class Collider:
    """An object that bodies cannot enter: a mesh, or the half-space below a plane."""

    #: Name of the object.
    name: str
    #: World matrices of the object: (f, 4, 4). A plane is the xy plane of the object.
    matrices: NDArray[np.float64]
    #: Positions in frame 0: (n, 3); None for a plane.
    vertices: NDArray[np.float64] | None = None
    faces: Sequence[Sequence[int]] | NDArray[np.int64] = ()
    #: Positions in all frames, if the mesh deforms: (f, n, 3). Otherwise it moves with the matrices.
    frames: NDArray[np.float32] | None = None
    friction: float = 0.5
    restitution: float = 0.0
    #: Distance outside of the surface at which bodies touch, in units of length, at least 0.
    thickness: float = 0.0


@dataclass
class Job:
    """A bake: bodies that touch each other and the colliders, for a number of frames."""

    bodies: list[Body]
    colliders: list[Collider]
    #: Number of frames, with the first one.
    frames: int
    #: Frames per second.
    fps: float
    #: Acceleration in units of length/s^2: (3,).
    gravity: Sequence[float]
    #: Number of the first frame in the scene.
    first_frame: int = 0
    #: Steps per frame; None: as many as the materials need.
    substeps: int | None = None
    #: Whether bodies touch each other.
    contact: bool = True
