"""The tasks: what is simulated, in SI units, z up. Each program gets the same Task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import shapes
from shapes import Indices, Points, Shape

FPS = 60
GRAVITY = 9.81
FRICTION = 0.5
Key = tuple[float, tuple[float, float, float], float]
"""Time, translation, and degrees about y."""


@dataclass(frozen=True)
class Hold:
    """Points that are moved along keys, relative to their rest positions and about their center, then let go."""

    points: Indices
    keys: tuple[Key, ...]

    @property
    def end(self) -> float:
        """When the points are let go."""
        return self.keys[-1][0]

    def positions(self, rest: Points, time: float) -> Points:
        """Return where the points are at a time, linear between the keys."""
        return self.move(rest[self.points], rest[self.points].mean(axis=0), time)

    def move(self, places: Points, center: Points, time: float) -> Points:
        """Move other places along, about the center of the held points."""
        times = [key[0] for key in self.keys]
        shift = np.array([np.interp(time, times, [key[1][axis] for key in self.keys]) for axis in range(3)])
        angle = np.radians(np.interp(time, times, [key[2] for key in self.keys]))
        return (places - center) @ about("y", angle).T + center + shift


@dataclass(frozen=True)
class Task:
    """Copies of a shape, what holds them, and the planes that they hit."""

    name: str
    shape: Shape
    frames: int
    timed_frames: int
    """Frames at the start over which the times count."""
    places: tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]
    """Rotation matrix and offset of each body."""
    youngs_modulus: float
    poissons_ratio: float = 0.45
    density: float = 1000.0
    holds: tuple[Hold, ...] = ()
    """Of the first body."""
    planes: tuple[tuple[tuple[float, float, float], tuple[float, float, float]], ...] = (((0, 0, 0), (0, 0, 1)),)
    """Point and normal to the free side."""
    self_contact: bool = False
    full_stretch: int | None = None
    """Frame at which the volume error under load is measured."""
    speeds: tuple[float, ...] = (3.0, 4.0, 6.0)
    depth_every: int = 15
    """Frames between two measurements of the depth of interpenetration."""

    def bodies(self) -> list[Points]:
        """Return the points of each body at the start."""
        return [self.shape.points @ rotation.T + offset for rotation, offset in self.places]


def about(axis: str, angle: float) -> NDArray[np.float64]:
    """Return the rotation about an axis by an angle in radians."""
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = np.cos(angle)
    matrix[first, second] = -np.sin(angle)
    matrix[second, first] = np.sin(angle)
    return matrix


def stretch(name: str, shape: Shape) -> Task:
    """Stretch a body 1.5 times in 1 s, let it go, and drop it by half a metre; 6 s, of which 3 s are timed."""
    z = shape.points[:, 2]
    height = z.max()
    margin = max(0.05 * height, 0.5 * shape.cell_size) if name.startswith("bust") else 0.5 * shape.cell_size
    low, high = np.flatnonzero(z <= margin), np.flatnonzero(z >= height - margin)
    return Task(
        name=name,
        shape=shape,
        frames=6 * FPS,
        timed_frames=3 * FPS,
        places=((np.eye(3), np.array([0, 0, 0.5])),),
        youngs_modulus=1e6,
        holds=(
            Hold(low, ((0, (0, 0, 0), 0), (1, (0, 0, 0), 0))),
            Hold(high, ((0, (0, 0, 0), 0), (1, (0, 0, 0.5 * height), 0))),
        ),
        full_stretch=FPS,
    )


def pile(cells: int = 5, bodies: int = 30) -> Task:
    """Drop cubes with edges of 0.3 m into a bin of 1.65 x 1.1 m, in layers of six, each turned differently; 6 s."""
    edge, spacing = 0.3, 0.55
    shape = shapes.from_cells(np.ones((cells, cells, cells), bool), edge / cells)
    places = []
    for index in range(bodies):
        turn = about("z", 0.7 * index) @ about("x", 0.4 * index)
        # The diagonal of a cube, 0.52 m, is less than the spacing: no two cubes touch at the start.
        middle = spacing * (np.array([index % 3, index // 3 % 2, index // 6]) + 0.5)
        places.append((turn, middle - turn @ np.full(3, edge / 2)))
    length, width = 3 * spacing, 2 * spacing
    walls = (((0, 0, 0), (1, 0, 0)), ((length, 0, 0), (-1, 0, 0)), ((0, 0, 0), (0, 1, 0)), ((0, width, 0), (0, -1, 0)))
    return Task(
        name="pile",
        shape=shape,
        frames=6 * FPS,
        timed_frames=6 * FPS,
        places=tuple(places),
        youngs_modulus=1e5,
        planes=(((0, 0, 0), (0, 0, 1)), *walls),
    )


def fold(cells: int = 5) -> Task:
    """Fold a bar of 2 m onto itself in 1.5 s, hold it for 1 s, and let it go; 6 s."""
    shape = shapes.bar(cells)
    x = shape.points[:, 0]
    first, last = np.flatnonzero(x <= 0.2), np.flatnonzero(x >= 1.8)
    # The held end goes half around a point above the middle, and ends 3 cm above the place where it touches the other.
    arc = []
    for step in range(9):
        angle = np.pi * step / 8
        rise = 0.28 * step / 8
        arc.append((1.5 * step / 8, (0.8 * np.cos(angle) - 0.8, 0.0, 0.8 * np.sin(angle) + rise), -180.0 * step / 8))
    arc.append((2.5, *arc[-1][1:]))
    return Task(
        name="fold",
        shape=shape,
        frames=6 * FPS,
        timed_frames=6 * FPS,
        places=((np.eye(3), np.array([0, 0, 0.02])),),
        youngs_modulus=1e5,
        holds=(Hold(first, ((0, (0, 0, 0), 0), (2.5, (0, 0, 0), 0))), Hold(last, tuple(arc))),
        self_contact=True,
        full_stretch=2 * FPS,
    )


def named(folder: Path) -> dict[str, Callable[[], Task]]:
    """Return the tasks by name. Shapes that supple builds are read from a folder."""
    tasks: dict[str, Callable[[], Task]] = {"pile": pile, "fold": fold}
    for points in (1000, 10_000, 100_000):
        tasks[f"box-{points}"] = lambda points=points: stretch(f"box-{points}", shapes.box(points))
        path = folder / f"bust-{points}.npz"
        tasks[f"bust-{points}"] = lambda points=points, path=path: stretch(f"bust-{points}", shapes.load(path))
    return tasks
