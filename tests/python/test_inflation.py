"""Inflation: rest volumes that change, and what is written of them."""

import copy
import pickle

import numpy as np
import pytest

import supple


def bar(**settings):
    """A bar of 8 x 3 x 3 cells, damped so that it soon rests."""
    lattice = supple.Lattice.from_cells(np.ones((8, 3, 3), bool), cell_size=0.25)
    return supple.Body(lattice, youngs_modulus=1e5, poisson_ratio=0.3, damping_ratio=0.5, **settings)


def alone(body):
    return supple.Simulation([body], fps=30, gravity=(0, 0, 0))


@pytest.mark.parametrize("ratio", [0.5, 1.3])
def test_a_body_grows_to_its_ratio_and_is_shown_with_it(ratio):
    body = bar()
    sim = alone(body)
    body.inflate = ratio
    assert body.inflate == ratio
    assert (body.rest_volume_ratios == 1).all()
    sim.advance(120)
    assert body.rest_volume_ratios == pytest.approx(ratio)
    report = body.volume_report()
    assert report.rest == pytest.approx(ratio * 8 * 3 * 3 * 0.25**3)
    assert report.before == pytest.approx(report.rest, rel=1e-4)
    assert report.after == pytest.approx(report.rest, rel=1e-6)
    extent = np.ptp(body.positions, axis=0)
    assert extent == pytest.approx(np.array([2, 0.75, 0.75]) * np.cbrt(ratio), rel=1e-4)


def test_keyframes_are_read_in_all_forms():
    keys = [(0, 1), (2, 1.5)]
    forms = [keys, np.array(keys), [{"time": 0, "value": 1}, {"time": 2, "value": 1.5}], {"keys": keys}]
    for form in forms:
        body = bar(inflate=form)
        assert body.inflate == [(0, 1), (2, 1.5)]
        sim = alone(body)
        sim.advance(30)
        assert body.rest_volume_ratios == pytest.approx(1.25)
    smooth = bar(inflate={"keys": keys, "interpolation": "smooth"})
    assert smooth.inflate == {"keys": [(0, 1), (2, 1.5)], "interpolation": "smooth"}
    sim = alone(smooth)
    sim.advance(15)
    # 3 s^2 - 2 s^3 at s = 1/4.
    assert smooth.rest_volume_ratios == pytest.approx(1 + 0.5 * (3 / 16 - 2 / 64))


def test_zones_have_ratios_of_their_own():
    body = bar()
    left = body.positions[:, 0] < 0.9
    body.zone(inflate=1.5, vertices=np.flatnonzero(left))
    body.inflate = 0.8
    sim = alone(body)
    sim.advance(1)
    assert body.rest_volume_ratios == pytest.approx(np.where(left, 1.2, 0.8))
    assert body.stiffness_factors is None
    body.zone(2, inflate=[(0, 1), (1, 2)], vertices=[0])
    assert body.stiffness_factors[0] == 2
    with pytest.raises(TypeError, match="zone\\(\\) needs factor, of Young's modulus, inflate"):
        body.zone(vertices=[0])


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (0, ValueError, "inflate = 0 is out of range: it must be in \\[0.1, 10\\]"),
        ([(0, 1), (1, 11)], ValueError, r"inflate\[1\].value = 11 is out of range: it must be in \[0.1, 10\]"),
        ([(1, 1), (0, 1)], ValueError, "inflate is a list of 2 values; .*: key 1 is at time 0, which is not"),
        ({"keys": [(1, 1), (0, 1)]}, ValueError, "inflate is a dict; .*: key 1 is at time 0, which is not after key 0"),
        ([], ValueError, r"inflate is \[\]; .*: there are no keys"),
        ([(0, 1, 2)], ValueError, r"inflate\[0\] must be \(time, value\)"),
        ([1, 2], ValueError, r"inflate\[0\] must be \(time, value\)"),
        ([{"time": 0}], ValueError, r"inflate\[0\].value is missing: a number: the value at this time"),
        ({"keys": [(0, 1)], "interpolate": "smooth"}, ValueError, "inflate has no key .interpolate."),
        ({}, ValueError, "inflate.keys is missing"),
        ("much", TypeError, "inflate must be a number, a list of keyframes .*, not str"),
        ([(0, float("nan"))], ValueError, r"inflate\[0\].value = NaN is out of range"),
    ],
)
def test_wrong_ratios_are_errors_that_name_them(value, error, words):
    with pytest.raises(error, match=words):
        bar(inflate=value)
    body = bar()
    with pytest.raises(error, match=words):
        body.inflate = value
    assert body.inflate == 1


def test_copies_states_and_scenes_keep_the_ratio(tmp_path):
    body = bar(inflate=[(0, 1), (1, 2)])
    sim = alone(body)
    sim.advance(10)
    state = sim.save_state()
    sim.advance(5)
    end = body.positions
    sim.restore_state(state)
    sim.advance(5)
    assert np.array_equal(body.positions, end)
    for other in (copy.deepcopy(body), pickle.loads(pickle.dumps(body))):
        assert other.inflate == body.inflate
        assert np.array_equal(other.rest_volume_ratios, body.rest_volume_ratios)
    (tmp_path / "cube.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
        "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    )
    (tmp_path / "scene.toml").write_text(
        "[simulation]\nframes = 60\nfps = 30\ngravity = [0, 0, 0]\n"
        "[[body]]\nmesh = 'cube.obj'\nlattice_vertices = 64\ninflate = 1.3\n"
        "[[body.zone]]\nbox = { min = [-1, -1, -1], max = [2, 0.4, 2] }\n"
        "inflate = [{ time = 0, value = 1 }, { time = 1, value = 2 }]\n"
    )
    (cube,) = supple.load_scene(tmp_path / "scene.toml").bodies
    assert cube.inflate == 1.3
    report = supple.run(tmp_path / "scene.toml", format="obj")
    volume = report.bodies[0].volume
    assert volume.rest > 1.3 * 1.2
    assert abs(volume.residual) < 1e-5


def test_rolling_resistance_follows_the_damping_unless_it_is_set(block):
    assert supple.Body(block).rolling_resistance == pytest.approx(0.024)
    assert supple.Body(block, damping_ratio=0).rolling_resistance == 0
    assert supple.Body(block, damping_rate=2).rolling_resistance == pytest.approx(0.016)
    assert supple.Body(block, rolling_resistance=0.1).rolling_resistance == 0.1
    with pytest.raises(ValueError, match="rolling_resistance = -1 is out of range: it must be a number of at least 0"):
        supple.Body(block, rolling_resistance=-1)


def test_rolling_resistance_of_a_collider(block):
    plane = supple.Plane((0, 0, 0), (0, 1, 0), rolling_resistance=0.1)
    sim = supple.Simulation([supple.Body(block, translate=(0, 2, 0))], colliders=[plane, supple.Sphere((9, 0, 0), 1)])
    assert [collider.rolling_resistance for collider in sim.colliders] == [0.1, None]
    with pytest.raises(ValueError, match="rolling_resistance"):
        supple.Plane((0, 0, 0), (0, 1, 0), rolling_resistance=-1)
