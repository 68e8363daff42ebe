"""Pictures of simulations, drawn without a display."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import colliders as shapes
from ._core import Body, Simulation, rotation_matrix
from .pictures import fill, png, shades
from .types import PathLike

__all__ = ["screenshot"]

#: Colors of bodies, repeated, and of colliders.
_COLORS = np.array([(0.88, 0.69, 0.56), (0.56, 0.71, 0.85), (0.85, 0.56, 0.56), (0.64, 0.78, 0.55), (0.89, 0.78, 0.47)])
_COLLIDER = np.array([0.93, 0.95, 0.98])
#: Samples per pixel along each axis.
_SAMPLES = 2
#: Number of edges of a circle.
_EDGES = 48

_Triangles = tuple[NDArray[np.float64], NDArray[np.int64]]


def screenshot(
    target: Simulation | Body,
    path: PathLike | None = None,
    *,
    size: tuple[int, int] = (800, 600),
    view: ArrayLike | None = None,
    bounds: ArrayLike | None = None,
    colliders: bool = True,
    smooth: bool = True,
) -> NDArray[np.uint8]:
    """Draw the displayed surfaces of a simulation or a body, and its colliders. Needs neither a display nor a package.

    target : Simulation or Body
        Of a body, only the body itself is drawn. A bare lattice is drawn as its cells.
    path : str or os.PathLike, optional
        PNG file to write.
    size : (int, int), default (800, 600)
        Width and height in pixels, from 1 to 8192.
    view : (3,) float, optional
        Direction to the camera, which sees the bodies without perspective. Default: from the front, a little from the
        right and from above. Up is against gravity, y without gravity.
    bounds : (2, 3) float, optional
        Minimum and maximum corner of the box that the picture shows. Default: the bounding box of the bodies. Give the
        same box for all pictures of a film.
    colliders : bool, default True
        Whether enabled colliders are drawn. Of planes only those are drawn that face up by more than 30 degrees: others
        are walls, which would hide the bodies.
    smooth : bool, default True
        Whether triangles share normals. If False, each triangle has one brightness, so that creases are visible.

    Returns the picture: (height, width, 3) uint8. The bust of the examples, on a plane, takes about a second.
    """
    if path is not None and Path(path).suffix.lower() != ".png":
        raise ValueError(f"path is {os.fspath(path)!r}; it must end in .png")
    if not isinstance(target, (Simulation, Body)):
        raise TypeError(f"target must be a Simulation or a Body, not {type(target).__name__}")
    width, height = (int(number) for number in size)
    if not (1 <= width <= 8192 and 1 <= height <= 8192):
        raise ValueError(f"size is {tuple(size)}; both numbers must be from 1 to 8192")
    simulation = target if isinstance(target, Simulation) else target.simulation
    bodies = target.bodies if isinstance(target, Simulation) else (target,)
    surfaces = [_surface(body) for body in bodies]
    box = _box(surfaces) if bounds is None else np.asarray(bounds, dtype=float)
    if box.shape != (2, 3) or not np.isfinite(box).all() or (box[0] > box[1]).any():
        raise ValueError("bounds must be (2, 3) finite numbers, the minimum and the maximum corner")
    up = _up(None if simulation is None else simulation.gravity)
    axes = _axes(up, view)
    # What the picture shows: the corners of the box.
    extent = np.array([np.where([k & 1, k & 2, k & 4], box[1], box[0]) for k in range(8)]) @ axes.T
    pixels = _SAMPLES * np.array([width, height])
    spans = np.maximum(np.ptp(extent, axis=0)[:2], 1e-300)
    scale = 0.92 * (pixels / spans).min()
    middle = (extent.min(axis=0) + extent.max(axis=0)) / 2
    offset = np.append(pixels / 2, 0.0)
    picture = np.ones((pixels[1], pixels[0], 3))
    depth = np.full(picture.shape[:2], -np.inf)
    # The cells of a bare lattice have edges.
    smooth_of = [smooth and body.mesh is not None for body in bodies]
    parts = [(part, _COLORS[index % len(_COLORS)], smooth_of[index]) for index, part in enumerate(surfaces)]
    if colliders and isinstance(target, Simulation):
        drawn = (collider for collider in target.colliders if collider.is_enabled and not _is_wall(collider, up))
        parts += [(_collider(collider, box, target.time), _COLLIDER, smooth) for collider in drawn]
    for (points, triangles), color, blended in parts:
        corners = ((points @ axes.T - middle) * scale + offset)[triangles]
        fill(picture, depth, corners, color, shades(points, triangles, axes, blended))
    averaged = picture.reshape(height, _SAMPLES, width, _SAMPLES, 3).mean(axis=(1, 3))
    result: NDArray[np.uint8] = np.round(255 * averaged).astype(np.uint8)
    if path is not None:
        Path(path).write_bytes(png(result))
    return result


def _up(gravity: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """Return the direction against gravity, y without gravity."""
    if gravity is None or not np.any(gravity):
        return np.array([0.0, 1, 0])
    up: NDArray[np.float64] = -gravity / np.linalg.norm(gravity)
    return up


def _is_wall(collider: shapes.Collider, up: NDArray[np.float64]) -> bool:
    """Return whether a collider is a plane that does not face up by more than 30 degrees."""
    if not isinstance(collider, shapes.Plane):
        return False
    normal = rotation_matrix(collider.rotation) @ np.asarray(collider.normal, dtype=float)
    return bool(normal @ up <= 0.5 * np.linalg.norm(normal))


def _axes(up: NDArray[np.float64], view: ArrayLike | None) -> NDArray[np.float64]:
    """Return the directions of columns, of rows downwards, and towards the camera."""
    front = np.array([0.0, 0, 1]) if abs(up[2]) < 0.9 else np.array([0.0, -1, 0])
    right = np.cross(up, front)
    toward = 0.42 * right + 0.26 * up + front if view is None else np.asarray(view, dtype=float)
    if toward.shape != (3,) or not np.isfinite(toward).all() or not np.any(toward):
        raise ValueError("view must be (3,) finite numbers, not all zero")
    toward = toward / np.linalg.norm(toward)
    # In a view from above or below, the front is at the lower edge.
    right = np.cross(up if abs(toward @ up) < 0.99 else -front * np.sign(toward @ up), toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(right, toward), toward])


def _box(surfaces: list[_Triangles]) -> NDArray[np.float64]:
    """Return the corners of the bounding box of surfaces."""
    points = np.concatenate([points for points, _ in surfaces])
    return np.array([points.min(axis=0), points.max(axis=0)])


def _surface(body: Body) -> _Triangles:
    """Return the displayed surface of a body, or the boundary of the cells of a bare lattice."""
    if body.mesh is not None:
        return body.surface(), body.mesh.faces
    corners = body.lattice.cell_corners
    # Corner i is at +x if i & 1, at +y if i & 2, and at +z if i & 4. The quads face outward.
    sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    quads = np.concatenate([corners[:, side] for side in sides])
    # Two cells share the vertices of their common face, unless the body is broken there.
    _, first, count = np.unique(np.sort(quads, axis=1), axis=0, return_index=True, return_counts=True)
    return body.corrected_positions(), _fans(quads[first[count == 1]])


def _fans(quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """Divide quads into triangles."""
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _collider(collider: shapes.Collider, box: NDArray[np.float64], time: float) -> _Triangles:
    """Return the surface of a collider of a simulation at its current pose."""
    points, triangles, center = _shape(collider, box, time)
    pose = rotation_matrix(collider.rotation)
    return (points - center) @ pose.T + center + collider.translation, triangles


def _shape(
    collider: shapes.Collider, box: NDArray[np.float64], time: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Return the surface of a collider at its given place, and the center of its rotations."""
    if isinstance(collider, shapes.Plane):
        point, normal = (np.asarray(vector, dtype=float) for vector in (collider.point, collider.normal))
        u = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        u /= np.linalg.norm(u)
        v = np.cross(normal / np.linalg.norm(normal), u)
        # A disc around the foot of the middle of the box, of rings, because small triangles are drawn faster.
        middle = box.mean(axis=0)
        foot = middle - normal * ((middle - point) @ normal) / (normal @ normal)
        angles = np.linspace(0, 2 * np.pi, _EDGES, endpoint=False)[:, None]
        circle = np.cos(angles) * u + np.sin(angles) * v
        radii = 0.75 * np.linalg.norm(box[1] - box[0]) * np.linspace(0, 1, _EDGES // 2)
        return np.concatenate([foot + radius * circle for radius in radii]), _tube(len(radii)), point
    if isinstance(collider, shapes.Sphere):
        center = np.asarray(collider.center, dtype=float)
        points, triangles = _round(np.zeros(3), np.zeros(3), collider.radius)
        return points + center, triangles, center
    if isinstance(collider, shapes.Capsule):
        a, b = (np.asarray(end, dtype=float) for end in (collider.a, collider.b))
        points, triangles = _round(a, b, collider.radius)
        return points, triangles, (a + b) / 2
    if isinstance(collider, shapes.MeshCollider):
        mesh, scale = collider.mesh, np.broadcast_to(np.asarray(collider.scale, dtype=float), 3)
        turn = rotation_matrix(collider.rotate) * scale
        shift = np.asarray(collider.translate, dtype=float)
        # Keyframes turn a mesh about the middle of its bounding box.
        return _at(collider, time) @ turn.T + shift, mesh.faces, mesh.bounds.mean(axis=0) @ turn.T + shift
    assert isinstance(collider, shapes.Box)
    center = np.asarray(collider.center, dtype=float)
    signs = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)]) * 2 - 1
    corners = signs * np.asarray(collider.half_extents) @ rotation_matrix(collider.rotate).T + center
    quads = np.array([[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]])
    # Corners of their own for each side, so that the edges are sharp.
    return corners[quads.ravel()], _fans(np.arange(24).reshape(6, 4)), center


def _at(collider: shapes.MeshCollider, time: float) -> NDArray[np.float64]:
    """Return the vertices of the mesh of a collider at a time: linear between two frames."""
    if collider.frames is None:
        return collider.mesh.vertices
    frames = np.asarray(collider.frames, dtype=float)
    phase = np.clip((time - collider.start) * collider.fps, 0, len(frames) - 1)
    before = int(phase)
    after = min(before + 1, len(frames) - 1)
    between: NDArray[np.float64] = frames[before] + (phase - before) * (frames[after] - frames[before])
    return between


def _round(a: NDArray[np.float64], b: NDArray[np.float64], radius: float) -> _Triangles:
    """Return the surface of all points within a radius of a segment: circles about its axis from pole to pole."""
    axis = b - a if np.any(b != a) else np.array([0.0, 1, 0])
    axis /= np.linalg.norm(axis)
    u = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    angles = np.linspace(0, 2 * np.pi, _EDGES, endpoint=False)[:, None]
    circle = np.cos(angles) * u + np.sin(angles) * v
    heights = np.linspace(-np.pi / 2, np.pi / 2, _EDGES // 2)
    rings = [
        (a if height < 0 else b) + radius * (np.cos(height) * circle + np.sin(height) * axis) for height in heights
    ]
    return np.concatenate(rings), _tube(len(rings))


def _tube(rings: int) -> NDArray[np.int64]:
    """Return the triangles between rings of _EDGES points each."""
    low = np.arange(_EDGES * (rings - 1)).reshape(-1, _EDGES)
    turned = np.roll(low, -1, axis=1)
    return _fans(np.stack([low, turned, turned + _EDGES, low + _EDGES], axis=-1).reshape(-1, 4))
