"""Fields: wind, drag and other accelerations of a simulation."""

import copy

import numpy as np
import pytest

import supple


def _simulation(**settings):
    lattice = supple.Lattice.from_cells(np.ones((2, 2, 2), bool), cell_size=0.5)
    bodies = [supple.Body(lattice, name=name, translate=(5 * k, 0, 0)) for k, name in enumerate(("a", "b"))]
    return supple.Simulation(bodies, dt=1 / 100, gravity=(0, 0, 0), **settings)


def _velocity(body):
    return body.linear_momentum / body.mass


def test_fields_accelerate_their_bodies():
    fields = [
        {"gravity": (0, -2, 0)},
        {"wind": {"velocity": (3, 0, 0), "drag": 2.0}, "bodies": ["a"]},
        {"drag": 5.0, "sphere": ((50, 0, 0), 1)},
    ]
    sim = _simulation(fields=fields)
    sim.step(100)
    assert np.allclose(_velocity(sim["b"]), (0, -2, 0), atol=1e-4)
    assert np.allclose(_velocity(sim["a"])[0], 3 * (1 - np.exp(-2)), rtol=1e-3)


def test_strengths_take_keys_and_fields_are_read_back():
    field = {"gravity": (0, 4, 0), "strength": [(0, 0), (1, 1)], "plane": ((0, 0, 0), (0, 1, 0)), "bodies": ["b"]}
    sim = _simulation(fields=field)
    (found,) = sim.fields
    assert found["gravity"] == (0, 4, 0)
    assert found["bodies"] == ("b",)
    assert found["strength"] == ({"time": 0, "value": 0}, {"time": 1, "value": 1})
    assert found["plane"] == {"point": (0, 0, 0), "normal": (0, 1, 0)}
    assert _simulation(fields=sim.fields).fields == sim.fields
    assert copy.deepcopy(sim).fields == sim.fields
    sim.step(100)
    assert np.allclose(_velocity(sim["b"]), (0, 2, 0), rtol=0.02)
    sim.fields = []
    before = _velocity(sim["b"])
    sim.step(10)
    assert sim.fields == ()
    assert np.allclose(_velocity(sim["b"]), before, rtol=1e-5)


@pytest.mark.parametrize(
    ("fields", "error", "message"),
    [
        ([{"wind": {"velocity": (1, 0, 0), "gusts": 1}}], ValueError, r'fields\[0\].wind has no key "gusts".*"gust"'),
        ([{"drag": -1}], ValueError, r"fields\[0\].drag = -1 is out of range"),
        ([{"drag": 1, "gravity": (0, 0, 0)}], ValueError, "mutually exclusive"),
        ([{"strength": 1}], ValueError, "gravity"),
        ([{"drag": 1, "bodies": ["c"]}], ValueError, r'fields\[0\].bodies names "c", and no body'),
        ([{"drag": 1, "vertices": [0]}], ValueError, "vertices"),
        ([3], TypeError, r"fields\[0\] must be a dict, not int"),
        (3, TypeError, "fields"),
    ],
)
def test_wrong_fields_are_errors_that_name_the_key(fields, error, message):
    with pytest.raises(error, match=message):
        _simulation(fields=fields)
    sim = _simulation()
    if "bodies names" not in message:
        with pytest.raises(error, match=message):
            sim.fields = fields
    assert sim.fields == ()
    # The bodies of a simulation that could not be built are free.
    body = supple.Body(supple.Lattice.from_cells(np.ones((1, 1, 1), bool)))
    with pytest.raises(error):
        supple.Simulation(body, fields=fields)
    supple.Simulation(body)
