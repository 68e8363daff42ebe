"""Shapes that the tests share."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import supple
from shapes import CORNERS, QUADS

ROOT = Path(__file__).parents[2]


@pytest.fixture
def cube() -> supple.Mesh:
    """A cube of edge 2 about the origin, of quads."""
    return supple.Mesh(2 * CORNERS - 1, QUADS)


@pytest.fixture
def block() -> supple.Lattice:
    """4 x 3 x 2 cells of edge 0.5."""
    return supple.Lattice.from_cells(np.ones((4, 3, 2), bool), cell_size=0.5, origin=(1, 2, 3))


@pytest.fixture
def bust() -> Path:
    """A head of 60,000 vertices, with open eyes."""
    return ROOT / "examples" / "scenes" / "bust.obj"


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C raises, also where the tests run in the background of a shell that has switched it off."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def polyscope(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """Drawn without a display; what it writes beside the program goes to a scratch folder."""
    monkeypatch.chdir(tmp_path)
    polyscope = pytest.importorskip("polyscope")
    if not polyscope.is_initialized():
        polyscope.set_use_prefs_file(False)
        try:
            polyscope.init("openGL3_egl")
        except RuntimeError as error:
            pytest.skip(f"nothing can be drawn here: {error}")
    # Each tick is a picture, however soon it comes after the last.
    polyscope.set_max_fps(-1)
    return polyscope


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A cube that falls on the ground, 12 frames of two steps."""
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in 2 * CORNERS - 1)
    faces = "".join("f " + " ".join(str(corner + 1) for corner in quad) + "\n" for quad in QUADS)
    (tmp_path / "cube.obj").write_text(corners + faces)
    path = tmp_path / "fall.toml"
    path.write_text(
        """
        [simulation]
        frames = 12
        fps = 30
        substeps = 2

        [[body]]
        name = "cube"
        mesh = "cube.obj"
        lattice_vertices = 125
        translate = [0, 1.2, 0]
        region_damping = 0.1

        [[body.pin]]
        box = { min = [-2, 2, -2], max = [2, 3, 2] }
        end = 0.1

        [[collider]]
        plane = { point = [0, 0, 0], normal = [0, 1, 0] }
        """
    )
    return path
