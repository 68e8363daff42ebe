"""Grids of cubes that fill a surface, for finite elements: `Grid`, `fill`."""

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
# Samples per edge of an eighth of a cell; they measure the share of it inside a surface.
SAMPLES = 4
# Minimum share of an eighth. With a share of 0, the outer corners of a cell would have no stiffness.
LEAST_SHARE = 0.01


@dataclass
class Grid:
    """Cubes at the integer coordinates `cells` (m, 3). The lower corner of a cube is origin + cell_size * cell."""

    cells: Ints
    cell_size: float
    origin: Floats

    def __post_init__(self) -> None:
        """Numbers the nodes: their positions (n, 3), and the node numbers of each cell (m, 8)."""
        corners = self.cells[:, None] + CORNERS
        shape = tuple(self.cells.max(axis=0) + 2)
        flat = np.ravel_multi_index(tuple(np.moveaxis(corners, -1, 0)), shape)
        nodes, numbers = np.unique(flat, return_inverse=True)
        self.nodes = np.stack(np.unravel_index(nodes, shape), axis=-1) * self.cell_size + self.origin
        self.corners = numbers.reshape(-1, 8)

    def mesh(self) -> skfem.MeshHex:
        """Returns the grid as a mesh of scikit-fem."""
        return skfem.MeshHex(self.nodes.T.copy(), self.corners.T.copy())

    def interpolate(self, values: Floats, points: Floats) -> Floats:
        """Interpolates node values (n, 3) trilinearly at points (k, 3) in the cells."""
        last = self.cells.max(axis=0)
        numbers = np.full(last + 1, -1)
        numbers[tuple(self.cells.T)] = np.arange(len(self.cells))
        scaled = (points - self.origin) / self.cell_size
        # Points on the far faces of the box belong to its last cells.
        cells = np.clip(np.floor(scaled).astype(int), 0, last)
        owners = numbers[tuple(cells.T)]
        if (owners < 0).any():
            raise ValueError(f"{(owners < 0).sum()} of {len(points)} points lie in no cell")
        inside = (scaled - cells)[:, None]
        weights = np.where(CORNERS, inside, 1 - inside).prod(axis=2)
        return np.einsum("ka,kai->ki", weights, values[self.corners[owners]])


def fill(surface: supple.Mesh, cell_size: float, anchor: Floats) -> tuple[Grid, Floats]:
    """Returns the cells that a closed surface touches or encloses, and the filled shares of their eighths.

    `anchor` is the position of a node. The shares have the shape (m, 2, 2, 2).
    """
    low, high = surface.bounds
    origin = anchor - np.ceil((anchor - low) / cell_size) * cell_size
    size = np.ceil((high - origin) / cell_size).astype(int)
    shares = _inside(surface, origin, cell_size / (2 * SAMPLES), size * 2 * SAMPLES)
    shares = shares.reshape([length for n in size for length in (n, 2, SAMPLES)]).mean(axis=(2, 5, 8))
    shares = shares.transpose(0, 2, 4, 1, 3, 5)
    occupied = shares.any(axis=(3, 4, 5))
    occupied[tuple(_touched(surface, origin, cell_size).T)] = True
    return Grid(np.argwhere(occupied), cell_size, origin), np.maximum(shares[occupied], LEAST_SHARE)


def _touched(surface: supple.Mesh, origin: Floats, cell_size: float) -> Ints:
    """Returns the cells (k, 3) that contain one of many sample points on each triangle of the surface."""
    steps = np.arange(13)
    first, second = (steps_on_edge.ravel() for steps_on_edge in np.meshgrid(steps, steps))
    within = first + second <= 12
    barycentric = np.stack([first, second, 12 - first - second], axis=1)[within] / 12
    points = np.einsum("ba,tai->tbi", barycentric, surface.vertices[surface.faces]).reshape(-1, 3)
    return np.unique(np.floor((points - origin) / cell_size).astype(int), axis=0)


def _inside(surface: supple.Mesh, origin: Floats, step: float, counts: Ints) -> NDArray[np.bool_]:
    """Returns which samples are inside, by parity along rays in x. Samples are centers of cubes of edge `step`."""
    inside = np.zeros(counts, dtype=bool)
    # In units of the step. The small shift keeps rays off vertices and edges of symmetric models.
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
