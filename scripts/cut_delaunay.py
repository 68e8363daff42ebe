"""Triangulates a polygon with holes, with points inside it where they make better triangles: `triangulate`.

A constrained Delaunay triangulation (Chew 1989, Constrained Delaunay triangulations) whose interior is refined with the
circumcenters of bad triangles (Ruppert 1995, A Delaunay refinement algorithm for quality 2-dimensional mesh
generation). Unlike Ruppert's algorithm it never splits an edge of the polygon, so angles beside short edges stay small.
Coordinates are rounded to whole numbers up to 2^40, and all decisions about them are exact.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from itertools import pairwise

import numpy as np

Point = tuple[int, int]
Edge = tuple[int, int]

GRID = 2**40
"""Whole numbers per extent of the polygon."""

MAX_RATIO = math.sqrt(2)
"""Largest circumradius over shortest edge of a good triangle: its angles are at least 20.7 degrees."""


class CrossingError(Exception):
    """Edges of the polygon cross or touch each other. `edge` has the indices of the ends of one of them."""

    def __init__(self, edge: Edge) -> None:
        """Takes the indices of the ends of an edge."""
        super().__init__("edges of the polygon cross or touch each other")
        self.edge = edge


class Triangulation:
    """Triangles as a map from each directed edge to the third corner of the triangle on its left."""

    def __init__(self, points: list[Point]) -> None:
        """Starts with one triangle that contains all points and whose corners are three further points."""
        count = len(points)
        self.points = [*points, (-4 * GRID, -4 * GRID), (8 * GRID, -4 * GRID), (-4 * GRID, 8 * GRID)]
        self.apex: dict[Edge, int] = {}
        self.fixed: set[Edge] = set()
        self.add(count, count + 1, count + 2)

    def add(self, a: int, b: int, c: int) -> None:
        """Adds a triangle."""
        self.apex[a, b], self.apex[b, c], self.apex[c, a] = c, a, b

    def remove(self, a: int, b: int, c: int) -> None:
        """Removes a triangle."""
        for edge in ((a, b), (b, c), (c, a)):
            del self.apex[edge]

    def side(self, a: int, b: int, p: int | Point) -> int:
        """Returns twice the area of the triangle a, b, p: positive if p is on the left of the edge a, b."""
        (ax, ay), (bx, by) = self.points[a], self.points[b]
        x, y = self.points[p] if isinstance(p, int) else p
        return (bx - ax) * (y - ay) - (by - ay) * (x - ax)

    def in_circle(self, a: int, b: int, c: int, p: int) -> bool:
        """Returns whether p is inside the circumcircle of the triangle a, b, c."""
        x0, y0 = self.points[p]
        (ax, ay), (bx, by), (cx, cy) = ((x - x0, y - y0) for x, y in (self.points[i] for i in (a, b, c)))
        a2, b2, c2 = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
        return ax * (by * c2 - b2 * cy) - ay * (bx * c2 - b2 * cx) + a2 * (bx * cy - by * cx) > 0

    def locate(self, p: Point, edge: Edge) -> Edge | None:
        """Walks from `edge` to the triangle that contains p, and returns one of its edges.

        Returns None if the walk leaves the triangulation, or takes more steps than there are edges.
        """
        a, b = edge if self.side(*edge, p) >= 0 else edge[::-1]
        for _ in range(len(self.apex)):
            c = self.apex.get((a, b))
            if c is None:
                break
            if self.side(b, c, p) < 0:
                a, b = c, b
            elif self.side(c, a, p) < 0:
                a, b = a, c
            else:
                return a, b
        return None

    def insert(self, index: int, edge: Edge) -> list[Edge]:
        """Inserts a point into the triangle of `edge`, and returns the edges opposite to it in its new triangles.

        Retriangulates all triangles whose circumcircle contains the point (Bowyer 1981, Watson 1981).
        """
        a, b = edge
        c = self.apex[edge]
        self.remove(a, b, c)
        border, queue = [], [(a, b), (b, c), (c, a)]
        while queue:
            a, b = queue.pop()
            c = self.apex.get((b, a), -1)
            if c < 0 or not self.in_circle(b, a, c, index):
                border.append((a, b))
            else:
                self.remove(b, a, c)
                queue += [(a, c), (c, b)]
        for a, b in border:
            self.add(a, b, index)
        return border

    def flip(self, a: int, b: int) -> Edge:
        """Replaces the edge a, b by the other diagonal of its two triangles, and returns this diagonal."""
        c, d = self.apex[a, b], self.apex[b, a]
        self.remove(a, b, c)
        self.remove(b, a, d)
        self.add(a, d, c)
        self.add(d, b, c)
        return d, c

    def crossed(self, a: int, b: int) -> list[Edge]:
        """Returns the edges that the segment a, b crosses, each from its left to its right.

        Raises `CrossingError` if the segment crosses a fixed edge or a point.
        """
        spokes = ((u, w) for (v, u), w in self.apex.items() if v == a)
        right, left = next((u, w) for u, w in spokes if self.side(a, u, b) >= 0 >= self.side(a, w, b))
        if self.side(a, right, b) == 0 or self.side(a, left, b) == 0:
            raise CrossingError((a, b))
        edges = []
        while True:
            if (right, left) in self.fixed or (left, right) in self.fixed:
                raise CrossingError((a, b))
            edges.append((left, right))
            c = self.apex[left, right]
            if c == b:
                return edges
            where = self.side(a, b, c)
            if where == 0:
                raise CrossingError((a, b))
            left, right = (c, right) if where > 0 else (left, c)

    def fix(self, a: int, b: int) -> None:
        """Makes the segment a, b an edge by flips (Sloan 1993), and fixes it."""
        if (a, b) not in self.apex:
            queue = deque(self.crossed(a, b))
            while queue:
                u, v = queue.popleft()
                c, d = self.apex[u, v], self.apex[v, u]
                if self.side(d, c, u) <= 0 or self.side(d, c, v) >= 0:
                    queue.append((u, v))
                    continue
                self.flip(u, v)
                if not {a, b} & {c, d} and (self.side(a, b, c) > 0) != (self.side(a, b, d) > 0):
                    queue.append((d, c))
        self.fixed.add((a, b))

    def legalize(self) -> None:
        """Flips edges that are not fixed until no circumcircle contains a point that is visible from its triangle."""
        queue = deque(self.apex)
        while queue:
            a, b = queue.popleft()
            c, d = self.apex.get((a, b)), self.apex.get((b, a))
            if c is None or d is None or (a, b) in self.fixed or (b, a) in self.fixed:
                continue
            if self.in_circle(a, b, c, d):
                self.flip(a, b)
                queue += [(a, d), (d, b), (b, c), (c, a)]

    def keep_inside(self) -> None:
        """Removes the triangles that are not on the left of the fixed edges."""
        inside: dict[Edge, int] = {}
        queue = list(self.fixed)
        while queue:
            a, b = queue.pop()
            if (a, b) in inside:
                continue
            c = self.apex[a, b]
            inside |= {(a, b): c, (b, c): a, (c, a): b}
            queue += [(v, u) for u, v in ((a, b), (b, c), (c, a)) if (u, v) not in self.fixed]
        self.apex = inside


def triangulate(points: np.ndarray, loops: list[list[int]], longest: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Triangulates the region on the left of all loops.

    points    (n, 2) coordinates
    loops     indices of points; outlines counter-clockwise, holes clockwise; every point is in a loop
    longest   approximate length above which interior edges are refined; None adds no points

    Returns the coordinates of the added points (m, 2), which follow the given points, and the triangles (k, 3),
    counter-clockwise. Each edge of a loop is an edge of one triangle. Raises `CrossingError` if loops cross or touch.
    """
    low, extent = points.min(axis=0), np.ptp(points, axis=0).max()
    cells = [(int(x), int(y)) for x, y in np.rint((points - low) * (GRID / extent))]
    mesh = Triangulation(cells)
    first: dict[Point, int] = {}
    edge = (len(cells), len(cells) + 1)
    for index, cell in enumerate(cells):
        if first.setdefault(cell, index) != index:
            raise CrossingError((first[cell], index))
        edge = mesh.insert(index, mesh.locate(cell, edge) or edge)[0]
    for loop in loops:
        for a, b in pairwise([*loop, loop[0]]):
            mesh.fix(a, b)
    mesh.legalize()
    mesh.keep_inside()
    del mesh.points[len(cells) :]
    if longest is not None:
        refine(mesh, longest * (GRID / extent))
    added = np.array(mesh.points[len(cells) :], dtype=float).reshape(-1, 2) * (extent / GRID) + low
    triangles = {min((a, b, c), (b, c, a), (c, a, b)) for (a, b), c in mesh.apex.items()}
    return added, np.array(sorted(triangles))


def refine(mesh: Triangulation, longest: float) -> None:
    """Inserts the circumcenters of triangles that are too large or too thin, the largest triangle first.

    A center is not inserted if it is inside the circle on a fixed edge as diameter, because it would make a thin
    triangle, or if the circumradius is less than half of the median fixed edge, so that refinement ends.
    """
    ends = np.array([[mesh.points[a], mesh.points[b]] for a, b in sorted(mesh.fixed)], dtype=float)
    least = np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)) / 2
    heap: list[tuple[float, int, int, int]] = []

    def push(a: int, b: int, c: int) -> None:
        radius, shortest = circle(mesh, a, b, c)[1:]
        # An equilateral triangle with edges `longest` has the circumradius longest / sqrt(3).
        if radius > least and (radius > longest / math.sqrt(3) or radius > MAX_RATIO * shortest):
            heapq.heappush(heap, (-radius, a, b, c))

    for (a, b), c in sorted(mesh.apex.items()):
        if a < b and a < c:
            push(a, b, c)
    while heap:
        _, a, b, c = heapq.heappop(heap)
        if mesh.apex.get((a, b)) != c:
            continue
        (x, y), *_ = circle(mesh, a, b, c)
        if (((ends[:, 0] - (x, y)) * (ends[:, 1] - (x, y))).sum(axis=1) < 0).any():
            continue
        center = (round(x), round(y))
        edge = mesh.locate(center, (a, b))
        if edge is None:
            continue
        mesh.points.append(center)
        for u, v in mesh.insert(len(mesh.points) - 1, edge):
            push(u, v, len(mesh.points) - 1)


def circle(mesh: Triangulation, a: int, b: int, c: int) -> tuple[tuple[float, float], float, float]:
    """Returns the circumcenter and the circumradius of a triangle, and the length of its shortest edge."""
    (ax, ay), (bx, by), (cx, cy) = (mesh.points[i] for i in (a, b, c))
    bx, by, cx, cy = bx - ax, by - ay, cx - ax, cy - ay
    area = 2 * (bx * cy - by * cx)
    b2, c2 = bx * bx + by * by, cx * cx + cy * cy
    x, y = (cy * b2 - by * c2) / area, (bx * c2 - cx * b2) / area
    shortest = math.sqrt(min(b2, c2, (cx - bx) ** 2 + (cy - by) ** 2))
    return (ax + x, ay + y), math.hypot(x, y), shortest
