"""Colliders: rest, motion, friction, and errors."""

import copy
import pickle

import numpy as np
import pytest

import supple

COLLIDERS = [
    supple.Plane((0, 0, 0), (0, 1, 0)),
    supple.Sphere((0, -5, 0), 5),
    supple.Box((0, -1, 0), (5, 1, 5)),
    supple.Box((0, -1, 0), half_extents=(5, 5, 1), rotate=(90, 0, 0)),
    supple.Capsule((-5, -1, 0), (5, -1, 0), 1, friction=0.9),
]


@pytest.mark.parametrize("collider", COLLIDERS, ids=lambda collider: type(collider).__name__)
def test_a_body_comes_to_rest_on_every_shape(cube, collider):
    body = supple.Body(cube, lattice_vertices=64, translate=(0, 1.2, 0), region_damping=0.3)
    sim = supple.Simulation([body], dt=1 / 120, colliders=[collider])
    sim.step(360)
    # Regression bounds for a body that settles. The lattice may extend below the mesh.
    assert body.positions[:, 1].min() > -0.5
    assert np.abs(body.velocities).max() < 0.2


def test_a_moving_collider_moves_a_body(cube):
    wall = supple.Plane((-1, 0, 0), (1, 0, 0), keys=[(0,), (1, (2, 0, 0))])
    body = supple.Body(cube, lattice_vertices=64)
    sim = supple.Simulation([body], dt=1 / 120, gravity=(0, 0, 0), colliders=[wall])
    sim.step(120)
    assert body.surface()[:, 0].min() > 0.9


def test_friction_and_restitution(cube):
    speeds = {}
    for friction in (0, 1):
        body = supple.Body(cube, lattice_vertices=64, velocity=(1, 0, 0), translate=(0, 1, 0))
        ground = supple.Plane((0, 0, 0), (0, 1, 0), friction=friction)
        supple.Simulation([body], dt=1 / 120, colliders=[ground]).step(60)
        speeds[friction] = body.velocities[:, 0].mean()
    assert speeds[0] == pytest.approx(1, abs=0.01)
    assert speeds[1] < 0.3


def test_colliders_can_be_set(cube):
    body = supple.Body(cube, lattice_vertices=64)
    sim = supple.Simulation([body])
    assert sim.colliders == ()
    sim.colliders = [supple.Plane((0, -1, 0), (0, 1, 0))]
    assert sim.colliders == (supple.Plane((0, -1, 0), (0, 1, 0)),)
    sim.step(120)
    assert body.surface()[:, 1].min() > -1.1
    sim.colliders = ()
    sim.step(60)
    assert body.surface()[:, 1].min() < -2


def test_colliders_are_hashable_dataclasses_that_pickle():
    plane = supple.Plane(np.array([1, 2, 3]), [0, 0, 2], friction=np.float32(0.5), keys=[{"time": 0}])
    assert plane == supple.Plane((1.0, 2.0, 3.0), (0, 0, 2), keys=[(0, (0, 0, 0), (0, 0, 0))])
    assert plane.point == (1, 2, 3)
    assert pickle.loads(pickle.dumps(plane)) == copy.deepcopy(plane) == plane
    assert hash(plane) == hash(copy.copy(plane))
    assert eval(repr(plane), {"Plane": supple.Plane}) == plane


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (
            lambda: supple.Plane((0, 0, 0), (0, 0, 0)),
            ValueError,
            "Plane: the plane's normal is zero; give the direction of the free side",
        ),
        (lambda: supple.Plane((0, 0), (0, 1, 0)), ValueError, r"point has the shape \(2,\); it must be \(3,\)"),
        (lambda: supple.Sphere((0, 0, 0), 0), ValueError, "Sphere: radius is 0; it must be greater than 0"),
        (lambda: supple.Sphere((0, 0, np.nan), 1), ValueError, r"center\[2\] = NaN is not finite"),
        (lambda: supple.Sphere((0, 0, 0), "1"), TypeError, "radius must be a number, not str"),
        (lambda: supple.Box((0, 0, 0), (1, 0, 1)), ValueError, "half_extents is 0; it must be greater than 0"),
        (lambda: supple.Capsule((0, 0, 0), (1, 1, 1), np.inf), ValueError, "radius is inf; it must be finite"),
        (lambda: supple.Sphere((0, 0, 0), 1, friction=-1), ValueError, "friction is -1; its range is 0 and above"),
        (lambda: supple.Sphere((0, 0, 0), 1, restitution=2), ValueError, "restitution is 2; its range is 0 to 1"),
        (
            lambda: supple.Sphere((0, 0, 0), 1, keys=[(1,), (0,)]),
            ValueError,
            "key 1 is at time 0, which is not after key 0 at 1; sort the keys by time",
        ),
    ],
)
def test_invalid_colliders_are_errors(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_other_objects_are_not_accepted_as_colliders(block):
    for given, message in [([3], r"colliders\[0\] must be a Plane"), (3, "colliders must be a list")]:
        with pytest.raises(TypeError, match=message):
            supple.Simulation([supple.Body(block)], colliders=given)
