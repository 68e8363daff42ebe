"""Types of arguments, for annotations: `from supple.types import Curve, FractureOptions`.

Times are in seconds.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

from numpy.typing import ArrayLike, NDArray

from .colliders import Enabled, Key, Rotate, RotationLike

__all__ = [
    "Accuracy",
    "BoxShape",
    "Curve",
    "Enabled",
    "FractureOptions",
    "Interpolation",
    "Key",
    "KeyedVector",
    "Material",
    "PathLike",
    "PlaneShape",
    "PlasticOptions",
    "Rotate",
    "RotationLike",
    "Skin",
    "SphereShape",
    "VolumeMeasure",
    "VolumeOptions",
]

#: A path of a file or a folder.
PathLike: TypeAlias = str | os.PathLike[str]
#: A named material.
Material: TypeAlias = Literal["jelly", "flesh", "rubber", "firm"]
#: How the half-width of the regions is chosen.
Accuracy: TypeAlias = Literal["fast", "balanced", "exact"]
#: How the lattice moves the mesh.
Skin: TypeAlias = Literal["linear", "smooth"]
#: The measure of the volume that is kept.
VolumeMeasure: TypeAlias = Literal["auto", "off", "lattice", "cells", "mesh"]
#: How values between keyframes are found.
Interpolation: TypeAlias = Literal["linear", "smooth", "cubic"]
#: A box that selects a part of a body: its corners `(min, max)`, or a dict with these keys. Length.
BoxShape: TypeAlias = Sequence[ArrayLike] | Mapping[str, ArrayLike] | NDArray[Any]
#: A number, or keyframes of one: a list of `(time, value)`, or a dict with the keys `keys` and `interpolation`.
Curve: TypeAlias = float | Sequence[tuple[float, float] | Mapping[str, float]] | Mapping[str, Any]
#: Keyframes of a vector: a list of `(time, value)`, or a dict with the keys `keys` and `interpolation`.
KeyedVector: TypeAlias = Sequence[tuple[float, ArrayLike] | Mapping[str, Any]] | Mapping[str, Any]
#: A ball that selects a part of a body: `(center, radius)`, or a dict with these keys. Length.
SphereShape: TypeAlias = tuple[ArrayLike, float] | Mapping[str, Any]
#: A plane: `(point, normal)`, or a dict with these keys. It selects the side to which the normal points.
PlaneShape: TypeAlias = Sequence[ArrayLike] | Mapping[str, ArrayLike] | NDArray[Any]

#: The keys of `plastic`.
PlasticOptions = TypedDict("PlasticOptions", {"yield": float, "creep": float, "max": float}, total=False)


class FractureOptions(TypedDict, total=False):
    """The keys of `fracture`."""

    strength: float
    strain: float
    rotation: float | None
    cracks: int
    noise: float
    seed: int
    surface: Literal["smooth", "cells"]


class VolumeOptions(TypedDict, total=False):
    """The keys of `volume`."""

    measure: VolumeMeasure
    scope: Literal["global", "regional"]
    field: Literal["auto", "surface", "cells", "paper"]
    max_correction: float
