"""Meshes from trimesh and from files that trimesh reads; texture coordinates and colors."""

import pickle

import numpy as np
import pytest

import supple

trimesh = pytest.importorskip("trimesh")


@pytest.fixture
def ball():
    return trimesh.creation.icosphere(subdivisions=2)


@pytest.fixture
def textured(ball):
    uv = np.column_stack([np.arange(len(ball.vertices)), np.ones(len(ball.vertices))]) / len(ball.vertices)
    ball.visual = trimesh.visual.TextureVisuals(uv=uv)
    return ball


@pytest.fixture
def scene():
    """Two boxes; one of them is a geometry with two places."""
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((1, 1, 1)), geom_name="box", node_name="first")
    place = trimesh.transformations.translation_matrix([5, 0, 0])
    scene.add_geometry(trimesh.creation.box((1, 2, 1)), geom_name="tall", transform=place)
    scene.graph.update(frame_to="second", matrix=trimesh.transformations.translation_matrix([0, 7, 0]), geometry="box")
    return scene


def test_from_trimesh_keeps_the_order(ball):
    mesh = supple.Mesh.from_trimesh(ball)
    assert np.array_equal(mesh.vertices, ball.vertices)
    assert np.array_equal(mesh.faces, ball.faces)
    assert mesh.volume == pytest.approx(ball.volume)
    with pytest.raises(TypeError, match="mesh must be"):
        supple.Mesh.from_trimesh(3)


def test_a_scene_is_all_its_meshes_at_their_places(scene):
    mesh = supple.Mesh.from_trimesh(scene)
    assert mesh.volume == pytest.approx(4)
    assert np.allclose(mesh.bounds, scene.bounds)
    body = supple.Body(scene, lattice_vertices=200)
    assert len(body.surface()) == 24
    assert len(supple.Lattice.from_mesh(scene, vertices=200)) == len(body)


def test_a_scene_without_meshes_is_an_error():
    with pytest.raises(ValueError, match="the scene has no meshes"):
        supple.Mesh.from_trimesh(trimesh.Scene())


@pytest.mark.parametrize("ending", ["stl", "ply", "glb", "off", "STL"])
def test_files_are_read_by_trimesh(ball, tmp_path, ending):
    path = tmp_path / f"ball.{ending}"
    ball.export(path, file_type=ending.lower())
    body = supple.Body(path, lattice_vertices=200)
    assert len(body.mesh.vertices) == len(ball.vertices)
    assert body.mesh.is_closed
    # STL and GLB have float32.
    assert body.mesh.volume == pytest.approx(ball.volume, rel=1e-6)
    if ending in ("ply", "glb", "off"):
        assert np.allclose(body.mesh.vertices, ball.vertices, atol=1e-6)
    assert len(supple.Lattice.from_mesh(str(path), vertices=200)) == len(body)


def test_files_that_trimesh_reads_have_clear_errors(tmp_path, ball, monkeypatch):
    with pytest.raises(FileNotFoundError, match=r"missing\.glb"):
        supple.Body(tmp_path / "missing.glb")
    ball.export(tmp_path / "ball.ply")
    with pytest.raises(ValueError, match="object needs an OBJ file"):
        supple.Body(tmp_path / "ball.ply", object="ball")
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    with pytest.raises(ModuleNotFoundError, match="trimesh is not installed; install it with `pip install trimesh`"):
        supple.Body(tmp_path / "ball.ply")


def test_texture_coordinates_are_kept(textured, tmp_path):
    body = supple.Body(textured, lattice_vertices=200, translate=(0, 3, 0))
    shown = body.to_trimesh()
    assert np.array_equal(shown.visual.uv, textured.visual.uv)
    assert np.array_equal(shown.vertices, body.surface())
    textured.export(tmp_path / "ball.glb")
    loaded = supple.Body(tmp_path / "ball.glb", lattice_vertices=200).to_trimesh()
    # trimesh turns v of GLB files over, in float32.
    assert np.allclose(loaded.visual.uv, textured.visual.uv, atol=1e-6)
    copies = [pickle.loads(pickle.dumps(body)), pickle.loads(pickle.dumps(supple.Simulation(body))).bodies[0]]
    for copy in copies:
        assert np.array_equal(copy.to_trimesh().visual.uv, textured.visual.uv)


def test_colors_are_kept_and_the_original_is_not_changed(ball):
    ball.visual.vertex_colors = np.arange(4 * len(ball.vertices)).reshape(-1, 4) % 256
    shown = supple.Body(ball, lattice_vertices=200).to_trimesh()
    assert np.array_equal(shown.visual.vertex_colors, ball.visual.vertex_colors)
    shown.visual.vertex_colors[:] = 0
    assert ball.visual.vertex_colors.any()


def test_a_mesh_of_arrays_has_no_visual(ball):
    shown = supple.Body(supple.Mesh(ball.vertices, ball.faces), lattice_vertices=200).to_trimesh()
    assert not shown.visual.defined
