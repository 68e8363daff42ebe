"""Rotations as arguments: angles, quaternions, matrices, scipy; interpolation of keyframes."""

import pickle

import numpy as np
import pytest

import supple

ANGLES = [(0, 0, 0), (30, -40, 170), (90, 0, 90), (12, 90, 50), (-100, -90, 3), (179, 5, -179)]


def _quaternion(angles):
    """The quaternion x, y, z, w of Euler angles in degrees about the fixed axes x, then y, then z."""
    total = np.array([0.0, 0, 0, 1])
    for axis, angle in enumerate(np.radians(angles)):
        x, y, z, w = np.append(np.sin(angle / 2) * np.eye(3)[axis], np.cos(angle / 2))
        a, b, c, d = total
        total = np.array(
            [
                w * a + x * d + y * c - z * b,
                w * b - x * c + y * d + z * a,
                w * c + x * b - y * a + z * d,
                w * d - x * a - y * b - z * c,
            ]
        )
    return total


def _matrix(angles):
    x, y, z, w = _quaternion(angles)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


class _Rotation:
    """Has the method of scipy's Rotation."""

    def __init__(self, angles):
        self._matrix = _matrix(angles)

    def as_matrix(self):
        return self._matrix


def _scipy(angles):
    return pytest.importorskip("scipy.spatial.transform").Rotation.from_euler("xyz", angles, degrees=True)


FORMS = {
    "quaternion": _quaternion,
    "longer quaternion": lambda angles: 1e200 * _quaternion(angles),
    "opposite quaternion": lambda angles: (-_quaternion(angles)).tolist(),
    "matrix": _matrix,
    "float32 matrix": lambda angles: _matrix(angles).astype(np.float32),
    "object with as_matrix": _Rotation,
    "scipy": _scipy,
}


@pytest.fixture(params=FORMS)
def form(request):
    return FORMS[request.param]


@pytest.fixture
def block():
    return supple.Lattice.from_cells(np.ones((3, 2, 1), bool))


@pytest.mark.parametrize("angles", ANGLES)
def test_bodies_and_colliders_take_any_form_of_a_rotation(block, form, angles):
    rotated, expected = (supple.Body(block, rotate=rotate) for rotate in (form(angles), angles))
    # float32 matrices have rounding errors of 6e-8.
    assert np.allclose(rotated.positions, expected.positions, atol=1e-6)
    assert np.array_equal(pickle.loads(pickle.dumps(rotated)).positions, rotated.positions)
    box = supple.Box((0, 0, 0), (1, 2, 3), rotate=form(angles))
    assert len(box.rotate) == 3
    turned = supple.Body(block, rotate=box.rotate)
    assert np.allclose(turned.positions, expected.positions, atol=1e-6)


def test_quaternions_are_x_y_z_w(block):
    half = np.sqrt(0.5)
    # 90 degrees about z.
    body = supple.Body(block, rotate=(0, 0, half, half))
    assert np.allclose(body.positions, supple.Body(block, rotate=(0, 0, 90)).positions, atol=1e-12)


def test_keys_take_rotations_and_do_not_jump(block, form):
    turns = np.arange(0, 800, 50)
    keys = [(index, None, form((0, 0, angle))) for index, angle in enumerate(turns)]
    hold = supple.Body(block).handle(keys=keys, vertices=[0, 1])
    # Angles of float32 matrices have rounding errors of 1e-5 degrees.
    assert np.allclose([rotate for _, _, rotate in hold.keys], [(0, 0, angle) for angle in turns], atol=1e-4)
    plate = supple.Plane((0, 0, 0), (0, 1, 0), keys=[{"time": 1, "rotate": form((0, 10, 0))}])
    assert np.allclose(plate.keys[0][2], (0, 10, 0), atol=1e-4)


def test_a_path_through_the_pole_does_not_jump(block, form):
    turns = np.arange(0, 400, 10)
    hold = supple.Body(block).handle(keys=[(i, None, form((20, a, 0))) for i, a in enumerate(turns)], vertices=[0])
    angles = np.array([rotate for _, _, rotate in hold.keys])
    assert np.allclose(angles[:, 1], turns, atol=0.1)
    assert np.abs(np.diff(angles, axis=0)).max() < 10.5


def test_move_to_turns_to_the_nearest_angles(block, form):
    sim = supple.Simulation(
        supple.Body(block, translate=(0, 5, 0), half_width=1), colliders=supple.Box((0, -2, 0), (9, 1, 9))
    )
    collider = sim.colliders[0]
    for angle in range(0, 600, 60):
        collider.move_to((0, 0, 0), form((0, angle, 0)))
        if angle:
            assert collider.spin[1] == pytest.approx(np.radians(60) / sim.dt, rel=1e-5)
        sim.step()
        assert np.allclose(collider.rotation, (0, angle, 0), atol=1e-4)


@pytest.mark.parametrize(
    ("rotate", "message"),
    [
        ((0, 0), r"rotate has the shape \(2,\); it must be \(3,\), angles in degrees, \(4,\), a quaternion x, y, z, w"),
        ((0, 0, 0, 0), "rotate is the quaternion zero"),
        ((0, 0, np.nan, 1), r"rotate\[2\] = NaN is not finite"),
        (np.eye(3) * 2, "rotate is no rotation matrix: R R. differs from the identity by 3.0e0"),
        (np.diag([1, 1, -1]), "rotate is no rotation matrix: it mirrors"),
        (np.eye(4), r"rotate has the shape \(4, 4\)"),
        (np.zeros((1, 3, 3)), r"rotate has the shape \(1, 3, 3\)"),
    ],
)
def test_invalid_rotations_are_errors(block, rotate, message):
    with pytest.raises(ValueError, match=message):
        supple.Body(block, rotate=rotate)


def test_several_rotations_of_scipy_are_an_error(block):
    several = pytest.importorskip("scipy.spatial.transform").Rotation.from_euler("x", [[10], [20]], degrees=True)
    with pytest.raises(ValueError, match=r"rotate.as_matrix\(\) has the shape \(2, 3, 3\)"):
        supple.Body(block, rotate=several)


def _heights(interpolation, times):
    body = supple.Body(supple.Lattice.from_cells(np.ones((1, 1, 1), bool)), half_width=1)
    sim = supple.Simulation(body, dt=0.05, gravity=(0, 0, 0))
    keys = [(0,), (1, (0, 2, 0)), (2, (0, 2, 0)), (3, (0, 5, 0))]
    hold = body.handle(vertices=np.arange(8), keys=keys, **({"interpolation": interpolation} if interpolation else {}))
    assert hold.interpolation == (interpolation or "linear")
    heights = []
    for time in times:
        sim.step(round((time - sim.time) / sim.dt))
        heights.append(body.positions[0, 1])
    return heights


def test_handles_are_interpolated():
    times = [0.25, 1.0, 1.5, 2.5, 2.75, 3.0]
    assert np.allclose(_heights(None, times), [0.5, 2, 2, 3.5, 4.25, 5], atol=1e-5)
    assert np.allclose(_heights("linear", times), [0.5, 2, 2, 3.5, 4.25, 5], atol=1e-5)
    smooth = 0.75**2 * (3 - 1.5)
    assert np.allclose(_heights("smooth", times), [2 * (1 - smooth), 2, 2, 3.5, 2 + 3 * smooth, 5], atol=1e-5)
    # A coordinate that does not change rests, so that here all slopes are zero.
    assert np.allclose(_heights("cubic", times), _heights("smooth", times), atol=1e-5)


def test_new_keys_keep_the_interpolation(block):
    body = supple.Body(block)
    pin, handle = body.pin(vertices=[0]), body.handle(vertices=[1], keys=[(0,)], interpolation="cubic")
    assert pin.interpolation is None
    pin.set_keys([(0,)])
    handle.set_keys([(1,)])
    assert (pin.interpolation, handle.interpolation) == ("linear", "cubic")
    handle.set_keys([(1,)], interpolation="smooth")
    twin = pickle.loads(pickle.dumps(body)).holds[1]
    assert (handle.interpolation, twin.interpolation) == ("smooth", "smooth")
    with pytest.raises(ValueError, match='interpolation is "ease"; it must be "linear" or "smooth" or "cubic"'):
        body.handle(vertices=[1], keys=[(0,)], interpolation="ease")


def test_colliders_are_interpolated(block):
    sim = supple.Simulation(
        supple.Body(block, translate=(0, 5, 0), half_width=1),
        dt=0.25,
        gravity=(0, 0, 0),
        colliders=supple.Sphere((0, -9, 0), 1, keys=[(0,), (1, (0, 2, 0))], interpolation="smooth"),
    )
    sim.step()
    assert sim.colliders[0].interpolation == "smooth"
    assert sim.colliders[0].translation[1] == pytest.approx(2 * 0.25**2 * (3 - 0.5))
    twin = pickle.loads(pickle.dumps(sim))
    for each in (sim, twin):
        each.step()
        assert each.colliders[0].translation[1] == pytest.approx(1.0)
    with pytest.raises(ValueError, match="interpolation is"):
        supple.Sphere((0, 0, 0), 1, interpolation="ease")


def test_scenes_have_the_interpolation(scene):
    text = scene.read_text().replace(
        "end = 0.1", "end = 0.1\n[[body.handle]]\nsphere = { center = [0, 0, 0], radius = 2 }"
    )
    keys = "keys = [{ time = 0 }, { time = 1, translate = [0, 2, 0] }]\ninterpolation = "
    scene.write_text(text.replace("radius = 2 }", f'radius = 2 }}\n{keys}"smooth"') + f'\n{keys}"cubic"\n')
    sim = supple.load_scene(scene)
    assert sim["cube"].holds[1].interpolation == "smooth"
    assert sim.colliders[0].interpolation == "cubic"
    scene.write_text(scene.read_text().replace('"cubic"', '"ease"'))
    with pytest.raises(supple.SceneError, match=r'interpolation.*one of .?"linear", "smooth", "cubic"'):
        supple.load_scene(scene)
    scene.write_text(scene.read_text().replace('interpolation = "ease"', 'interpolate = "cubic"'))
    with pytest.raises(supple.SceneError, match="interpolation"):
        supple.load_scene(scene)
