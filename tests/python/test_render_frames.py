"""`examples/python/render_frames.py`: pictures of surfaces without a display."""

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from shapes import CORNERS, QUADS

ROOT = Path(__file__).parents[2]
PROGRAM = ROOT / "examples" / "python" / "render_frames.py"


@pytest.fixture(scope="module")
def program():
    pytest.importorskip("matplotlib")
    return runpy.run_path(str(PROGRAM))


def cube(program, shift=(0, 0, 0)):
    triangles = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
    return program["Surface"](CORNERS + shift, triangles)


def test_a_surface_covers_its_projection_in_the_colors_of_its_faces(program):
    box = cube(program)
    assert box.volume == pytest.approx(1, rel=1e-12)
    low, high = np.array([-1.0, -1, -1]), np.array([2.0, 2, 2])
    picture = program["draw"](box, low, high, view=(0, 0, 1))
    assert picture.shape == (500, 480, 3)
    covered = (picture < 1).any(axis=2)
    # 3 units fill 96 % of the width of 480 pixels; a row of pixels at the border may count or not.
    assert np.sqrt(covered.sum()) == pytest.approx(0.96 * 480 / 3, abs=1)
    rows, columns = np.nonzero(covered)
    assert (rows.mean(), columns.mean()) == pytest.approx((249.5, 239.5), abs=0.6)
    # Two triangles in one plane have one color.
    assert (
        np.ptp(picture[rows.min() + 2 : rows.max() - 2, columns.min() + 2 : columns.max() - 2], axis=(0, 1)).max()
        < 1e-9
    )
    # From a corner three faces are visible, each in a color of its own.
    picture = program["draw"](box, low, high, view=(1, 1.1, 1.2))
    values, counts = np.unique(picture[:, :, 0].round(6), return_counts=True)
    assert len([1 for value, count in zip(values, counts, strict=True) if count > 2000 and value < 1]) == 3


def test_the_nearer_surface_hides_the_other_and_smooth_shading_blends(program):
    low, high = np.array([-1.0, -1, -1]), np.array([2.0, 2, 4])
    near, far = cube(program, (0, 0, 3)), cube(program)
    view = (0.2, 0.1, 1)
    alone, smooth = (program["draw"](near, low, high, view=view, smooth=smooth) for smooth in (False, True))
    # Without the border, whose pixels contain several surfaces.
    covered = (alone < 1).all(axis=2)
    inside = covered & np.logical_and.reduce([np.roll(covered, step, axis) for step in (1, -1) for axis in (0, 1)])
    for first, second in ((near, far), (far, near)):
        points, triangles = [first.points, second.points], [first.triangles, second.triangles + 8]
        both = program["Surface"](np.concatenate(points), np.concatenate(triangles))
        picture = program["draw"](both, low, high, view=view)
        assert np.array_equal(picture[inside], alone[inside])
        assert (picture < 1).all(axis=2).sum() > covered.sum() + 1000
    # One color for each visible face, apart from pixels on the edges between them.
    values, counts = np.unique(alone[inside][:, 0].round(6), return_counts=True)
    assert (counts > 500).sum() == 3, values[counts > 500]
    assert len(np.unique(smooth[inside][:, 0].round(2))) > 10


def test_the_ground_has_a_shadow(program):
    low, high = np.array([0.0, 0, 0]), np.array([1.0, 2, 1])
    picture = program["draw"](cube(program, (0, 1, 0)), low, high, ground=0)
    colors = {tuple(color) for color in picture.reshape(-1, 3).round(6)}
    for name in ("GROUND", "SHADOW"):
        assert tuple(program[name].round(6)) in colors


def test_frames_of_runs_become_one_picture(program, tmp_path, monkeypatch):
    from matplotlib import image

    for run, height in (("a", 1.0), ("b", 2.0)):
        (tmp_path / run).mkdir()
        for frame in (0, 5):
            lines = [f"v {x} {y * height} {z}" for x, y, z in CORNERS]
            lines += ["f " + " ".join(str(i + 1) for i in quad) for quad in QUADS]
            (tmp_path / run / f"box_{frame:04d}.obj").write_text("\n".join(lines))
    rows = [f"{run}={tmp_path / run}" for run in "ab"]
    for frames, shape in ((["0", "5"], (637, 598)), (["5"], (318, 598))):
        monkeypatch.setattr(sys, "argv", ["render_frames.py", str(tmp_path / "x.png"), *rows, "--frames", *frames])
        program["main"]()
        assert image.imread(tmp_path / "x.png").shape[:2] == shape
    monkeypatch.setattr(sys, "argv", ["render_frames.py", str(tmp_path / "x.png"), *rows, "--frames", "7"])
    with pytest.raises(SystemExit, match="contains no frame 7"):
        program["main"]()
