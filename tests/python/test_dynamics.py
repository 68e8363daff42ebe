"""Motion: free fall, placement, setters, changes between steps."""

import gc
import pickle
import re
import weakref

import numpy as np
import pytest

import supple

GRAVITY = np.array([0, -9.81, 0])


def test_free_fall(block):
    body = supple.Body(block, velocity=(1, 2, 3))
    sim = supple.Simulation([body], dt=0.01)
    start = body.positions
    sim.step(100)
    # v += g dt, then x += v dt: the sum of 1 to n.
    fallen = GRAVITY * 0.01**2 * 100 * 101 / 2
    assert np.allclose(body.positions, start + np.array([1, 2, 3]) + fallen, rtol=0, atol=1e-6)
    assert np.allclose(body.velocities, np.array([1, 2, 3]) + GRAVITY, rtol=0, atol=1e-4)
    assert sim.time == 100 * 0.01


def test_placement_follows_the_order_scale_rotate_translate(cube):
    body = supple.Body(
        cube, cell_size=0.5, scale=2, rotate=(90, 0, 90), translate=(1, 2, 3), velocity=(0, 1, 0), spin=(0, 0, 2)
    )
    x, y, z = (2 * cube.vertices).T
    turned = np.stack([z, x, y], axis=1)  # about x: y -> z, then about z: x -> y
    assert np.allclose(body.surface(), turned + [1, 2, 3], atol=1e-6)
    arms = body.positions - [1, 2, 3]
    spin = np.cross([0, 0, 2], arms)
    assert np.allclose(body.velocities, spin + [0, 1, 0], atol=1e-5)
    assert np.allclose(body.rotations, [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-6)


def test_a_bare_lattice_is_scaled_too(block):
    body = supple.Body(block, scale=2, translate=(0, 0, 1))
    assert np.allclose(body.positions, 2 * block.rest_positions + [0, 0, 1], atol=1e-6)
    assert body.lattice.cell_size == 1


def test_masses(block):
    body = supple.Body(block, density=12)
    assert body.masses.sum() == pytest.approx(12 * 0.5**3 * 4 * 3 * 2, rel=1e-12)
    corner = body.masses[0]
    assert corner == pytest.approx(12 * 0.5**3 / 8, rel=1e-12)
    assert body.masses.max() == pytest.approx(4 * 2 * corner, rel=1e-12)


def test_positions_and_velocities_are_set_independently(block):
    body = supple.Body(block)
    sim = supple.Simulation([body], gravity=(0, 0, 0))
    velocities = np.random.default_rng(0).normal(size=(len(body), 3))
    body.velocities = velocities
    body.positions = body.positions + [5, 0, 0]
    assert np.allclose(body.velocities, velocities, atol=1e-6)
    body.velocities = 0 * velocities
    assert np.allclose(body.positions, block.rest_positions + [5, 0, 0], atol=1e-6)
    sim.step(50)
    assert np.allclose(body.positions, block.rest_positions + [5, 0, 0], atol=1e-5)
    body.velocities = body.velocities + [1, 0, 0]
    sim.step(60)
    assert np.allclose(body.positions, block.rest_positions + [6, 0, 0], atol=1e-5)


def test_evaluating_a_body_changes_no_bit(cube):
    bodies = [supple.Body(cube, lattice_vertices=200, half_width=2, region_damping=0.2) for _ in range(2)]
    sims = [supple.Simulation([body], colliders=[supple.Plane((0, -2, 0), (0, 1, 0))], threads=1) for body in bodies]
    for _ in range(60):
        for sim in sims:
            sim.step()
        for method in (
            "goals",
            "surface",
            "surface_normals",
            "surface_velocities",
            "corrected_positions",
            "volume_report",
        ):
            getattr(bodies[0], method)()
    for name in ("positions", "velocities", "rotations"):
        assert getattr(bodies[0], name).tobytes() == getattr(bodies[1], name).tobytes()


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_no_bit(threads):
    lattice = supple.Lattice.from_cells(np.random.default_rng(4).random((30, 30, 30)) < 0.7)
    results = []
    for count in (1, threads):
        bodies = [supple.Body(lattice, region_damping=0.1, half_width=w, spin=(0, 1, 2)) for w in (1, 4)]
        sim = supple.Simulation(bodies, threads=count, contact=False, colliders=[supple.Sphere((15, -5, 15), 8)])
        sim.step(20)
        assert sim.threads == count
        results.append([body.positions.tobytes() for body in bodies])
    assert results[0] == results[1]


def test_dt_time_and_gravity_can_be_set(block):
    body = supple.Body(block, half_width=2, damping_ratio=0)
    sim = supple.Simulation([body], dt=0.1, gravity=[0, 0, 0])
    sim.step(10)
    sim.dt = 0.25
    assert sim.dt == 0.25
    assert sim.time == 1
    sim.gravity = (1, 0, 0)
    assert sim.gravity.tolist() == [1, 0, 0]
    sim.step(4)
    assert sim.time == 2
    assert np.allclose(body.velocities, [1, 0, 0], atol=1e-5)
    sim.time = 10
    sim.step(2)
    assert sim.time == 10.5
    for name, value, error in [
        ("dt", 0, ValueError),
        ("dt", np.nan, ValueError),
        ("dt", "x", TypeError),
        ("time", np.inf, ValueError),
        ("gravity", (0, np.nan, 0), ValueError),
        ("gravity", (0, 0), ValueError),
        ("gravity", "down", TypeError),
    ]:
        with pytest.raises(error, match=f"^{name}"):
            setattr(sim, name, value)
    assert (sim.dt, sim.time) == (0.25, 10.5)


def test_stiffness_and_damping_can_be_set(block):
    body = supple.Body(block, frequency=5, region_damping_rate=2)
    assert (body.material, body.half_width) == (None, 2)
    assert (body.stiffness, body.frequency) == (None, 5)
    assert (body.region_damping, body.region_damping_rate) == (None, 2)
    body.stiffness = 0.5
    body.region_damping = 0.25
    assert (body.stiffness, body.frequency) == (0.5, None)
    assert (body.region_damping, body.region_damping_rate) == (0.25, None)
    body.frequency = 3
    body.region_damping_rate = 0
    assert (body.frequency, body.region_damping_rate) == (3, 0)
    for name, value in [
        ("stiffness", 0),
        ("stiffness", 1.1),
        ("frequency", 0),
        ("region_damping", -1),
        ("region_damping_rate", -1),
    ]:
        with pytest.raises(ValueError, match=f"{name} = "):
            setattr(body, name, value)
    for name in ("stiffness", "frequency", "region_damping", "region_damping_rate", "half_width", "stiffness_radius"):
        for value in ("x", None, True):
            with pytest.raises(TypeError, match=f"^{name} must be a .*number, not"):
                setattr(body, name, value)


def test_half_width_can_be_set(block):
    body = supple.Body(block, half_width=1)
    body.half_width = np.int8(3)
    assert (body.half_width, body.stiffness_radius) == (3, None)
    body.stiffness_radius = 1.0
    assert (body.half_width, body.stiffness_radius) == (2, 1.0)
    body.half_width = 0.5
    assert (body.half_width, len(body.rotations)) == (0.5, len(block))
    body.half_width = 100
    assert body.half_width == 4
    for value in (0, -1):
        with pytest.raises(
            ValueError, match=f"half_width = {value} is out of range: it must be 0.5 or a whole number of"
        ):
            body.half_width = value
    with pytest.raises(ValueError, match="stiffness_radius = 0 is out of range: it must be a length > 0"):
        body.stiffness_radius = 0
    assert body.half_width == 4


def test_settings_changed_later_equal_settings_of_the_constructor(block):
    stretched = block.rest_positions * [1.3, 1, 1]
    given = supple.Body(block, stiffness=0.4, region_damping=0.3, half_width=3)
    later = supple.Body(block)
    later.stiffness, later.region_damping, later.half_width = 0.4, 0.3, 3
    for body in (given, later):
        sim = supple.Simulation([body])
        body.positions = stretched
        sim.step(20)
    assert given.positions.tobytes() == later.positions.tobytes()


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"half_width": 0}, ValueError, "half_width = 0 is out of range: it must be 0.5 or a whole number of cells"),
        ({"half_width": 1.5}, ValueError, "half_width = 1.5 is out of range: it must be 0.5 or a whole number"),
        ({"half_width": True}, TypeError, "half_width must be a number, not bool"),
        ({"half_width": 10**400}, ValueError, "half_width is too large for a float"),
        ({"stiffness": 0}, ValueError, r"stiffness = 0 is out of range: it must be in \(0, 1\]"),
        ({"stiffness": np.nan}, ValueError, r"stiffness = NaN is out of range: it must be in \(0, 1\]"),
        ({"stiffness": "soft"}, TypeError, "stiffness must be a number, not str"),
        ({"region_damping": 1.1}, ValueError, r"region_damping = 1\.1 is out of range: it must be in \[0, 1\]"),
        ({"density": -1}, ValueError, "density = -1 is out of range: it must be a number above 0"),
        ({"stiffness_radius": 0}, ValueError, "stiffness_radius = 0 is out of range: it must be a length > 0"),
        ({"stiffness": 1, "frequency": 3}, ValueError, "stiffness and frequency are mutually exclusive"),
        ({"material": "wood"}, ValueError, 'material is "wood"; it must be one of "jelly", "flesh", "rubber", "firm"'),
        ({"material": 3}, TypeError, "material must be a string, not int"),
        ({"youngs_modulus": 0}, ValueError, "youngs_modulus = 0 is out of range: it must be a force per area > 0"),
        ({"damping_ratio": 1.1}, ValueError, r"damping_ratio = 1\.1 is out of range: it must be in \[0, 1\]"),
        ({"damping_rate": -1}, ValueError, "damping_rate = -1 is out of range: it must be a rate in 1/s, >= 0"),
        ({"material": "firm", "youngs_modulus": 1}, ValueError, "material and youngs_modulus are mutually exclusive"),
        ({"material": "firm", "half_width": 2}, ValueError, "material and half_width are mutually exclusive"),
        ({"youngs_modulus": 1, "stiffness": 1}, ValueError, "youngs_modulus and stiffness are mutually exclusive"),
        ({"frequency": 1, "youngs_modulus": 1}, ValueError, "youngs_modulus and frequency are mutually exclusive"),
        ({"damping_ratio": 0, "damping_rate": 0}, ValueError, "damping_ratio and damping_rate are mutually exclusive"),
        (
            {"region_damping": 0, "region_damping_rate": 3},
            ValueError,
            "region_damping and .*_rate are mutually exclusive",
        ),
        (
            {"half_width": 1, "stiffness_radius": 3},
            ValueError,
            "half_width and stiffness_radius are mutually exclusive",
        ),
        ({"velocity": (0, np.inf, 0)}, ValueError, r"velocity\[1\] = inf is not finite"),
        ({"spin": 3}, ValueError, r"spin is 3; it must be three numbers in one argument, such as \(0, 0, 1\)"),
        ({"scale": 0}, ValueError, "scale = 0 is out of range: it must be a number above 0, or three"),
        ({"scale": np.inf}, ValueError, "scale = inf is out of range: it must be a number above 0, or three"),
        ({"name": 3}, TypeError, "name must be a string, not int"),
        ({"lattice_vertices": 100}, ValueError, "lattice_vertices is for a mesh"),
        ({"halfwidth": 3}, TypeError, '"halfwidth"; the nearest one is "half_width"'),
        ({"density": None}, TypeError, "density must be a number, not None"),
        ({"density": True}, TypeError, "density must be a number, not bool"),
        ({"spin": None}, TypeError, r"spin must be numbers of shape \(3,\), not NoneType"),
    ],
)
def test_invalid_settings_are_errors(block, settings, error, message):
    with pytest.raises(error, match=message):
        supple.Body(block, **settings)


def test_numpy_scalars_are_numbers(block):
    body = supple.Body(block, half_width=np.int8(1), stiffness=np.float32(0.5), density=np.array(2.0))
    assert body.half_width == 1
    assert body.density == 2
    sim = supple.Simulation([body], dt=np.float64(0.5), gravity=(0, 0, 0))
    sim.step(np.int64(2))
    assert sim.time == 1
    for n, error, message in [
        (-1, ValueError, "n = -1 is out of range: it must be a whole number, at least 0"),
        (1.0, TypeError, "n must be a whole number, not float"),
        ("3", TypeError, "n must be a whole number, not str"),
        (None, TypeError, "n must be a whole number, not None"),
        (10**30, ValueError, r"n = 10+ is out of range: it must be a whole number, at least 0, and below 2\^63"),
        (-(10**30), ValueError, r"n = -10+ is out of range: it must be a whole number, at least 0$"),
    ]:
        with pytest.raises(error, match=message):
            sim.step(n)


def test_a_body_belongs_to_one_simulation(block):
    body, other = supple.Body(block), supple.Body(block)
    sim = supple.Simulation([body])
    assert sim.bodies == (body,)
    with pytest.raises(ValueError, match=r"bodies\[1\] already belongs to a simulation, its `simulation`, or"):
        supple.Simulation([other, body])
    with pytest.raises(ValueError, match=r"bodies\[1\] is the same Body as bodies\[0\]"):
        supple.Simulation([other, other])
    with pytest.raises(ValueError, match="dt = -1 is out of range: it must be a time in seconds, from 1e-12 to 1e6"):
        supple.Simulation([other], dt=-1)
    with pytest.raises(ValueError, match="at least one body"):
        supple.Simulation([])
    with pytest.raises(TypeError, match=r"bodies\[0\] must be a Body, not str"):
        supple.Simulation("body")
    # After these errors the other body still has no simulation, and the first simulation still works.
    supple.Simulation([other]).step()
    sim.step()
    assert body.positions[0, 1] < block.rest_positions[0, 1]


def test_a_body_keeps_its_simulation_alive(block):
    body = supple.Body(block)
    assert body.simulation is None
    supple.Simulation([body, supple.Body(block, name="other")]).step(10)
    gc.collect()
    goals = supple.reference.goals(block, body.positions, body.half_width)
    assert np.abs(body.goals() - goals).max() <= 1e-5 * block.cell_size
    with pytest.raises(ValueError, match="already belongs"):
        supple.Simulation([body])
    sim = body.simulation
    assert sim is body.simulation
    assert sim.bodies[0] is body
    assert sim.bodies[1].name == "other"
    assert sim.bodies[1].simulation is sim
    before = sim.bodies[1].positions
    body.simulation.step()
    assert not np.array_equal(sim.bodies[1].positions, before)


def test_a_simulation_is_freed_with_its_last_body(block):
    gc.disable()
    try:
        body = supple.Body(block)
        sim = supple.Simulation([body])
        references = [weakref.ref(sim), weakref.ref(body), weakref.ref(sim.bodies[0])]
        del sim
        assert all(reference() is not None for reference in references)
        del body
        assert all(reference() is None for reference in references)
    finally:
        gc.enable()


def test_repr_and_plan(block, cube):
    assert repr(block) == "<supple.Lattice: 60 vertices, 24 cells of 0.5000, 3 kB>"
    body = supple.Body(cube, name="die", lattice_vertices=125)
    assert '"die": 125 lattice vertices, 64 cells' in repr(body)
    assert "half-width 2" in repr(body)
    assert "mesh of 8 vertices" in repr(body)
    assert re.search(r"0\.\d MB>", repr(body))
    assert re.match(
        r"<supple.Simulation: 1 body of 125 lattice vertices, time 0\.0000 s.* MB>", repr(supple.Simulation([body]))
    )
    header, total, *lines, left_out = supple.Simulation([supple.Body(cube, half_width=2)]).plan().splitlines()
    assert "threads: " in header
    stages = [
        "momentum tracker",
        "elastic damping",
        "shape matching",
        "integration",
        "volume correction",
        "mesh update",
    ]
    assert [[name for name in stages if name in line] for line in lines] == [[name] for name in stages]
    names = "inflation, region damping, fracture, external forces, contact of bodies, contacts, pins and handles"
    assert left_out == f"  left out: {names}"
    # The total also has the lattice and the state, which are not stages.
    kilobytes = [float(re.search(r"([\d.]+) kB$", line)[1]) for line in lines]
    assert 0 < sum(kilobytes) < 1000 * float(re.search(r"([\d.]+) MB$", total)[1])


def test_gravity_takes_keyframes_and_reads_the_value_in_force(block):
    keys = [(0, (0, -8, 0)), {"time": 1, "value": [4, 0, 0]}]
    for gravity in (keys, {"keys": keys, "interpolation": "linear"}):
        sim = supple.Simulation([supple.Body(block)], dt=1 / 128, gravity=gravity)
        np.testing.assert_array_equal(sim.gravity, [0, -8, 0])
        sim.step(64)
        np.testing.assert_array_equal(sim.gravity, [2, -4, 0])
    body = sim.bodies[0]
    # The sum of the gravity at the starts of the steps: the mean of the first and the last one times 1/2 s.
    expected = np.mean([[0, -8, 0], [2 * 63 / 64, -8 + 4 * 63 / 64, 0]], axis=0) / 2
    np.testing.assert_allclose(body.linear_momentum / body.mass, expected, atol=1e-5)
    state = sim.save_state()
    sim.gravity = (1, 2, 3)
    np.testing.assert_array_equal(sim.gravity, [1, 2, 3])
    sim.restore_state(state)
    np.testing.assert_array_equal(sim.gravity, [2, -4, 0])
    sim.gravity = [(0.25, (0, 1, 0)), (0.75, (0, 3, 0))]
    np.testing.assert_array_equal(sim.gravity, [0, 2, 0])
    twin = pickle.loads(pickle.dumps(sim))
    sim.step(64)
    twin.step(64)
    np.testing.assert_array_equal(twin.gravity, [0, 3, 0])
    np.testing.assert_array_equal(twin.bodies[0].positions, body.positions)
    for gravity, error, message in [
        ([(0, (0, 1))], TypeError, r"gravity\[0\].value must be a list of three numbers"),
        ([(0, 1)], TypeError, r"gravity\[0\].value must be a list of three numbers, not int"),
        ([(0,)], ValueError, r"gravity\[0\] must be \(time, value\)"),
        ([(1, (0, 0, 0)), (1, (0, 0, 0))], ValueError, "not after key 0 at 1"),
        ([(0, (0, 2e12, 0))], ValueError, "gravity = 2000000000000"),
        ({"key": 1}, ValueError, 'gravity has no key "key"'),
        ((0, 1), ValueError, "gravity"),
        ((0, np.nan, 1), ValueError, "gravity"),
    ]:
        with pytest.raises(error, match=message):
            sim.gravity = gravity
        with pytest.raises(error, match=message):
            supple.Simulation([supple.Body(block)], gravity=gravity)
