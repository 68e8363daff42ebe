"""Meshes from arrays, files and trimesh, and their errors."""

import pickle

import numpy as np
import pytest
import trimesh

import supple
from shapes import CORNERS, QUADS


def test_faces_are_triangulated_as_fans_from_their_first_vertex(cube):
    assert cube.vertices.shape == (8, 3)
    assert cube.vertices.dtype == np.float64
    assert cube.faces.dtype == np.int64
    expected = [triangle for a, b, c, d in QUADS for triangle in ([a, b, c], [a, c, d])]
    assert np.array_equal(cube.faces, expected)


def test_volume_and_is_closed(cube):
    assert cube.volume == pytest.approx(8, rel=1e-15)
    assert cube.is_closed
    open_box = supple.Mesh(CORNERS, QUADS[1:])
    assert not open_box.is_closed
    # `volume` is never negative, so it is the same for faces of the reverse orientation.
    turned = supple.Mesh(CORNERS, QUADS[:, ::-1])
    assert turned.volume == pytest.approx(1, rel=1e-15)


def test_faces_of_different_sizes():
    faces = [*QUADS[1:].tolist(), [0, 2, 1], [1, 2, 3]]
    mesh = supple.Mesh(CORNERS, faces)
    assert mesh.is_closed
    assert len(mesh.faces) == 12
    assert supple.Mesh(CORNERS, [np.array([0, 1, 3, 2]), (0, 1, 5)]).faces.tolist() == [[0, 1, 3], [0, 3, 2], [0, 1, 5]]
    assert len(supple.Mesh(CORNERS, [[0, 1, 5, 7, 6]]).faces) == 3
    assert len(supple.Mesh(CORNERS, QUADS.astype(np.uint64)).faces) == 12


def test_constant_arrays_are_read_only_views(cube):
    for array in (cube.vertices, cube.faces):
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
    assert cube.vertices is cube.vertices


def test_trimesh_objects_and_paths_are_accepted_as_meshes(bust):
    ball = trimesh.creation.icosphere(subdivisions=3)
    lattice = supple.Lattice.from_mesh(ball, cell_size=0.25)
    assert lattice.cell_size == 0.25
    body = supple.Body(ball, lattice_vertices=200)
    assert np.allclose(body.surface(), ball.vertices, atol=1e-6)
    assert len(supple.Body(bust, lattice_vertices=300)) == pytest.approx(300, rel=0.05)
    assert len(supple.Body(str(bust), lattice_vertices=300)) == pytest.approx(300, rel=0.05)


def test_read_obj(bust):
    mesh = supple.read_obj(bust)
    assert mesh.vertices.shape == (4717, 3)
    assert "4717 vertices" in repr(mesh)
    with pytest.raises(supple.MeshError, match="no object or group `Nose`"):
        supple.read_obj(bust, object="Nose")


def test_missing_and_invalid_files_are_errors_with_path_and_line(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        supple.read_obj(tmp_path / "none.obj")
    assert caught.value.filename == str(tmp_path / "none.obj")
    with pytest.raises(IsADirectoryError):
        supple.read_obj(tmp_path)
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n")
    with pytest.raises(supple.MeshError, match=r"bad\.obj:4: face 1 refers to vertex 4 of 3"):
        supple.read_obj(bad)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (CORNERS, [[0, 1, 8]], r"face 0 refers to vertex 8 of 8 \(counted from 0\)"),
        (CORNERS, [[0, 1, 2], [0, -1, 2]], "face 1 refers to vertex -1 of 8"),
        (CORNERS, [[0, 1]], r"faces\[0\] has 2 corners; a face has at least 3"),
        (CORNERS, [[0, 1, 2], [0, 1]], r"faces\[1\] has 2 corners; a face has at least 3"),
        (CORNERS, np.zeros((1, 2), int), r"faces has the shape \(1, 2\); it must be \(m, 3\) or \(m, 4\)"),
        (CORNERS, np.array([[0, 1, 3, 2, 6]]), r"faces has the shape \(1, 5\); it must be \(m, 3\) or \(m, 4\)"),
        (CORNERS, np.array([[0, 1, 2**64 - 1]], np.uint64), "faces: 18446744073709551615 is out of range"),
        (CORNERS, [[0, 1, 2**64]], "faces has an index beyond 64 bits; there are 8 vertices"),
        (CORNERS, [], "no faces: 0 given, none with three distinct corners"),
        (CORNERS * 1e300, QUADS, "vertex 1 .* x = 1e300: .* within the range of f32"),
        (CORNERS, np.zeros((0, 3), int), "no faces: 0 given, none with three distinct corners"),
        (np.where(CORNERS == 1, np.nan, CORNERS), QUADS, "vertex 1 .* x = NaN: coordinates must be finite"),
        (np.where(CORNERS == 1, np.inf, CORNERS), QUADS, "vertex 1 .* x = inf: coordinates must be finite"),
        (CORNERS[:, :2], QUADS, r"vertices has the shape \(8, 2\); it must be \(n, 3\)"),
        (np.zeros((8, 3)), QUADS, r"no extent: all 8 vertices of the faces lie at \(0, 0, 0\)"),
        ([[0, 0, 0], [1]], QUADS, r"vertices must be numbers of shape \(n, 3\): .* inhomogeneous"),
    ],
)
def test_invalid_arrays_are_errors_with_index_and_value(vertices, faces, message):
    with pytest.raises(supple.MeshError, match=message) as caught:
        supple.Mesh(vertices, faces)
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, supple.SuppleError)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ("corners", QUADS, r"vertices must be numbers of shape \(n, 3\), not str"),
        (CORNERS.astype(complex), QUADS, r"vertices must be numbers of shape \(n, 3\), .* complex128"),
        (CORNERS, QUADS.astype(float), "faces must be integers .* float64"),
        (CORNERS, None, r"faces must be integers of shape \(m, 3\) or \(m, 4\), not NoneType"),
    ],
)
def test_arrays_of_wrong_type_are_errors(vertices, faces, message):
    with pytest.raises(TypeError, match=message):
        supple.Mesh(vertices, faces)


def test_a_pickled_mesh_is_equal():
    mesh = supple.Mesh(CORNERS, [*QUADS[1:].tolist(), [0, 2, 1], [1, 2, 3]])
    again = pickle.loads(pickle.dumps(mesh))
    assert np.array_equal(again.vertices, mesh.vertices)
    assert np.array_equal(again.faces, mesh.faces)
    assert repr(again) == repr(mesh)


def test_scales_by_axis_stretch_and_mirror_bodies_and_colliders(cube):
    body = supple.Body(cube, scale=(1, 2, -3), cell_size=0.5)
    low, high = body.mesh.vertices.min(0), body.mesh.vertices.max(0)
    rest = np.sort([cube.vertices.min(0) * (1, 2, -3), cube.vertices.max(0) * (1, 2, -3)], axis=0)
    assert np.array_equal([low, high], rest)
    assert body.mass == pytest.approx(6 * 1000 * cube.volume)
    a, b, c = np.moveaxis(body.mesh.vertices[body.mesh.faces], 1, 0)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0, "the outside stays outside"
    twin = pickle.loads(pickle.dumps(body))
    assert np.array_equal(twin.positions, body.positions)
    slab = supple.MeshCollider(cube, scale=(50, 0.5, -50), translate=(-25, -0.5, 25))
    ball = supple.Body(cube, lattice_vertices=64, translate=(0, 1.05, 0))
    sim = supple.Simulation([ball], fps=30, colliders=[slab])
    sim.advance(30)
    assert ball.surface()[:, 1].min() == pytest.approx(0, abs=0.02)
    for scale, message in [(0, "it must be a number above 0, or three"), ((1, 0, 1), "three numbers that are not 0")]:
        with pytest.raises(ValueError, match=message):
            supple.Body(cube, scale=scale)
    with pytest.raises(supple.errors.LatticeError, match="cells are cubes"):
        supple.Body(supple.Lattice.from_cells(np.ones((2, 2, 2), bool)), scale=(1, 2, 1))


def test_refined_meshes_have_edges_of_about_a_cell(cube):
    body = supple.Body(cube, cell_size=0.1, refine="auto")
    a, b, c = np.moveaxis(body.mesh.vertices[body.mesh.faces], 1, 0)
    assert max(np.linalg.norm(edge, axis=1).max() for edge in (a - b, b - c, c - a)) <= 0.15 + 1e-12
    assert np.array_equal(body.mesh.vertices[: len(cube.vertices)], cube.vertices)
    assert body.mesh.is_closed
    assert body.mesh.volume == pytest.approx(cube.volume)
    assert len(supple.Body(cube, cell_size=0.1).mesh.vertices) == len(cube.vertices)
    assert len(body.surface()) == len(body.mesh.vertices)
    with pytest.raises(ValueError, match='refine is "fine"; it must be one of "off", "auto"'):
        supple.Body(cube, refine="fine")
