"""Rigid bodies: mass, motion, contacts, joints, states, and arguments of soft bodies."""

import pickle

import numpy as np
import pytest

import supple


def _falling(cube, **arguments):
    body = supple.RigidBody(cube, translate=(0, 1.2, 0), **arguments)
    return supple.Simulation(body, dt=1 / 60, colliders=supple.Plane((0, 0, 0), (0, 1, 0)))


def test_mass_and_motion_are_exact(cube):
    body = supple.RigidBody(cube, density=500, velocity=(1, 2, 3), spin=(0, 0, 2))
    assert body.is_rigid
    assert not supple.Body(cube).is_rigid
    assert body.mass == pytest.approx(4000, rel=1e-14)
    assert np.allclose(body.linear_momentum, [4000, 8000, 12000], rtol=1e-14)
    # m a^2 / 6 = 4000 * 4 / 6
    assert np.allclose(body.angular_momentum, [0, 0, 2 * 16000 / 6], rtol=1e-14, atol=1e-9)
    sim = supple.Simulation(body, dt=1 / 60, gravity=(0, 0, 0))
    sim.step(60)
    assert np.allclose(body.center_of_mass, [1, 2, 3], rtol=1e-12)
    surface = body.surface()
    edges = np.linalg.norm(surface[:, None] - surface[None], axis=-1)
    assert np.allclose(np.unique(edges.round(5)), [0, 2, 2 * 2**0.5, 2 * 3**0.5], atol=1e-5)


def test_a_rigid_body_rests_and_sleeps(cube):
    sim = _falling(cube)
    sim.step(200)
    body = sim.bodies[0]
    assert body.is_asleep
    assert np.allclose(body.center_of_mass, [0, 1, 0], atol=5e-3)
    force = sim.contacts()["force"].sum(axis=0)
    assert np.allclose(force, [0, body.mass * 9.81, 0], rtol=1e-4, atol=1e-4 * body.mass)
    report = body.volume_report()
    assert report.lambda_ == 0
    assert report.after == pytest.approx(report.rest, rel=1e-6)


def test_states_and_pickles_continue_with_the_same_bits(cube):
    sim = _falling(cube, spin=(3, 1, 2))
    sim.step(30)
    state, copy = sim.save_state(), pickle.loads(pickle.dumps(sim))
    sim.step(30)
    positions = sim.bodies[0].positions
    copy.step(30)
    assert np.array_equal(copy.bodies[0].positions, positions)
    sim.restore_state(state)
    sim.step(30)
    assert np.array_equal(sim.bodies[0].positions, positions)


def test_a_held_vertex_is_a_joint(cube):
    body = supple.RigidBody(cube)
    corner = int(np.argmin(np.linalg.norm(body.positions - [-1, 1, -1], axis=1)))
    place = body.positions[corner]
    body.pin(vertices=[corner])
    sim = supple.Simulation(body, dt=1 / 120)
    sim.step(60)
    assert np.allclose(body.positions[corner], place, atol=1e-6)
    assert body.center_of_mass[1] < -0.1


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("material", "flesh"),
        ("youngs_modulus", 1e5),
        ("half_width", 2),
        ("damping_ratio", 0.2),
        ("inflate", 1.1),
        ("plastic", True),
        ("fracture", {"strain": 0.1}),
        ("poisson_ratio", 0.3),
        ("volume", "mesh"),
    ],
)
def test_arguments_of_soft_bodies_are_errors(cube, key, value):
    with pytest.raises(ValueError, match=f"rigid and {key} are mutually exclusive"):
        supple.Body(cube, rigid=True, **{key: value})


def test_a_rigid_body_cannot_be_cut(cube):
    with pytest.raises(ValueError, match="the body is rigid"):
        supple.RigidBody(cube).cut(((0, 0, 0), (1, 0, 0)))
