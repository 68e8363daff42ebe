"""The thickness of bodies and colliders: arguments, errors, and the distance at rest."""

import pickle

import numpy as np
import pytest

import supple

GROUND = supple.Plane((0, 0, 0), (0, 1, 0))


def test_a_body_rests_at_the_sum_of_the_thicknesses(cube):
    def height(body_thickness, ground_thickness):
        body = supple.Body(cube, lattice_vertices=64, translate=(0, 1.1, 0), thickness=body_thickness)
        ground = supple.Plane((0, 0, 0), (0, 1, 0), thickness=ground_thickness)
        sim = supple.Simulation([body], fps=60, colliders=[ground])
        sim.advance(120)
        contacts = sim.contacts()
        assert np.abs(contacts["point"][:, 1] - ground_thickness).max() < 0.02 * body.lattice.cell_size
        assert np.abs(contacts["depth"]).max() < 0.02 * body.lattice.cell_size
        return body.surface()[:, 1].min(), body.lattice.cell_size

    (thin, cell), (thick, _) = height(0, 0), height(0.1, 0.05)
    # A body rests within 0.01 cells of the surface.
    assert thick - thin == pytest.approx(0.15, abs=0.02 * cell)


def test_thickness_is_read_copied_and_checked(cube):
    body = supple.Body(cube, lattice_vertices=64, thickness=0.02)
    assert (body.thickness, supple.Body(cube, lattice_vertices=64).thickness) == (0.02, 0)
    assert supple.RigidBody(cube, thickness=0.02).thickness == 0.02
    box = supple.Box((0, 0, 0), (1, 1, 1), thickness=0.1)
    sim = supple.Simulation([body], fps=60, colliders=[GROUND, box])
    assert [collider.thickness for collider in sim.colliders] == [0, 0.1]
    assert pickle.loads(pickle.dumps(box)) == box
    with pytest.raises(ValueError, match="thickness = -1 is out of range: it must be a number of at least 0"):
        supple.Body(cube, thickness=-1)
    with pytest.raises(ValueError, match="half of the longest side of the body"):
        supple.Body(cube, thickness=1.5)
    with pytest.raises(ValueError, match="thickness"):
        supple.Sphere((0, 0, 0), 1, thickness=-1)
