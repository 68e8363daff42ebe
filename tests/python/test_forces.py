"""Forces: arrays of apply_force, force fields, one body as a simulation."""

import copy
import gc
import pickle
import weakref

import numpy as np
import pytest

import supple


@pytest.fixture
def sim():
    lattice = supple.Lattice.from_cells(np.ones((3, 2, 2), bool), cell_size=0.5)
    return supple.Simulation(supple.Body(lattice, damping_ratio=0), dt=1 / 120, gravity=(0, 0, 0))


def _momentum(body):
    return body.masses @ body.velocities


def _drag(positions, velocities, time):
    """Pulls along x until 0.1 s, in proportion to the distance from the plane y = 0, against the velocity in z."""
    force = np.zeros_like(positions)
    if time < 0.1 - 1e-9:
        force[:, 0] = 2 * positions[:, 1]
    force[:, 2] = -velocities[:, 2]
    return force


def test_a_simulation_takes_one_body_and_one_collider(sim):
    assert len(sim.bodies) == 1
    one = supple.Simulation(supple.Body(sim.bodies[0].lattice), colliders=supple.Sphere((0, -3, 0), 1))
    assert len(one.bodies) == len(one.colliders) == 1
    with pytest.raises(TypeError, match="bodies must be a list of Body, or a Body, not int"):
        supple.Simulation(3)


def test_rows_of_forces_act_on_their_vertices(sim):
    body = sim.bodies[0]
    forces = np.random.default_rng(1).normal(size=(len(body), 3))
    body.apply_force(forces)
    body.apply_force([[0, 0, 5], [0, 7, 0]], vertices=[9, 2])
    top = body.positions[:, 1] > 0.9
    body.apply_force(np.full((top.sum(), 3), 0.5), vertices=top)
    body.apply_force((0, 0, 3))  # the whole body
    total = forces.sum(axis=0) + [0, 7, 5] + 0.5 * top.sum() * np.ones(3) + [0, 0, 3]
    sim.step()
    # The sums of f32 velocities of 36 vertices are exact to 1e-5 of the momentum.
    assert np.allclose(_momentum(body), total * sim.dt, rtol=1e-5, atol=1e-6)


def test_rows_have_the_order_of_the_given_vertices():
    def velocities(forces, vertices):
        lattice = supple.Lattice.from_cells(np.ones((3, 2, 2), bool))
        sim = supple.Simulation(supple.Body(lattice), gravity=(0, 0, 0))
        sim.bodies[0].apply_force(forces, vertices=vertices)
        sim.step()
        return sim.bodies[0].velocities

    swapped = velocities([[9, 0, 0], [0, 9, 0]], [20, 3])
    assert np.array_equal(swapped, velocities([[0, 9, 0], [9, 0, 0]], [3, 20]))
    assert not np.array_equal(swapped, velocities([[0, 9, 0], [9, 0, 0]], [20, 3]))


@pytest.mark.parametrize(
    ("force", "options", "error", "message"),
    [
        (np.zeros((3, 3)), {}, ValueError, r"force has the shape \(3, 3\); it must be \(36, 3\)"),
        (np.zeros((2, 3)), {"vertices": [1]}, ValueError, r"force has the shape \(2, 3\); it must be \(1, 3\)"),
        (np.zeros((36, 2)), {}, ValueError, r"force has the shape \(36, 2\); it must be \(36, 3\)"),
        ("up", {}, TypeError, r"force must be numbers of shape \(3,\)"),
        ((0, 1, 0), {"vertices": []}, ValueError, "the list of vertices is empty"),
        ((0, 1, 0), {"everything": True}, TypeError, "has no argument"),
    ],
)
@pytest.mark.parametrize("method", ["apply_force", "add_force_field"])
def test_invalid_forces_are_errors(sim, method, force, options, error, message):
    with pytest.raises(error, match=message):
        getattr(sim.bodies[0], method)(force, **options)


def test_a_constant_field_acts_until_it_is_removed(sim):
    body = sim.bodies[0]
    field = body.add_force_field((6, 0, 0))
    right = body.add_force_field((0, 0, 3), plane=((1, 0, 0), (1, 0, 0)))
    assert body.force_fields == (field, right)
    assert len(field.vertices) == len(body)
    assert np.array_equal(right.vertices, np.flatnonzero(body.lattice.rest_positions[:, 0] >= 1))
    assert np.array_equal(right.force, (0, 0, 3))
    sim.step(60)
    assert np.allclose(_momentum(body), [6 * 60 * sim.dt, 0, 3 * 60 * sim.dt], rtol=1e-4, atol=1e-4)
    field.remove()
    assert (field.removed, right.removed) == (True, False)
    assert repr(field).endswith("removed>")
    with pytest.raises(ValueError, match="the force field was removed"):
        _ = field.force
    sim.step(60)
    assert np.allclose(_momentum(body), [6 * 60 * sim.dt, 0, 3 * 120 * sim.dt], rtol=1e-4, atol=1e-4)


def test_a_constant_field_is_the_same_force_in_every_step(sim):
    other = copy.deepcopy(sim)
    sim.bodies[0].add_force_field((6, 0, 1), vertices=[3, 4])
    sim.step(20)
    for _ in range(20):
        other.bodies[0].apply_force((6, 0, 1), vertices=[3, 4])
        other.step()
    assert sim.save_state() == other.save_state()


def test_a_function_is_called_before_each_step(sim):
    body, calls = sim.bodies[0], []

    def field(positions, velocities, time):
        assert positions.shape == velocities.shape == (2, 3)
        assert not positions.flags.writeable
        assert np.array_equal(positions, body.positions[[7, 5]])
        calls.append(time)
        return (0, 4, 0)

    body.add_force_field(field, vertices=[7, 5])
    sim.step(30)
    assert np.allclose(calls, np.arange(30) * sim.dt)
    assert np.allclose(_momentum(body), [0, 4 * 30 * sim.dt, 0], rtol=1e-4, atol=1e-4)


def test_fields_of_several_bodies_act_in_frames():
    lattice = supple.Lattice.from_cells(np.ones((2, 2, 2), bool))
    # Without a Poisson's ratio, a pull along y moves nothing along x.
    bodies = [
        supple.Body(lattice, name=name, translate=(x, 0, 0), poisson_ratio=0) for name, x in [("left", 0), ("right", 9)]
    ]
    sim = supple.Simulation(bodies, fps=30, gravity=(0, 0, 0))
    for body in bodies:
        body.add_force_field(lambda x, v, time: (x - x.mean(axis=0)) * [0, 1e3, 0] + [0, 0, x[0, 0] + 1])
    sim.advance(3)
    count = 27
    for body, x in zip(bodies, (0, 9), strict=True):
        # x keeps its value to rounding.
        assert np.allclose(_momentum(body), [0, 0, count * (x + 1) * 0.1], rtol=1e-4, atol=1e-3)


def test_an_exception_of_a_function_passes_and_the_step_is_not_made(sim):
    def broken(positions, velocities, time):
        if time > 0.05:
            raise KeyError("broken")
        return 0 * positions

    field = sim.bodies[0].add_force_field(broken)
    with pytest.raises(KeyError, match="broken"):
        sim.step(100)
    # Steps from 0 to 0.05 s, both included, are made.
    assert sim.time == pytest.approx(7 * sim.dt)
    field.remove()
    for result, problem in [
        (np.zeros((2, 3)), r"has the shape \(2, 3\); it must be \(36, 3\)"),
        ((0, np.nan, 0), r"\[1\] = NaN is not finite"),
    ]:
        field = sim.bodies[0].add_force_field(lambda x, v, time, result=result: result)
        with pytest.raises(ValueError, match="the result of the force field ?" + problem):
            sim.step()
        field.remove()


def test_a_field_that_does_not_change_lets_a_body_sleep_and_wakes_it_later():
    lattice = supple.Lattice.from_cells(np.ones((3, 3, 3), bool), cell_size=0.3)
    ground = supple.Plane((0, 0, 0), (0, 1, 0))

    def asleep(sim, frames):
        for _ in range(frames):
            sim.advance()
            if sim.bodies[0].is_asleep:
                return True
        return False

    wind = {"share": 0.0}
    # Below the friction coefficient of 0.5 the body leans against it; above it, it slides.
    for share in (0.0, 0.3):
        sim = supple.Simulation(supple.Body(lattice), fps=30, colliders=ground)
        body = sim.bodies[0]
        weights = 9.81 * body.masses[:, None] * [1, 0, 0]
        wind["share"] = share
        body.add_force_field(lambda x, v, time, weights=weights: wind["share"] * weights)
        assert asleep(sim, 200)
        wind["share"] = 2.0
        sim.advance(1)
        assert not body.is_asleep
        assert body.velocities[:, 0].mean() > 0

    sim = supple.Simulation(supple.Body(lattice), fps=30, colliders=ground)
    field = sim.bodies[0].add_force_field((0.3 * 9.81 * sim.bodies[0].mass, 0, 0))
    assert asleep(sim, 200)
    calm = sim.bodies[0].positions
    sim.advance(10)
    assert np.array_equal(sim.bodies[0].positions, calm)
    field.remove()
    sim.step()
    assert not sim.bodies[0].is_asleep


@pytest.mark.parametrize("make", [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))])
def test_copies_have_the_fields(sim, make):
    body = sim.bodies[0]
    body.add_force_field(_drag)
    body.add_force_field(np.ones((2, 3)), vertices=[6, 1])
    body.add_force_field((0, 1, 0))
    sim.step(4)
    twin = make(sim)
    assert [repr(field) for field in twin.bodies[0].force_fields] == [repr(field) for field in body.force_fields]
    for each in (sim, twin):
        each.step(20)
    assert twin.save_state() == sim.save_state()


def test_a_body_outside_a_simulation_keeps_its_fields(sim):
    body = supple.Body(sim.bodies[0].lattice)
    field = body.add_force_field((0, 0, 2))
    twin = pickle.loads(pickle.dumps(body))
    assert len(twin.force_fields) == 1
    alone = supple.Simulation(body, gravity=(0, 0, 0))
    assert alone.bodies[0].force_fields == (field,)
    alone.step()
    assert _momentum(body)[2] == pytest.approx(2 * alone.dt, rel=1e-5)


def test_a_function_that_cannot_be_pickled_is_an_error_of_pickle(sim):
    sim.bodies[0].add_force_field(lambda x, v, time: 0 * x)
    with pytest.raises((pickle.PicklingError, AttributeError), match="lambda"):
        pickle.dumps(sim)


@pytest.mark.parametrize("owner", ["body", "body alone", "sim", "field", "hold"])
def test_a_body_to_which_a_function_refers_is_freed(owner, block):
    """Each episode is a cycle of references: object, body, function, object. The garbage collector has to see it."""
    freed = []
    for _ in range(20):
        body = supple.Body(block)
        sim = supple.Simulation(body) if owner != "body alone" else None
        hold = body.pin(vertices=[0]) if owner == "hold" else None
        field = body.add_force_field((0, 0, 0)) if owner == "field" else None
        target = {"sim": sim, "hold": hold, "field": field}.get(owner, body)

        def wind(positions, velocities, time, target=target):
            return 0 * positions

        body.add_force_field(wind)
        if sim is not None:
            sim.step()
        weakref.finalize(body, freed.append, body.name)
        del body, sim, hold, field, target, wind
    gc.collect()
    assert len(freed) == 20


def test_a_function_lives_as_long_as_its_body_is_stepped(sim):
    calls = []

    def count(positions, velocities, time):
        gc.collect()
        calls.append(len(positions))
        return 0 * positions

    sim.bodies[0].add_force_field(count)
    del count
    gc.collect()
    sim.step(3)
    assert calls == [36] * 3


def test_a_function_may_remove_its_field(sim):
    body = sim.bodies[0]
    calls = []

    def once(positions, velocities, time):
        calls.append(time)
        body.force_fields[0].remove()
        return 0 * positions

    body.add_force_field(once)
    sim.step(3)
    assert len(calls) == 1


def test_a_force_lasts_for_a_call_or_a_time_at_any_number_of_steps(sim):
    body = sim.bodies[0]
    force = np.array((3.0, -1.0, 0.5))
    for _ in range(2):
        body.apply_force(force)
        sim.step(6)
        sim.step(10)
    body.apply_force(force, duration=0.055)
    sim.step(30)
    assert np.allclose(_momentum(body), force * (12 * sim.dt + 0.055), rtol=1e-5, atol=1e-6)

    frames = supple.Simulation(supple.Body(body.lattice), fps=24, substeps=5, gravity=(0, 0, 0))
    frames.bodies[0].apply_force(force)
    frames.advance(3)
    frames.advance(3)
    assert np.allclose(_momentum(frames.bodies[0]), force * 3 / 24, rtol=1e-5, atol=1e-6)


def test_an_impulse_does_not_depend_on_the_step_length(sim):
    impulse = np.array((0.5, 2.0, -1.0))
    for dt in (1 / 30, 1 / 500):
        other = supple.Simulation(supple.Body(sim.bodies[0].lattice), dt=dt, gravity=(0, 0, 0))
        body = other.bodies[0]
        body.apply_impulse(impulse)
        body.apply_impulse([[0, 0, 1.0]], vertices=[3])
        other.step(5)
        assert np.allclose(_momentum(body), impulse + (0, 0, 1), rtol=1e-5, atol=1e-6)


def test_forces_at_a_point_and_torques_turn_a_body(sim):
    body = sim.bodies[0]
    point, force, torque = np.array((2.0, 1.0, 0)), np.array((0, 0, 4.0)), np.array((0, 3.0, 0))
    center = body.center_of_mass
    body.apply_force(force, point=point, torque=torque)
    sim.step()
    expected = (np.cross(point - center, force) + torque) * sim.dt
    assert np.allclose(body.angular_momentum, expected, rtol=1e-4, atol=1e-6)
    assert np.allclose(_momentum(body), force * sim.dt, rtol=1e-5, atol=1e-7)
    with pytest.raises(ValueError, match="lie on a line or at a point"):
        body.apply_force((0, 0, 0), torque=torque, vertices=[0])
    with pytest.raises(TypeError, match=r"point and torque only together with a total force \(3,\)"):
        body.apply_force(np.ones((len(body), 3)), torque=torque)
    with pytest.raises(ValueError, match="duration = 0"):
        body.apply_force(force, duration=0)


def test_a_call_that_an_exception_ends_also_ends_its_forces(sim):
    body = sim.bodies[0]

    def fail(positions, velocities, time):
        if time > 2.5 * sim.dt:
            raise RuntimeError("stop")
        return np.zeros(3)

    field = body.add_force_field(fail)
    body.apply_force((3, 0, 0))
    with pytest.raises(RuntimeError, match="stop"):
        sim.step(10)
    field.remove()
    before = _momentum(body)
    sim.step(10)
    assert np.allclose(_momentum(body), before, rtol=1e-5)


def test_an_exception_of_one_body_leaves_no_force_of_another_for_the_next_step():
    cells = np.ones((2, 2, 2), bool)
    bodies = [
        supple.Body(supple.Lattice.from_cells(cells), name=name, translate=(x, 0, 0))
        for name, x in (("a", 0), ("b", 9))
    ]
    sim = supple.Simulation(bodies, dt=0.01, gravity=(0, 0, 0))
    field = bodies[0].add_force_field((0, 1e4, 0))

    def fail(*_):
        raise KeyError("broken")

    bodies[1].add_force_field(fail)
    with pytest.raises(KeyError, match="broken"):
        sim.step()
    field.remove()
    bodies[1].force_fields[0].remove()
    sim.step()
    # The force would give 4e-3; rounding gives less than 1e-6.
    assert np.abs(bodies[0].velocities).max() < 1e-6
