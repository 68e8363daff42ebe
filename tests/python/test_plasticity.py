"""Plastic bodies: arguments, properties, what they keep, and what is saved."""

import pickle

import numpy as np
import pytest

import supple

DEFAULTS = {"yield": 0.05, "creep": 5.0, "max": 1.0}


@pytest.fixture
def bar():
    return supple.Lattice.from_cells(np.ones((12, 6, 6), bool))


def pulled(body, frames):
    """Pull a bar from 12 to 16 cells within a second, release it after two, and return the simulation."""
    ends = body.lattice.indices[:, 0]
    body.handle(vertices=ends == 0, keys=[(0,)], end=2)
    body.handle(vertices=ends == 12, keys=[(0,), (1, (4, 0, 0))], end=2)
    sim = supple.Simulation([body], fps=30, substeps=4, gravity=(0, 0, 0))
    sim.advance(frames)
    return sim


def test_plastic_is_a_dict_or_true(bar):
    assert supple.Body(bar).plastic is None
    assert supple.Body(bar, plastic=True).plastic == DEFAULTS
    assert supple.Body(bar, plastic=False).plastic is None
    body = supple.Body(bar, plastic={"yield": 0.1})
    assert body.plastic == DEFAULTS | {"yield": 0.1}
    body.plastic = {"creep": 20}
    assert body.plastic == DEFAULTS | {"creep": 20}
    body.plastic = None
    assert body.plastic is None


@pytest.mark.parametrize(
    ("plastic", "error", "message"),
    [
        ({"yeild": 0.1}, ValueError, 'plastic has no key "yeild"; the nearest one is "yield"'),
        ({"yield": 0}, ValueError, r"plastic.yield = 0 is out of range: it must be in \(0, 1\]"),
        ({"creep": np.inf}, ValueError, "plastic.creep = inf is out of range: it must be a rate in 1/s, > 0"),
        ({"max": 3}, ValueError, r"plastic.max = 3 is out of range: it must be in \(0, 2\]"),
        ({"max": "1"}, TypeError, "max must be a number, not str"),
        (0.05, TypeError, "plastic must be a dict like .*, not float"),
    ],
)
def test_wrong_plasticity_is_an_error(bar, plastic, error, message):
    with pytest.raises(error, match=message):
        supple.Body(bar, plastic=plastic)
    body = supple.Body(bar, plastic=True)
    with pytest.raises(error, match=message):
        body.plastic = plastic
    assert body.plastic == DEFAULTS


def test_a_pulled_bar_stays_longer_and_returns_after_a_reset(bar):
    body = supple.Body(bar, half_width=1, plastic={"yield": 0.02}, damping_rate=8)
    sim = pulled(body, 180)
    length = np.ptp(body.positions[:, 0])
    assert 15 < length < 16
    strain, shapes = body.plastic_strain, body.plastic_shapes
    assert (strain.shape, strain.dtype, shapes.shape) == ((len(body),), np.float64, (len(body), 3, 3))
    np.testing.assert_allclose(strain, np.linalg.norm(shapes - np.eye(3), axis=(1, 2)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(shapes), 1, atol=1e-5)
    body.plastic = {"yield": 1}
    body.reset_plastic()
    assert not body.plastic_strain.any()
    sim.advance(180)
    assert np.ptp(body.positions[:, 0]) == pytest.approx(12, abs=1e-3)


def test_a_body_without_plasticity_has_no_plastic_strain(bar):
    body = supple.Body(bar)
    pulled(body, 60)
    body.reset_plastic()
    assert body.plastic_strain.tolist() == [0] * len(body)
    assert (body.plastic_shapes == np.eye(3)).all()


def test_plastic_shapes_are_saved(bar):
    body = supple.Body(bar, half_width=1, plastic={"yield": 0.02})
    sim = pulled(body, 40)
    state, copy = sim.save_state(), pickle.loads(pickle.dumps(sim))
    assert copy.bodies[0].plastic == body.plastic
    sim.advance(50)
    copy.advance(50)
    expected = body.positions.tobytes(), body.plastic_shapes.tobytes()
    assert (copy.bodies[0].positions.tobytes(), copy.bodies[0].plastic_shapes.tobytes()) == expected
    assert body.plastic_strain.max() > 0.1
    sim.restore_state(state)
    sim.advance(50)
    assert (body.positions.tobytes(), body.plastic_shapes.tobytes()) == expected


def test_a_scene_and_a_sweep_set_plasticity(scene):
    overrides = {"body.cube.plastic.yield": 0.01, "body.cube.plastic.creep": 50}
    sim = supple.load_scene(scene, overrides=overrides)
    assert sim.bodies[0].plastic == DEFAULTS | {"yield": 0.01, "creep": 50}
    twin = pickle.loads(pickle.dumps(sim))
    for each in (sim, twin):
        each.advance(60)
    assert sim.bodies[0].plastic_strain.max() > 0
    assert twin.bodies[0].plastic_shapes.tobytes() == sim.bodies[0].plastic_shapes.tobytes()
    results = supple.sweep(scene, {"body.cube.plastic": [{"yield": 0.01}, {"yield": 0.5}]}, frames=2)
    assert all(result.report.outcome == "finished" for result in results)
    with pytest.raises(supple.SceneError, match=r"body\.cube\.plastic\.yeild.*`yield`"):
        supple.load_scene(scene, overrides={"body.cube.plastic.yeild": 0.1})
