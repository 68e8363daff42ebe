"""Bodies that break: arguments, cuts, arrays that grow, and what is saved."""

import base64
import copy
import gzip
import json
import pickle

import numpy as np
import pytest

import supple
from shapes import BAR

DEFAULTS = {"rotation": None, "cracks": 1, "noise": 0.05, "seed": 0, "surface": "smooth"}


def bar(**settings):
    return supple.Body(BAR, **{"cell_size": 0.8, "half_width": 1, "volume": "mesh"} | settings)


def pulled(body, frames):
    """Pull the ends of a bar apart by a fourth of its length within a second, and return the simulation."""
    x = body.lattice.indices[:, 0]
    body.handle(vertices=x == x.min(), keys=[(0,)])
    body.handle(vertices=x == x.max(), keys=[(0,), (1, (3, 0, 0))])
    sim = supple.Simulation([body], fps=30, substeps=4, gravity=(0, 0, 0))
    sim.advance(frames)
    return sim


def everything(body):
    """Return the state of a body as bytes."""
    arrays = [body.positions, body.velocities, body.surface(), body.faces, body.rotations]
    return [array.tobytes() for array in arrays] + [body.pieces, body.broken_joints, body.topology_version]


def test_fracture_is_a_dict():
    assert bar().fracture is None
    assert bar(fracture=None).fracture is None
    assert bar(fracture={"strain": 0.1}).fracture == DEFAULTS | {"strain": 0.1}
    given = {"strength": 2e4, "rotation": 20, "cracks": 3, "noise": 0.1, "seed": 7, "surface": "cells"}
    body = bar(fracture=given)
    assert body.fracture == given
    assert bar(fracture=body.fracture).fracture == given


@pytest.mark.parametrize(
    ("fracture", "error", "message"),
    [
        ({}, ValueError, 'fracture.strength is missing: give one of "strength", "strain"'),
        ({"strain": 0.1, "strength": 1}, ValueError, "fracture: strength and strain are mutually exclusive"),
        ({"strian": 0.1}, ValueError, 'fracture has no key "strian"; the nearest one is "strain"'),
        ({"strain": 0}, ValueError, "fracture.strain = 0 is out of range: it must be a number above 0"),
        ({"strength": np.nan}, ValueError, "strength = NaN is out of range"),
        ({"strain": 0.1, "rotation": 181}, ValueError, r"rotation = 181 .* in \(0, 180\] degrees"),
        ({"strain": 0.1, "cracks": 0}, ValueError, "cracks = 0 is out of range"),
        ({"strain": 0.1, "cracks": 1_000_001}, ValueError, "cracks = 1000001 is out of range: .* from 1 to 1000000"),
        ({"strain": 0.1, "noise": 0.6}, ValueError, r"noise = 0.6 is out of range: it must be in \[0, 0.5\]"),
        ({"strain": 0.1, "seed": -1}, ValueError, "seed = -1 is out of range"),
        (
            {"strain": 0.1, "surface": "rough"},
            ValueError,
            'fracture.surface is "rough"; it must be one of "smooth", "cells"',
        ),
        ({"strain": "0.1"}, TypeError, "strain must be a number, not str"),
        (0.1, TypeError, "fracture must be a dict like .*, not float"),
    ],
)
def test_wrong_fracture_is_an_error(fracture, error, message):
    with pytest.raises(error, match=message):
        bar(fracture=fracture)


@pytest.mark.parametrize(
    "plane",
    [supple.Plane((5.9, 0, 0), (1, 0, 0)), ((5.9, 0, 0), (2, 0, 0)), {"point": (5.9, 0, 0), "normal": (-1, 0, 0)}],
)
def test_a_cut_divides_a_body(plane):
    body = bar()
    whole = body.mesh, body.lattice, body.surface()
    assert (body.pieces, body.broken_joints, body.topology_version) == (1, 0, 0)
    assert body.faces is body.mesh.faces
    assert not body.piece_of_vertex.any()
    vertices, mass = len(body), body.mass
    # 5 x 5 cells of edge 0.8 have a part of a section of 4 x 4.
    assert body.cut(plane) == 25
    assert (body.pieces, body.broken_joints, body.topology_version) == (2, 25, 1)
    assert len(body) == vertices + 36 == len(body.lattice) == len(body.positions) == len(body.masses)
    assert body.lattice.component_count == 2
    assert body.mass == pytest.approx(mass, rel=1e-6)
    surface, pieces = body.surface(), body.piece_of_vertex
    assert surface.shape == (len(body.mesh.vertices), 3) == body.surface_normals().shape
    assert len(surface) > len(whole[2])
    np.testing.assert_array_equal(surface[: len(whole[2])], whole[2])
    assert body.faces.max() < len(surface)
    assert body.mesh.is_closed
    assert body.mesh.volume == pytest.approx(whole[0].volume, rel=1e-12)
    # The pieces lie on the two sides of the plane, to a fraction of a cell.
    for piece, volume in enumerate((5.9 * 16, 6.1 * 16)):
        faces = body.faces[pieces[body.faces[:, 0]] == piece]
        corners = surface[faces]
        assert (pieces[faces] == piece).all()
        found = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        assert found == pytest.approx(volume, rel=0.02)
    # Nothing is left to break.
    assert body.cut(plane) == 0
    assert body.topology_version == 1
    assert (body.mesh is body.mesh, body.lattice is body.lattice) == (True, True)
    assert (body.mesh is whole[0], body.lattice is whole[1]) == (False, False)


def test_wrong_planes_are_errors():
    body = bar()
    for plane, error, message in (
        (((0, 0, 0), (0, 0, 0)), ValueError, "normal"),
        (((0, 0, 0),), ValueError, "plane has 1 parts"),
        ({"point": (0, 0, 0)}, ValueError, "plane has no normal"),
        (((0, 0, 0), (0, np.nan, 0)), ValueError, r"plane normal\[1\] = NaN is not finite"),
        ("x", TypeError, "plane must be a pair"),
    ):
        with pytest.raises(error, match=message):
            body.cut(plane)
    assert body.topology_version == 0


def test_the_message_about_another_shape_says_that_the_body_broke():
    body = bar()
    out = body.surface()
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    for function in (body.surface, body.surface_normals, body.surface_velocities):
        with pytest.raises(ValueError, match="because the body broke; see topology_version"):
            function(out=out)
    sim = supple.Simulation([body], dt=1 / 60)
    with pytest.raises(ValueError, match=r"out\[0\] .* because the body broke"):
        sim.surfaces(out=[out])
    out = np.empty((len(body.mesh.vertices), 3))
    np.testing.assert_array_equal(body.surface(out=out), sim.surfaces()[0])


def test_a_bare_lattice_breaks_and_has_no_faces():
    body = supple.Body(supple.Lattice.from_cells(np.ones((6, 2, 2), bool)))
    assert body.cut(((3, 0, 0), (1, 0, 0))) == 4
    assert (body.pieces, body.mesh, len(body)) == (2, None, 7 * 9 + 9)
    for name in ("faces", "piece_of_vertex"):
        with pytest.raises(ValueError, match="bare lattice without a mesh"):
            getattr(body, name)
    corners = body.lattice.cell_corners
    assert corners.shape == (24, 8)
    offsets = [[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]
    np.testing.assert_array_equal(body.lattice.indices[corners], body.lattice.cells[:, None] + np.array(offsets))
    left = corners[body.lattice.cells[:, 0] < 3]
    assert not np.intersect1d(left, corners[body.lattice.cells[:, 0] >= 3]).size
    body.positions = body.positions + (body.lattice.indices[:, :1] >= 3) * [1, 0, 0]
    assert supple.screenshot(body, size=(80, 60)).shape == (60, 80, 3)


def test_the_lattice_of_a_broken_body_is_no_shape():
    body = bar()
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    with pytest.raises(ValueError, match="lattice of a broken body"):
        supple.Body(body.lattice)
    with pytest.raises(ValueError, match="lattice of a broken body"):
        pickle.dumps(body.lattice)


def test_a_pulled_bar_breaks():
    body = bar(fracture={"strain": 0.1})
    sim = pulled(body, 90)
    assert 2 <= body.pieces <= 3
    assert body.mesh.is_closed
    assert body.broken_joints >= 25
    surface = body.surface()
    assert np.isfinite(surface).all()
    # No piece is as long as the bar, and none is strained much.
    for piece in np.unique(body.piece_of_vertex):
        assert np.ptp(surface[body.piece_of_vertex == piece, 0]) < 12
    assert body.volume == pytest.approx(12 * 16, rel=1e-4)
    sim.advance(10)


def test_states_are_restored_in_both_directions():
    sim = pulled(bar(fracture={"strain": 0.1, "noise": 0.2}), 5)
    body = sim.bodies[0]
    states, expected = [], []
    while body.pieces == 1 and len(states) < 400:
        states.append(sim.save_state())
        expected.append(everything(body))
        sim.step()
    versions = [entry[-1] for entry in expected]
    # A crack grows over several steps.
    assert versions[0] == 0 < versions[-1] < body.topology_version
    states.append(sim.save_state())
    expected.append(everything(body))
    chosen = [0, len(states) - 1, versions.index(1), 0, len(states) - 2, 0, len(states) - 1]
    for index in chosen:
        sim.restore_state(states[index])
        assert everything(body) == expected[index]
        if index + 1 < len(states):
            sim.step()
            assert everything(body) == expected[index + 1]


def test_a_mesh_is_current_after_another_cut_of_the_same_joints():
    body = bar()
    sim = supple.Simulation([body], dt=1 / 60, gravity=(0, 0, 0))
    whole, mesh = sim.save_state(), body.mesh
    meshes = []
    for x in (5.9, 6.1):
        body.cut(((x, 0, 0), (1, 0, 0)))
        meshes.append(body.mesh)
        assert len(body.surface()) == len(body.mesh.vertices)
        sim.restore_state(whole)
        assert body.mesh is mesh
    assert meshes[0].vertices.tobytes() != meshes[1].vertices.tobytes()


@pytest.mark.parametrize("steps", [0, 200, 400])
@pytest.mark.parametrize("duplicate", [lambda sim: pickle.loads(pickle.dumps(sim)), copy.deepcopy])
def test_copies_before_in_and_after_a_break(steps, duplicate):
    sim = pulled(bar(fracture={"strain": 0.1}), 0)
    force = np.zeros((len(sim.bodies[0]), 3))
    force[:, 2] = 0.1
    sim.bodies[0].add_force_field(force)
    sim.step(steps)
    twin = duplicate(sim)
    assert everything(twin.bodies[0]) == everything(sim.bodies[0])
    assert twin.bodies[0].fracture == sim.bodies[0].fracture
    for each in (sim, twin):
        each.step(400 - steps)
    assert sim.bodies[0].pieces > 1
    assert everything(twin.bodies[0]) == everything(sim.bodies[0])


def test_copies_of_a_body_that_is_cut():
    body = bar()
    body.cut(((5.9, 0, 0), (1, 0.2, 0)))
    for twin in (copy.deepcopy(body), pickle.loads(pickle.dumps(body))):
        assert everything(twin) == everything(body)
        assert twin.cut(((3, 0, 0), (1, 0, 0))) > 0
        assert (twin.pieces, body.pieces) == (3, 2)


def middle_cut():
    """Return a simulation of a bar that is cut in the middle, without gravity, and its state before the cut."""
    body = bar(damping_ratio=0)
    sim = supple.Simulation([body], dt=1 / 240, gravity=(0, 0, 0))
    whole = sim.save_state()
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    return sim, whole


def momentum(body):
    return body.masses @ body.velocities


def copies_of(body, vertices):
    """Return the lattice vertices at the places of some vertices."""
    places = {tuple(index) for index in body.lattice.indices[vertices]}
    return [vertex for vertex, index in enumerate(body.lattice.indices) if tuple(index) in places]


def test_force_fields_follow_the_copies_of_their_vertices():
    body = bar(damping_ratio=0)
    sim = supple.Simulation([body], dt=1 / 240, gravity=(0, 0, 0))
    rows = np.random.default_rng(2).normal(size=(len(body), 3))
    chosen = [300, 40, *np.flatnonzero(body.lattice.indices[:, 0] == body.lattice.indices[:, 0].max() // 2)]
    some = np.arange(3.0 * len(chosen)).reshape(-1, 3)
    fields = [
        body.add_force_field(rows),
        body.add_force_field(some, vertices=chosen),
        body.add_force_field((5, 0, 7), vertices=chosen),
    ]
    seen = []
    watch = body.add_force_field(lambda x, v, time: seen.append(x) or np.zeros_like(x), vertices=chosen)
    expected = (rows.sum(axis=0) + some.sum(axis=0) + [5, 0, 7]) * sim.dt
    sim.step()
    np.testing.assert_allclose(momentum(body), expected, rtol=1e-4, atol=1e-4)
    plane = [(5.9, 0, 0), (1, 0, 0)]
    assert body.cut(plane) == 25
    before, positions = momentum(body), body.positions
    assert len(fields[0].vertices) == len(body)
    follows = fields[1].vertices
    assert list(follows[: len(chosen)]) == chosen
    assert sorted(follows) == copies_of(body, chosen)
    assert len(follows) > len(chosen)
    np.testing.assert_array_equal(fields[1].force, some)
    sim.step()
    np.testing.assert_allclose(momentum(body) - before, expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(seen[-1], positions[follows])
    watch.remove()  # a lambda is not copied
    twin = copy.deepcopy(sim)
    for each in (sim, twin):
        each.step(3)
    assert everything(twin.bodies[0]) == everything(body)


def test_a_vertex_and_its_copies_share_a_force_by_their_masses():
    body = bar(damping_ratio=0)
    sim = supple.Simulation([body], dt=1 / 240, gravity=(0, 0, 0))
    twin, planes = bar(), [((5.9, 0, 0), (1, 0, 0)), ((0, 0.7, 0), (0, 1, 0))]
    for plane in planes:
        twin.cut(plane)
    # A vertex at the edge where both cuts meet has three copies.
    places, counts = np.unique(twin.lattice.indices, axis=0, return_counts=True)
    vertex = int(np.flatnonzero((body.lattice.indices == places[counts.argmax()]).all(axis=1))[0])
    body.add_force_field([[0, 0, 3e5]], vertices=[vertex])
    for plane in planes:
        body.cut(plane)
    group = copies_of(body, [vertex])
    assert len(group) == 4
    sim.step()
    # The velocities are equal, up to the rotation of the pieces, so the forces are in the ratio of the masses.
    expected = 3e5 * sim.dt / body.masses[group].sum()
    np.testing.assert_allclose(body.velocities[group, 2], expected, rtol=0.01)


def test_force_fields_of_a_broken_body_follow_it_to_a_whole_state():
    sim, whole = middle_cut()
    body = sim.bodies[0]
    calls = []

    def push(positions, velocities, time):
        calls.append(len(positions))
        return np.ones_like(positions)

    copies = np.arange(len(body) - 4, len(body))
    everywhere = body.add_force_field(push)
    copied = body.add_force_field(push, vertices=copies)
    constant = body.add_force_field(np.full((4, 3), 2.0), vertices=copies)
    sources = sorted(set(copies_of(body, copies)) - set(copies))
    assert list(copied.vertices) == list(constant.vertices) == list(copies)
    sim.step()
    count = len(body)
    assert calls == [count, 4]
    sim.restore_state(whole)
    assert list(everywhere.vertices) == list(range(len(body)))
    assert sorted(copied.vertices) == sorted(constant.vertices) == sources
    sim.step()
    assert calls[2:] == [len(body), 4]
    np.testing.assert_allclose(momentum(body), (len(body) + 4 + 8) * sim.dt * np.ones(3), rtol=1e-4)
    # Another cut gives the copies other numbers.
    body.cut(((2.0, 0, 0), (1, 0, 0)))
    assert body.topology_version == 1
    assert sorted(copied.vertices) == copies_of(body, sources)


def test_handles_follow_animations_of_whole_bodies_only():
    body = bar()
    walk = np.array([BAR.vertices + [0, 0, 0.1 * k] for k in range(30)])
    body.handle(follow=walk, plane=((10, 0, 0), (1, 0, 0)))
    sim = supple.Simulation([body], fps=30, substeps=4, gravity=(0, 0, 0))
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    joints = body.broken_joints
    pieces = np.array([body.mesh.vertices] * 2)
    for follow in (walk, pieces):
        with pytest.raises(ValueError, match=f"follow needs a whole body, and this one has {joints} broken joints"):
            body.handle(follow=follow, plane=((10, 0, 0), (1, 0, 0)))
    assert len(body.holds) == 1
    twins = [sim, copy.deepcopy(sim), pickle.loads(pickle.dumps(sim))]
    for each in twins:
        each.advance(5)
    assert all(everything(each.bodies[0]) == everything(body) for each in twins)
    assert twins[1].bodies[0].holds[0].follow.shape == walk.shape
    assert body.surface()[:, 2].max() > 4.3
    alone = bar()
    alone.handle(follow=walk, plane=((10, 0, 0), (1, 0, 0)))
    alone.cut(((5.9, 0, 0), (1, 0, 0)))
    assert everything(copy.deepcopy(alone)) == everything(alone)


def test_trimesh_has_the_pieces():
    trimesh = pytest.importorskip("trimesh")
    body = bar()
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    mesh = body.to_trimesh()
    np.testing.assert_array_equal(mesh.faces, body.faces)
    assert mesh.is_watertight
    with pytest.raises(ValueError, match="uv=True needs a body that is whole"):
        body.to_trimesh(uv=True)
    colored = trimesh.Trimesh(BAR.vertices, BAR.faces, vertex_colors=np.full((len(BAR.vertices), 4), 9), process=False)
    body = supple.Body(colored, cell_size=0.8)
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    assert body.to_trimesh().is_watertight


def test_pictures_show_the_pieces():
    body = bar()
    before = supple.screenshot(body, size=(80, 60))
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    body.positions = body.positions + np.where(body.lattice.indices[:, :1] >= 8, [1, 0, 0], 0)
    assert (supple.screenshot(body, size=(80, 60)) != before).any()
    assert f"<td>{len(body.surface())}</td>" in body._repr_html_()


def test_a_viewer_shows_the_faces_after_a_break(polyscope):
    from supple.viewer import Viewer

    body = bar()
    Viewer(body)
    polyscope.frame_tick()
    body.cut(((5.9, 0, 0), (1, 0, 0)))
    polyscope.frame_tick()
    assert polyscope.get_surface_mesh("body [0]").n_vertices() == len(body.surface())


def test_a_scene_sets_fracture(scene):
    sim = supple.load_scene(scene, overrides={"body.cube.fracture.strain": 0.2, "body.cube.fracture.surface": "cells"})
    assert sim.bodies[0].fracture == DEFAULTS | {"strain": 0.2, "surface": "cells"}
    assert pickle.loads(pickle.dumps(sim)).bodies[0].fracture == sim.bodies[0].fracture
    with pytest.raises(supple.SceneError, match=r"body\.cube\.fracture\.strian.*`strain`"):
        supple.load_scene(scene, overrides={"body.cube.fracture.strian": 0.1})
    with pytest.raises(supple.SceneError, match=r"strength.*strain"):
        supple.load_scene(scene, overrides={"body.cube.fracture.noise": 0.1})


def page_header(path):
    """Return the description of the only run of a page."""
    text = path.read_bytes().split(b'<script type="text/plain" data-run="0">')[1].split(b"</script>")[0]
    data = gzip.decompress(base64.b64decode(text))
    return json.loads(data[4 : 4 + int.from_bytes(data[:4], "little")])


def test_pages_show_bodies_that_are_cut_and_that_break(tmp_path):
    sim = supple.Simulation([bar(), bar()], fps=30)
    with supple.Recorder(sim, tmp_path / "cut.html") as recorder:
        recorder.record()
        sim.bodies[1].cut(supple.Plane((5.9, 0, 0), (1, 0, 0)))
        sim.advance(1)
        recorder.record()
    supple.save_html(pulled(bar(), 1), tmp_path / "whole.html", 1)
    supple.save_html(pulled(bar(fracture={"strain": 0.1}), 0), tmp_path / "pulled.html", 30)
    headers = [page_header(tmp_path / f"{name}.html") for name in ("cut", "whole", "pulled")]
    assert [header["version"] for header in headers] == [2, 1, 2]
    # The bodies are described as they are when they are whole.
    assert all(header["surfaces"] == headers[0]["surfaces"] for header in headers)
    assert [body["lattice"] for body in headers[0]["bodies"]] == [16 * 6 * 6] * 2


def test_run_writes_a_page_of_a_body_that_breaks_and_no_point_cache(tmp_path):
    lines = [f"v {x} {y} {z}" for x, y, z in BAR.vertices]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in BAR.faces]
    (tmp_path / "bar.obj").write_text("\n".join(lines))
    scene = tmp_path / "scene.toml"
    scene.write_text(
        "[simulation]\nframes = 40\nsubsteps = 4\ngravity = [0, 0, 0]\n"
        "[[body]]\nname = 'bar'\nmesh = 'bar.obj'\ncell_size = 0.8\nhalf_width = 1\n"
        "[body.fracture]\nstrain = 0.1\n"
        "[[body.pin]]\nbox = { min = [-1, -1, -1], max = [0.5, 5, 5] }\n"
        "[[body.handle]]\nbox = { min = [11.5, -1, -1], max = [13, 5, 5] }\n"
        "keys = [ { time = 0 }, { time = 1, translate = [4, 0, 0] } ]\n"
    )
    supple.run(scene, tmp_path / "out", format="html")
    header = page_header(tmp_path / "out" / "supple.html")
    assert header["frames"] == 41
    assert header["version"] == 2  # a body is broken in a frame
    formats = "obj, ply, usd, usdz, html, vtu, lattice"
    with pytest.raises(ValueError, match=f"pc2 has the same faces in all frames: write {formats}"):
        supple.run(scene, tmp_path / "points", format="pc2")
    assert not (tmp_path / "points").exists()
