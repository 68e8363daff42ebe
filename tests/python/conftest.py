"""Fixtures that several tests share."""

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
    """The path of the bust of the example scenes, 4,717 vertices."""
    return ROOT / "examples" / "scenes" / "bust.obj"


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Makes Ctrl-C raise, also in a background process whose shell ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def polyscope(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """Returns polyscope rendering without a display, in a temporary working directory for the files that it writes."""
    monkeypatch.chdir(tmp_path)
    polyscope = pytest.importorskip("polyscope")
    if not polyscope.is_initialized():
        polyscope.set_use_prefs_file(False)
        try:
            polyscope.init("openGL3_egl")
        except RuntimeError as error:
            pytest.skip(f"no renderer is available: {error}")
    # Every tick renders, without a limit on the frame rate.
    polyscope.set_max_fps(-1)
    return polyscope


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """The path of a scene: a cube falls on the ground in 12 frames of two steps."""
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
