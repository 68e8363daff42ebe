"""What the worker asks of each program: one class per program, in peer_*.py."""

from __future__ import annotations

import itertools
from typing import ClassVar, Protocol

import numpy as np
from tasks import Task

from shapes import Points, Shape

THREADS = 2


class UnsupportedError(Exception):
    """Raised by a peer for a task that the program has no means for; the message says which are missing."""


class Peer(Protocol):
    """A program that simulates a task. The constructor builds the task and is timed as set-up."""

    PACKAGE: ClassVar[str]
    """The package whose version is reported."""
    SETTINGS: ClassVar[str]
    """The settings that decide speed and quality, and where the program's documentation recommends them."""

    def __init__(self, task: Task) -> None:
        """Build the simulation."""

    def drive(self, frame: int) -> None:
        """Set the targets of what is held for the frame that ends at (frame + 1) / 60 s. This is not timed."""

    def advance(self) -> None:
        """Simulate a frame. This is timed, with surface()."""

    def surface(self) -> Points:
        """Return the positions of shape.surface of each body: (bodies, s, 3)."""


def lumped_masses(shape: Shape, density: float) -> Points:
    """Return the masses of the points: an eighth of each cube that has the point as its corner."""
    grid = np.rint(shape.points / shape.cell_size).astype(int)
    count = np.zeros(grid.max(axis=0) + 1)
    for offset in itertools.product((0, 1), repeat=3):
        np.add.at(count, tuple((shape.corners + offset).T), 1)
    return count[tuple(grid.T)] * density * shape.cell_size**3 / 8
