"""Handles that follow an animated mesh."""

from __future__ import annotations

import copy
import pickle
import struct

import numpy as np
import pytest

import supple

FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)
LEFT = ((0.1, 0, 0), (-1, 0, 0))


def _walk(frames=20):
    """Return positions of the corners that rise by 0.1 in a frame and turn about z."""
    angles = 0.1 * np.arange(frames)
    turns = np.array([[[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]] for a in angles])
    return (CORNERS @ turns.transpose(0, 2, 1) + 0.1 * np.arange(frames)[:, None, None] * [0, 1, 0]).astype(np.float32)


def _body(**settings):
    return supple.Body(supple.Mesh(CORNERS, FACES), lattice_vertices=64, material="jelly", volume="off", **settings)


def _cache(path, positions, first=0.0, interval=1.0):
    header = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, positions.shape[1], first, interval, len(positions))
    path.write_bytes(header + positions.astype("<f4").tobytes())
    return path


def test_held_vertices_follow_the_animation_with_the_scale_and_placement_of_the_body():
    walk = _walk()
    body = _body(scale=2.0, translate=(5, 0, 0))
    hold = body.handle(plane=((9, 0, 0), (-1, 0, 0)), follow=walk, follow_fps=10)
    assert hold.keys is None
    assert hold.interpolation is None
    assert np.array_equal(hold.follow, walk)
    assert hold.follow.dtype == np.float32
    assert not hold.follow.flags.writeable
    assert hold.follow_fps == pytest.approx(10)
    assert hold.follow_start == 0
    assert "follows 20 frames" in repr(hold)
    sim = supple.Simulation([body], dt=0.05)
    for step in range(1, 39):
        sim.step()
        before, after = walk[step // 2], walk[(step + 1) // 2]
        expected = 2.0 * (before + after) / 2 + [5, 0, 0]
        # The mesh vertices are in cells whose corners all are held.
        assert np.abs(body.surface() - expected).max() < 2e-3
    sim.step(20)
    assert np.abs(body.surface() - (2.0 * walk[-1] + [5, 0, 0])).max() < 2e-3


def test_a_file_has_its_own_times_unless_others_are_given(tmp_path):
    path = _cache(tmp_path / "walk.pc2", _walk(), first=6.0, interval=2.0)
    for options, start, fps in [
        ({}, 0.2, 15),
        ({"follow_fps": 60}, 0.1, 30),
        ({"follow_start": -1, "follow_fps": 24.0}, -1, 12),
    ]:
        for follow in (path, str(path)):
            hold = _body().handle(plane=LEFT, follow=follow, **options)
            assert hold.follow_start == pytest.approx(start)
            assert hold.follow_fps == pytest.approx(fps)
            assert np.array_equal(hold.follow, _walk())


def test_invalid_animations_raise_errors_that_name_the_shapes(tmp_path):
    body = _body()
    with pytest.raises(ValueError, match=r"follow has the shape \(20, 7, 3\); it must be \(frames, 8, 3\)"):
        body.handle(plane=LEFT, follow=_walk()[:, :7])
    with pytest.raises(ValueError, match=r"must have the shape \(frames, vertices, 3\)"):
        body.handle(plane=LEFT, follow=_walk()[0])
    with pytest.raises(ValueError, match="sample 3: the position of vertex 0 is not finite"):
        body.handle(plane=LEFT, follow=np.where(np.arange(20)[:, None, None] == 3, np.nan, _walk()))
    with pytest.raises(ValueError, match="follow_fps is 0"):
        body.handle(plane=LEFT, follow=_walk(), follow_fps=0)
    with pytest.raises(ValueError, match="keys and follow are mutually exclusive"):
        body.handle(plane=LEFT, follow=_walk(), keys=[(0,)])
    with pytest.raises(TypeError, match="handle\\(\\) needs keys= or follow="):
        body.handle(plane=LEFT)
    with pytest.raises(TypeError, match="follow_fps only together with follow"):
        body.handle(plane=LEFT, keys=[(0,)], follow_fps=3)
    with pytest.raises(TypeError, match="interpolation only together with keys"):
        body.handle(plane=LEFT, follow=_walk(), interpolation="cubic")
    with pytest.raises(FileNotFoundError):
        body.handle(plane=LEFT, follow=tmp_path / "missing.pc2")
    (tmp_path / "text.pc2").write_text("not a point cache, but as long as its header")
    with pytest.raises(ValueError, match="not a PC2 file"):
        body.handle(plane=LEFT, follow=tmp_path / "text.pc2")
    with pytest.raises(ValueError, match="it has 7 vertices, and the mesh has 8; export the animation"):
        body.handle(plane=LEFT, follow=_cache(tmp_path / "seven.pc2", _walk()[:, :7]))
    bare = supple.Body(supple.Lattice.from_cells(np.ones((2, 2, 2), bool)))
    with pytest.raises(ValueError, match="without a mesh"):
        bare.handle(plane=((0.5, 0, 0), (-1, 0, 0)), follow=_walk())
    assert body.holds == ()


def test_keyframes_can_replace_an_animation():
    body = _body()
    hold = body.handle(plane=LEFT, follow=_walk())
    sim = supple.Simulation([body], dt=1 / 60)
    sim.step(6)
    hold.set_keys([(sim.time,), (sim.time + 1 / 60, (0, 0, 0.5))])
    before = body.positions
    sim.step()
    moved = (body.positions - before)[hold.vertices]
    assert np.abs(moved - [0, 0, 0.5]).max() < 1e-5
    assert hold.follow is None
    assert hold.follow_fps is None
    assert len(hold.keys) == 2


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_copies_of_bodies_and_simulations_continue_with_the_same_bits(copied):
    bodies = [_body(name=name, translate=(x, 0, 0)) for name, x in (("a", 0), ("b", 5))]
    walk = _walk(200)
    bodies[0].handle(plane=LEFT, follow=walk, start=0.05)
    bodies[0].handle(vertices=[5, 6], follow=walk, follow_fps=20, end=0.4)
    bodies[1].handle(plane=((5.1, 0, 0), (-1, 0, 0)), follow=walk, follow_start=0.1)
    alone = copied(bodies[0])
    sims = [supple.Simulation([bodies[0], bodies[1]], dt=1 / 60)]
    sims[0].step(10)
    sims.append(copied(sims[0]))
    sims.append(supple.Simulation([alone, _body(name="b", translate=(50, 0, 0))], dt=1 / 60))
    sims[2].step(10)
    for sim in sims:
        sim.step(30)
    for sim in sims[1:]:
        assert np.array_equal(sim["a"].positions, bodies[0].positions)
    assert np.array_equal(sims[1]["b"].positions, bodies[1].positions)
    assert np.array_equal(sims[1]["a"].holds[0].follow, walk)


def test_a_state_names_the_animation_that_the_body_must_have():
    body = _body()
    hold = body.handle(plane=LEFT, follow=_walk())
    sim = supple.Simulation([body], dt=1 / 60)
    sim.step(5)
    state = sim.save_state()
    sim.step(20)
    expected = body.positions
    for _ in range(2):
        sim.restore_state(state)
        sim.step(20)
        assert np.array_equal(body.positions, expected)
    hold.release()
    sim.step()
    with pytest.raises(ValueError, match="handle 0 of the state follows an animation"):
        sim.restore_state(state)
    body.handle(plane=LEFT, follow=_walk())
    sim.restore_state(state)
    sim.step(20)
    assert np.array_equal(body.positions, expected)


def test_a_scene_with_an_animation_is_loaded_and_run(tmp_path):
    corners = "".join(f"v {x:g} {y:g} {z:g}\n" for x, y, z in CORNERS)
    faces = "".join("f " + " ".join(str(corner + 1) for corner in face) + "\n" for face in FACES)
    (tmp_path / "cube.obj").write_text(corners + faces)
    _cache(tmp_path / "walk.pc2", _walk())
    (tmp_path / "scene.toml").write_text(
        '[simulation]\nframes = 5\n[[body]]\nmesh = "cube.obj"\nlattice_vertices = 64\n[[body.handle]]\n'
        'plane = { point = [0.1, 0, 0], normal = [-1, 0, 0] }\nfollow = "walk.pc2"\n'
    )
    sim = supple.load_scene(tmp_path / "scene.toml")
    twin = pickle.loads(pickle.dumps(sim))
    sim.advance(5)
    twin.advance(5)
    surfaces = []
    supple.run(
        tmp_path / "scene.toml",
        tmp_path / "frames",
        progress=lambda progress: surfaces.append(progress.simulation.bodies[0].surface()),
    )
    assert np.array_equal(sim.bodies[0].surface(), surfaces[-1])
    assert np.array_equal(twin.bodies[0].surface(), surfaces[-1])
    assert sim.bodies[0].holds[0].follow_fps == pytest.approx(30)
