"""Links: glue and springs between bodies of a simulation."""

import pickle

import numpy as np
import pytest

import supple

FACE = ((0.9, -1, -1), (1.1, 2, 2))


def _pair(**settings):
    lattice = supple.Lattice.from_cells(np.ones((2, 2, 2), bool), cell_size=0.5)
    bodies = [supple.Body(lattice, name=name, translate=(k, 0, 0)) for k, name in enumerate(("a", "b"))]
    return supple.Simulation(bodies, dt=1 / 100, gravity=(0, 0, 0), contact=False, **settings)


def test_glue_pulls_the_other_body_along_and_keeps_momentum():
    sim = _pair(links={"body": "a", "other": "b", "box": FACE})
    sim["a"].apply_impulse((-100, 0, 0))
    sim.step(200)
    total = sim["a"].linear_momentum + sim["b"].linear_momentum
    assert np.allclose(total, (-100, 0, 0), rtol=1e-3, atol=1e-3)
    assert sim["b"].linear_momentum[0] < -20
    (link,) = sim.links
    assert link["body"] == "a"
    assert link["other"] == "b"
    assert not link["broken"]
    assert link["force"].shape == (3,)


def test_links_break_and_are_pickled_with_their_state():
    sim = _pair(links=[{"body": "a", "other": "b", "box": FACE, "stiffness": 1e4, "break": 5.0}])
    sim["a"].apply_impulse((-100, 0, 0))
    sim.step(20)
    assert sim.links[0]["broken"]
    assert sim.links[0]["break"] == 5
    other = pickle.loads(pickle.dumps(sim))
    assert other.links[0]["broken"]
    before = sim["a"].linear_momentum
    sim.step(10)
    assert np.allclose(sim["a"].linear_momentum, before, rtol=1e-4)


def test_a_part_is_glued_to_the_world():
    sim = _pair(links={"body": "a", "plane": ((0, 0.9, 0), (0, 1, 0))})
    sim.gravity = (0, -9.81, 0)
    sim.step(300)
    assert sim["a"].center_of_mass[1] > 0
    assert sim["b"].center_of_mass[1] < -10
    (link,) = sim.links
    assert "other" not in link
    assert np.isclose(link["force"][1], sim["a"].mass * 9.81, rtol=0.05)


@pytest.mark.parametrize(
    ("link", "message"),
    [
        ({"body": "c", "box": FACE}, r'links\[0\].body is "c", and no body'),
        ({"body": "a", "other": "a", "box": FACE}, "to itself"),
        ({"body": "a", "other": "b"}, "box"),
        ({"body": "a", "other": "b", "box": FACE, "stiffness": 0}, r"links\[0\].stiffness = 0 is out of range"),
        ({"body": "a", "box": FACE, "brake": 1}, '"brake".*"break"'),
    ],
)
def test_wrong_links_are_errors_that_name_the_key(link, message):
    with pytest.raises(ValueError, match=message):
        _pair(links=link)


def test_the_links_of_a_simulation_are_arguments_of_another():
    sim = _pair(links=[{"body": "a", "other": "b", "box": FACE, "stiffness": 1e4, "break": 5e6}])
    sim.step(3)
    again = _pair(links=sim.links)
    (link,) = again.links
    assert {key: value for key, value in link.items() if key not in ("force", "broken")} == {
        key: value for key, value in sim.links[0].items() if key not in ("force", "broken")
    }
