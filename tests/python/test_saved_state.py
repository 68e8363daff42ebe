"""States: save_state and restore_state of a simulation."""

import pickle

import numpy as np
import pytest

import supple


def _cube(name, height, **settings):
    lattice = supple.Lattice.from_cells(np.ones((3, 3, 3), bool), cell_size=0.3)
    return supple.Body(lattice, name=name, translate=(0.02 * height, height, 0), **settings)


def _pile(heights=(0.05, 1.0, 1.95), colliders=1, fps=60, **settings):
    """Cubes that fall on each other and on the ground. They touch after 10 frames, and sleep after about 400."""
    bodies = [_cube(f"cube{index}", height, **settings) for index, height in enumerate(heights)]
    ground = supple.Plane((0, 0, 0), (0, 1, 0))
    return supple.Simulation(bodies, fps=fps, colliders=[ground] * colliders)


def _bits(sim):
    """Everything that a step changes, as bytes."""
    arrays = [
        array
        for body in sim.bodies
        for array in (body.positions, body.velocities, body.rotations, body.corrected_positions())
    ]
    return b"".join(array.tobytes() for array in arrays) + np.float64(sim.time).tobytes()


def test_a_restored_simulation_continues_with_the_same_bits():
    sim = _pile()
    sim.advance(20)
    touching = sim.contacts()
    assert {(int(c["body"]), int(c["other"])) for c in touching} >= {(0, 1), (1, 2)}
    state, before = sim.save_state(), _bits(sim)
    sim.advance(30)
    after, contacts = _bits(sim), sim.contacts()
    assert after != before
    for _ in range(2):
        sim.restore_state(state)
        assert _bits(sim) == before
        assert np.array_equal(sim.contacts(), touching)
        sim.advance(30)
        assert _bits(sim) == after
        assert np.array_equal(sim.contacts(), contacts)


def test_pins_handles_forces_driven_colliders_and_settings_are_restored():
    sim = _pile()
    pin = sim["cube2"].pin(plane=((0, 2.4, 0), (0, 1, 0)))
    sim.colliders[0].move_to((0, 0.2, 0), duration=1.0)
    sim.advance(20)
    sim["cube1"].apply_force((300, 0, 0), vertices=[0, 1, 2])
    state, gravity = sim.save_state(), sim.gravity
    sim.advance(30)
    after = _bits(sim)
    pin.release()
    later = sim["cube0"].pin(vertices=[0])
    sim.gravity = (0, 3, 0)
    sim["cube1"].youngs_modulus = 2 * sim["cube1"].youngs_modulus
    sim.advance(5)
    sim.restore_state(state)
    assert np.array_equal(sim.gravity, gravity)
    assert pin.active
    assert not pin.released
    with pytest.raises(ValueError, match="no pin or handle"):
        _ = later.vertices
    sim.advance(30)
    assert _bits(sim) == after


def test_sleeping_bodies_still_sleep_after_a_restore():
    sim = _pile(heights=(0.0, 0.9))
    for _ in range(100):
        sim.advance(10)
        if all(body.is_asleep for body in sim.bodies):
            break
    assert [body.is_asleep for body in sim.bodies] == [True, True]
    state, bits = sim.save_state(), _bits(sim)
    sim["cube0"].apply_force((0, 900, 0), vertices=[0])
    sim.advance(10)
    assert not sim["cube0"].is_asleep
    sim.restore_state(state)
    assert [body.is_asleep for body in sim.bodies] == [True, True]
    sim.advance(1)
    assert [body.is_asleep for body in sim.bodies] == [True, True]
    assert _bits(sim)[:-8] == bits[:-8]


@pytest.mark.parametrize("convert", [bytes, bytearray, memoryview, lambda s: np.frombuffer(s, np.uint8)])
def test_a_state_restores_in_a_simulation_that_was_built_alike(convert):
    sim, fork = _pile(), _pile()
    sim.advance(20)
    fork.restore_state(convert(pickle.loads(pickle.dumps(sim.save_state()))))
    assert fork.save_state() == sim.save_state()
    sim.advance(20)
    fork.advance(20)
    assert _bits(fork) == _bits(sim)


def test_a_mesh_keeps_its_surface(bust):
    body = supple.Body(bust, lattice_vertices=300, spin=(0, 0, 2))
    sim = supple.Simulation([body], fps=30, colliders=supple.Sphere((0, 4, 0), 1.5))
    sim.advance(5)
    state, surface = sim.save_state(), body.surface()
    sim.advance(5)
    after = body.surface()
    sim.restore_state(state)
    assert np.array_equal(body.surface(), surface)
    sim.advance(5)
    assert np.array_equal(body.surface(), after)


def _renamed():
    return supple.Simulation([_cube("other", 0.05), _cube("cube1", 1.0), _cube("cube2", 1.95)], fps=60)


def _reshaped():
    cells = np.ones((3, 3, 3), bool)
    cells[0, 0, 0] = False
    lattices = [supple.Lattice.from_cells(given, cell_size=0.3) for given in (cells, np.ones((3, 3, 3), bool))]
    bodies = [supple.Body(lattices[index > 0], name=f"cube{index}") for index in range(3)]
    return supple.Simulation(bodies, fps=60, contact=False)


@pytest.mark.parametrize(
    ("other", "problem"),
    [
        (lambda: _pile(heights=(0.05, 1.0)), "the state has 3 bodies, and this one 2"),
        (_renamed, "body 0 is cube0 in the state, and other in this one"),
        (_reshaped, "body cube0: the state has 64 lattice vertices, and this one 63"),
        (lambda: _pile(colliders=2), "the state has 1 collider, and this one 2"),
        (lambda: _pile(fps=30), "the state has fps = 60, and this one fps = 30"),
    ],
)
def test_a_state_of_another_simulation_is_refused(other, problem):
    state, other = _pile().save_state(), other()
    before = other.save_state()
    with pytest.raises(ValueError, match="state cannot be restored: it is of another simulation: " + problem):
        other.restore_state(state)
    assert other.save_state() == before


def test_a_lattice_with_the_same_number_of_vertices_but_another_shape_is_refused():
    def bar(shape):
        lattice = supple.Lattice.from_cells(np.ones(shape, bool))
        return supple.Simulation([supple.Body(lattice)])

    with pytest.raises(ValueError, match="another lattice"):
        bar((1, 1, 3)).restore_state(bar((1, 3, 1)).save_state())


def test_damaged_states_and_other_versions_are_refused():
    sim = _pile(heights=(0.05,))
    state = sim.save_state()
    for length in (0, 7, 19, 20, len(state) - 1):
        with pytest.raises(ValueError, match=r"not a state|damaged"):
            sim.restore_state(state[:length])
    for at in (0, 12, 25, len(state) // 2, len(state) - 1):
        damaged = bytearray(state)
        damaged[at] ^= 4
        with pytest.raises(ValueError, match=r"not a state|damaged"):
            sim.restore_state(damaged)
    later = bytearray(state)
    later[8] += 1
    with pytest.raises(ValueError, match="its format is version"):
        sim.restore_state(later)
    with pytest.raises(TypeError, match=r"state must be bytes from save_state\(\), not list"):
        sim.restore_state([1, 2])
    sim.restore_state(state)
