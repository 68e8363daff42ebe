"""Pickles and copies of simulations and bodies continue bit for bit."""

import copy
import gc
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import supple

NAMES = ("positions", "velocities", "rotations", "masses")


def _same(a, b):
    return all(getattr(a, name).tobytes() == getattr(b, name).tobytes() for name in NAMES)


def _changed_simulation(cube):
    """Returns a simulation in which every setting that can change between steps has changed."""
    body = supple.Body(
        cube, name="die", lattice_vertices=200, scale=0.7, rotate=(10, 20, 30), translate=(0, 1, 0), region_damping=0.1
    )
    block = supple.Body(supple.Lattice.from_cells(np.ones((3, 3, 3))), translate=[5, 0, 0], frequency=10)
    ground = supple.Plane((0, 0, 0), (0, 1, 0), friction=0.3, keys=[(0,), (2, (0, 0.3, 0))])
    sim = supple.Simulation([body, block], dt=1 / 100, colliders=[ground], threads=2, substeps=2)
    hold = body.handle(vertices=[0, 1, 2], keys=[(0,), (1, (0.2, 0, 0), (0, 0, 90))], end=0.4)
    sim.step(7)
    body.pin(vertices=[20], start=0.2)
    sim.gravity = (0.5, -9, 0)
    sim.dt = 1 / 120
    body.stiffness = 0.7
    body.half_width = 3
    block.volume_options = "lattice"
    block.region_damping_rate = 2
    hold.set_keys([(0,), (1, (0.1, 0, 0))])
    sim.step(20)
    body.apply_force((0, 50, 0), vertices=[5, 6])
    return sim


@pytest.mark.parametrize("again", [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))])
def test_a_copied_simulation_continues_bit_for_bit(cube, again):
    sim = _changed_simulation(cube)
    other = again(sim)
    assert other is not sim
    assert [body.name for body in other.bodies] == ["die", "body"]
    for name in ("dt", "time", "colliders", "steps_per_frame", "threads"):
        assert getattr(other, name) == getattr(sim, name), name
    assert np.array_equal(other.gravity, sim.gravity)
    for _ in range(3):
        for body, twin in zip(sim.bodies, other.bodies, strict=True):
            assert body is not twin
            assert _same(body, twin)
            assert body.volume_report() == twin.volume_report()
            for name in ("stiffness", "frequency", "region_damping", "half_width", "volume_options"):
                assert getattr(body, name) == getattr(twin, name), name
        assert sim.bodies[0].surface().tobytes() == other.bodies[0].surface().tobytes()
        sim.step(10)
        other.step(10)


def test_a_copy_is_independent_of_the_original(cube):
    sim = _changed_simulation(cube)
    other = copy.deepcopy(sim)
    before = sim.bodies[0].positions
    other.step(10)
    assert np.array_equal(sim.bodies[0].positions, before)


def test_bodies_pickled_with_their_simulation_stay_in_it(cube):
    sim = _changed_simulation(cube)
    twin, body, other = pickle.loads(pickle.dumps((sim, sim.bodies[1], sim.bodies[0])))
    assert twin.bodies == (other, body)
    assert copy.copy(sim.bodies[0]) is sim.bodies[0]


def test_a_body_without_a_simulation_is_pickled(cube):
    volume = {"measure": "cells", "max_correction": 0.5}
    body = supple.Body(cube, lattice_vertices=100, half_width=2, spin=(1, 0, 0), volume=volume)
    body.positions = body.positions * 1.1
    body.pin(vertices=[3])
    twin = pickle.loads(pickle.dumps(body))
    assert _same(body, twin)
    assert twin.volume_report() == body.volume_report()
    for each in (body, twin):
        supple.Simulation([each]).step(20)
    assert _same(body, twin)


@pytest.mark.parametrize("again", [copy.deepcopy, lambda body: pickle.loads(pickle.dumps(body))])
def test_a_copied_body_has_a_live_simulation(block, again):
    body = supple.Body(block)
    sim = supple.Simulation([supple.Body(block, name="other"), body], gravity=(0, -5, 0))
    sim.step(5)
    twin = again(body)
    gc.collect()
    assert _same(body, twin)
    assert [each.name for each in twin.simulation.bodies] == ["other", "body"]
    assert twin.simulation.bodies[1] is twin
    assert twin.simulation.time == sim.time
    for each in (sim, twin.simulation):
        each.step(5)
    assert _same(body, twin)


def test_a_hold_is_pickled_with_its_body(block):
    body = supple.Body(block)
    body.pin(vertices=[0])
    handle = body.handle(vertices=[3, 4], keys=[(0,), (1, (1, 0, 0))], end=2)
    sim = supple.Simulation([body])
    sim.step(3)
    other, twin = pickle.loads(pickle.dumps((sim, handle)))
    assert twin.body is other.bodies[0]
    assert twin == other.bodies[0].holds[1] != handle
    assert (twin.keys, twin.end, twin.active) == (handle.keys, 2, True)
    for hold in (handle, twin):
        hold.set_keys([(0, (0, 1, 0))])
    sim.step(3)
    other.step(3)
    assert _same(body, twin.body)


@pytest.fixture
def _limited_memory():
    """Makes allocations of more than a gigabyte fail. A damaged length in a pickle can ask for any size."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + 2**30, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs the memory limit of Linux")
# CPython reports a byte array that it cannot allocate twice.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.usefixtures("_limited_memory")
def test_a_damaged_pickle_is_an_error(cube):
    sim = _changed_simulation(cube)
    things = {
        "simulation": (sim, supple.Simulation),
        "body": (supple.Body(cube, lattice_vertices=50), supple.Body),
        "mesh": (cube, supple.Mesh),
        "lattice": (sim.bodies[0].lattice, supple.Lattice),
    }
    rng = np.random.default_rng(11)
    for name, (thing, kind) in things.items():
        data = pickle.dumps(thing)
        unequal = []
        for position in rng.choice(len(data), 150):
            damaged = bytearray(data)
            damaged[position] ^= 1 << rng.integers(8)
            try:
                loaded = pickle.loads(bytes(damaged))
            except Exception:
                continue
            # Some bits of a pickle have no meaning. What loads is then the same.
            if not isinstance(loaded, kind) or pickle.dumps(loaded) != data:
                unequal.append(position)
        assert not unequal, name


def _advance(sim):
    sim.step(15)
    return sim


def test_a_simulation_continues_in_another_process(cube):
    sim = _changed_simulation(cube)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        other = executor.submit(_advance, sim).result()
    sim.step(15)
    assert _same(sim.bodies[0], other.bodies[0])


def test_arguments_are_copied(block):
    velocity = np.array([1.0, 0, 0])
    body = supple.Body(block, velocity=velocity)
    velocity[:] = 7
    assert np.allclose(copy.deepcopy(body).velocities, [1, 0, 0])


def test_data_of_another_pickle_is_an_error(block):
    restore, (shape, data) = supple.Body(block).__reduce__()
    damaged = bytes([data[0] ^ 1]) + data[1:]
    for wrong in (damaged, data[:20], b""):
        with pytest.raises(ValueError, match="the pickle is damaged: its checksum does not match; save it again"):
            restore(shape, wrong)
    (other,) = shape.__reduce__()[1]
    with pytest.raises(ValueError, match="the pickle was made by a different version of supple; save it again"):
        restore(shape, other)
    with pytest.raises(ValueError, match="the pickle is damaged: a body has the shape of another one"):
        restore(supple.Lattice.from_cells(np.ones((9, 1, 1))), data)
    restore, (shapes, data) = supple.Simulation([supple.Body(block)]).__reduce__()
    with pytest.raises(ValueError, match="the pickle is damaged: it has 1 bodies and 2 shapes"):
        restore([*shapes, block], data)
