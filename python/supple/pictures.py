"""Draws triangles with numpy: a depth buffer, shading, and PNG files. Needs no display and no other package."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["fill", "shades", "write_png"]

#: Number of pixels that are computed at a time, which bounds the memory.
_BATCH = 1 << 19


def shades(
    points: NDArray[np.float64], triangles: NDArray[np.integer], axes: NDArray[np.float64], smooth: bool
) -> NDArray[np.float64]:
    """Compute the brightness of the corners of all triangles, (m, 3), under a light above and left of the camera.

    axes : (3, 3)
        Directions of columns, of rows downwards, and towards the camera.
    smooth : bool
        Whether triangles share the normals of their corners; otherwise each one has a single brightness.
    """
    a, b, c = points[triangles].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    corner = np.repeat(normal[:, None], 3, axis=1)
    if smooth:
        sums = np.zeros_like(points)
        np.add.at(sums, triangles, corner)
        corner = sums[triangles]
    # The back of a triangle is lit like its front.
    corner = corner * np.where(normal @ axes[2] < 0, -1, 1)[:, None, None]
    length = np.linalg.norm(corner, axis=2, keepdims=True)
    light = np.array([-0.4, -0.4, 1]) @ axes
    cosine = (corner / np.where(length > 0, length, 1)) @ (light / np.linalg.norm(light))
    brightness: NDArray[np.float64] = 0.3 + 0.7 * np.clip(cosine, 0, 1)
    return brightness


def fill(
    picture: NDArray[np.float64],
    depth: NDArray[np.float64],
    corners: NDArray[np.float64],
    color: ArrayLike,
    shade: NDArray[np.float64],
) -> None:
    """Draw triangles into a picture, (height, width, 3), with a depth buffer, (height, width).

    corners : (m, 3, 3)
        Columns, rows and depths of the corners, the greatest depth in front.
    color : (3,), or (m, 3) for a color of each triangle
    shade : (m, 3)
        Brightness of the corners.
    """
    height, width, _ = picture.shape
    colors = np.broadcast_to(np.asarray(color, dtype=float), (len(corners), 3))
    edges = corners[:, 1:, :2] - corners[:, :1, :2]
    area = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    top = np.clip(np.ceil(corners[:, :, 1].min(axis=1)), 0, height).astype(int)
    rows = np.clip(np.floor(corners[:, :, 1].max(axis=1)) + 1, 0, height).astype(int) - top
    seen = np.flatnonzero((area != 0) & (rows > 0))
    of_row, place = _repeated(seen, rows[seen])
    y_row = top[of_row] + place
    first, last = _spans(corners[of_row, :, :2], y_row, width)
    counts = np.maximum(last - first, 0)
    pixels, depths = picture.reshape(-1, 3), depth.reshape(-1)
    for batch in _batches(counts):
        # One entry per pixel that a row of a triangle may cover.
        row, place = _repeated(batch, counts[batch])
        triangle, x, y = of_row[row], first[row] + place, y_row[row]
        dx, dy = x - corners[triangle, 0, 0], y - corners[triangle, 0, 1]
        (ux, uy), (vx, vy) = edges[triangle, 0].T, edges[triangle, 1].T
        second, third = (dx * vy - dy * vx) / area[triangle], (dy * ux - dx * uy) / area[triangle]
        weights = np.stack([1 - second - third, second, third], axis=-1)
        z = (weights * corners[triangle, :, 2]).sum(axis=1)
        index = y * width + x
        # Of several triangles at a pixel, the assignment keeps the last one: the one in front, and of two at the same
        # depth the first one, as in the order of the batches.
        drawn = np.flatnonzero((weights.min(axis=-1) >= 0) & (z > depths[index]))[::-1]
        drawn = drawn[np.argsort(z[drawn], kind="stable")]
        depths[index[drawn]] = z[drawn]
        brightness = (weights[drawn] * shade[triangle[drawn]]).sum(axis=1)
        pixels[index[drawn]] = brightness[:, None] * colors[triangle[drawn]]


def _repeated(items: NDArray[Any], counts: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Repeat each item, and number its copies from 0."""
    return np.repeat(items, counts), np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def _spans(corners: NDArray[np.float64], y: NDArray[Any], width: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the first column that each triangle covers in a row, and the one after the last column.

    corners : (k, 3, 2)
        Columns and rows of the corners.
    """
    ends = np.roll(corners, -1, axis=1)
    low, high = np.minimum(corners[..., 1], ends[..., 1]), np.maximum(corners[..., 1], ends[..., 1])
    crossed = (low <= y[:, None]) & (y[:, None] <= high) & (low < high)
    share = (y[:, None] - corners[..., 1]) / np.where(crossed, ends[..., 1] - corners[..., 1], 1)
    x = corners[..., 0] + share * (ends[..., 0] - corners[..., 0])
    # Wider than rounding errors: the weights of the pixels decide.
    first = np.ceil(np.where(crossed, x, np.inf).min(axis=1) - 1e-3)
    last = np.floor(np.where(crossed, x, -np.inf).max(axis=1) + 1e-3) + 1
    return np.clip(first, 0, width).astype(int), np.clip(last, 0, width).astype(int)


def _batches(counts: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Divide rows of triangles into batches of together about _BATCH pixels."""
    return iter(np.split(np.arange(len(counts)), np.flatnonzero(np.diff(np.cumsum(counts) // _BATCH)) + 1))


def write_png(picture: NDArray[np.uint8], path: str | os.PathLike[str]) -> None:
    """Write a picture, (height, width, 3), to a PNG file."""
    height, width, _ = picture.shape
    # Every row begins with its filter: none.
    rows = np.concatenate([np.zeros((height, 1), np.uint8), picture.reshape(height, -1)], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")]
    parts = (
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))
