"""Meshes of meshio, Open3D and PyVista, and model files of all formats."""

import json
import struct
from types import SimpleNamespace

import numpy as np
import pytest

import supple
from shapes import CORNERS, QUADS

TRIANGLES = [corners for a, b, c, d in np.asarray(QUADS).tolist() for corners in ([a, b, c], [a, c, d])]


def same(mesh, expected):
    return np.array_equal(mesh.vertices, expected.vertices) and np.array_equal(mesh.faces, expected.faces)


def test_meshes_of_meshio_open3d_and_pyvista_are_read(cube):
    points = 2 * CORNERS - 1
    padded = np.hstack([[4, *face] for face in np.asarray(QUADS).tolist()])
    for mesh in (
        SimpleNamespace(points=points, cells_dict={"line": np.array([[0, 1]]), "quad": np.array(QUADS)}),
        SimpleNamespace(vertices=points.tolist(), triangles=np.array(TRIANGLES, np.int32)),
        SimpleNamespace(points=points.astype(np.float32), faces=padded, regular_faces=np.array(QUADS)),
    ):
        assert same(supple.Mesh.from_trimesh(mesh), cube)
        assert supple.Body(mesh, lattice_vertices=64).volume_report().rest == pytest.approx(8)
        assert len(supple.Lattice.from_mesh(mesh, vertices=64)) == len(supple.Body(mesh, lattice_vertices=64))
        assert same(supple.MeshCollider(mesh).mesh, cube)
    mixed = {"triangle": np.array(TRIANGLES[:2]), "polygon4": np.array(QUADS[1:])}
    assert supple.Mesh.from_trimesh(SimpleNamespace(points=points, cells_dict=mixed)).is_closed
    plane = SimpleNamespace(points=[[0, 0], [1, 0], [0, 1]], cells_dict={"triangle": [[0, 1, 2]]})
    assert supple.Mesh.from_trimesh(plane).vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_meshes_without_faces_have_clear_errors():
    points = CORNERS
    tetrahedra = SimpleNamespace(points=points, cells_dict={"tetra": np.array([[0, 1, 2, 4]])})
    with pytest.raises(ValueError, match="no triangles, quads or polygons, but cells: tetra; pass its surface"):
        supple.Body(tetrahedra)
    with pytest.raises(ValueError, match=r"faces\[4\] is 7, which is not the number of corners of a face"):
        supple.Body(SimpleNamespace(points=points, faces=[3, 0, 1, 2, 7, 0, 1]))
    with pytest.raises(supple.MeshError, match="face 0 refers to vertex 8 of 8"):
        supple.Body(SimpleNamespace(points=points, faces=[3, 0, 1, 8]))
    grid = SimpleNamespace(points=points, extract_surface=None)
    with pytest.raises(TypeError, match=r"has no faces; pass mesh\.extract_surface\(\)"):
        supple.Body(grid)
    with pytest.raises(TypeError, match=r"shape must be a supple\.Mesh, a path"):
        supple.Body(SimpleNamespace(points=points))


def test_meshes_of_the_packages_are_read(cube):
    points = 2 * CORNERS - 1
    meshes = []
    for module, build in (
        ("meshio", lambda meshio: meshio.Mesh(points, [("quad", np.array(QUADS))])),
        (
            "open3d",
            lambda open3d: open3d.geometry.TriangleMesh(
                open3d.utility.Vector3dVector(points), open3d.utility.Vector3iVector(np.array(TRIANGLES))
            ),
        ),
        ("pyvista", lambda pyvista: pyvista.PolyData.from_regular_faces(points, np.array(QUADS))),
    ):
        try:
            meshes.append(build(__import__(module)))
        except ImportError:
            continue
    if not meshes:
        pytest.skip("none of meshio, Open3D and PyVista is installed")
    assert all(same(supple.Mesh.from_trimesh(mesh), cube) for mesh in meshes)


def glb(name="crate"):
    """Return a GLB file with the cube at a node of this name."""
    points = np.asarray(2 * CORNERS - 1, "<f4").tobytes()
    corners = np.asarray(TRIANGLES, "<u2").tobytes()
    root = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(points) + len(corners)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-1] * 3, "max": [1] * 3},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "name": name}],
        "scenes": [{"nodes": [0]}],
    }
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    binary = points + corners
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def test_models_need_no_other_package(cube, tmp_path):
    path = tmp_path / "crate.glb"
    path.write_bytes(glb())
    assert same(supple.read_obj(path), cube)
    assert same(supple.Body(path, object="crate", lattice_vertices=64).mesh, cube)
    assert same(supple.MeshCollider(path).mesh, cube)
    (body,) = supple.load_scene(path).bodies
    assert (body.name, same(body.mesh, cube)) == ("crate", True)
    with pytest.raises(
        supple.MeshError, match=r"crate\.glb: no object or group `lid` with faces; the file has: `crate`"
    ):
        supple.read_obj(path, object="lid")
    path.write_bytes(glb()[:-1])
    with pytest.raises(supple.MeshError, match=r"crate\.glb: the header of the GLB file tells"):
        supple.Body(path)
    (tmp_path / "cloud.ply").write_text("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n")
    with pytest.raises(supple.MeshError, match=r"cloud\.ply: the PLY header has no element `vertex` with x, y and z"):
        supple.Body(tmp_path / "cloud.ply")
