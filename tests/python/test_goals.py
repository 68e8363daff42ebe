"""Goal positions compared with the naive reference."""

import numpy as np
import pytest

import supple

RNG = np.random.default_rng(2)
U_SHAPE = np.ones((5, 4, 2), bool)
U_SHAPE[2, 1:] = False
SHAPES = {
    "box": np.ones((5, 4, 3), bool),
    "u": U_SHAPE,
    "rod": np.ones((12, 1, 1), bool),
    "sheet": np.ones((6, 1, 7), bool),
    "cell": np.ones((1, 1, 1), bool),
    "random": RNG.random((5, 5, 5)) < 0.4,
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("half_width", [0.5, 1, 2, 3, 5])
def test_goals_equal_the_reference(name, half_width):
    lattice = supple.Lattice.from_cells(SHAPES[name], cell_size=0.25, join=False)
    body = supple.Body(lattice, half_width=half_width)
    body.positions = lattice.rest_positions + 0.05 * RNG.normal(size=(len(lattice), 3))
    expected = supple.reference.goals(lattice, body.positions, half_width)
    assert np.abs(body.goals() - expected).max() <= 1e-5 * lattice.cell_size


def test_goals_keep_momentum_and_rigid_motions(block):
    body = supple.Body(block, half_width=2)
    moved = block.rest_positions + RNG.normal(size=(len(block), 3))
    body.positions = moved
    masses = body.masses[:, None]
    assert np.allclose((masses * body.goals()).sum(axis=0), (masses * moved).sum(axis=0), rtol=1e-6)
    turn = supple.rotations(RNG.normal(size=(3, 3)))
    body.positions = block.rest_positions @ turn.T + [1e6, 0, 0]
    assert np.allclose(body.goals(), body.positions, rtol=0, atol=1e-5)


def test_region_kinds_differ_only_at_concave_corners():
    for name, equal in [("box", True), ("u", False)]:
        lattice = supple.Lattice.from_cells(SHAPES[name])
        positions = lattice.rest_positions + 0.1 * RNG.normal(size=(len(lattice), 3))
        staircase = supple.reference.goals(lattice, positions, 2)
        breadth_first = supple.reference.goals(lattice, positions, 2, regions="breadth_first")
        assert np.allclose(staircase, breadth_first, rtol=0, atol=1e-12) == equal


def test_invalid_arguments_are_errors_with_name_and_range(block):
    positions = block.rest_positions
    with pytest.raises(ValueError, match='regions is "cube"; it must be "staircase" or "breadth_first"'):
        supple.reference.goals(block, positions, 2, regions="cube")
    for half_width in (0, -1):
        message = f"half_width = {half_width} is out of range: it must be 0.5 or a whole number"
        with pytest.raises(ValueError, match=message):
            supple.reference.goals(block, positions, half_width)
    with pytest.raises(ValueError, match=r"half_width = 1\.5 is out of range: it must be 0\.5 or a whole number"):
        supple.reference.goals(block, positions, 1.5)
    with pytest.raises(ValueError, match=r"positions has the shape \(59, 3\); it must be \(60, 3\)"):
        supple.reference.goals(block, positions[1:], 2)
    with pytest.raises(TypeError, match=r"lattice must be a supple\.Lattice, not ndarray"):
        supple.reference.goals(positions, positions, 2)
