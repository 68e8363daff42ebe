"""The measures of a run, on the surface that a program shows: the same for all programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapes import Indices, Points

BLOCK = 1 << 21
"""Pairs of points and triangles that are measured at a time."""


def volume(surface: Points, triangles: Indices) -> float:
    """Return the volume inside a closed surface."""
    centered = surface - surface.mean(axis=0)
    return float(np.linalg.det(centered[triangles]).sum() / 6)


def shape_error(surface: Points, rest: Points) -> float:
    """Return the rms distance from the rest shape, after the rotation and the shift that fit best (Kabsch 1976)."""
    now, then = surface - surface.mean(axis=0), rest - rest.mean(axis=0)
    left, _, right = np.linalg.svd(now.T @ then)
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    return float(np.sqrt(np.mean(np.sum((now - then @ (left @ right).T) ** 2, axis=1))))


def plane_depth(surface: Points, planes: tuple) -> float:
    """Return how deep the deepest point is behind a plane."""
    depths = [((np.array(point) - surface) @ np.array(normal)).max() for point, normal in planes]
    return max(0.0, *depths)


def body_depth(surfaces: Points, triangles: Indices) -> float:
    """Return how deep the deepest surface point of a body is inside another one."""
    low, high = surfaces.min(axis=1), surfaces.max(axis=1)
    deepest = 0.0
    for one in range(len(surfaces)):
        corners = surfaces[one][triangles]
        for other in range(len(surfaces)):
            if one == other or (low[one] > high[other]).any() or (low[other] > high[one]).any():
                continue
            near = np.all((surfaces[other] >= low[one]) & (surfaces[other] <= high[one]), axis=1)
            points = surfaces[other][near]
            inside = points[winding_numbers(points, corners) > 0.5]
            if len(inside):
                deepest = max(deepest, float(distances(inside, corners).max()))
    return deepest


def self_depth(surface: Points, rest: Points, triangles: Indices, apart: float) -> float:
    """Return how deep the deepest surface point is inside another part of its body.

    At a point of its own surface the winding number is the share of the solid angle that the body fills, below 1. A
    second layer adds 1. The depth is the distance to the parts of the surface that are further than `apart` at rest.
    """
    corners = surface[triangles]
    doubled = np.flatnonzero(winding_numbers(surface, corners) > 1)
    centers = rest[triangles].mean(axis=1)
    deepest = 0.0
    for point in doubled:
        far = np.linalg.norm(centers - rest[point], axis=1) > apart
        deepest = max(deepest, float(distances(surface[point][None], corners[far])[0]))
    return deepest


def winding_numbers(points: Points, corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how often a surface encloses each point (Van Oosterom & Strackee 1983)."""
    result = np.empty(len(points))
    rows = max(1, BLOCK // len(corners))
    for start in range(0, len(points), rows):
        a, b, c = (corners[None, :, k] - points[start : start + rows, None] for k in range(3))
        x, y, z = (np.linalg.norm(edge, axis=2) for edge in (a, b, c))
        triple = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
        dots = [np.einsum("ijk,ijk->ij", *pair) for pair in ((a, b), (b, c), (c, a))]
        solid = np.arctan2(triple, x * y * z + dots[0] * z + dots[1] * x + dots[2] * y)
        # At a corner of the triangle the angle is undefined; its own triangles do not count.
        solid[(x * y * z) == 0] = 0
        result[start : start + rows] = solid.sum(axis=1) / (2 * np.pi)
    return result


def distances(points: Points, corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance of each point from a surface."""
    result = np.empty(len(points))
    rows = max(1, BLOCK // len(corners))
    for start in range(0, len(points), rows):
        block = points[start : start + rows, None]
        squares = [segment_squares(block, corners[:, k], corners[:, (k + 1) % 3]) for k in range(3)]
        squares.append(face_squares(block, corners))
        result[start : start + rows] = np.sqrt(np.min(squares, axis=(0, 2)))
    return result


def segment_squares(points: Points, one: Points, other: Points) -> NDArray[np.float64]:
    """Return the squared distances of points (p, 1, 3) from segments: (p, t)."""
    along = other - one
    share = np.einsum("ijk,jk->ij", points - one, along) / np.maximum(np.sum(along**2, axis=1), 1e-300)
    nearest = one + np.clip(share, 0, 1)[..., None] * along
    return np.sum((points - nearest) ** 2, axis=2)


def face_squares(points: Points, corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the squared distances of points (p, 1, 3) from the triangles that they project into, else infinity."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    square = np.maximum(np.sum(normal**2, axis=1), 1e-300)
    offset = points - a
    v = np.einsum("ijk,jk->ij", np.cross(offset, c - a), normal) / square
    w = np.einsum("ijk,jk->ij", np.cross(b - a, offset), normal) / square
    height = np.einsum("ijk,jk->ij", offset, normal)
    return np.where((v >= 0) & (w >= 0) & (v + w <= 1), height**2 / square, np.inf)
