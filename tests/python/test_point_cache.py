"""Point caches of any positions: bytes of the file, temporary name, errors."""

import numpy as np
import pytest

import supple


def read(path):
    """Return first frame and positions of a point cache."""
    data = path.read_bytes()
    assert data[:12] == b"POINTCACHE2\0"
    version, points = np.frombuffer(data, "<i4", 2, 12)
    first, interval = np.frombuffer(data, "<f4", 2, 20)
    samples = np.frombuffer(data, "<i4", 1, 28)[0]
    assert (version, interval) == (1, 1)
    return first, np.frombuffer(data, "<f4", offset=32).reshape(samples, points, 3)


def test_frames_are_written_as_they_are_given(cube, tmp_path):
    path = tmp_path / "folder" / "cube.pc2"
    frames = np.random.default_rng(1).normal(size=(5, 8, 3))
    with supple.PointCache(path, cube, first_frame=7) as cache:
        for index, frame in enumerate(frames):
            assert cache.frames == index
            cache.write(frame)
        assert not path.exists()
        assert (tmp_path / "folder" / "cube.pc2.part").exists()
    first, positions = read(path)
    assert first == 7
    assert np.array_equal(positions, frames.astype(np.float32))
    assert repr(cache).endswith("cube.pc2: frames: 5>")
    with pytest.raises(ValueError, match="is complete"):
        cache.write(frames[0])
    cache.close()


def test_a_handle_can_follow_the_cache_of_a_body(cube, tmp_path):
    path = tmp_path / "cube.pc2"
    body = supple.Body(cube, lattice_vertices=100)
    sim = supple.Simulation([body], fps=30)
    with supple.PointCache(path, cube) as cache:
        cache.write(body.surface())
        sim.advance()
        cache.write(body.surface())
    assert np.array_equal(read(path)[1][1], body.surface().astype(np.float32))
    follower = supple.Body(cube, lattice_vertices=100)
    assert follower.handle(plane=((0, 0, 0), (0, 1, 0)), follow=path).follow.shape == (2, 8, 3)


def test_an_exception_keeps_the_frames_so_far(cube, tmp_path):
    path = tmp_path / "cube.pc2"
    cache = supple.PointCache(path, cube)
    cache.write(cube.vertices)
    with pytest.raises(ZeroDivisionError), cache:
        raise ZeroDivisionError
    assert len(read(path)[1]) == 1


def test_invalid_arguments_change_no_file(cube, tmp_path):
    for name in ("cube.obj", "cube", ".pc2"):
        with pytest.raises(ValueError, match=r"must end in NAME\.pc2"):
            supple.PointCache(tmp_path / name, cube)
    with pytest.raises(TypeError, match=r"mesh must be a supple\.Mesh"):
        supple.PointCache(tmp_path / "cube.pc2", cube.vertices)
    with pytest.raises(ValueError, match="first_frame = -1 is out of range"):
        supple.PointCache(tmp_path / "cube.pc2", cube, first_frame=-1)
    assert not list(tmp_path.iterdir())
    with supple.PointCache(tmp_path / "cube.pc2", cube) as cache:
        with pytest.raises(ValueError, match="positions has the shape"):
            cache.write(cube.vertices[1:])
        with pytest.raises(ValueError, match="not finite"):
            cache.write(np.full((8, 3), np.nan))
        with pytest.raises(supple.OutputError, match="not finite"):
            cache.write(np.full((8, 3), 1e300))  # too large for float32
        assert cache.frames == 0
    assert len(read(tmp_path / "cube.pc2")[1]) == 0


def test_an_unwritable_place_is_an_output_error(cube, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(supple.OutputError, match="file"):
        supple.PointCache(tmp_path / "file" / "cube.pc2", cube)
