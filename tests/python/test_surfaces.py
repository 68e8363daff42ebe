"""Surfaces of all bodies: sim.surfaces."""

import numpy as np
import pytest

import supple


@pytest.fixture
def sim(bust, cube):
    bodies = [
        supple.Body(bust, name="bust", lattice_vertices=300, translate=(0, 2, 0), skin="smooth"),
        supple.Body(cube, name="cube", lattice_vertices=200, spin=(1, 2, 0)),
        supple.Body(supple.Lattice.from_cells(np.ones((2, 2, 2), bool)), name="bare", translate=(20, 0, 0)),
        supple.Body(bust, name="other", lattice_vertices=200, translate=(-20, 0, 0), volume="off"),
    ]
    sim = supple.Simulation(bodies, fps=30, colliders=supple.Plane((0, -1, 0), (0, 1, 0)))
    sim.advance(5)
    return sim


def test_surfaces_are_those_of_the_bodies(sim):
    surfaces = sim.surfaces()
    assert [surface.shape for surface in surfaces] == [(4717, 3), (8, 3), (0, 3), (4717, 3)]
    for body in (sim["bust"], sim["cube"], sim["other"]):
        surface = surfaces[sim.bodies.index(body)]
        assert surface.dtype == np.float64
        assert np.array_equal(surface, body.surface())


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_surfaces_write_into_given_arrays(sim, dtype):
    out = [np.full_like(surface, np.nan, dtype=dtype) for surface in sim.surfaces()]
    # Rows that are not contiguous, and columns first.
    out[1] = np.full((16, 3), np.nan, dtype)[::2]
    out[3] = np.full((3, 4717), np.nan, dtype).T
    result = sim.surfaces(out=out)
    assert len(result) == 4
    assert all(given is returned for given, returned in zip(out, result, strict=True))
    for body, array in zip(sim.bodies, out, strict=True):
        if body.mesh is not None:
            assert np.array_equal(array, body.surface(out=np.empty(array.shape, dtype)))


def test_surfaces_do_not_depend_on_the_number_of_threads(bust):
    def surfaces(threads):
        bodies = [supple.Body(bust, name=f"b{i}", lattice_vertices=150, translate=(8 * i, 0, 0)) for i in range(5)]
        sim = supple.Simulation(bodies, fps=30, substeps=2, threads=threads)
        sim.advance(2)
        return sim.surfaces()

    for one, several in zip(surfaces(1), surfaces(4), strict=True):
        assert np.array_equal(one, several)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (lambda out: out[:2], ValueError, "out has 2 entries; it must have 4, one per body"),
        (lambda out: [*out[:3], out[3][:5]], ValueError, r"out\[3\] has the shape \(5, 3\); it must be \(4717, 3\)"),
        (lambda out: [out[0], out[1], None, out[3]], TypeError, r"out\[2\] must be a numpy array, not None"),
        (lambda out: [out[0].astype(int), *out[1:]], TypeError, r"out\[0\] has dtype int64"),
        (lambda out: [*out[:3], out[0]], ValueError, "in use"),
        (lambda out: 3, TypeError, "out must be a list of arrays, one per body, not int"),
    ],
)
def test_invalid_arrays_are_errors(sim, change, error, message):
    with pytest.raises(error, match=message):
        sim.surfaces(out=change(sim.surfaces()))
