"""Material, damping, mass, momenta and energies of a body."""

import copy
import pickle
import warnings

import numpy as np
import pytest

import supple


@pytest.fixture
def bar():
    """A bar of 20 x 2 x 2 cells of edge 0.1 along x."""
    return supple.Lattice.from_cells(np.ones((20, 2, 2), bool), cell_size=0.1)


def test_the_default_material_is_flesh(block):
    body = supple.Body(block)
    assert (body.material, body.damping_ratio, body.damping_rate) == ("flesh", 0.3, None)
    assert (body.stiffness, body.frequency, body.stiffness_radius) == (None, None, None)
    assert (supple.Body(block, material="jelly").damping_ratio, supple.Body(block, half_width=3).damping_ratio) == (
        0.1,
        0.2,
    )


@pytest.mark.parametrize(("name", "k"), [("jelly", 20), ("flesh", 80), ("rubber", 300), ("firm", 1500)])
def test_a_named_material_has_the_modulus_of_the_size_and_the_gravity(block, name, k):
    body = supple.Body(block, material=name, density=700)
    supple.Simulation([body], fps=30, gravity=(0, 0, -20))
    size = np.cbrt(24 * 0.5**3)
    assert body.youngs_modulus == pytest.approx(k * 700 * size * max(20, 8 * size), rel=1e-9)
    assert body.material == name


def test_youngs_modulus_outside_a_simulation_is_the_value_that_was_set(block):
    assert supple.Body(block, youngs_modulus=2e5).youngs_modulus == 2e5
    for settings in ({}, {"half_width": 3}):
        body = supple.Body(block, **settings)
        with pytest.raises(
            ValueError, match=r"youngs_modulus was not set, so .* set body.youngs_modulus, or build a Sim"
        ):
            _ = body.youngs_modulus
        body.youngs_modulus = 3
        assert (body.youngs_modulus, body.material) == (3, None)


def test_material_and_regions_replace_each_other(block):
    body = supple.Body(block)
    body.half_width = 3
    assert (body.material, body.half_width, body.stiffness) == (None, 3, 1)
    body.material = "firm"
    assert (body.material, body.stiffness, body.damping_ratio) == ("firm", None, 0.2)
    body.youngs_modulus = 1e5
    body.frequency = 4
    assert (body.material, body.frequency, body.half_width) == (None, 4, 2)
    body.damping_rate = 3
    assert (body.damping_ratio, body.damping_rate) == (None, 3)
    body.damping_ratio = 0
    assert (body.damping_ratio, body.damping_rate) == (0, None)
    for name, value, error in [
        ("material", "wood", ValueError),
        ("material", None, TypeError),
        ("youngs_modulus", -1, ValueError),
        ("youngs_modulus", "1", TypeError),
        ("damping_ratio", 2, ValueError),
        ("damping_rate", -1, ValueError),
        ("density", 0, ValueError),
        ("density", None, TypeError),
    ]:
        with pytest.raises(error, match=name):
            setattr(body, name, value)


def test_a_material_set_later_equals_that_of_the_constructor(block):
    given = supple.Body(block, youngs_modulus=2e5, damping_rate=2, density=500)
    later = supple.Body(block)
    later.youngs_modulus, later.damping_rate, later.density = 2e5, 2, 500
    for body in (given, later):
        sim = supple.Simulation([body], dt=0.01)
        body.positions = block.rest_positions * [1.1, 1, 1]
        sim.step(20)
    assert given.positions.tobytes() == later.positions.tobytes()


def test_the_lowest_frequency_of_a_bar_is_that_of_its_bending(bar):
    body = supple.Body(bar, youngs_modulus=2e5)
    with pytest.raises(ValueError, match=r"lowest_frequency depends on .* build a Simulation with the body"):
        _ = body.lowest_frequency
    supple.Simulation([body], dt=0.001)
    # Free-free Euler-Bernoulli beam, thickness t = 0.2, length l = 2, E/rho = 200; shear and the size of the regions
    # change it by the order of (t/l)^2 pi^2 and of 0.6 R^2/t^2 with R <= 0.15 here.
    beam = 4.730**2 / (2 * np.pi * 2**2) * np.sqrt(200 * 0.2**2 / 12)
    assert body.lowest_frequency == pytest.approx(beam, rel=0.5)


@pytest.mark.parametrize("half_width", [1, 2, 4])
def test_the_lowest_frequency_is_that_of_the_smallest_eigenvalue(block, half_width):
    body = supple.Body(block, half_width=half_width)
    supple.Simulation([body], dt=0.01)
    rest, eps = block.rest_positions, 0.01
    columns = []
    for entry in range(rest.size):
        change = np.zeros(rest.size)
        change[entry] = eps
        goals = []
        for sign in (1, -1):
            body.positions = rest + sign * change.reshape(rest.shape)
            goals.append(body.goals())
        columns.append((change - (goals[0] - goals[1]).ravel() / 2) / eps)
    # Symmetric after scaling by the square roots of the masses; six eigenvalues belong to rigid motions.
    scale = np.repeat(np.sqrt(body.masses), 3)
    matrix = np.array(columns).T * scale[:, None] / scale
    smallest = np.linalg.eigvalsh((matrix + matrix.T) / 2)[6]
    assert body.lowest_frequency == pytest.approx(np.sqrt(smallest) / (2 * np.pi * 0.01), rel=0.02)
    if half_width == 4:  # one region
        assert body.lowest_frequency == pytest.approx(1 / (2 * np.pi * 0.01), rel=1e-3)


def test_the_damping_rate_is_the_decay_of_the_amplitude(bar):
    body = supple.Body(bar, youngs_modulus=2e5, damping_rate=4)
    sim = supple.Simulation([body], dt=0.001, gravity=(0, 0, 0), sleep=False)
    body.positions = bar.rest_positions * [1.02, 1, 1]
    energies = []
    for _ in range(2):
        energies.append(sum(body.kinetic_energy + body.elastic_energy for _ in range(200) if sim.step() is None))
    # Sums over 0.2 s, 0.2 s apart; the energy decays at twice the rate of the amplitude.
    assert np.log(energies[0] / energies[1]) / (2 * 0.2) == pytest.approx(4, rel=0.1)


def test_a_material_out_of_reach_warns_once(block):
    body = supple.Body(block, name="brick", youngs_modulus=1e9)
    sim = supple.Simulation([body], dt=0.01)
    in_force = body.youngs_modulus
    assert in_force < 1e9
    asked = "youngs_modulus = 1.0000e9 needs shorter steps than 1.000e-2 s"
    way_out = 'build the Simulation with fps= and substeps="auto", or with dt of at most (.*)'
    with pytest.warns(supple.MaterialWarning, match=f'body "brick" is softer than its material: {asked}') as caught:
        sim.step(3)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert f"{in_force:.4e}".replace("e+0", "e") in str(caught[0].message)
    assert sim.step(3) is None
    sim.dt = 0.005
    with pytest.warns(supple.MaterialWarning, match=way_out) as caught:
        sim.step()
    sim.dt = float(str(caught[0].message).rsplit(maxsplit=1)[1]) * 0.999
    sim.step()
    assert body.youngs_modulus == pytest.approx(1e9)
    sim.dt = 0.005
    with pytest.warns(supple.MaterialWarning):
        sim.step()
    body.youngs_modulus = 2e9
    with pytest.warns(supple.MaterialWarning, match=r"= 2\.0000e9"):
        sim.step()


def test_warnings_name_frequency_material_and_substeps(block):
    soft = supple.Body(block, frequency=20)
    with pytest.warns(supple.MaterialWarning, match=r"frequency = 20 Hz .* 10\.0+ Hz is in force"):
        supple.Simulation([soft]).step()
    body = supple.Body(block, material="firm", poisson_ratio=0)
    sim = supple.Simulation([body], fps=5, substeps=1)
    with pytest.warns(supple.MaterialWarning, match='material "firm".*set substeps to "auto" or to at least') as caught:
        sim.advance()
    sim.substeps = int(str(caught[0].message).rsplit(maxsplit=1)[1])
    sim.advance()
    other = supple.Body(block, material="firm", poisson_ratio=0)
    supple.Simulation([other], fps=5).advance()
    assert body.youngs_modulus == pytest.approx(other.youngs_modulus, rel=1e-9)


def test_a_warning_as_an_error_is_raised_by_the_step(block):
    sim = supple.Simulation([supple.Body(block, frequency=20)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(supple.MaterialWarning):
            sim.step()
        sim.step()


def test_mass_momenta_and_energies(block):
    body = supple.Body(block, half_width=2, density=12, velocity=(1, 2, -3), spin=(0, 0, 2))
    for name in ("elastic_energy", "gravity_energy"):
        with pytest.raises(ValueError, match=f"{name} depends on the step length and the gravity of a simulation"):
            getattr(body, name)
    supple.Simulation([body], gravity=(0, -10, 0))
    mass, center = 12 * 24 * 0.5**3, np.array([2, 2.75, 3.5])
    arms = body.positions - center
    assert body.mass == pytest.approx(mass)
    assert np.allclose(body.center_of_mass, center, atol=1e-6)
    assert np.allclose(body.linear_momentum, mass * np.array([1, 2, -3]), rtol=1e-6)
    moment = (body.masses[:, None] * np.cross(arms, body.velocities - [1, 2, -3])).sum(axis=0)
    assert np.allclose(body.angular_momentum, moment, atol=1e-5)
    assert body.kinetic_energy == pytest.approx((body.masses * (body.velocities**2).sum(axis=1)).sum() / 2)
    assert body.gravity_energy == pytest.approx(mass * 10 * 2.75)
    assert 0 <= body.elastic_energy < 1e-9
    assert not body.center_of_mass.flags.writeable
    body.density = 24
    assert body.mass == pytest.approx(2 * mass)


def test_the_elastic_energy_of_a_stretched_bar(bar):
    body = supple.Body(bar, youngs_modulus=2e5, accuracy="fast")
    supple.Simulation([body], dt=0.001)
    body.positions = bar.rest_positions * [1.01, 1, 1]
    # 4 w of 20 cells are near the ends.
    expected = 0.5 * 2e5 * 0.01**2 * 20 * 2 * 2 * 0.1**3
    assert body.half_width == 1
    assert body.elastic_energy == pytest.approx(expected, rel=4 / 20)


@pytest.mark.parametrize("again", [copy.deepcopy, lambda body: pickle.loads(pickle.dumps(body))])
def test_a_copied_body_keeps_its_material(block, again):
    body = supple.Body(block, material="flesh", damping_rate=2)
    twin = again(body)
    assert (twin.material, twin.damping_rate, twin.damping_ratio) == ("flesh", 2, None)
    body.youngs_modulus, body.density = 4e4, 300
    twin = again(body)
    assert (twin.material, twin.youngs_modulus, twin.density) == (None, 4e4, 300)


def test_zones_and_factors_change_the_stiffness_of_parts(bar):
    body = supple.Body(bar, youngs_modulus=1e5)
    assert body.stiffness_factors is None
    body.zone(4, plane=((1, 0, 0), (1, 0, 0)))
    body.zone(0.5, vertices=[0])
    factors, x = body.stiffness_factors, bar.rest_positions[:, 0]
    assert np.all(factors[x > 1 - 1e-9] == 4)
    assert factors[0] == 0.5
    assert np.all(factors[(x < 0.9 - 1e-9) & (np.arange(len(bar)) > 0)] == 1)
    assert not factors.flags.writeable
    copied = pickle.loads(pickle.dumps(body))
    np.testing.assert_array_equal(copied.stiffness_factors, factors)
    body.set_stiffness_factors(None)
    assert body.stiffness_factors is None
    for bad, words in [
        (np.ones(3), r"factors has the shape \(3,\); it must be \(189,\)"),
        (np.full(len(bar), np.nan), "factors"),
        (np.zeros(len(bar)), r"\(0, 100\]"),
    ]:
        with pytest.raises(ValueError, match=words):
            body.set_stiffness_factors(bad)
    with pytest.raises(ValueError, match="selects nothing"):
        body.zone(2, sphere=((9, 9, 9), 1))
    with pytest.raises(TypeError, match="needs one of box="):
        body.zone(2)


def test_the_softer_half_of_a_bar_stretches_more(bar):
    body = supple.Body(bar, youngs_modulus=1e5, damping_ratio=1)
    x = bar.rest_positions[:, 0]
    body.set_stiffness_factors(np.where(x > 1, 0.2, 1.0))
    body.pin(vertices=x < 0.05)
    body.handle(vertices=x > 1.95, keys=[(0, (0, 0, 0)), (0.5, (0.2, 0, 0))])
    sim = supple.Simulation([body], fps=30, substeps="auto", gravity=(0, 0, 0))
    sim.advance(120)
    left, right = (np.ptp(body.positions[(x > a) & (x < a + 0.45), 0]) - 0.4 for a in (0.27, 1.27))
    assert 0 < 3 * left < right


def test_poisson_ratio_is_set_by_arguments_scenes_and_between_steps(block, bust, tmp_path):
    body = supple.Body(block, youngs_modulus=1e7, poisson_ratio=0.45)
    plain = supple.Body(block, youngs_modulus=1e7)
    assert (body.poisson_ratio, plain.poisson_ratio) == (0.45, 0)
    sims = [supple.Simulation(each, fps=30, gravity=(0, 0, 0)) for each in (plain, body)]
    plain_steps, steps = (sim.steps_per_frame for sim in sims)
    assert steps > 1.5 * plain_steps
    twin = copy.deepcopy(sims[1])
    assert twin.bodies[0].poisson_ratio == 0.45
    plain.poisson_ratio = 0.3
    assert plain.poisson_ratio == 0.3
    plain.poisson_ratio = None
    assert plain.poisson_ratio == 0
    for value in (-0.01, 0.48, np.nan):
        with pytest.raises(ValueError, match=r"poisson_ratio = .* is out of range: it must be in \[0, 0.47\]"):
            plain.poisson_ratio = value
    path = tmp_path / "scene.toml"
    path.write_text(f"[[body]]\nmesh = '{bust}'\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\n", encoding="utf-8")
    assert supple.load_scene(path).bodies[0].poisson_ratio == 0.3
    with pytest.raises(supple.SceneError, match=r"poisson_ratio` is 0.5; it must be in \[0, 0.47\]"):
        supple.load_scene(path, overrides={"body.bust.poisson_ratio": 0.5})


def test_a_body_that_is_stretched_becomes_narrower():
    lattice = supple.Lattice.from_cells(np.ones((4, 4, 20), bool))
    widths = []
    for ratio in (0.0, 0.45):
        body = supple.Body(lattice, half_width=1, poisson_ratio=ratio, damping_ratio=1)
        body.pin(plane=((0, 0, 0.5), (0, 0, -1)))
        body.handle(plane=((0, 0, 19.5), (0, 0, 1)), keys=[(0,), (1, (0, 0, 2))])
        sim = supple.Simulation(body, dt=1 / 120, gravity=(0, 0, 0))
        sim.step(600)
        middle = body.positions[lattice.indices[:, 2] == 10]
        widths.append(np.ptp(middle[:, 0]) / 4)
    # Stretched by 10 %.
    assert widths[0] == pytest.approx(1, abs=1e-3)
    assert widths[1] == pytest.approx(1 - 0.45 * 0.1, abs=0.005)


def test_accuracy_chooses_the_regions(block, bust, tmp_path):
    bodies = {name: supple.Body(block, youngs_modulus=1e5, accuracy=name) for name in ("fast", "balanced", "exact")}
    sims = {name: supple.Simulation([body], fps=30, substeps="auto") for name, body in bodies.items()}
    assert sims["fast"].steps_per_frame < sims["exact"].steps_per_frame
    widths = {name: sim.bodies[0].half_width for name, sim in sims.items()}
    assert widths["fast"] >= 1
    assert widths["balanced"] == widths["exact"] == 0.5  # a small body
    assert supple.Body(block).accuracy == "balanced"
    body = bodies["exact"]
    body.accuracy = "fast"
    sims["exact"].step()
    assert (body.accuracy, body.half_width >= 1) == ("fast", True)
    with pytest.raises(ValueError, match='accuracy is "best"; it must be one of "fast", "balanced", "exact"'):
        body.accuracy = "best"
    path = tmp_path / "scene.toml"
    path.write_text(f"[[body]]\nmesh = '{bust}'\naccuracy = 'exact'\n", encoding="utf-8")
    assert supple.load_scene(path).bodies[0].accuracy == "exact"
    with pytest.raises(
        supple.SceneError, match='accuracy` is the string "best"; it must be one of "fast", "balanced", "exact"'
    ):
        supple.load_scene(path, overrides={"body.bust.accuracy": "best"})


def test_a_bar_of_one_cell_bends_and_stretches_as_a_thick_one():
    """Stretched by 2 % between handles, the force is E A times the strain at every thickness."""
    for cells in (1, 2, 4):
        lattice = supple.Lattice.from_cells(np.ones((cells, cells, 8 * cells), bool))
        body = supple.Body(lattice, youngs_modulus=1e4, accuracy="exact", damping_ratio=1, density=1)
        z = lattice.rest_positions[:, 2]
        body.pin(vertices=z == 0)
        shift = 0.02 * 8 * cells
        body.handle(vertices=z == 8 * cells, keys=[(0, (0, 0, 0)), (1, (0, 0, shift))])
        sim = supple.Simulation([body], fps=30, substeps="auto", gravity=(0, 0, 0), sleep=False)
        sim.advance(frames=240)
        assert body.half_width == 0.5
        force = body.holds[0].force[2]
        assert abs(force) == pytest.approx(1e4 * cells**2 * 0.02, rel=0.01)


def test_numbers_of_the_material_take_keyframes(block):
    keys = [(0, 2e5), (1, 1e5)]
    keyed = {"youngs_modulus": keys, "damping_ratio": [(0, 0), (1, 0.5)], "friction": [(0, 1), (1, 0)]}
    body = supple.Body(block, accuracy="exact", **keyed)
    sim = supple.Simulation([body], fps=30, gravity=(0, 0, 0))
    assert sim.steps_per_frame > 1
    sim.advance(15)
    assert body.youngs_modulus == pytest.approx(1.5e5)
    assert body.damping_ratio == pytest.approx(0.25)
    other = copy.deepcopy(sim)
    sim.advance(15)
    other.advance(15)
    assert body.youngs_modulus == pytest.approx(1e5) == other.bodies[0].youngs_modulus
    body.youngs_modulus = [(1, 1e5), (2, 5e4)]
    body.poisson_ratio = [(1, 0.1), (2, 0.3)]
    sim.advance(30)
    assert body.youngs_modulus == pytest.approx(5e4)
    assert body.poisson_ratio == pytest.approx(0.3)
    body.youngs_modulus = 7e4
    sim.advance(1)
    assert body.youngs_modulus == pytest.approx(7e4)
    with pytest.raises(ValueError, match="poisson_ratio"):
        body.poisson_ratio = [(0, 0.1), (1, 0.6)]
