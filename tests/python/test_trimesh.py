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
def test_files_that_trimesh_writes_are_read(ball, tmp_path, ending):
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
    for name in ("missing.off", "missing.glb"):
        with pytest.raises(FileNotFoundError, match=name):
            supple.Body(tmp_path / name)
    ball.export(tmp_path / "ball.off")
    with pytest.raises(ValueError, match="object needs an OBJ, GLB, glTF, STL or PLY file"):
        supple.Body(tmp_path / "ball.off", object="ball")
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    with pytest.raises(ModuleNotFoundError, match="trimesh is not installed; install it with `pip install trimesh`"):
        supple.Body(tmp_path / "ball.off")


def test_texture_coordinates_are_kept(textured, tmp_path):
    body = supple.Body(textured, lattice_vertices=200, translate=(0, 3, 0))
    shown = body.to_trimesh()
    assert np.array_equal(shown.visual.uv, textured.visual.uv)
    assert np.array_equal(shown.vertices, body.surface())
    textured.export(tmp_path / "ball.glb")
    loaded = supple.Body(tmp_path / "ball.glb", lattice_vertices=200).to_trimesh(uv=True)
    # v of GLB files is turned over, in float32.
    assert np.allclose(loaded.visual.uv, textured.visual.uv, atol=1e-6)
    copies = [pickle.loads(pickle.dumps(body)), pickle.loads(pickle.dumps(supple.Simulation(body))).bodies[0]]
    for copy in copies:
        assert np.array_equal(copy.to_trimesh().visual.uv, textured.visual.uv)


def test_the_image_inside_of_a_glb_file_is_kept(textured, tmp_path):
    image = pytest.importorskip("PIL.Image")
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    textured.visual.material = trimesh.visual.material.PBRMaterial(baseColorTexture=image.fromarray(pixels))
    textured.export(tmp_path / "ball.glb")
    loaded = supple.Body(tmp_path / "ball.glb", lattice_vertices=200).to_trimesh(uv=True)
    assert np.array_equal(np.asarray(loaded.visual.material.image.convert("RGB")), pixels)


def test_colors_are_kept_and_the_original_is_not_changed(ball):
    ball.visual.vertex_colors = np.arange(4 * len(ball.vertices)).reshape(-1, 4) % 256
    shown = supple.Body(ball, lattice_vertices=200).to_trimesh()
    assert np.array_equal(shown.visual.vertex_colors, ball.visual.vertex_colors)
    shown.visual.vertex_colors[:] = 0
    assert ball.visual.vertex_colors.any()


def test_a_mesh_of_arrays_has_no_visual(ball):
    shown = supple.Body(supple.Mesh(ball.vertices, ball.faces), lattice_vertices=200).to_trimesh()
    assert not shown.visual.defined


#: Two squares that share an edge, whose texture coordinates differ between them at one end of the edge, and a vertex
#: that no face uses. The second face has no material of the library.
SEAM = """mtllib seam.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 5 5 5
v 1 0 1
v 1 1 1
vt 0 0
vt 0.5 0
vt 0.5 1
vt 0 1
vt 0.75 0.25
vt 1 0
vt 1 1
usemtl red paint
f 1/1 2/2 3/3 4/4
usemtl other
f 2/5 6/6 7/7 3/3
"""


@pytest.fixture
def seam(tmp_path):
    (tmp_path / "seam.obj").write_text(SEAM)
    (tmp_path / "seam.mtl").write_text("newmtl red paint\nKd 1 0.2 0\nd 0.4\nmap_Kd dots.png\n")
    pixels = np.array([[[255, 0, 0], [0, 255, 0]]], np.uint8)
    (tmp_path / "dots.png").write_bytes(supple.pictures.png(pixels))
    return tmp_path / "seam.obj"


def test_texture_coordinates_of_an_obj_file_split_vertices_at_seams(seam, tmp_path):
    body = supple.Body(seam, cell_size=0.25, translate=(0, 2, 0))
    plain = body.to_trimesh()
    assert np.array_equal(plain.vertices, body.surface())
    assert not plain.visual.defined
    shown = body.to_trimesh(uv=True)
    vertex = shown.vertex_attributes["input_vertex"]
    # Vertex 1, the second one of the file, has two coordinates, and the fifth one has no face.
    assert vertex.tolist() == [0, 1, 1, 2, 3, 5, 6]
    assert np.array_equal(shown.vertices, body.surface()[vertex])
    assert np.array_equal(vertex[shown.faces], body.mesh.faces)
    assert shown.visual.uv.tolist() == [[0, 0], [0.5, 0], [0.75, 0.25], [0.5, 1], [0, 1], [1, 0], [1, 1]]
    red, other = shown.visual.material.materials
    assert (red.name, other.name) == ("red paint", "other")
    assert red.diffuse.tolist() == [255, 51, 0, 102]
    assert shown.visual.face_materials.tolist() == [0, 0, 1, 1]
    pytest.importorskip("PIL")
    assert red.image.size == (2, 1)
    shown.export(tmp_path / "seam.glb")
    # trimesh turns v of GLB files over, in float32.
    assert np.allclose(trimesh.load(tmp_path / "seam.glb", force="mesh").visual.uv, shown.visual.uv, atol=1e-6)


def test_an_obj_file_has_as_many_vertices_as_trimesh_gives_it(bust):
    shown = supple.Body(bust, lattice_vertices=300).to_trimesh(uv=True)
    other = trimesh.load(bust, process=False)
    assert len(shown.vertices) == len(other.vertices) > len(supple.read_obj(bust).vertices)

    rows = [mesh.visual.uv[np.lexsort(mesh.visual.uv.T)] for mesh in (shown, other)]
    assert np.array_equal(*(row.astype(np.float32) for row in rows))
    # At rest, the lattice gives back the positions of the file to f32 rounding of coordinates below 16.
    assert np.allclose(shown.bounds, other.bounds, atol=1e-5)


def test_an_obj_file_without_texture_coordinates_keeps_its_vertices(cube, tmp_path):
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in cube.vertices)
    faces = "".join(f"f {' '.join(str(corner + 1) for corner in face)}\n" for face in cube.faces.tolist())
    (tmp_path / "cube.obj").write_text(rows + "usemtl gray\n" + faces)
    body = supple.Body(tmp_path / "cube.obj", lattice_vertices=60)
    shown = body.to_trimesh(uv=True)
    assert np.array_equal(shown.vertices, body.surface())
    assert shown.visual.uv is None
    assert shown.visual.material.name == "gray"
    assert supple.Body(cube, lattice_vertices=60).to_trimesh(uv=True).is_watertight


def test_texture_coordinates_are_those_of_the_file_that_was_read(seam, tmp_path, monkeypatch):
    (tmp_path / "s.toml").write_text('[[body]]\nname = "a"\nmesh = "seam.obj"\ncell_size = 0.3\n')
    monkeypatch.chdir(tmp_path)
    bodies = [supple.Body("seam.obj", cell_size=0.3), supple.load_scene("s.toml").bodies[0]]
    bodies.append(pickle.loads(pickle.dumps(bodies[0])))
    monkeypatch.chdir("/")
    for body in bodies:
        assert len(body.to_trimesh(uv=True).visual.uv) == 7
    seam.write_text(SEAM.replace("v 1 1 1", "v 1 1 2"))
    for body in bodies:
        with pytest.raises(supple.MeshError, match=r"seam\.obj has changed since the mesh was read; read it again"):
            body.to_trimesh(uv=True)
        assert len(body.to_trimesh().vertices) == 7
    seam.unlink()
    with pytest.raises(FileNotFoundError, match=r"seam\.obj"):
        bodies[0].to_trimesh(uv=True)
