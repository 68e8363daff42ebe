"""Contact between bodies: the array of contacts, forces on colliders, settings, warnings, and bodies by name."""

import copy
import pickle

import numpy as np
import pytest

import supple

GROUND = supple.Plane((0, 0, 0), (0, 1, 0))
FIELDS = ("body", "other", "other_is_collider", "point", "normal", "depth", "force")


def _box(cube, name, height, **settings):
    """A box of edge 1, of rubber, with its center at a height."""
    settings = {"lattice_vertices": 125, "translate": (0, height, 0)} | settings
    return supple.Body(cube, name=name, scale=0.5, **settings)


def _stack(cube, **settings):
    """Two boxes, one above the other on a ground, with gaps of 0.01."""
    bodies = [_box(cube, "lower", 0.51), _box(cube, "upper", 1.52, density=500)]
    return supple.Simulation(bodies, fps=60, substeps=4, colliders=[GROUND], **settings)


@pytest.fixture(scope="module")
def resting():
    """Two boxes that rest on each other and on the ground, after 5 s."""
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    sim = _stack(supple.Mesh(2 * corners - 1, quads))
    sim.advance(300)
    return sim


def test_contacts_are_a_structured_array(resting):
    contacts = resting.contacts()
    assert contacts.dtype.names == FIELDS
    kinds = [contacts.dtype[name].base for name in FIELDS]
    assert kinds == [np.int32, np.int32, np.bool_, np.float64, np.float64, np.float64, np.float64]
    assert contacts["point"].shape == contacts["normal"].shape == contacts["force"].shape == (len(contacts), 3)
    at_ground = contacts[contacts["other_is_collider"]]
    between = contacts[~contacts["other_is_collider"]]
    assert len(at_ground) > 3
    assert len(between) > 3
    assert set(at_ground["body"]) == set(at_ground["other"]) == {0}
    assert set(zip(between["body"], between["other"], strict=True)) == {(0, 1)}
    # Up at the ground, and down at the upper box; 45 degrees at the edges of the upper box, whose normals are the means
    # of two faces. A tenth of a radian allows for the deformation of the boxes.
    assert np.all(at_ground["normal"] @ [0, 1, 0] > np.cos(0.1))
    assert np.all(between["normal"] @ [0, -1, 0] > np.cos(np.pi / 4 + 0.1))
    cell = resting["lower"].lattice.cell_size
    assert np.all(np.abs(at_ground["point"][:, 1]) < 0.1 * cell)
    assert np.all(np.abs(between["point"][:, 1] - 1) < 0.2 * cell)
    assert np.all(contacts["depth"] < 0.1 * cell)


def test_at_rest_the_forces_carry_the_weights(resting):
    contacts = resting.contacts()
    at_ground = contacts["other_is_collider"]
    lower, upper = (body.mass * 9.81 for body in resting.bodies)
    force_on_lower = contacts["force"][~at_ground].sum(axis=0)
    force_of_ground = contacts["force"][at_ground].sum(axis=0)
    # One per cent of the weight: the boxes have come to rest.
    assert np.allclose(force_on_lower, [0, -upper, 0], atol=0.01 * upper)
    assert np.allclose(force_of_ground, [0, lower + upper, 0], atol=0.01 * (lower + upper))
    (ground,) = resting.colliders
    assert np.allclose(ground.force, -force_of_ground, atol=1e-9 * (lower + upper))
    assert not ground.force.flags.writeable
    with pytest.raises(RuntimeError, match="not a collider of a simulation"):
        _ = GROUND.force


def test_an_impact_keeps_the_momenta(cube):
    left = supple.Body(cube, name="left", scale=0.5, lattice_vertices=125, velocity=(2, 0, 0))
    right = supple.Body(
        cube, name="right", scale=0.5, lattice_vertices=64, translate=(1.1, 0.3, 0.2), density=300, spin=(0, 0, 1)
    )
    sim = supple.Simulation([left, right], dt=1 / 240, gravity=(0, 0, 0), sleep=False)

    def momenta():
        # The angular momentum of a body is about its center of mass.
        angular = [b.angular_momentum + np.cross(b.center_of_mass, b.linear_momentum) for b in sim.bodies]
        return np.array([sum(b.linear_momentum for b in sim.bodies), sum(angular)])

    before = momenta()
    start = right.linear_momentum
    touched = False
    for _ in range(120):
        sim.step()
        contacts = sim.contacts()
        touched |= len(contacts) > 0
        assert not contacts["other_is_collider"].any()
    assert touched
    assert np.linalg.norm(right.linear_momentum - start) > 0.1 * np.linalg.norm(before[0])
    # The momenta are tracked in f64; positions and velocities of 32 bits round them.
    assert np.allclose(momenta(), before, atol=1e-4 * np.abs(before).max())


def test_bodies_pass_through_each_other_without_contact_or_if_one_ignores_the_other(cube):
    def gap(contact=True, lower=(), upper=()):
        bodies = [_box(cube, "lower", 0.51, ignore=lower), _box(cube, "upper", 1.52, ignore=upper)]
        sim = supple.Simulation(bodies, fps=60, substeps=4, colliders=[GROUND], contact=contact)
        sim.advance(60)
        return sim["upper"].center_of_mass[1] - sim["lower"].center_of_mass[1]

    assert gap() > 0.95
    # Both fall to the ground.
    assert abs(gap(contact=False)) < 0.05
    assert abs(gap(lower=["upper"])) < 0.05
    assert abs(gap(upper=("lower",))) < 0.05


def test_settings_can_be_read(cube):
    body = _box(cube, "a", 0, friction=0.2, restitution=0.3, ignore=["b"], self_contact=True)
    assert (body.friction, body.restitution, body.ignore, body.self_contact) == (0.2, 0.3, ("b",), True)
    other = _box(cube, "b", 5)
    assert (other.friction, other.restitution, other.ignore, other.self_contact) == (0.5, 0, (), None)
    sim = supple.Simulation([body, other], contact=False, self_contact=True)
    assert (sim.contact, sim.self_contact) == (False, True)
    for name in ("friction", "restitution", "ignore", "self_contact"):
        with pytest.raises(AttributeError):
            setattr(body, name, None)
    default = supple.Simulation([_box(cube, "c", 0)])
    assert (default.contact, default.self_contact) == (True, False)


def test_invalid_settings_raise(cube):
    for settings, error, message in [
        ({"friction": -1}, ValueError, "friction = -1"),
        ({"friction": float("nan")}, ValueError, "friction"),
        ({"restitution": 1.5}, ValueError, "restitution = 1.5"),
        ({"ignore": "b"}, TypeError, "ignore must be a list of names of bodies like .*, not str"),
        ({"ignore": [3]}, TypeError, r"ignore\[0\] must be a string, not int"),
        ({"self_contact": 1}, TypeError, "self_contact must be True or False, not int"),
    ]:
        with pytest.raises(error, match=message):
            _box(cube, "a", 0, **settings)
    bodies = [_box(cube, "bust", 0, ignore=["eyse"]), _box(cube, "eyes", 5)]
    with pytest.raises(ValueError, match=r'bodies\[0\]: ignore names "eyse", .* the nearest name is "eyes"$'):
        supple.Simulation(bodies)
    with pytest.raises(ValueError, match=r'ignore names "a", .* the simulation has no other body$'):
        supple.Simulation([_box(cube, "a", 0, ignore=["a"])])
    # No body moved into the simulation that failed.
    supple.Simulation([_box(cube, "eyse", 9), *bodies])


def test_bodies_that_overlap_are_named(cube):
    def build(**settings):
        return supple.Simulation([_box(cube, "lower", 0), _box(cube, "upper", 0.8, **settings)])

    with pytest.warns(supple.ContactWarning, match=r"lower and upper overlap at the start, up to 0\.2 deep") as caught:
        sim = build()
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert 'ignore = ["upper"]' in str(caught[0].message)
    # Neither of these warns: warnings are errors here.
    build(ignore=["lower"])
    copy.deepcopy(sim)
    pickle.loads(pickle.dumps(sim))


def test_overlapping_bodies_of_a_scene_are_named(scene, tmp_path):
    text = scene.read_text()
    body = text[text.index("[[body]]") : text.index("[[body.pin]]")].replace('"cube"', '"twin"')
    scene.write_text(text + body.replace("[0, 1.2, 0]", "[0, 3, 0]"))
    for call in (lambda: supple.load_scene(scene), lambda: supple.run(scene, tmp_path / "out", frames=1)):
        with pytest.warns(supple.ContactWarning, match="cube and twin overlap") as caught:
            call()
        assert caught[0].filename == __file__
    with pytest.raises(supple.ContactWarning):
        supple.run(scene, tmp_path / "other", frames=1)
    sim = supple.load_scene(scene, overrides={"body.twin.ignore": ["cube"], "simulation.self_contact": True})
    assert sim.self_contact
    assert sim["twin"].ignore == ("cube",)
    assert pickle.loads(pickle.dumps(sim))["twin"].ignore == ("cube",)


@pytest.mark.parametrize("again", [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))])
def test_copies_keep_the_settings_and_continue_bit_for_bit(cube, again):
    bodies = [_box(cube, "lower", 0.51, friction=0.1, restitution=0.5, self_contact=True), _box(cube, "upper", 1.52)]
    sim = supple.Simulation(bodies, fps=60, substeps=4, colliders=[GROUND], self_contact=False)
    sim.advance(20)
    twin = again(sim)
    assert (twin.contact, twin.self_contact) == (True, False)
    for name in ("friction", "restitution", "ignore", "self_contact"):
        assert getattr(twin["lower"], name) == getattr(sim["lower"], name)
    assert len(sim.contacts()) > 0
    assert twin.contacts().tobytes() == sim.contacts().tobytes()
    for each in (sim, twin):
        each.advance(20)
    assert twin["upper"].positions.tobytes() == sim["upper"].positions.tobytes()
    assert twin.contacts().tobytes() == sim.contacts().tobytes()
    assert len(sim.contacts()) > 0


def test_bodies_are_found_by_name(cube):
    sim = supple.Simulation([_box(cube, "left", 0), _box(cube, "right", 5), _box(cube, "right", 9)])
    assert sim["left"] is sim.bodies[0]
    with pytest.raises(KeyError, match='no body is called "lft"; the nearest name is "left"'):
        sim["lft"]
    with pytest.raises(KeyError, match=r'2 bodies are called "right"; use sim\.bodies\[1\]'):
        sim["right"]
    with pytest.raises(TypeError, match="the name of a body must be a string, not int"):
        sim[0]
