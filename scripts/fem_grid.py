"""Fills a closed surface with a grid of cubes, for finite elements: `Grid`, `fill`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import skfem
from numpy.typing import NDArray

import supple

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Corners of a cube in scikit-fem's order, so that the cells have the orientation of its reference cube.
CORNERS = skfem.ElementHex1.doflocs.astype(int)
# Samples along each edge of an eighth of a cell. They measure the fraction of the eighth that is inside a surface.
SAMPLES = 4
# Minimum filled fraction of an eighth. With a fraction of 0, the outer corners of a cell would have no stiffness.
MIN_FRACTION = 0.01


@dataclass
class Grid:
    """Cubes with the integer coordinates `cells` (m, 3). The lower corner of a cube is origin + cell_size * cell."""

    cells: Ints
    cell_size: float
    origin: Floats

    def __post_init__(self) -> None:
        """Computes the positions of the nodes (n, 3), and the node indices of each cell (m, 8)."""
        corners = self.cells[:, None] + CORNERS
        shape = tuple(self.cells.max(axis=0) + 2)
        flat = np.ravel_multi_index(tuple(np.moveaxis(corners, -1, 0)), shape)
        nodes, node_indices = np.unique(flat, return_inverse=True)
        self.nodes = np.stack(np.unravel_index(nodes, shape), axis=-1) * self.cell_size + self.origin
        self.corners = node_indices.reshape(-1, 8)

    def mesh(self) -> skfem.MeshHex:
        """Returns the grid as a mesh of scikit-fem."""
        return skfem.MeshHex(self.nodes.T.copy(), self.corners.T.copy())

    def interpolate(self, values: Floats, points: Floats) -> Floats:
        """Interpolates node values (n, 3) trilinearly at points (k, 3) in the cells."""
        last = self.cells.max(axis=0)
        cell_indices = np.full(last + 1, -1)
        cell_indices[tuple(self.cells.T)] = np.arange(len(self.cells))
        scaled = (points - self.origin) / self.cell_size
        # Points on the far faces of the box belong to its last cells.
        cells = np.clip(np.floor(scaled).astype(int), 0, last)
        containing = cell_indices[tuple(cells.T)]
        if (containing < 0).any():
            raise ValueError(f"{(containing < 0).sum()} of {len(points)} points lie in no cell")
        local = (scaled - cells)[:, None]
        weights = np.where(CORNERS, local, 1 - local).prod(axis=2)
        return np.einsum("ka,kai->ki", weights, values[self.corners[containing]])


def fill(surface: supple.Mesh, cell_size: float, anchor: Floats) -> tuple[Grid, Floats]:
    """Returns the cells that a closed surface touches or encloses, and the filled fractions of their eighths.

    `anchor` is the position of a node. The fractions have the shape (m, 2, 2, 2).
    """
    low, high = surface.bounds
    origin = anchor - np.ceil((anchor - low) / cell_size) * cell_size
    size = np.ceil((high - origin) / cell_size).astype(int)
    fractions = _inside(surface, origin, cell_size / (2 * SAMPLES), size * 2 * SAMPLES)
    fractions = fractions.reshape([length for n in size for length in (n, 2, SAMPLES)]).mean(axis=(2, 5, 8))
    fractions = fractions.transpose(0, 2, 4, 1, 3, 5)
    occupied = fractions.any(axis=(3, 4, 5))
    occupied[tuple(_touched(surface, origin, cell_size).T)] = True
    return Grid(np.argwhere(occupied), cell_size, origin), np.maximum(fractions[occupied], MIN_FRACTION)


def _touched(surface: supple.Mesh, origin: Floats, cell_size: float) -> Ints:
    """Returns the cells (k, 3) that contain one of many sample points on each triangle of the surface."""
    steps = np.arange(13)
    first, second = (steps_on_edge.ravel() for steps_on_edge in np.meshgrid(steps, steps))
    is_inside = first + second <= 12
    barycentric = np.stack([first, second, 12 - first - second], axis=1)[is_inside] / 12
    points = np.einsum("ba,tai->tbi", barycentric, surface.vertices[surface.faces]).reshape(-1, 3)
    return np.unique(np.floor((points - origin) / cell_size).astype(int), axis=0)


def _inside(surface: supple.Mesh, origin: Floats, step: float, counts: Ints) -> NDArray[np.bool_]:
    """Returns whether each sample is inside the surface, by parity along rays in x. Samples are `step` apart."""
    inside = np.zeros(counts, dtype=bool)
    # Coordinates are in units of the step. A small shift keeps the rays off the vertices and edges of symmetric models.
    triangles = (surface.vertices[surface.faces] - origin) / step - 0.5 + [0, 1.7e-6, 2.3e-6]
    for triangle in triangles:
        first = np.ceil(triangle[:, 1:].min(axis=0)).astype(int)
        last = np.floor(triangle[:, 1:].max(axis=0)).astype(int)
        rays = np.stack(np.meshgrid(*map(np.arange, first, last + 1), indexing="ij"), axis=-1).reshape(-1, 2)
        corners = np.column_stack([triangle[:, 1:], np.ones(3)])
        if len(rays) == 0 or abs(np.linalg.det(corners)) < 1e-12:
            continue
        barycentric = np.column_stack([rays, np.ones(len(rays))]) @ np.linalg.inv(corners)
        hits = (barycentric >= 0).all(axis=1)
        for (j, k), x in zip(rays[hits], barycentric[hits] @ triangle[:, 0], strict=True):
            inside[max(0, int(np.ceil(x))) :, j, k] ^= True
    return inside
