"""Vertex groups of a mesh as parts of its lattice."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

import supple

_Entry = TypeVar("_Entry", np.int64, np.bool_)

#: Bits of the weights of zones.
BITS = 5

#: Corners of a cell, relative to the one with the smallest coordinates.
CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])


def held_vertices(body: supple.Body, group: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the lattice vertices that hold a vertex group: the corners of all cells with a vertex of the group.

    group : (n,) bool
        Whether each vertex of the mesh is in the group.
    """
    table = _Grid(body.lattice)
    cells, _ = table.cells_of(_points(body)[group])
    found = np.unique(table.vertex_at(cells[:, None] + CORNERS))
    return found[found >= 0]


def stiffness_factors(body: supple.Body, factors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the stiffness factors of the lattice vertices, whose logarithms are means of those of the mesh.

    factors : (n,) float, > 0
        Factor at each vertex of the mesh.
    """
    return np.exp(_means(body, np.log(factors)))


def inflated_zones(body: supple.Body, weights: NDArray[np.float64]) -> list[tuple[float, NDArray[np.int64]]]:
    """Return the zones of a vertex group as pairs of an exponent and lattice vertices.

    weights : (n,) float, in [0, 1]
        Weight of each vertex of the mesh.

    The ratios of overlapping zones multiply. A zone for each bit of the weights, with the ratio r ** exponent, gives a
    vertex of weight w the ratio r ** w, with w in steps of 1/31.
    """
    greatest = 2**BITS - 1
    levels = np.rint(greatest * _means(body, weights)).astype(np.int64)
    zones = ((2**bit / greatest, np.flatnonzero(levels >> bit & 1)) for bit in range(BITS))
    return [(exponent, vertices) for exponent, vertices in zones if len(vertices)]


def _means(body: supple.Body, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return numbers at the lattice vertices, from those at the vertices of the mesh, (n,).

    A lattice vertex has the mean in the cells around it, with the weights of the interpolation within a cell. Lattice
    vertices without a mesh vertex around them have the mean of their neighbors.
    """
    table = _Grid(body.lattice)
    cells, offset = table.cells_of(_points(body))
    corners = table.vertex_at(cells[:, None] + CORNERS)
    weights = np.where(CORNERS, offset[:, None], 1.0 - offset[:, None]).prod(axis=2)
    weights[corners < 0] = 0.0
    count = len(body)
    total = np.bincount(corners.ravel(), weights.ravel(), count)
    summed = np.bincount(corners.ravel(), (weights * values[:, None]).ravel(), count)
    known = total > 0
    means = np.divide(summed, total, out=np.zeros(count), where=known)
    return _filled(table, means, known)


def _points(body: supple.Body) -> NDArray[np.float64]:
    """Return the rest positions of the mesh, in the frame of its lattice."""
    assert body.mesh is not None, "bodies of a bake have meshes"
    return body.mesh.vertices


def _filled(table: _Grid, values: NDArray[np.float64], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the values, where unknown ones are the means of their known neighbors along the axes, layer by layer."""
    steps = np.vstack([np.eye(3, dtype=int), -np.eye(3, dtype=int)])
    neighbors = table.vertex_at(table.indices[:, None] + steps)
    values, known = values.copy(), known.copy()
    while not known.all():
        usable = (neighbors >= 0) & known[neighbors]
        count = usable.sum(axis=1)
        new = ~known & (count > 0)
        if not new.any():
            break  # components without a vertex of the mesh keep 0
        values[new] = (values[neighbors[new]] * usable[new]).sum(axis=1) / count[new]
        known |= new
    return values


class _Grid:
    """Finds the vertices and cells of a lattice by their coordinates."""

    def __init__(self, lattice: supple.Lattice) -> None:
        """Fill tables with one entry per point of the bounding box of the lattice, and a border of one point."""
        self._lattice = lattice
        self._low = lattice.indices.min(axis=0) - 1
        self._shape = lattice.indices.max(axis=0) + 2 - self._low
        self.indices = lattice.indices
        self._vertex = np.full(self._shape, -1, np.int64)
        self._vertex[tuple((lattice.indices - self._low).T)] = np.arange(len(lattice))
        self._occupied = np.zeros(self._shape, bool)
        self._occupied[tuple((lattice.cells - self._low).T)] = True

    def vertex_at(self, indices: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the lattice vertices with given coordinates, -1 where there is none."""
        return self._at(self._vertex, indices)

    def cells_of(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the occupied cells that contain points, and the positions of the points in them, from 0 to 1.

        A point on the border of a cell may be attributed to the other side, which is empty. It then belongs to the
        nearest occupied cell around.
        """
        place = (points - self._lattice.origin) / self._lattice.cell_size
        cells = np.floor(place).astype(np.int64)
        lost = ~self._at(self._occupied, cells)
        around = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
        for point in np.flatnonzero(lost):
            candidates = cells[point] + around
            candidates = candidates[self._at(self._occupied, candidates)]
            if len(candidates):
                distances = np.linalg.norm(candidates + 0.5 - place[point], axis=1)
                cells[point] = candidates[distances.argmin()]
        return cells, np.clip(place - cells, 0.0, 1.0)

    def _at(self, table: NDArray[_Entry], indices: NDArray[np.int64]) -> NDArray[_Entry]:
        """Return the entries of a table. Coordinates outside of it have those of its border, which is empty."""
        places = np.clip(indices - self._low, 0, self._shape - 1)
        entries: NDArray[_Entry] = table[tuple(np.moveaxis(places, -1, 0))]
        return entries
