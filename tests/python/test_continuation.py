"""Runs from a frame with a changed scene, slow motion and pre-roll."""

import numpy as np
import pytest

import supple

SCENE = """
[simulation]
frames = 8
substeps = 3
[output]
format = "pc2"
states = 3
[[body]]
mesh = "cube.obj"
name = "cube"
lattice_vertices = 64
half_width = 1
translate = [0, 0.1, 0]
[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"""
QUADS = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"


@pytest.fixture
def scene(tmp_path):
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
    (tmp_path / "cube.obj").write_text(vertices + QUADS)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path / "scene.toml"


def _frames(output):
    return np.frombuffer((output / "cube.pc2").read_bytes(), "<f4", offset=32).reshape(-1, 8, 3)


def test_a_run_continues_from_a_frame_with_another_gravity(scene, tmp_path):
    out = tmp_path / "out"
    supple.run(scene, out)
    before = _frames(out)
    up = {"simulation.gravity": [0, 5, 0]}
    report = supple.run(scene, out, overrides=up, from_frame=5)
    assert (report.outcome, report.resumed_after, report.last, report.written) == ("finished", 3, 8, 5)
    after = _frames(out)
    assert np.array_equal(after[:4], before[:4])
    assert (after[8, :, 1] > before[8, :, 1]).all()
    with pytest.raises(supple.SceneError, match="no state at or before frame 2"):
        supple.run(scene, out, overrides=up, from_frame=2)
    with pytest.raises(supple.SceneError, match=r"`body\.cube\.lattice_vertices` changed from 64 to 200"):
        supple.run(scene, out, overrides={"body.cube.lattice_vertices": 200}, from_frame=5)
    with pytest.raises(supple.SceneError, match="`from` is 5; it must be left out with `resume`"):
        supple.run(scene, out, overrides=up, from_frame=5, resume=True)
    with pytest.raises(ValueError, match="from_frame"):
        supple.run(scene, out, from_frame=-1)
    assert np.array_equal(_frames(out), after)


def test_slow_motion_and_preroll_of_runs_and_live_scenes(scene, tmp_path):
    times = []
    overrides = {"simulation.time_scale": [{"time": 0, "value": 1}, {"time": 0.2, "value": 0.1}]}
    supple.run(scene, tmp_path / "slow", overrides=overrides, progress=lambda progress: times.append(progress.time))
    assert times[0] == 0
    assert times[6] == pytest.approx(0.2 * 0.55)
    assert times[8] - times[6] == pytest.approx(0.1 * 2 / 30)

    supple.run(scene, tmp_path / "whole")
    sim = supple.load_scene(scene, overrides={"simulation.preroll": 0.1})
    assert sim.time == 0
    assert np.array_equal(sim["cube"].surface().astype(np.float32), _frames(tmp_path / "whole")[3])
    with pytest.raises(supple.SceneError, match=r"in \(0, 10\]"):
        supple.load_scene(scene, overrides={"simulation.time_scale": 20})
