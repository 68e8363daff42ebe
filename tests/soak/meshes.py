"""Generated surfaces, and OBJ files of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

#: A surface: vertices (n, 3), and faces as lists of indices from 0.
Surface = tuple[NDArray[np.float64], list[list[int]]]


def box(size: Sequence[float] = (1, 1, 1)) -> Surface:
    """Return a box of quads around the origin, normals outwards."""
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return (corners - 0.5) * size, quads


def sphere(rings: int = 12, segments: int = 16, radius: float = 1.0) -> Surface:
    """Return a sphere of quads, with triangles at the poles."""
    polar = np.linspace(0, np.pi, rings + 1)[1:-1, None]
    around = np.linspace(0, 2 * np.pi, segments, endpoint=False)[None, :]
    ring = np.stack(
        [np.sin(polar) * np.cos(around), np.cos(polar) + 0 * around, np.sin(polar) * np.sin(around)], axis=-1
    ).reshape(-1, 3)
    vertices = radius * np.concatenate([ring, [[0, 1, 0], [0, -1, 0]]])
    top, bottom = len(ring), len(ring) + 1
    faces = []
    for s in range(segments):
        t = (s + 1) % segments
        faces.append([top, t, s])
        for r in range(rings - 2):
            faces.append([r * segments + s, r * segments + t, (r + 1) * segments + t, (r + 1) * segments + s])
        faces.append([bottom, (rings - 2) * segments + s, (rings - 2) * segments + t])
    return vertices, faces


def torus(around: int = 20, across: int = 10, radius: float = 0.35) -> Surface:
    """Return a torus about the y axis whose tube has the given radius; the radius of its center line is 1."""
    u, v = np.meshgrid(
        np.linspace(0, 2 * np.pi, around, endpoint=False),
        np.linspace(0, 2 * np.pi, across, endpoint=False),
        indexing="ij",
    )
    distance = 1 + radius * np.cos(v)
    vertices = np.stack([distance * np.cos(u), radius * np.sin(v), distance * np.sin(u)], axis=-1).reshape(-1, 3)

    def at(i: int, j: int) -> int:
        return i % around * across + j % across

    faces = [[at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)] for i in range(around) for j in range(across)]
    return vertices, faces


def prism(corners: int = 9, height: float = 1.5) -> Surface:
    """Return a prism whose two ends are faces with many corners."""
    angles = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    circle = np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=-1)
    vertices = np.concatenate([circle, circle + [0, height, 0]])
    sides = [[k, k + corners, (k + 1) % corners + corners, (k + 1) % corners] for k in range(corners)]
    return vertices, [list(range(corners)), list(range(2 * corners - 1, corners - 1, -1)), *sides]


def soup(triangles: NDArray[np.float64]) -> Surface:
    """Return triangles (n, 3, 3) without shared vertices."""
    return triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3).tolist()


def joined(surfaces: Iterable[Surface]) -> Surface:
    """Return surfaces as one, without shared vertices."""
    vertices: list[NDArray[np.float64]] = []
    faces: list[list[int]] = []
    first = 0
    for more, polygons in surfaces:
        vertices.append(more)
        faces += [[first + corner for corner in polygon] for polygon in polygons]
        first += len(more)
    return np.concatenate(vertices), faces


def any_surface(random: np.random.Generator) -> Surface:
    """Return one of the closed surfaces of this module."""
    makers = [
        lambda: box(random.uniform(0.5, 2, 3)),
        lambda: sphere(int(random.integers(3, 16)), int(random.integers(3, 20))),
        lambda: torus(radius=float(random.uniform(0.2, 0.6))),
        lambda: prism(int(random.integers(3, 30))),
        lambda: joined([sphere(), box([0.5, 3, 0.5])]),
    ]
    return makers[random.integers(len(makers))]()


def write_obj(path: Path, surface: Surface) -> None:
    """Write a surface as an OBJ file."""
    vertices, faces = surface
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
