"""Lattices from arrays of cells and from meshes."""

import pickle
import re

import numpy as np
import pytest

import supple


def test_grid_indices_are_array_indices():
    cells = np.zeros((4, 3, 2), bool)
    cells[3, 0, 1] = True
    lattice = supple.Lattice.from_cells(cells)
    assert lattice.cells.tolist() == [[3, 0, 1]]
    assert lattice.indices.min(axis=0).tolist() == [3, 0, 1]
    assert lattice.indices.max(axis=0).tolist() == [4, 1, 2]
    assert len(lattice) == 8


def test_vertices_and_cells_are_sorted_z_y_x(block):
    for array in (block.indices, block.cells):
        order = np.lexsort(array.T)
        assert np.array_equal(order, np.arange(len(array)))
    assert len(block) == 5 * 4 * 3
    assert len(block.cells) == 4 * 3 * 2


def test_rest_positions_are_origin_plus_cell_size_times_indices(block):
    assert np.array_equal(block.rest_positions, block.origin + block.cell_size * block.indices)
    assert block.origin.tolist() == [1, 2, 3]
    assert block.cell_size == 0.5


@pytest.mark.parametrize("dtype", [bool, np.uint8, np.int64, np.float32, float])
def test_cells_of_any_number_type(dtype):
    cells = np.zeros((3, 3, 3), dtype)
    cells[1] = 1
    assert len(supple.Lattice.from_cells(cells).cells) == 9
    assert len(supple.Lattice.from_cells(cells.tolist()).cells) == 9
    assert len(supple.Lattice.from_cells(cells.T).cells) == 9
    assert len(supple.Lattice.from_cells(np.asfortranarray(cells)).cells) == 9


def test_strided_cells_keep_their_axes():
    cells = np.random.default_rng(3).random((6, 5, 4)) < 0.4
    lattice = supple.Lattice.from_cells(cells[::2, ::-1], join=False)
    expected = np.argwhere(np.ascontiguousarray(cells[::2, ::-1]))
    assert np.array_equal(lattice.cells[np.lexsort(lattice.cells.T[::-1])], expected)


def test_join_bridges_floating_parts():
    cells = np.zeros((5, 1, 1), bool)
    cells[[0, 4]] = True
    assert supple.Lattice.from_cells(cells, join=False).component_count == 2
    joined = supple.Lattice.from_cells(cells)
    assert joined.component_count == 1
    assert len(joined.cells) == 5


def test_from_mesh(cube):
    lattice = supple.Lattice.from_mesh(cube, cell_size=0.5)
    assert len(lattice.cells) == 4**3
    assert len(supple.Lattice.from_mesh(cube, vertices=1000)) == 1000
    assert np.allclose(lattice.rest_positions.mean(axis=0), 0)


def test_constant_arrays_are_read_only(block):
    for array in (block.indices, block.rest_positions, block.cells):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("cells", "settings", "message"),
    [
        (np.zeros((2, 2, 2)), {}, "no cell is occupied; a lattice needs at least one"),
        (np.ones((2, 2)), {}, r"shape \(2, 2\); it must be \(nx, ny, nz\)"),
        (np.ones((1, 1, 1)), {"cell_size": 0}, "cell size is 0; it must be a positive, finite length"),
        (np.ones((1, 1, 1)), {"cell_size": np.nan}, "cell size is NaN; it must be a positive, finite length"),
        (np.ones((1, 1, 1)), {"origin": (0, np.inf, 0)}, r"origin\[1\] = inf is not finite"),
        (np.ones((1, 1, 1)), {"origin": (0, 0)}, r"origin has the shape \(2,\); it must be \(3,\)"),
        (np.full((1, 2, 1), np.nan), {}, r"cells\[0, 0, 0\] = NaN is not finite"),
    ],
)
def test_invalid_cells_are_errors(cells, settings, message):
    with pytest.raises(supple.LatticeError, match=message) as caught:
        supple.Lattice.from_cells(cells, **settings)
    assert isinstance(caught.value, ValueError)


def test_too_much_memory_is_an_error_before_allocation(cube):
    with pytest.raises(supple.LatticeError, match=r"cells of size 1\.0000e-4 needs .* would fit"):
        supple.Lattice.from_mesh(cube, cell_size=1e-4)
    limit = "more(?: memory)? than the limit of 977 KiB; a cell size of ([0-9.e-]+) would fit"
    with pytest.raises(supple.LatticeError, match=limit) as caught:
        supple.Body(cube, lattice_vertices=100_000, memory_limit=1_000_000)
    fitting = float(re.search(limit, str(caught.value))[1])
    supple.Body(cube, cell_size=fitting, memory_limit=1_000_000)


def test_vertices_and_cell_size_are_mutually_exclusive(cube):
    with pytest.raises(ValueError, match="vertices and cell_size are mutually exclusive"):
        supple.Lattice.from_mesh(cube, vertices=100, cell_size=0.5)
    with pytest.raises(ValueError, match="vertices = 7 is out of range: it must be a whole number, at least 8"):
        supple.Lattice.from_mesh(cube, vertices=7)


def test_a_pickled_lattice_is_equal():
    cells = np.random.default_rng(5).random((4, 5, 6)) < 0.3
    for join in (False, True):
        lattice = supple.Lattice.from_cells(cells, 0.3, (1, 2, 3), join)
        again = pickle.loads(pickle.dumps(lattice))
        for name in ("indices", "rest_positions", "cells", "cell_size", "component_count"):
            assert np.array_equal(getattr(again, name), getattr(lattice, name)), name
