"""Maps: weights of the mesh vertices for zones, pins and handles."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import supple
from shapes import BAR


@pytest.fixture
def bar() -> supple.Mesh:
    return BAR


def along(mesh: supple.Mesh) -> np.ndarray:
    """Return weights from 0 to 1 along the bar."""
    x = mesh.vertices[:, 0]
    return (x - x.min()) / np.ptp(x)


def test_weights_are_carried_to_the_lattice_within_half_a_cell(bar):
    body = supple.Body(bar, lattice_vertices=600)
    weights = body.weights(along(bar))
    x = body.lattice.rest_positions[:, 0]
    expected = (x - bar.vertices[:, 0].min()) / np.ptp(bar.vertices[:, 0])
    assert weights.shape == (len(body),)
    inside = (expected > 0) & (expected < 1)
    assert np.abs(weights - expected)[inside].max() <= body.lattice.cell_size / np.ptp(bar.vertices[:, 0])
    assert ((weights >= 0) & (weights <= 1)).all()


def test_a_zone_takes_a_map_as_exponent(bar):
    body = supple.Body(bar, lattice_vertices=600)
    weights = body.weights(along(bar))
    body.zone(9.0, map=along(bar))
    np.testing.assert_allclose(body.stiffness_factors, 9**weights)
    body.zone(density_factor=4.0, map=along(bar))
    np.testing.assert_allclose(body.stiffness_factors, 9**weights)
    plain = supple.Body(bar, lattice_vertices=600)
    ratio = body.masses / plain.masses
    # The density of a cell is the mean over its corners, and the mass of a vertex the mean over its cells.
    cell = 4 ** (body.lattice.cell_size / np.ptp(bar.vertices[:, 0]))
    assert (np.abs(np.log(ratio / 4**weights)) <= np.log(cell)).all()


def test_a_mask_and_weights_of_0_and_1_are_the_same(bar):
    mask = along(bar) > 0.7
    first, second = (supple.Body(bar, lattice_vertices=600) for _ in range(2))
    assert np.array_equal(first.pin(map=mask).vertices, second.pin(map=mask.astype(float)).vertices)


def test_a_pin_by_a_map_holds_ones_and_pulls_the_rest(bar):
    body = supple.Body(bar, lattice_vertices=600, youngs_modulus=1e5)
    weights = np.clip(2 - 3 * along(bar), 0, 1)
    hold = body.pin(map=weights)
    carried = body.weights(weights)
    assert np.array_equal(hold.vertices, np.flatnonzero(carried >= 0.01))
    start = body.positions.copy()
    sim = supple.Simulation([body], fps=30, gravity=(0, -9.81, 0))
    sim.advance(15)
    moved = np.linalg.norm(body.positions - start, axis=1)
    assert moved[carried > 1 - 1e-6].max() < 1e-6
    assert moved[(carried > 0.1) & (carried < 0.5)].min() > 1e-4
    # A copy has the weights too.
    other = copy.deepcopy(sim)
    sim.advance(5)
    other.advance(5)
    assert np.array_equal(other.bodies[0].positions, body.positions)


def test_named_maps_need_a_mesh_that_has_them(bar):
    body = supple.Body(bar, lattice_vertices=600)
    assert bar.maps == {}
    with pytest.raises(ValueError, match=r"no map \"red\""):
        body.zone(2.0, map="red")


@pytest.mark.parametrize(
    ("wrong", "match"),
    [
        (np.zeros(3), "3 weights, and the mesh has 226 vertices"),
        (None, "weight of mesh vertex 5 is 2"),
        ("mask", "4 weights"),
    ],
    ids=["length", "range", "mask"],
)
def test_wrong_weights_are_errors(bar, wrong, match):
    if wrong is None:
        wrong = np.zeros(len(bar.vertices))
        wrong[5] = 2
    elif isinstance(wrong, str):
        wrong = np.zeros(4, bool)
    body = supple.Body(bar, lattice_vertices=600)
    with pytest.raises(ValueError, match=match):
        body.zone(2.0, map=wrong)


def test_strength_needs_a_body_that_breaks(bar):
    with pytest.raises(ValueError, match=r"strength_factor.*fracture"):
        supple.Body(bar, lattice_vertices=600).zone(strength_factor=0.5, map=along(bar))
    supple.Body(bar, lattice_vertices=600, fracture={"strain": 0.1}).zone(strength_factor=0.5, map=along(bar))


def test_a_map_of_a_broken_body_has_the_vertices_of_the_whole_mesh(bar):
    body = supple.Body(bar, lattice_vertices=600)
    body.cut(plane=((6, 2, 2), (1, 0, 0)))
    weights = body.weights(along(bar))
    assert len(weights) == len(body)
    assert weights.max() == pytest.approx(1, abs=0.1)
    body.zone(3.0, map=along(bar))
    np.testing.assert_allclose(body.stiffness_factors, 3**weights)


def test_a_map_has_no_pose(bar):
    with pytest.raises(TypeError, match="map selects the same in any pose"):
        supple.Body(bar, lattice_vertices=600).pin(map=along(bar), at="now")


def test_zones_take_maps_of_damping_friction_and_yield_strain(bar):
    weights = along(bar)
    body = supple.Body(bar, lattice_vertices=600, youngs_modulus=1e5, plastic={"yield": 0.02})
    body.zone(damping_factor=8.0, friction_factor=0.1, yield_factor=3.0, map=weights)
    assert body.stiffness_factors is None or (body.stiffness_factors == 1).all()
    sim = supple.Simulation([body], fps=30, colliders=supple.Plane((0, -0.3, 0), (0.3, 1, 0)))
    sim.advance(15)
    for key in ("damping_factor", "friction_factor", "yield_factor"):
        factors = {"damping_factor": 8.0, "friction_factor": 0.1, "yield_factor": 3.0}
        other = supple.Body(bar, lattice_vertices=600, youngs_modulus=1e5, plastic={"yield": 0.02})
        other.zone(map=weights, **{name: factor for name, factor in factors.items() if name != key})
        without = supple.Simulation([other], fps=30, colliders=supple.Plane((0, -0.3, 0), (0.3, 1, 0)))
        without.advance(15)
        assert not np.array_equal(other.positions, body.positions), f"{key} has no effect"
    state, before = sim.save_state(), body.positions
    sim.advance(5)
    after, contacts = body.positions, sim.contacts()
    assert len(contacts) > 0
    sim.restore_state(state)
    assert np.array_equal(body.positions, before)
    sim.advance(5)
    assert np.array_equal(body.positions, after)
    with pytest.raises(TypeError, match=r"zone\(\) needs factor.*friction_factor.*yield_factor"):
        body.zone(map=weights)
    with pytest.raises(ValueError, match=r"friction_factor.*101"):
        body.zone(friction_factor=101, map=weights)
    with pytest.raises(ValueError, match=r"yield_factor.*plastic"):
        supple.Body(bar, lattice_vertices=600).zone(yield_factor=2.0, map=weights)
