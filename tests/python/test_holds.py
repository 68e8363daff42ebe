"""Pins, handles, forces."""

import pickle

import numpy as np
import pytest

import supple

#: Values of a Hold that need a pin or handle that was not released.
NAMES = ("vertices", "keys", "start", "end")


@pytest.fixture
def bar():
    return supple.Lattice.from_cells(np.ones((8, 2, 2), bool), cell_size=0.25)


def _sim(body, **settings):
    return supple.Simulation([body], dt=1 / 120, gravity=settings.pop("gravity", (0, 0, 0)), **settings)


SELECTIONS = [
    {"box": ((-1, -1, -1), (0.1, 1, 1))},
    {"box": np.array([(-1, -1, -1), (0.1, 1, 1)])},
    {"box": {"min": (-1, -1, -1), "max": [0.1, 1, 1]}},
    {"sphere": ((-0.2, 0.25, 0.25), 0.43)},
    {"sphere": {"center": (-0.2, 0.25, 0.25), "radius": 0.43}},
    {"plane": ((0.1, 0, 0), (-1, 0, 0))},
]


@pytest.mark.parametrize("selection", SELECTIONS)
def test_shapes_select_the_vertices_inside(bar, selection):
    body = supple.Body(bar)
    body.pin(**selection)
    sim = _sim(body, gravity=(0, -9.81, 0))
    sim.step(60)
    moved = np.linalg.norm(body.positions - bar.rest_positions, axis=1)
    assert np.array_equal(moved < 1e-6, bar.indices[:, 0] == 0)


def test_vertices_are_selected_by_index_or_mask(bar):
    mask = bar.indices[:, 0] == 0
    for vertices in (
        mask,
        mask.tolist(),
        np.flatnonzero(mask),
        np.flatnonzero(mask).tolist(),
        np.flatnonzero(mask).astype(np.uint8),
    ):
        body = supple.Body(bar)
        body.pin(vertices=vertices)
        _sim(body, gravity=(0, -9.81, 0)).step(30)
        assert np.array_equal(np.linalg.norm(body.positions - bar.rest_positions, axis=1) < 1e-6, mask)


def test_a_pin_is_active_from_start_to_end(bar):
    body = supple.Body(bar, velocity=(1, 0, 0))
    body.pin(vertices=np.arange(len(bar)), start=0.25, end=0.5)
    sim = _sim(body)
    sim.step(30)
    assert np.allclose(body.positions, bar.rest_positions + [0.25, 0, 0], atol=1e-5)
    sim.step(30)
    assert np.allclose(body.positions, bar.rest_positions + [0.25, 0, 0], atol=1e-5)
    assert np.allclose(body.velocities, 0)


@pytest.mark.parametrize("as_dicts", [False, True])
def test_a_handle_moves_along_its_keys(bar, as_dicts):
    body = supple.Body(bar)
    held = bar.indices[:, 0] == 8
    keys = [(0, (0, 0, 0), (0, 0, 0)), (1, (0.5, 0, 0), (360, 0, 0))]
    if as_dicts:
        keys = [{"time": 0}, {"time": 1, "translate": (0.5, 0, 0), "rotate": (360, 0, 0)}]
    body.handle(vertices=held, keys=keys)
    sim = _sim(body)
    sim.step(30)
    center = bar.rest_positions[held].mean(axis=0)
    arms = bar.rest_positions[held] - center
    quarter = arms @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]).T
    assert np.allclose(body.positions[held], center + quarter + [0.125, 0, 0], atol=1e-5)
    sim.step(90)
    assert np.allclose(body.positions[held], bar.rest_positions[held] + [0.5, 0, 0], atol=1e-5)


def test_a_handle_follows_new_keys_and_is_released(bar):
    body = supple.Body(bar)
    held = bar.indices[:, 0] == 0
    sim = _sim(body)
    hold = body.handle(vertices=held, keys=[(0,)])
    assert hold.body is body
    for frame in range(10):
        hold.set_keys([(sim.time, (0.01 * frame, 0, 0)), (sim.time + sim.dt, (0.01 * (frame + 1), 0, 0))])
        sim.step()
    assert np.allclose(body.positions[held], bar.rest_positions[held] + [0.1, 0, 0], atol=1e-6)
    hold.release()
    sim.gravity = (0, -9.81, 0)
    sim.step(60)
    # The center of mass, at y = 0.25 before, falls freely for 60 steps: g dt^2 n (n + 1)/2.
    fallen = 9.81 / 120**2 * 60 * 61 / 2
    assert np.average(body.positions[:, 1], weights=body.masses) == pytest.approx(0.25 - fallen, abs=1e-4)
    with pytest.raises(ValueError, match="no keys"):
        hold.set_keys([])


def test_holds_lists_pins_and_handles_with_their_values(bar):
    body = supple.Body(bar, name="bar")
    assert body.holds == ()
    pin = body.pin(vertices=[4, 1], start=0.25)
    handle = body.handle(vertices=[7], keys=[(0,), {"time": 1, "rotate": (0, 90, 0)}], end=0.5)
    assert body.holds == (pin, handle)
    assert len({pin, handle, *body.holds}) == 2
    assert pin.vertices.tolist() == [1, 4]
    with pytest.raises(ValueError, match="read-only"):
        pin.vertices[0] = 3
    assert (pin.keys, pin.start, pin.end, pin.active, pin.released) == (None, 0.25, None, False, False)
    assert handle.keys == ((0, (0, 0, 0), (0, 0, 0)), (1, (0, 0, 0), (0, 90, 0)))
    assert (handle.start, handle.end) == (0, 0.5)
    assert repr(pin) == '<supple.Hold 0 of body "bar": pin on 2 lattice vertices, from 0.25 s on>'
    sim = _sim(body)
    sim.step(2)
    assert (pin.active, handle.active) == (False, True)
    what = "handle with 2 keys on 1 lattice vertex, from 0 to 0.5 s, active"
    assert repr(handle) == f'<supple.Hold 1 of body "bar": {what}>'
    sim.step(70)
    assert (pin.active, handle.active) == (True, False)
    assert body.holds == (pin, handle)


def test_a_released_hold_is_forgotten_and_says_so(bar):
    body = supple.Body(bar, name="bar")
    sim = _sim(body)
    first = body.pin(vertices=[1])
    sim.step()
    memory = repr(sim).split()[-2]
    size = len(pickle.dumps(sim))
    for step in range(1000):
        released = body.pin(vertices=[2])
        if step % 100 == 0:
            sim.step()
        released.release()
    last = body.handle(vertices=[3], keys=[(0,)])
    sim.step()
    assert repr(sim).split()[-2] == memory
    assert len(pickle.dumps(sim)) < size + 200
    assert body.holds == (first, last)
    released.release()
    assert (released.released, released.active, released.body) == (True, False, body)
    assert repr(released) == '<supple.Hold 1000 of body "bar": released>'
    message = r"the pin or handle was released; add another one with body\.pin\(\) or body\.handle\(\)"
    for use in (lambda: released.set_keys([(0,)]), *(lambda name=name: getattr(released, name) for name in NAMES)):
        with pytest.raises(ValueError, match=message):
            use()
    start = body.positions
    last.set_keys([(0, (0, 1, 0))])
    sim.step()
    assert np.allclose(body.positions[3], start[3] + [0, 1, 0], atol=1e-6)
    assert np.allclose(body.positions[1], bar.rest_positions[1], atol=1e-6)


def test_the_hold_that_was_added_last_moves_common_vertices(bar):
    body = supple.Body(bar)
    body.pin(vertices=[0, 1])
    body.handle(vertices=[1, 2], keys=[(0, (0, 1, 0))], end=0.1)
    sim = _sim(body)
    sim.step(12)
    up = [0, 1, 0]
    assert np.allclose(body.positions[:3], bar.rest_positions[:3] + [[0, 0, 0], up, up], atol=1e-6)
    sim.step()
    # After its end the pin holds the common vertex again.
    assert np.allclose(body.positions[:2], bar.rest_positions[:2], atol=1e-6)


def test_a_pin_can_be_added_between_steps(bar):
    body = supple.Body(bar)
    sim = _sim(body, gravity=(0, -9.81, 0))
    sim.step(20)
    pinned = body.positions
    body.pin(vertices=np.arange(len(bar)))
    sim.step(20)
    assert np.allclose(body.positions, pinned, atol=1e-6)


def test_selections_of_a_mesh_pin_the_cells_of_its_vertices(cube):
    body = supple.Body(cube, cell_size=0.5)
    body.pin(box=((0.9, 0.9, 0.9), (1.1, 1.1, 1.1)))
    _sim(body, gravity=(0, -9.81, 0)).step(30)
    still = np.linalg.norm(body.positions - body.lattice.rest_positions, axis=1) < 1e-6
    assert still.sum() == 8
    assert body.lattice.rest_positions[still].min() == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({}, TypeError, "needs one of box="),
        ({"box": ((0, 0, 0), (1, 1, 1)), "vertices": [0]}, TypeError, "box and vertices were given"),
        (
            {"box": ((9, 9, 9), (10, 10, 10))},
            ValueError,
            r"nothing of the body at frame 0: the nearest vertex is at \(2\.0+, 0\.50+, 0\.50+\), 13\.91",
        ),
        ({"box": ((1, 1, 1), (0, 0, 0))}, ValueError, "min 1 > max 0 along x; swap the two"),
        ({"box": ((0, 0, 0),)}, ValueError, r"box has 1 parts; it must be a pair \(min, max\)"),
        ({"box": 3}, TypeError, r"box must be a pair \(min, max\), not int"),
        ({"box": {"mim": (0, 0, 0), "max": (1, 1, 1)}}, ValueError, 'box has no key "mim"; the nearest one is "min"'),
        ({"box": ((0, np.nan, 0), (1, 1, 1))}, ValueError, r"box min\[1\] = NaN is not finite"),
        ({"sphere": ((0, 0, 0), -1)}, ValueError, "the sphere's radius is -1; it must be greater than 0"),
        ({"sphere": ((0, 0, 0), "1")}, TypeError, "sphere radius must be a number, not str"),
        ({"plane": ((0, 0, 0), (0, 0, 0))}, ValueError, "normal is zero; give the direction of the side to select"),
        ({"vertices": []}, ValueError, "list of vertices is empty; name at least one vertex"),
        ({"vertices": [0, 81]}, ValueError, "81 is out of range: the lattice has 81 vertices, 0 to 80"),
        ({"vertices": [-1]}, ValueError, "-1 is out of range: the lattice has 81 vertices, 0 to 80"),
        ({"vertices": np.array([2**64 - 1], np.uint64)}, ValueError, "18446744073709551615 is out of range"),
        ({"vertices": [True, False]}, ValueError, r"vertices has the shape \(2,\); it must be \(81,\)"),
        ({"vertices": [0], "start": None}, TypeError, "start must be a number, not None"),
        ({"vertices": [0.5]}, TypeError, r"vertices must be integers of shape \(k,\), .* float64"),
        ({"vertices": np.ones(3, bool)}, ValueError, r"vertices has the shape \(3,\); it must be \(81,\)"),
        ({"vertices": [0], "start": 2, "end": 1}, ValueError, "start is 2 and end is 1; .* end greater than start"),
        ({"vertices": [0], "endd": 1}, TypeError, '"endd"; the nearest one is "end"'),
    ],
)
def test_invalid_selections_are_errors(bar, arguments, error, message):
    body = supple.Body(bar)
    with pytest.raises(error, match=message):
        body.pin(**arguments)
    if "endd" not in arguments:
        with pytest.raises(error, match=message):
            body.handle(keys=[(0,)], **arguments)


@pytest.mark.parametrize(
    ("keys", "error", "message"),
    [
        ([], ValueError, "there are no keys; give at least one"),
        ([(0,), (0,)], ValueError, "key 1 is at time 0, which is not after key 0 at 0; sort the keys by time"),
        ([()], ValueError, r"keys\[0\] has 0 parts; it must be \(time, translate, rotate\)"),
        ([(0, (0, 0))], ValueError, r"keys\[0\]\.translate has the shape \(2,\); it must be \(3,\)"),
        ([(0, (0, 0, 0), (0, np.nan, 0))], ValueError, r"keys\[0\]\.rotate\[1\] = NaN is not finite"),
        ([("0",)], TypeError, r"keys\[0\]\.time must be a number, not str"),
        ([{"translate": (0, 0, 0)}], ValueError, r"keys\[0\] has no time"),
        ([{"time": 0, "rotat": (0, 0, 0)}], ValueError, r'keys\[0\] has no key "rotat"; the nearest one is "rotate"'),
        (3, TypeError, r"keys must be a list of \(time, translate, rotate\), not int"),
        ([3], TypeError, r"keys\[0\] must be \(time, translate, rotate\), not int"),
    ],
)
def test_invalid_keys_are_errors(bar, keys, error, message):
    with pytest.raises(error, match=message):
        supple.Body(bar).handle(vertices=[0], keys=keys)


def test_a_force_gives_its_impulse_once(bar):
    body = supple.Body(bar)
    sim = _sim(body)
    body.apply_force((6, 0, 3), plane=((1, 0, 0), (1, 0, 0)))
    body.apply_force((-3, 0, 0), vertices=[0, 5])
    sim.step()
    momentum = (body.masses[:, None] * body.velocities).sum(axis=0)
    assert np.allclose(momentum, np.array([3, 0, 3]) / 120, rtol=1e-5, atol=1e-7)
    sim.step(100)
    momentum = (body.masses[:, None] * body.velocities).sum(axis=0)
    assert np.allclose(momentum, np.array([3, 0, 3]) / 120, rtol=1e-4, atol=1e-6)


def test_a_force_against_gravity_balances_it_and_invalid_forces_are_errors(bar):
    body = supple.Body(bar, density=100)
    sim = _sim(body, gravity=(0, -9.81, 0))
    for _ in range(60):
        body.apply_force((0, 9.81 * body.masses.sum(), 0), vertices=np.arange(len(bar)))
        sim.step()
    assert np.allclose(body.positions, bar.rest_positions, atol=1e-4)
    with pytest.raises(ValueError, match=r"force\[0\] = NaN is not finite"):
        body.apply_force((np.nan, 0, 0), vertices=[0])
    with pytest.raises(
        ValueError, match=r"force = 1e300 is out of range: it must be finite, and accelerate by at most 1e15 cells/s\^2"
    ):
        body.apply_force((1e300, 0, 0), vertices=[0])
    with pytest.raises(ValueError, match="the sphere selects nothing of the body at frame 0: the nearest vertex is at"):
        body.apply_force((1, 0, 0), sphere=((9, 9, 9), 1))


def test_a_hold_carries_the_weight_of_a_hanging_bar():
    lattice = supple.Lattice.from_cells(np.ones((3, 12, 3)), cell_size=0.1)
    body = supple.Body(lattice)
    hold = body.pin(vertices=lattice.rest_positions[:, 1] > 1.15)
    with pytest.raises(ValueError, match="force depends on the step length and the gravity"):
        _ = hold.force
    sim = supple.Simulation([body], fps=30, substeps="auto")
    assert not hold.force.any()
    sim.advance(150)
    # The limit of sleep leaves an error of less than the part of the deformation that has not decayed.
    assert hold.force == pytest.approx([0, 9.81 * body.mass, 0], rel=0.01, abs=0.01 * 9.81 * body.mass)
    assert np.abs(hold.torque).max() < 0.01 * 9.81 * body.mass
    hold.release()
    with pytest.raises(ValueError, match="was released"):
        _ = hold.torque


def test_masks_of_numbers_are_masks(bar):
    mask = bar.rest_positions[:, 0] < 0.3
    expected = np.flatnonzero(mask)
    for dtype in (bool, np.uint8, np.int64):
        body = supple.Body(bar)
        assert np.array_equal(body.pin(vertices=mask.astype(dtype)).vertices, expected)
    body = supple.Body(bar)
    assert body.pin(vertices=[0, 1]).vertices.tolist() == [0, 1]
    with pytest.raises(ValueError, match=f"vertices has 5 entries, all of them 0 or 1: a mask has .* {len(bar)} "):
        body.pin(vertices=[0, 1, 1, 0, 1])


def test_shapes_select_where_the_body_is_or_where_it_started(bar):
    body = supple.Body(bar, velocity=(2, 0, 0))
    sim = _sim(body)
    left = ((-0.1, -1, -1), (0.1, 1, 1))
    before = body.handle(box=left, keys=[(0,)], start=100).vertices
    assert np.array_equal(before, np.flatnonzero(bar.rest_positions[:, 0] == 0))
    sim.step(60)
    moved = ((0.9, -1, -1), (1.1, 1, 1))
    assert np.array_equal(body.pin(box=moved, start=100).vertices, before)
    assert np.array_equal(body.pin(box=left, at="start", start=100).vertices, before)
    field = body.add_force_field((1, 0, 0), box=moved)
    assert np.array_equal(field.vertices, before)
    with pytest.raises(ValueError, match=r"the box selects nothing of the body as it is now: .* at \(1\.0"):
        body.pin(box=left)
    with pytest.raises(ValueError, match="the box selects nothing of the body at frame 0: "):
        body.pin(box=((5, 5, 5), (6, 6, 6)), at="start")
    body.zone(0.5, box=moved)
    assert np.array_equal(np.flatnonzero(body.stiffness_factors == 0.5), before)


def test_a_shape_on_a_mesh_selects_where_the_mesh_is(cube):
    body = supple.Body(cube, lattice_vertices=300, velocity=(0, 0, 3), spin=(0, 0, 0))
    sim = _sim(body)
    top = body.pin(plane=((0, 0, 0.5), (0, 0, 1)), start=100).vertices
    sim.step(120)
    assert np.array_equal(body.pin(plane=((0, 0, 3.5), (0, 0, 1)), start=100).vertices, top)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda body: body.pin(vertices=[0], at="now"), TypeError, "pin.. has at only together with a shape"),
        (lambda body: body.apply_force((0, 0, 1), at="now"), TypeError, "apply_force.. has at only together"),
        (lambda body: body.pin(box=((0, 0, 0), (1, 1, 1)), at="then"), ValueError, 'it must be "start" or "now"'),
        (
            lambda body: body.handle(box=((-2, -2, -2), (2, 2, 2)), follow=np.zeros((2, 8, 3)), at="now"),
            ValueError,
            'follow has only at="start"',
        ),
    ],
)
def test_poses_of_selections_that_do_not_apply_are_errors(cube, call, error, message):
    with pytest.raises(error, match=message):
        call(supple.Body(cube, lattice_vertices=300))
