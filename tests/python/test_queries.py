"""What rays meet, and what is nearest to points."""

from __future__ import annotations

import numpy as np
import pytest

import supple
from shapes import BAR


@pytest.fixture
def sim() -> supple.Simulation:
    """A bar of 12 x 4 x 4, and the ground one below it."""
    body = supple.Body(BAR, name="bar", lattice_vertices=300)
    return supple.Simulation([body], dt=0.01, gravity=(0, 0, 0), colliders=supple.Plane((0, -1, 0), (0, 1, 0)))


def test_many_rays_in_one_call_meet_the_bar_or_the_ground(sim):
    x = np.linspace(-3, 15, 37)
    origins = np.stack([x, np.full(37, 10.0), np.full(37, 1.9)], axis=1)
    found = sim.raycast(origins, (0, -2, 0))
    on_bar = (x > 0) & (x < 12)
    off_bar = (x < 0) | (x > 12)
    assert (found["body"][on_bar] == 0).all()
    assert (found["collider"][on_bar] == -1).all()
    assert found["distance"][on_bar] == pytest.approx(6, abs=1e-6)
    assert (found["collider"][off_bar] == 0).all()
    assert (found["face"][off_bar] == -1).all()
    assert found["distance"][off_bar] == pytest.approx(11)
    np.testing.assert_allclose(found["normal"], np.tile([0, 1, 0], (37, 1)), atol=1e-6)
    faces = found["face"][on_bar]
    assert (faces >= 0).all()
    assert len(np.unique(faces)) == 12  # one square after the other along the bar


def test_one_ray_gives_one_entry_and_a_miss_is_infinite(sim):
    hit = sim.raycast((6, 2, -5), (0, 0, 1))
    assert (hit["body"], hit["collider"]) == (0, -1)
    assert hit["distance"] == pytest.approx(5, abs=1e-6)
    assert hit["point"] == pytest.approx([6, 2, 0], abs=1e-6)
    miss = sim.raycast((6, 2, -5), (0, 0, -1))
    assert (miss["body"], miss["collider"], miss["face"], miss["distance"]) == (-1, -1, -1, np.inf)
    assert np.isfinite(miss["point"]).all()
    assert sim.raycast((6, 2, -5), (0, 0, 1), max_distance=4.9)["body"] == -1


def test_the_nearest_points_follow_the_body(sim):
    body = sim.bodies[0]
    before = sim.nearest([[6, 5, 2], [6, 2, 6], [100, 7, 0]])
    assert list(before["body"]) == [0, 0, -1]
    assert before["distance"] == pytest.approx([1, 2, 8], abs=1e-6)
    body.positions = body.positions + [0, 0.5, 0]
    assert sim.nearest((6, 5, 2))["distance"] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(
    ("origins", "directions", "match"),
    [
        (np.zeros((2, 3)), np.ones((3, 3)), "2 origins and 3 directions"),
        ((0, 0, 0), (0, 0, 0), "direction"),
        ((0, 0, np.nan), (0, 0, 1), "origins"),
        ((0, 0), (0, 0, 1), "origins"),
    ],
)
def test_wrong_rays_are_errors(sim, origins, directions, match):
    with pytest.raises(ValueError, match=match):
        sim.raycast(origins, directions)
