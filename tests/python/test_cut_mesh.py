"""`scripts/cut_mesh.py`: closed results, exact volumes, kept and interpolated elements, and errors."""

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh

from shapes import CORNERS, QUADS

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from cut_delaunay import CrossingError, triangulate  # noqa: E402
from cut_mesh import CutError, cut  # noqa: E402
from cut_obj import Face, Model, ObjError, read, text, write  # noqa: E402

# Text of f32 numbers is rounded by at most 2^-24 of their size.
ROUNDING = 2.0**-23


def model(vertices, faces, state=("", "", "", "")) -> Model:
    """Returns a model of polygons without texture coordinates and normals."""
    corners = [tuple((int(index), -1, -1) for index in face) for face in faces]
    return Model(vertices=[text(vertex) for vertex in vertices], faces=[Face(each, state) for each in corners])


def join(*models: Model) -> Model:
    """Returns one model of several models without texture coordinates and normals."""
    result = Model()
    for each in models:
        shift = len(result.vertices)
        result.vertices += each.vertices
        result.faces += [Face(tuple((v + shift, -1, -1) for v, _, _ in f.corners), f.state) for f in each.faces]
    return result


def box(low=(0, 0, 0), high=(1, 1, 1), turned=False, state=("", "", "", "")) -> Model:
    """Returns a box of six quads."""
    return model(np.where(CORNERS == 1, high, low), QUADS[:, ::-1] if turned else QUADS, state)


def prism(outline) -> Model:
    """Returns the prism 0 <= z <= 1 of a polygon, whose ends are one polygon each."""
    count = len(outline)
    points = [(*point, z) for z in (0, 1) for point in outline]
    ring = [(i, (i + 1) % count) for i in range(count)]
    ends = [list(range(count))[::-1], list(range(count, 2 * count))]
    return model(points, ends + [[a, b, b + count, a + count] for a, b in ring])


def polygons(each: Model) -> list[list[int]]:
    return [[corner[0] for corner in face.corners] for face in each.faces]


def volume(each: Model) -> float:
    """Returns the signed volume inside the faces, triangulated as fans."""
    points = each.positions()
    fans = [points[[face[0], b, c]] for face in polygons(each) for b, c in pairwise(face[1:])]
    return float(np.linalg.det(np.array(fans)).sum() / 6)


def is_closed(each: Model) -> bool:
    """Returns whether each directed edge has exactly one opposite edge, with vertices at equal positions as one."""
    names = np.unique(each.positions() + 0.0, axis=0, return_inverse=True)[1].ravel()
    edges = [(names[a], names[b]) for face in polygons(each) for a, b in zip(face, face[1:] + face[:1], strict=True)]
    return len(set(edges)) == len(edges) and set(edges) == {(b, a) for a, b in edges}


def both(each: Model, point, normal) -> tuple[Model, Model]:
    """Returns the two sides of a cut, and checks that both are closed and have the volume of the whole."""
    point, normal = np.array(point, dtype=float), np.array(normal, dtype=float)
    sides = cut(each, point, normal), cut(each, point, -normal)
    assert all(is_closed(side) for side in sides)
    assert sum(map(volume, sides)) == pytest.approx(volume(each), rel=20 * ROUNDING)
    for side, sign in zip(sides, (1, -1), strict=True):
        assert (sign * (side.positions() - point) @ normal).min() > -4 * ROUNDING * np.abs(side.positions()).max()
    return sides


def test_a_cut_box_has_the_exact_volume():
    # Below z = 0.5 + 0.3 x + 0.2 y is the volume 0.5 + 0.15 + 0.1.
    above, below = both(box(), (0, 0, 0.5), (-0.3, -0.2, 1))
    assert volume(below) == pytest.approx(0.75, abs=10 * ROUNDING)
    assert volume(above) == pytest.approx(0.25, abs=10 * ROUNDING)
    # The four corners that remain are the first vertices, in their order.
    assert below.vertices[:4] == [row for row in box().vertices if row.endswith(" 0")]
    assert above.vertices[:4] == [row for row in box().vertices if row.endswith(" 1")]


def test_a_cut_sphere_has_the_volume_of_a_spherical_cap():
    ball = trimesh.creation.icosphere(subdivisions=3)
    mesh = model(ball.vertices, ball.faces)
    rng = np.random.default_rng(5)
    for height in (-0.7, -0.2, 0.0, 0.4, 0.9):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        upper, _ = both(mesh, height * normal, normal)
        exact = np.pi * (1 - height) ** 2 * (2 + height) / 3
        # The polyhedron is inside the ball and contains the ball of the radius of its nearest face.
        inner = np.einsum("ij,ij->i", ball.triangles_center, ball.face_normals).min()
        missing = 4 / 3 * np.pi * (1 - inner**3)
        assert exact - missing <= volume(upper) <= exact + 20 * ROUNDING


def test_vertices_and_edges_in_the_plane_stay():
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    # Through four vertices and the four edges between them.
    upper, lower = both(model(corners, faces), (0, 0, 0), (0, 0, 1))
    assert volume(upper) == volume(lower) == pytest.approx(2 / 3, rel=4 * ROUNDING)
    assert upper.vertices[:5] == model(corners[:5], []).vertices
    # Through two opposite vertices and across the other edges; through two edges of a box and across two faces.
    both(model(corners, faces), (0, 0, 0), (0, 1, 1))
    both(model(corners, faces), (0, 0, 0), (0, 2, 1))
    half, _ = both(box(), (0, 0, 0), (1, -1, 0))
    assert volume(half) == 0.5
    assert sorted(half.vertices[:6]) == sorted(["0 0 0", "0 0 1", "1 0 0", "1 0 1", "1 1 0", "1 1 1"])
    # A step: the plane contains one face, which closes the upper part, and is a part of the cap of the lower one.
    step = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    left, right = both(step, (1, 0, 0), (-1, 0, 0))
    assert (volume(left), volume(right)) == pytest.approx((2, 1), rel=10 * ROUNDING)


def test_a_vertex_at_rounding_distance_counts_as_in_the_plane():
    tolerance = 1e-6 * np.linalg.norm([6, 1, 2])
    for distance, kept in ((0.9 * tolerance, 8), (1.1 * tolerance, 4)):
        corners = CORNERS.astype(float)
        corners[CORNERS[:, 2] == 1, 2] += [distance] * 4
        tall = join(model(corners, QUADS), box((5, 0, 0), (6, 1, 2)))
        part = cut(tall, np.array([0, 0, 1.0]), np.array([0, 0, -1.0]))
        assert is_closed(part)
        assert len([row for row in tall.vertices[:8] if row in part.vertices]) == kept


def test_a_plane_that_cuts_nothing_is_an_error():
    for point, normal in (
        ((0, 0, -1), (0, 0, 1)),
        ((0, 0, 2), (0, 0, 1)),
        ((0, 0, 1), (0, 0, 1)),
        ((1, 1, 1), (1, 1, 1)),
    ):
        for sign in (1, -1):
            with pytest.raises(CutError, match=r"the plane cuts no face: the vertices are at distances from"):
                cut(box(), np.array(point, dtype=float), sign * np.array(normal, dtype=float))
    with pytest.raises(CutError, match="the normal not zero"):
        cut(box(), np.zeros(3), np.zeros(3))


def test_texture_coordinates_normals_and_colors_are_interpolated():
    mesh = box()
    points = mesh.positions()
    # Affine functions of the position: interpolation on edges reproduces them.
    mesh.textures = [text([0.25 * x + 0.5 * y, 0.5 * z]) for x, y, z in points]
    mesh.vertices = [f"{vertex} {text([x, z, 0.5])}" for vertex, (x, _, z) in zip(mesh.vertices, points, strict=True)]
    mesh.normals = [text(2 * point - 1) for point in points]
    mesh.faces = [Face(tuple((v, v, v) for v, _, _ in face.corners), face.state) for face in mesh.faces]
    part = cut(mesh, np.array([0, 0, 0.375]), np.array([0.125, 0.25, -1]))
    rows = np.array([[float(x) for x in row.split()] for row in part.vertices])
    assert len(rows) == 8
    assert np.allclose(rows[:, 3:], np.column_stack([rows[:, 0], rows[:, 2], np.full(8, 0.5)]), rtol=0, atol=ROUNDING)
    textures = np.array([[float(x) for x in row.split()] for row in part.textures])
    normals = np.array([[float(x) for x in row.split()] for row in part.normals])
    places = part.positions()
    for face in part.faces:
        v, vt, vn = np.array(face.corners).T
        if face.state[1] == "cap":
            assert np.allclose(normals[vn], -np.array([0.125, 0.25, -1]) / np.sqrt(1 + 5 / 64), atol=ROUNDING)
            # The shape in the plane, scaled: distances have one ratio.
            ratio = np.linalg.norm(np.diff(textures[vt], axis=0), axis=1)
            ratio /= np.linalg.norm(np.diff(places[v], axis=0), axis=1)
            assert np.ptp(ratio) < 1e-5
        else:
            expected = np.column_stack([0.25 * places[v, 0] + 0.5 * places[v, 1], 0.5 * places[v, 2]])
            assert np.allclose(textures[vt], expected, rtol=0, atol=2 * ROUNDING)
    assert textures.min() >= 0
    assert textures.max() <= 1
    crossed = [row for row in normals if not np.isclose(np.abs(row), 1).all()]
    assert np.allclose(np.linalg.norm(crossed, axis=1), 1, atol=2 * ROUNDING)


def test_vertices_inside_a_cap_have_the_mean_color_of_its_outline():
    ball = trimesh.creation.icosphere(subdivisions=3)
    mesh = model(np.hstack([ball.vertices, ball.vertices]), ball.faces)
    part = cut(mesh, np.array([0, 0, 0.25]), np.array([0, 0, 1.0]))
    rows = np.array([[float(x) for x in row.split()] for row in part.vertices])
    in_plane = np.abs(rows[:, 2] - 0.25) < 1e-6
    inside = in_plane & (np.hypot(rows[:, 0], rows[:, 1]) < 0.9)
    assert inside.sum() > 10
    mean = rows[in_plane & ~inside, 3:].mean(axis=0)
    assert np.allclose(rows[inside, 3:], mean, rtol=0, atol=ROUNDING)


def test_objects_groups_materials_and_libraries_stay(tmp_path):
    first = box(state=("First  Part", "side all", "red", "1"))
    side = next(index for index, quad in enumerate(QUADS) if (CORNERS[quad, 0] == 1).all())
    first.faces[side] = Face(first.faces[side].corners, ("First  Part", "front", "blue", "1"))
    mesh = join(first, box((3, 0, 0), (4, 1, 2), state=("second", "", "", "")), box((0, 0, 7), (1, 1, 9)))
    mesh.libraries, mesh.comments = ["a b.mtl", "c.mtl"], ["# a comment"]
    write(mesh, tmp_path / "in.obj")
    part = cut(read(tmp_path / "in.obj"), np.array([0, 0, 0.5]), np.array([0, 0, 1.0]))
    write(part, tmp_path / "out.obj")
    part = read(tmp_path / "out.obj")
    assert (part.libraries, part.comments) == (mesh.libraries, mesh.comments)
    assert is_closed(part)
    states = {face.state for face in mesh.faces}
    states |= {("First  Part", "cap", "cap", "off"), ("second", "cap", "", "")}
    assert {face.state for face in part.faces} == states
    # The faces of an object stay together, so that a reader sees each object once.
    objects = [face.state[0] for face in part.faces]
    assert [name for name, before in zip(objects, [None, *objects], strict=False) if name != before] == [
        "First  Part",
        "second",
        "",
    ]
    # Each object is closed by its own cap, and the uncut one has none.
    for name, expected in (("First  Part", 0.5), ("second", 1.5), ("", 2.0)):
        alone = Model(vertices=part.vertices, faces=[face for face in part.faces if face.state[0] == name])
        assert is_closed(alone)
        assert volume(alone) == pytest.approx(expected, rel=10 * ROUNDING)


def test_several_outlines_and_holes_are_capped():
    tube = trimesh.creation.annulus(r_min=1, r_max=2, height=1, sections=32)
    mesh = model(tube.vertices, tube.faces)
    one_hole, _ = both(mesh, (0, 0, 0.1), (0, 0, 1))
    assert volume(one_hole) == pytest.approx(0.4 * volume(mesh), rel=1e-5)
    two_outlines, _ = both(mesh, (0, 0, 0), (1, 0.1, 0.2))
    assert volume(two_outlines) == pytest.approx(0.5 * volume(mesh), rel=1e-5)
    # A hollow box, with a solid box in its cavity; and a box inside out.
    shells = [box((0, 0, 0), (4, 4, 4)), box((1, 1, 1), (3, 3, 3), turned=True), box((1.5, 1.5, 1.5), (2.5, 2.5, 2.5))]
    half, _ = both(join(*shells), (2, 2, 2), (0.1, 0.2, 1))
    assert volume(half) == pytest.approx(32 - 4 + 0.5, rel=1e-5)
    half, _ = both(box(turned=True), (0.5, 0.5, 0.5), (1, 0, 0))
    assert volume(half) == pytest.approx(-0.5, rel=1e-5)


def test_polygons_that_are_not_convex_are_cut():
    outline = [(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
    for start in range(len(outline)):
        comb = prism(outline[start:] + outline[:start])
        teeth, _ = both(comb, (0, 2, 0), (0, 1, 0))
        assert volume(teeth) == pytest.approx(3, rel=10 * ROUNDING)
        both(comb, (0, 2, 0.25), (0.1, 1, 0.2))


def test_seams_and_open_meshes(capsys):
    seams = read(ROOT / "tests" / "data" / "seams.obj")
    part = cut(seams, np.array([0.25, 0, 0]), np.array([-1.0, 0, 0]))
    assert is_closed(part)
    assert volume(part) == 0.25
    lidless = model(CORNERS, [quad for quad in QUADS if not (CORNERS[quad, 2] == 1).all()])
    bottom = cut(lidless, np.array([0, 0, 0.5]), np.array([0, 0, -1.0]))
    assert is_closed(bottom)
    assert capsys.readouterr().err == ""
    side = cut(lidless, np.array([0.5, 0, 0]), np.array([1.0, 0, 0]))
    assert "warning: 3 edges of the cut stay open, because the mesh is open there" in capsys.readouterr().err
    assert all(face.state[1] != "cap" for face in side.faces)


def test_outlines_that_cross_are_an_error_with_the_place():
    eight = prism([(0, 0), (2, 2), (2, 0), (0, 2)])
    with pytest.raises(CutError, match=r"crosses or touches itself near \([02], [02], 0\.5\); move the plane"):
        cut(eight, np.array([0, 0, 0.5]), np.array([0, 0, 1.0]))
    with pytest.raises(CutError, match="crosses or touches itself"):
        cut(prism([(0, 0), (3, 3), (3, 0), (0, 2)]), np.array([0, 0, 0.5]), np.array([0, 0, 1.0]))
    with pytest.raises(CrossingError):
        triangulate(np.array([[0, 0], [4, 0], [4, 4], [2, 0], [0, 4.0]]), [[0, 1, 2, 3, 4]], None)


def test_caps_have_no_slivers():
    count = 96
    angles = 2 * np.pi * np.arange(count) / count
    outline = np.column_stack([4 * np.cos(angles), np.sin(angles)])
    hole = 0.4 * np.column_stack([np.cos(angles), -np.sin(angles)])[::3]
    points = np.concatenate([outline, hole])
    loops = [list(range(count)), list(range(count, len(points)))]
    edge = np.linalg.norm(np.diff(outline, axis=0), axis=1).mean()
    added, triangles = triangulate(points, loops, 3 * edge)
    corners = np.concatenate([points, added])[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    area = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2
    exact = count / 2 * np.sin(2 * np.pi / count) * 4 - len(hole) / 2 * np.sin(2 * np.pi / len(hole)) * 0.16
    assert area.sum() == pytest.approx(exact, rel=1e-9)
    # Without points inside, triangles span the shape, and their least angle is about edge / 2 or 6 degrees.
    least = np.degrees(np.arcsin((2 * area / np.sort(sides, axis=1)[:, 1:].prod(axis=1)).clip(0, 1)))
    assert area.min() > 0
    assert least.min() > 15, "regression bound"
    # A triangle without a center beside the outline has a circumradius of at most 3 edges / sqrt(3).
    assert sides.max() < 2 * 3 * edge / np.sqrt(3) * 1.5, "regression bound"


def test_the_program_reads_and_writes_files(tmp_path):
    source = tmp_path / "box.obj"
    source.write_text(
        "# box\n\nv 0 0 0 # corner\nv 1 0 0\nv 1 1 \\\n0\nv 0 1 0\nv 0.50 0.5 1\nl 1 2\n"
        "f -5 -2 -3 -4\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    )

    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, str(ROOT / "scripts" / "cut_mesh.py"), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    result = run(source, tmp_path / "out.obj", "--point", 0, 0, 0.5, "--normal", 0, 0, 2)
    assert result.returncode == 0, result.stderr
    assert "warning: not written: 1 x l" in result.stderr
    lines = (tmp_path / "out.obj").read_text().splitlines()
    assert lines[:3] == ["# box", "# Cut by scripts/cut_mesh.py --point 0 0 0.5 --normal 0 0 2", "v 0.50 0.5 1"]
    part = read(tmp_path / "out.obj")
    assert is_closed(part)
    assert volume(part) == pytest.approx(1 / 3 / 8, rel=10 * ROUNDING)

    for arguments, message in (
        ((source, "x.obj", "--point", 0, 0, 3, "--normal", 0, 0, 1), "distances from -3 to -2"),
        ((tmp_path / "none.obj", "x.obj", "--point", 0, 0, 3, "--normal", 0, 0, 1), "none.obj"),
    ):
        result = run(*arguments)
        assert result.returncode == 1
        assert "error: " in result.stderr
        assert message in result.stderr


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("v 0 0 0\nf 1 2 3", r":2: `2` refers to element 2 of 1"),
        ("v 0 0 0\nf 1 1/1 1", r":2: `1/1` refers to element 1 of 0"),
        ("v 0 0\n", r":1: `0 0` are not the numbers of `v`"),
        ("v 0 0 nan\n", r":1: `0 0 nan` are not the numbers of `v`"),
        ("v 0 0 0\n\nf 1 1", r":3: a face needs 3 corners, 2 found"),
        ("v 0 0 x", r":1: could not convert string to float: 'x'"),
    ],
)
def test_invalid_files_are_errors_with_the_line(tmp_path, lines, message):
    (tmp_path / "bad.obj").write_text(lines)
    with pytest.raises(ObjError, match=r"bad\.obj" + message):
        read(tmp_path / "bad.obj")


def test_the_shipped_busts_are_closed_and_end_in_the_plane_of_their_cut():
    for name in ("bust", "bust_parts"):
        mesh = read(ROOT / "examples" / "scenes" / f"{name}.obj")
        assert mesh.comments[-1] == "# Cut by scripts/cut_mesh.py --point 0 5.6 0 --normal 0 1 0"
        skin = Model(vertices=mesh.vertices, faces=[face for face in mesh.faces if face.state[0] in ("", "skin")])
        assert is_closed(skin)
        cap = np.array([corner[0] for face in skin.faces if face.state[1] == "cap" for corner in face.corners])
        assert (mesh.positions()[cap, 1] == 5.6).all()
        assert mesh.positions()[:, 1].min() == 5.6
