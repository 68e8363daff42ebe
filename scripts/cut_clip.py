"""Cuts the polygons of a model by a plane: `Clipper`."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from cut_delaunay import CrossingError, triangulate
from cut_obj import Corner, Face, Model, numbers, text

IN_PLANE = 1e-6
"""Largest distance from the plane, over the diagonal of the bounding box, of a vertex that counts as in the plane."""


class Clipper:
    """Cuts polygons of a model, and adds the elements at the cut to the model.

    `same` maps each vertex to the first vertex at its position, and `signs` to its side of the plane: 1 is kept, 0 is
    in the plane, -1 is removed.
    """

    def __init__(self, model: Model, point: np.ndarray, normal: np.ndarray) -> None:
        """Takes a point of the plane, and its unit normal, which points to the kept side."""
        self.model, self.point, self.normal = model, point, normal
        self.positions = model.positions()
        first: dict[tuple[float, ...], int] = {}
        # Adding 0 makes -0 equal to 0.
        keys = map(tuple, (self.positions + 0.0).tolist())
        self.same = [first.setdefault(key, index) for index, key in enumerate(keys)]
        self.distances = (self.positions - point) @ normal
        tolerance = IN_PLANE * np.linalg.norm(np.ptp(self.positions, axis=0))
        self.signs = [int(sign) for sign in np.sign(self.distances) * (np.abs(self.distances) > tolerance)]
        self.new: dict[object, int] = {}

    def clip(self, face: Face) -> list[Face]:
        """Returns the parts of a face on the kept side."""
        return [Face(part, face.state) for part in self.parts(face.corners)]

    def parts(self, corners: tuple[Corner, ...]) -> list[tuple[Corner, ...]]:
        """Returns the parts of a polygon on the kept side."""
        signs = [self.signs[corner[0]] for corner in corners]
        if not any(signs):
            # A face in the plane closes the kept side if its front is on the other side.
            closes = area_vector(self.positions[[corner[0] for corner in corners]]) @ self.normal < 0
            return [corners] if closes else []
        if min(signs) >= 0:
            return [corners]
        crossings = sum(a * b < 0 for a, b in pairwise([*signs, signs[0]]))
        if max(signs) > 0 and signs.count(0) + crossings > 2:
            # The polygon is not convex, because it meets the plane more than twice.
            return [part for triangle in self.triangles(corners) for part in self.parts(triangle)]
        part = []
        for a, b in pairwise([*corners, corners[0]]):
            if self.signs[a[0]] >= 0:
                part.append(a)
            if self.signs[a[0]] * self.signs[b[0]] < 0:
                part.append(self.between(a, b))
        return [tuple(part)] if max(signs) > 0 else []

    def triangles(self, corners: tuple[Corner, ...]) -> list[tuple[Corner, ...]]:
        """Returns the triangles of a polygon: a fan if its outline crosses itself, seen along its normal."""
        polygon = self.positions[[corner[0] for corner in corners]]
        try:
            flat = polygon @ plane_axes(area_vector(polygon)).T
            indices = triangulate(flat, [list(range(len(corners)))], None)[1].tolist()
        except CrossingError:
            indices = [(0, i, i + 1) for i in range(1, len(corners) - 1)]
        return [tuple(corners[index] for index in triangle) for triangle in indices]

    def between(self, a: Corner, b: Corner) -> Corner:
        """Returns the corner where the plane crosses the edge between two corners.

        All faces at an edge get the same vertex, because it is stored by the edge.
        """
        if self.same[a[0]] > self.same[b[0]]:
            a, b = b, a
        edge = (self.same[a[0]], self.same[b[0]])
        share = self.distances[a[0]] / (self.distances[a[0]] - self.distances[b[0]])
        indices = []
        for kind, elements in enumerate((self.model.vertices, self.model.textures, self.model.normals)):
            ends = (a[kind], b[kind])
            key = edge if kind == 0 else (kind, edge, ends)
            if min(ends) < 0:
                indices.append(-1)
                continue
            if key not in self.new:
                values = blend(elements, ends, share)
                if kind == 0:
                    values[:3] -= ((values[:3] - self.point) @ self.normal) * self.normal
                    self.same.append(len(elements))
                    self.signs.append(0)
                elif kind == 2:
                    values /= np.linalg.norm(values) or 1
                self.new[key] = len(elements)
                elements.append(text(values))
            indices.append(self.new[key])
        return indices[0], indices[1], indices[2]

    def polygon(self, face: Face) -> tuple[int, ...]:
        """Returns the vertices of a face, with vertices at equal positions as one."""
        return tuple(self.same[corner[0]] for corner in face.corners)


def blend(elements: list[str], ends: tuple[int, int], share: float) -> np.ndarray:
    """Returns the numbers of two elements, interpolated: those of the first at share 0, of the second at 1."""
    first, second = (numbers(elements[index]) for index in ends)
    count = min(len(first), len(second))
    return (1 - share) * np.array(first[:count]) + share * np.array(second[:count])


def plane_axes(normal: np.ndarray) -> np.ndarray:
    """Returns two unit vectors (2, 3) at right angles to a vector and right-handed about it."""
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal / np.linalg.norm(normal), first)])


def area_vector(polygon: np.ndarray) -> np.ndarray:
    """Returns the area of a polygon (n, 3) times its normal."""
    edges = polygon - polygon[0]
    return np.cross(edges[1:-1], edges[2:]).sum(axis=0) / 2
