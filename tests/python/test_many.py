"""Many simulations at once, reset, and a simulation as a collection of bodies."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import supple


def _pile(block, height=0.2, **settings):
    """Two blocks that fall on the ground and on each other. They touch after about 10 steps."""
    low = supple.Body(block, name="low", half_width=2, translate=(0, height, 0))
    high = supple.Body(block, name="high", half_width=2, translate=(0.1, height + 1.6, 0))
    ground = supple.Plane((0, 2, 0), (0, 1, 0))
    return supple.Simulation([low, high], dt=1 / 120, colliders=[ground], **settings)


def _bits(sim):
    arrays = [array for body in sim for array in (body.positions, body.velocities, body.rotations)]
    return b"".join(array.tobytes() for array in arrays) + np.float64(sim.time).tobytes()


def test_steps_of_many_simulations_have_the_bits_of_steps_of_each(block):
    def build():
        sims = [_pile(block, 0.1 * index, threads=index % 3) for index in range(7)]
        sims.append(supple.Simulation([supple.Body(block, material="jelly")], fps=24))
        return sims

    alone, together = build(), build()
    for sims in (alone, together):
        sims[2]["low"].apply_force((5e3, 0, 0))
        sims[3]["low"].add_force_field(lambda positions, velocities, time: -300.0 * velocities)
        sims[4]["high"].apply_force((0, 0, 5e3), duration=0.1)
    for count in (1, 20, 0, 35):
        for sim in alone:
            sim.step(count)
        supple.step_all(together, count)
        assert [_bits(sim) for sim in together] == [_bits(sim) for sim in alone]
    supple.step_all(iter(together))
    assert together[0].time == pytest.approx(57 / 120)
    assert together[0].threads == alone[0].threads
    supple.step_all([])


def test_items_that_are_no_simulations_or_the_same_one_are_refused(block):
    sim = _pile(block)
    with pytest.raises(ValueError, match=r"sims\[0\] and sims\[2\] are the same simulation; give each once"):
        supple.step_all([sim, _pile(block), sim])
    with pytest.raises(TypeError, match=r"sims must be a sequence of supple\.Simulation, not one Simulation"):
        supple.step_all(sim)
    with pytest.raises(TypeError, match="not one with an item of type Body"):
        supple.step_all([sim, sim["low"]])
    with pytest.raises(TypeError, match="not int"):
        supple.step_all(3)
    with pytest.raises(ValueError, match="n = -1 is out of range"):
        supple.step_all([sim], n=-1)
    assert sim.time == 0


def test_an_exception_of_a_force_field_leaves_step_all_and_ends_the_forces_of_the_call(block):
    def fail(positions, velocities, time):
        raise RuntimeError("stop")

    first, second = _pile(block), _pile(block)
    field = second["low"].add_force_field(fail)
    first["low"].apply_force((5e3, 0, 0))
    with pytest.raises(RuntimeError, match="stop"):
        supple.step_all([first, second])
    field.remove()
    supple.step_all([first, second], 5)
    assert _bits(first) == _bits(second)


def test_materials_out_of_reach_warn_once_for_each_simulation(block):
    sims = [supple.Simulation([supple.Body(block, youngs_modulus=1e9)], dt=1 / 30) for _ in range(2)]
    with pytest.warns(supple.MaterialWarning) as warnings:
        supple.step_all(sims, 3)
    assert len(warnings) == 2


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_long_steps_of_many_simulations(block):
    sims = [_pile(block, sleep=False) for _ in range(5)]
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        supple.step_all(sims, 2**60)
    assert time.perf_counter() - start < 10
    timer.join()
    supple.step_all(sims)


def test_contacts_of_one_body_or_collider(block):
    sim = _pile(block)
    sim.step(60)
    contacts = sim.contacts()
    low, high = sim
    between = ~contacts["other_is_collider"]
    assert between.any()
    assert not between.all()
    ground = contacts["other_is_collider"]
    of_high = (contacts["body"] == 1) | (between & (contacts["other"] == 1))
    of_low = (contacts["body"] == 0) | (between & (contacts["other"] == 0))
    for body, expected in (("high", of_high), (high, of_high), (1, of_high), (low, of_low), (np.int64(0), of_low)):
        assert sim.contacts(body).tobytes() == contacts[expected].tobytes()
        assert sim.contacts(body=body, collider=0).tobytes() == contacts[expected & ground].tobytes()
    for collider in (0, sim.colliders[0]):
        assert sim.contacts(collider=collider).tobytes() == contacts[ground].tobytes()
    assert sim.contacts(body=None).dtype == contacts.dtype
    rows = [dict(zip(contacts.dtype.names, row, strict=True)) for row in contacts]
    assert rows[0]["point"].shape == (3,)
    with pytest.raises(KeyError, match="the nearest name is"):
        sim.contacts("hihg")
    with pytest.raises(IndexError, match="body is 2, and the simulation has 2 bodies; it must be less than 2"):
        sim.contacts(2)
    with pytest.raises(IndexError, match="collider is 1, and the simulation has 1 colliders"):
        sim.contacts(collider=1)
    with pytest.raises(ValueError, match=r"body is a Body that is not in sim\.bodies"):
        sim.contacts(supple.Body(block))
    with pytest.raises(ValueError, match=r"collider is a Plane that is not in sim\.colliders"):
        sim.contacts(collider=supple.Plane((0, 2, 0), (0, 1, 0)))
    with pytest.raises(TypeError, match=r"body must be an item of sim\.bodies or its index, not float"):
        sim.contacts(1.5)
    with pytest.raises(TypeError, match="not bool"):
        sim.contacts(True)


def test_a_simulation_is_a_collection_of_its_bodies(block):
    sim = _pile(block)
    assert len(sim) == 2
    assert list(sim) == list(sim.bodies)
    assert "low" in sim
    assert "ground" not in sim
    assert sim["low"] in sim
    assert supple.Body(block, name="low") not in sim
    assert 0 not in sim
    assert bool(sim)


def _bar(block, **settings):
    """A plastic bar that breaks or is cut, with a pin and a handle that starts late."""
    bar = supple.Lattice.from_cells(np.ones((8, 1, 1), bool), cell_size=0.25)
    body = supple.Body(bar, name="bar", half_width=1, plastic=True, spin=(0, 0, 0.1), **settings)
    body.pin(box=((-0.2, -1, -1), (0.1, 1, 1)))
    body.handle(box=((1.9, -1, -1), (2.2, 1, 1)), start=0.05, keys=[(0.05,), (0.3, (0.6, 0, 0))])
    return supple.Simulation([body], dt=1 / 240, colliders=supple.Plane((0, -0.1, 0), (0, 1, 0)))


@pytest.mark.parametrize("settings", [{}, {"fracture": {"strain": 0.1}}])
def test_a_reset_simulation_has_the_bits_of_a_new_one(block, settings):
    sim, new = _bar(block, **settings), _bar(block, **settings)
    sim.step(80)
    (body,) = sim
    if not settings:
        body.cut(((1.1, 0, 0), (1, 0, 0)))
        sim.step(5)
    body.apply_force((0, 10.0, 0))
    sim.colliders[0].move_to((0, 0.5, 0), duration=1)
    sim.step(5)
    assert body.pieces > 1
    sim.reset()
    assert sim.time == 0
    assert body.pieces == 1
    assert _bits(sim) == _bits(new)
    for count in (1, 30, 60):
        sim.step(count)
        new.step(count)
        assert _bits(sim) == _bits(new)
        assert body.surface().tobytes() == new["bar"].surface().tobytes() if body.mesh else True


def test_reset_keeps_settings_pins_and_fields(block):
    sim, new = _pile(block), _pile(block)
    sim.step(20)
    for each in (sim, new):
        each.gravity = (1, -5, 0)
        each["low"].density = 300
        each.fields = [{"wind": {"velocity": (3, 0, 0), "drag": 2.0}}]
    hold = sim["high"].pin(vertices=[0, 1])
    new["high"].pin(vertices=[0, 1])
    sim.step(20)
    sim.reset()
    assert hold in sim["high"].holds
    for each in (sim, new):
        each.step(50)
    assert _bits(sim) == _bits(new)


def test_a_reset_leaves_no_copy_of_the_state(block):
    sim = _pile(block)
    sim.step(30)
    before = repr(sim).split("thread")[1]
    for _ in range(3):
        sim.reset()
        sim.step(30)
    assert repr(sim).split("thread")[1] == before
