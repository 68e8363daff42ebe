"""Keyframes of objects that move rigidly, from their matrices, and of numbers that change."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import supple

#: Relative size of the rounding errors of matrices, which Blender computes in 32-bit numbers: some units in the last
#: place, for a chain of several parents.
ROUNDING = 1e-5


def is_still(values: NDArray[Any]) -> bool:
    """Return whether all frames, the first axis, are equal."""
    return bool((values == values[:1]).all())


def rigid_keys(matrices: NDArray[np.float64], center: ArrayLike, fps: float) -> list[tuple[float, Any, Any]]:
    """Return the keyframes, one per frame, of a part that moves with an object.

    matrices : (f, 4, 4)
        World matrices of the object. Changes of its scale are left out.
    center : (3,)
        Point about which the keyframes turn, in frame 0.
    fps : float
        Frames per second.

    Returns a list of (time, displacement, rotation matrix), relative to frame 0. Raises numpy.linalg.LinAlgError if the
    object has no extent along an axis in frame 0.
    """
    point = np.asarray(center, float)
    turns = supple.rotations(_relative(matrices))
    origins = matrices[:, :3, 3]
    moved = origins + (turns @ (point - origins[0]))
    return [(frame / fps, to - point, turn) for frame, (to, turn) in enumerate(zip(moved, turns, strict=True))]


def curve(values: NDArray[np.float64], fps: float) -> float | list[tuple[float, float]]:
    """Return keyframes (time, value), one per frame, of a number, (f,); or the number if it does not change."""
    if is_still(values):
        return float(values[0])
    return [(frame / fps, float(value)) for frame, value in enumerate(values)]


def is_rigid(matrices: NDArray[np.float64]) -> bool:
    """Return whether an object with these world matrices, (f, 4, 4), keeps its size and shape."""
    try:
        relative = _relative(matrices)
    except np.linalg.LinAlgError:
        return False
    error = relative @ relative.transpose(0, 2, 1) - np.eye(3)
    return bool(np.abs(error).max() <= ROUNDING and (np.linalg.det(relative) > 0).all())


def transformed(matrix: NDArray[np.float64], points: NDArray[Any]) -> NDArray[np.float64]:
    """Return points, (n, 3), transformed by a matrix (4, 4)."""
    result: NDArray[np.float64] = np.asarray(points, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return result


def _relative(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the linear part of the motion from frame 0 to each frame: (f, 3, 3)."""
    linear = matrices[:, :3, :3]
    relative: NDArray[np.float64] = linear @ np.linalg.inv(linear[0])
    return relative
