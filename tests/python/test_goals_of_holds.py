"""Weights of pins and handles, and parts by groups and mesh vertices."""

import pickle

import numpy as np
import pytest

import supple

OBJ = """o upper
v 0 1 0
v 1 1 0
v 0 1 1
v 1 1 1
v 0 2 0
v 1 2 0
v 0 2 1
v 1 2 1
usemtl skin
f 1 3 4 2
usemtl hat
f 5 6 8 7
f 1 2 6 5
f 3 7 8 4
f 1 5 7 3
f 2 4 8 6
"""


@pytest.fixture
def mesh(tmp_path):
    path = tmp_path / "hat.obj"
    path.write_text(OBJ)
    return supple.read_obj(path)


def test_a_mesh_has_the_groups_of_its_file(mesh):
    groups = mesh.groups
    assert list(groups) == ["hat", "skin", "upper"]
    assert groups["skin"].tolist() == [0, 1, 2, 3]
    assert groups["upper"].tolist() == list(range(8))
    again = pickle.loads(pickle.dumps(mesh)).groups
    assert all(np.array_equal(again[name], groups[name]) for name in groups)


def test_parts_are_selected_by_groups_and_mesh_vertices(mesh):
    body = supple.Body(mesh, cell_size=0.25)
    by_group = body.pin(group="skin").vertices
    assert np.array_equal(by_group, body.pin(mesh_vertices=[3, 2, 1, 0]).vertices)
    mask = mesh.vertices[:, 1] < 1.5
    assert np.array_equal(by_group, body.pin(mesh_vertices=mask).vertices)
    with pytest.raises(ValueError, match=r'no group "skins"; it has \["hat", "skin", "upper"\]'):
        body.pin(group="skins")
    with pytest.raises(ValueError, match="mesh_vertices: 8 is out of range: the mesh has 8 vertices"):
        body.pin(mesh_vertices=[8])
    with pytest.raises(TypeError, match="at only together with a shape"):
        body.pin(group="skin", at="start")


def test_a_weight_pulls_and_one_holds(mesh):
    def height(**goal):
        body = supple.Body(mesh, cell_size=0.25, youngs_modulus=1e6)
        hold = body.pin(mesh_vertices=np.ones(8, bool), **goal)
        sim = supple.Simulation(body, fps=60)
        sim.advance(300)
        return body.center_of_mass[1], hold, body

    held, hold, _ = height()
    assert hold.weight == 1
    soft, hold, body = height(weight=0.5, goal_frequency=4, goal_damping=1)
    assert hold.weight == 0.5
    assert hold.active
    # Eight corner cells carry the cube.
    assert 1e-3 < held - soft < 0.2
    assert np.allclose(hold.force, (0, body.mass * 9.81, 0), rtol=0.01, atol=1)
    _, hold, _ = height(weight=[(0, 0.5), (2, 1)])
    assert hold.weight == [(0, 0.5), (2, 1)]


@pytest.mark.parametrize("goal", [{"weight": 0}, {"weight": 1.5}, {"goal_frequency": 0}, {"goal_damping": 2}])
def test_goals_out_of_range_are_errors(mesh, goal):
    body = supple.Body(mesh, cell_size=0.25)
    with pytest.raises(ValueError, match=f"{next(iter(goal))} = .* is out of range"):
        body.pin(group="skin", **goal)


def test_the_pose_moves_the_mesh_to_the_body(mesh):
    body = supple.Body(mesh, cell_size=0.25, scale=2, rotate=(0, 30, 10), translate=(5, 0, -1), youngs_modulus=1e7)
    sim = supple.Simulation(body, dt=1 / 240, gravity=(0, 0, 0))

    def moved():
        rotation, translation = body.pose
        return 2 * mesh.vertices @ rotation.T + translation

    assert np.allclose(moved(), body.surface(), atol=1e-4)
    body.apply_impulse((0, 0, 2000), point=(7, 4, 0))
    sim.step(240)
    assert np.abs(moved() - body.surface()).max() < 0.02
    assert np.abs(moved() - (2 * mesh.vertices + (5, 0, -1))).max() > 0.1
