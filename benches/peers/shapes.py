"""The shapes of the tasks: lattices of cubes, with tetrahedra and a surface, the same for all programs.

z is up. All programs get the same points. Programs with tetrahedra get the cubes cut into six each (Kuhn), and every
result is measured on the same surface: the outer faces of the cubes, which Body.surface deforms in supple.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Indices = NDArray[np.int64]

SCENES = Path(__file__).parents[2] / "examples/scenes"


@dataclass(frozen=True)
class Shape:
    """A body at rest."""

    points: Points
    """(n, 3): corners of the cubes."""
    corners: Indices
    """(c, 3): the grid coordinates of the cubes."""
    tetrahedra: Indices
    """(6 c, 4): into points, of positive volume."""
    surface: Indices
    """(s,): the points on the surface."""
    triangles: Indices
    """(t, 3): into surface, outward."""
    cell_size: float
    """Edge of a cube."""

    @property
    def size(self) -> float:
        """The cube root of the volume."""
        return float(len(self.corners)) ** (1 / 3) * self.cell_size


def box(points: int) -> Shape:
    """A cube with edges of 1 m, of about this number of points."""
    edge = round(points ** (1 / 3)) - 1
    return from_cells(np.ones((edge, edge, edge), bool), 1 / edge)


def bar(cells: int) -> Shape:
    """A bar of 2 x 0.25 x 0.25 m, with this number of cubes across."""
    return from_cells(np.ones((8 * cells, cells, cells), bool), 0.25 / cells)


def bust(points: int) -> Shape:
    """The bust of the examples, 1 m high, as cubes with about this number of points."""
    import supple

    mesh = supple.read_obj(SCENES / "bust.obj")
    upright = mesh.vertices[:, [2, 0, 1]]
    height = np.ptp(upright[:, 2])
    lattice = supple.Lattice.from_mesh(supple.Mesh(upright / height, mesh.faces), vertices=points)
    cells = np.zeros(lattice.cells.max(axis=0) + 1, bool)
    cells[tuple(lattice.cells.T)] = True
    return from_cells(cells, lattice.cell_size)


def from_cells(cells: NDArray[np.bool_], cell_size: float) -> Shape:
    """Build the shape of the occupied cells, with its lowest corner at the origin."""
    corners = np.argwhere(cells)
    corners -= corners.min(axis=0)
    offsets = np.array(list(itertools.product((0, 1), repeat=3)))
    grid = (corners[:, None] + offsets).reshape(-1, 3)
    coordinates, number = np.unique(grid, axis=0, return_inverse=True)
    cubes = number.reshape(-1, 8)
    tetrahedra = np.concatenate([cubes[:, path] for path in kuhn_paths()])
    faces = outer_faces(tetrahedra)
    surface, triangles = np.unique(faces, return_inverse=True)
    return Shape(
        points=coordinates * cell_size,
        corners=corners,
        tetrahedra=tetrahedra,
        surface=surface,
        triangles=triangles.reshape(-1, 3),
        cell_size=cell_size,
    )


def kuhn_paths() -> list[list[int]]:
    """Cut a cube into six tetrahedra: the paths along edges from corner 0 to corner 7, one per order of the axes."""
    paths = []
    for order in itertools.permutations((4, 2, 1)):
        path = [0, order[0], order[0] + order[1], 7]
        odd = ((order[0] > order[1]) + (order[0] > order[2]) + (order[1] > order[2])) % 2
        # The paths of even permutations of x, y, z have a positive volume; the bits 4, 2, 1 stand for x, y, z.
        paths.append(path if odd else [path[0], path[2], path[1], path[3]])
    return paths


def outer_faces(tetrahedra: Indices) -> Indices:
    """Return the faces that belong to one tetrahedron only, outward."""
    faces = np.concatenate([tetrahedra[:, face] for face in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1])])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def save(shape: Shape, path: Path) -> None:
    """Write a shape to a file."""
    np.savez(path, points=shape.points, corners=shape.corners, cell_size=shape.cell_size)


def load(path: Path) -> Shape:
    """Read a shape from a file."""
    with np.load(path) as file:
        corners, cell_size = file["corners"], float(file["cell_size"])
    cells = np.zeros(corners.max(axis=0) + 1, bool)
    cells[tuple(corners.T)] = True
    return from_cells(cells, cell_size)
