"""Colliders: rest, motion, friction, and errors."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import supple

SHEET = supple.Mesh([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)], [(0, 1, 2, 3)])

COLLIDERS = [
    supple.Plane((0, 0, 0), (0, 1, 0)),
    supple.Sphere((0, -5, 0), 5),
    supple.Box((0, -1, 0), (5, 1, 5)),
    supple.Box((0, -1, 0), half_extents=(5, 5, 1), rotate=(90, 0, 0)),
    supple.Capsule((-5, -1, 0), (5, -1, 0), 1, friction=0.9),
    supple.MeshCollider(SHEET, scale=5, friction=0.9),
]


@pytest.mark.parametrize("collider", COLLIDERS, ids=lambda collider: type(collider).__name__)
def test_a_body_comes_to_rest_on_every_shape(cube, collider):
    body = supple.Body(cube, lattice_vertices=64, translate=(0, 1.2, 0), region_damping=0.3)
    sim = supple.Simulation([body], dt=1 / 120, colliders=[collider])
    sim.step(360)
    # Regression bounds for a body that settles. The lattice may extend below the mesh.
    assert body.positions[:, 1].min() > -0.5
    assert np.abs(body.velocities).max() < 0.2


def test_a_moving_collider_moves_a_body(cube):
    wall = supple.Plane((-1, 0, 0), (1, 0, 0), keys=[(0,), (1, (2, 0, 0))])
    body = supple.Body(cube, lattice_vertices=64)
    sim = supple.Simulation([body], dt=1 / 120, gravity=(0, 0, 0), colliders=[wall])
    sim.step(120)
    assert body.surface()[:, 0].min() > 0.9


def test_friction_and_restitution(cube):
    speeds = {}
    for friction in (0, 1):
        body = supple.Body(cube, lattice_vertices=64, velocity=(1, 0, 0), translate=(0, 1, 0))
        ground = supple.Plane((0, 0, 0), (0, 1, 0), friction=friction)
        supple.Simulation([body], dt=1 / 120, colliders=[ground]).step(60)
        speeds[friction] = body.velocities[:, 0].mean()
    assert speeds[0] == pytest.approx(1, abs=0.01)
    assert speeds[1] < 0.3


def test_colliders_can_be_set(cube):
    body = supple.Body(cube, lattice_vertices=64)
    sim = supple.Simulation([body])
    assert sim.colliders == ()
    sim.colliders = [supple.Plane((0, -1, 0), (0, 1, 0))]
    assert sim.colliders == (supple.Plane((0, -1, 0), (0, 1, 0)),)
    sim.step(120)
    assert body.surface()[:, 1].min() > -1.1
    sim.colliders = ()
    sim.step(60)
    assert body.surface()[:, 1].min() < -2


def test_colliders_are_hashable_dataclasses_that_pickle():
    plane = supple.Plane(np.array([1, 2, 3]), [0, 0, 2], friction=np.float32(0.5), keys=[{"time": 0}])
    assert plane == supple.Plane((1.0, 2.0, 3.0), (0, 0, 2), keys=[(0, (0, 0, 0), (0, 0, 0))])
    assert plane.point == (1, 2, 3)
    assert pickle.loads(pickle.dumps(plane)) == copy.deepcopy(plane) == plane
    assert hash(plane) == hash(copy.copy(plane))
    assert eval(repr(plane), {"Plane": supple.Plane}) == plane


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (
            lambda: supple.Plane((0, 0, 0), (0, 0, 0)),
            ValueError,
            "Plane: the plane's normal is zero; give the direction of the free side",
        ),
        (lambda: supple.Plane((0, 0), (0, 1, 0)), ValueError, r"point has the shape \(2,\); it must be \(3,\)"),
        (lambda: supple.Sphere((0, 0, 0), 0), ValueError, "Sphere: radius is 0; it must be greater than 0"),
        (lambda: supple.Sphere((0, 0, np.nan), 1), ValueError, r"center\[2\] = NaN is not finite"),
        (lambda: supple.Sphere((0, 0, 0), "1"), TypeError, "radius must be a number, not str"),
        (lambda: supple.Box((0, 0, 0), (1, 0, 1)), ValueError, "half_extents is 0; it must be greater than 0"),
        (lambda: supple.Capsule((0, 0, 0), (1, 1, 1), np.inf), ValueError, "radius is inf; it must be finite"),
        (lambda: supple.Sphere((0, 0, 0), 1, friction=-1), ValueError, "friction is -1; its range is 0 and above"),
        (lambda: supple.Sphere((0, 0, 0), 1, restitution=2), ValueError, "restitution is 2; its range is 0 to 1"),
        (
            lambda: supple.Sphere((0, 0, 0), 1, keys=[(1,), (0,)]),
            ValueError,
            "key 1 is at time 0, which is not after key 0 at 1; sort the keys by time",
        ),
    ],
)
def test_invalid_colliders_are_errors(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_other_objects_are_not_accepted_as_colliders(block):
    for given, message in [([3], r"colliders\[0\] must be a Plane"), (3, "colliders must be a list")]:
        with pytest.raises(TypeError, match=message):
            supple.Simulation([supple.Body(block)], colliders=given)


def _platform(**options):
    """Returns a simulation of a block of 4 x 2 x 4 cells of edge 0.5 that rests on a box whose top is at y = 2."""
    lattice = supple.Lattice.from_cells(np.ones((4, 2, 4)), 0.5, (1, 2, 3))
    body = supple.Body(lattice, region_damping=0.3, half_width=4, damping_ratio=0)
    platform = supple.Box((2, 1, 4), (9, 1, 9), **options)
    sim = supple.Simulation([body], dt=1 / 240, gravity=(0, -10, 0), colliders=platform)
    sim.step(240)
    return sim, body


def test_a_control_loop_moves_a_platform_and_friction_carries_the_body():
    sim, body = _platform(friction=0.5)
    (platform,) = sim.colliders
    start = body.positions.mean(axis=0)
    for tick in range(1, 61):
        platform.move_to((0, 0, tick / 60), duration=1 / 60)
        assert platform.velocity == pytest.approx([0, 0, 1])
        sim.step(4)
        assert platform.translation.tolist() == [0, 0, tick / 60]
    assert platform.velocity.tolist() == platform.spin.tolist() == [0, 0, 0]
    # The platform starts at the speed v = 1. Friction accelerates the body by mu g; it slips by v^2 / (2 mu g). The sum
    # over steps differs by at most v dt from this; 0.01 cells are for the deformation of the body.
    moved = body.positions.mean(axis=0) - start
    assert moved == pytest.approx([0, 0, 1 - 1 / (2 * 0.5 * 10)], abs=1 / 240 + 0.01 * 0.5)


def test_move_to_without_a_duration_takes_one_step():
    sim, _ = _platform(keys=[(0,), (4, (2, 0, 0))])
    (platform,) = sim.colliders
    assert platform.translation == pytest.approx([0.5, 0, 0])
    assert platform.velocity == pytest.approx([0.5, 0, 0])
    platform.move_to((9, 9, 9), (90, 90, 90), 5)
    platform.move_to([0.5, 0.1, 0], rotate=np.array([0, 1, 0]))
    assert platform.velocity == pytest.approx([0, 24, 0])
    assert platform.spin == pytest.approx([0, np.radians(240), 0])
    sim.step(3)
    assert platform.translation.tolist() == [0.5, 0.1, 0]
    assert platform.rotation.tolist() == [0, 1, 0]
    assert platform.velocity.tolist() == platform.spin.tolist() == [0, 0, 0]
    assert not platform.velocity.flags.writeable


@pytest.mark.parametrize("again", [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))])
def test_a_copy_in_mid_motion_continues_bit_for_bit(again):
    sim, body = _platform()
    sim.colliders[0].move_to((1, 0.2, 0), (0, 200, 0), duration=0.5)
    sim.step(50)
    other = again(sim)
    twin = other.bodies[0]
    for _ in range(4):
        assert other.colliders == sim.colliders
        for name in ("translation", "rotation", "velocity", "spin"):
            assert getattr(other.colliders[0], name).tobytes() == getattr(sim.colliders[0], name).tobytes()
        assert twin.positions.tobytes() == body.positions.tobytes()
        assert twin.velocities.tobytes() == body.velocities.tobytes()
        sim.step(30)
        other.step(30)
    other.colliders[0].move_to((0, 0, 0))
    other.step()
    assert sim.colliders[0].translation.tolist() == [1, 0.2, 0]


def test_colliders_of_a_simulation_are_equal_to_those_that_were_given():
    given = supple.Plane((0, 0, 0), (0, 1, 0), friction=0.3)
    sim = supple.Simulation([supple.Body(supple.Lattice.from_cells(np.ones((2, 2, 2))))], colliders=given)
    (plane,) = sim.colliders
    assert isinstance(plane, supple.Plane)
    assert plane is sim.colliders[0]
    assert (plane, hash(plane), repr(plane)) == (given, hash(given), repr(given))
    assert (plane.point, plane.normal, plane.friction) == ((0, 0, 0), (0, 1, 0), 0.3)
    assert dataclasses.asdict(plane) == dataclasses.asdict(given)
    for other in (given, copy.copy(plane), copy.deepcopy(plane), pickle.loads(pickle.dumps(plane))):
        assert other == plane
        with pytest.raises(RuntimeError, match=r"this Plane is not a collider of a simulation; use an item of sim\."):
            other.move_to((0, 0, 0))


def test_replaced_colliders_cannot_be_moved():
    sim, _ = _platform()
    (old,) = sim.colliders
    old.move_to((0, -1, 0))
    sim.step()
    sim.colliders = [*sim.colliders, supple.Sphere((0, 0, 0), 1)]
    message = r"this collider was replaced when sim\.colliders was set; use sim\.colliders\[0\] again"
    with pytest.raises(RuntimeError, match=message):
        old.move_to((0, 0, 0))
    for name in ("translation", "rotation", "velocity", "spin"):
        with pytest.raises(RuntimeError, match=message):
            getattr(old, name)
    new, sphere = sim.colliders
    assert (new, new.translation.tolist()) == (old, [0, 0, 0])
    sphere.move_to((1, 0, 0))
    with pytest.raises(ValueError, match="Plane: the plane's normal is zero"):
        sim.colliders = supple.Plane((0, 0, 0), (0, 0, 0))
    assert sphere.velocity[0] == pytest.approx(240)
    sim.colliders = supple.Plane((0, 0, 0), (0, 1, 0))
    assert sim.colliders == (supple.Plane((0, 0, 0), (0, 1, 0)),)


def test_a_collider_outlives_the_python_object_of_its_simulation():
    sim, body = _platform()
    platform = sim.colliders[0]
    del sim
    platform.move_to((0, 1, 0))
    body.simulation.step()
    assert platform.translation.tolist() == [0, 1, 0]


def test_a_collider_of_a_scene_is_driven(bust):
    sim = supple.load_scene(bust, overrides={"body.bust.lattice_vertices": 100})
    (ground,) = sim.colliders
    rise = (0, 2 * np.ptp(sim.bodies[0].positions[:, 1]), 0)
    ground.move_to(rise, duration=1)
    sim.step(round(2 / sim.dt))
    assert ground.translation.tolist() == list(rise)
    # The lattice may extend below the mesh.
    assert sim.bodies[0].surface()[:, 1].min() > ground.point[1] + 0.95 * rise[1]


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (((0, np.nan, 0),), ValueError, r"translate\[1\] = NaN is not finite"),
        (((0, 0),), ValueError, r"translate has the shape \(2,\); it must be \(3,\)"),
        (("up",), TypeError, "translate must be"),
        ((None,), TypeError, "translate must be"),
        (((2e15, 0, 0),), ValueError, "translate = 2e15 is out of range: it must be finite and at most 1e15"),
        (((0, 0, 0), (0, 0, np.inf)), ValueError, r"rotate\[2\] = inf is not finite"),
        (((0, 0, 0), 90), ValueError, r"rotate has the shape \(\); it must be \(3,\)"),
        (((0, 0, 0), (0, -2e15, 0)), ValueError, "rotate = -2e15 is out of range"),
        (((0, 0, 0), (0, 0, 0), 0), ValueError, "duration = 0 is out of range: it must be a time in seconds"),
        (((0, 0, 0), (0, 0, 0), np.nan), ValueError, "duration = NaN is out of range"),
        (((0, 0, 0), (0, 0, 0), "1"), TypeError, "duration must be a number, not str"),
    ],
)
def test_invalid_targets_are_errors(arguments, error, message):
    sim, _ = _platform()
    with pytest.raises(error, match=message):
        sim.colliders[0].move_to(*arguments)
    assert sim.colliders[0].velocity.tolist() == [0, 0, 0]
    with pytest.raises(IndexError):
        sim.colliders[1].move_to((0, 0, 0))


def test_mesh_colliders_take_a_mesh_and_check_it(cube):
    bowl = supple.MeshCollider(cube, scale=2.0, rotate=(0, 90, 0), translate=[0, 1, 0], keys=[(0,), (1, (0, 1, 0))])
    assert bowl.mesh is cube
    assert (bowl.scale, bowl.rotate, bowl.translate) == (2.0, (0.0, 90.0, 0.0), (0.0, 1.0, 0.0))
    assert repr(bowl).startswith("MeshCollider(mesh=<supple.Mesh: ")
    restored = pickle.loads(pickle.dumps(bowl))
    assert np.array_equal(restored.mesh.vertices, cube.vertices)
    assert (restored.scale, restored.keys) == (bowl.scale, bowl.keys)
    assert copy.copy(bowl) == bowl
    for arguments, error, words in [
        ({"mesh": cube, "scale": 0}, ValueError, "scale = 0 is out of range: it must be a number above 0, or three"),
        ({"mesh": cube, "translate": (0, float("nan"), 0)}, ValueError, "translate"),
        (
            {"mesh": cube.vertices},
            TypeError,
            "mesh must be a supple.Mesh, a path, an object with vertices and faces, or a mesh of .*, not ndarray",
        ),
        ({"mesh": supple.Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)])}, ValueError, "no triangle"),
    ]:
        with pytest.raises(error, match=words):
            supple.MeshCollider(**arguments)


def test_mesh_colliders_take_what_bodies_take(cube, bust):
    class Triangles:
        vertices = cube.vertices
        triangles = cube.faces

    assert np.array_equal(supple.MeshCollider(Triangles()).mesh.faces, cube.faces)
    read = supple.MeshCollider(bust, inside=True).mesh
    assert np.array_equal(read.vertices, supple.read_obj(bust).vertices)
    with pytest.raises(FileNotFoundError, match=r"missing\.glb"):
        supple.MeshCollider("missing.glb")


def test_a_driven_mesh_carries_a_body(cube):
    body = supple.Body(cube, lattice_vertices=64, translate=(0, 1.02, 0))
    sim = supple.Simulation([body], dt=1 / 120, colliders=[supple.MeshCollider(SHEET, scale=3)], sleep=False)
    (sheet,) = sim.colliders
    assert sheet.mesh is SHEET
    sim.step(60)
    sheet.move_to((0.5, 0, 0), duration=1.0)
    sim.step(120)
    assert body.positions[:, 0].mean() == pytest.approx(0.5, abs=0.1)
    assert body.surface()[:, 1].min() > 0


def test_a_scene_with_a_mesh_collider_loads(tmp_path, cube):
    lines = [f"v {x} {y} {z}" for x, y, z in cube.vertices]
    lines += ["f " + " ".join(str(index + 1) for index in face) for face in cube.faces]
    (tmp_path / "cube.obj").write_text("\n".join(lines))
    scene = tmp_path / "scene.toml"
    scene.write_text('[[body]]\nmesh = "cube.obj"\ntranslate = [0, 3, 0]\n[[collider]]\nmesh = "cube.obj"\nscale = 2\n')
    (collider,) = supple.load_scene(scene).colliders
    assert isinstance(collider, supple.MeshCollider)
    assert (collider.scale, len(collider.mesh.vertices)) == (2.0, len(cube.vertices))


def test_a_mesh_that_deforms_lifts_a_body(cube):
    frames = np.stack([SHEET.vertices + (0, height, 0) for height in (0, 0, 1)])
    sheet = supple.MeshCollider(SHEET, scale=2, frames=frames, fps=1, start=0.5)
    assert np.array_equal(sheet.frames, frames)
    assert (sheet.fps, sheet.start) == (1.0, 0.5)
    restored = pickle.loads(pickle.dumps(sheet))
    assert np.array_equal(restored.frames, frames)
    body = supple.Body(cube, lattice_vertices=64, translate=(0, 1.02, 0))
    sim = supple.Simulation([body], dt=1 / 120, colliders=[restored])
    heights = []
    for _ in range(4):
        sim.step(75)
        heights.append(body.positions[:, 1].mean())
    # From 1.5 s to 2.5 s the sheet rises by 2.
    assert heights[3] - heights[1] == pytest.approx(2, abs=0.15)
    for arguments, words in [
        ({"frames": frames[:, :3]}, r"frames has the shape \(3, 3, 3\); it must be \(frames, 4, 3\)"),
        ({"frames": frames[0]}, "frames must have the shape"),
        ({"frames": frames, "fps": 0}, "fps is 0"),
        ({"frames": frames * np.nan}, "not finite"),
    ]:
        with pytest.raises(ValueError, match=words):
            supple.MeshCollider(SHEET, **arguments)


def test_a_box_is_given_by_corners_or_by_its_center():
    box = supple.Box((1, 2, 3), (1, 0.5, 2), friction=0.1)
    corners = supple.Box(min=(0, 1.5, 1), max=(2, 2.5, 5), friction=0.1)
    assert corners == box
    assert repr(corners) == repr(box)
    assert pickle.loads(pickle.dumps(corners)) == copy.copy(corners) == box
    for arguments, options in [
        ((), {}),
        (((0, 0, 0),), {}),
        ((), {"min": (0, 0, 0)}),
        (((0, 0, 0), (1, 1, 1)), {"max": 1}),
    ]:
        with pytest.raises(TypeError, match="either center and half_extents, or min= and max="):
            supple.Box(*arguments, **options)
    with pytest.raises(
        ValueError, match=r"min of a Box is \[0.0, 3.0, 0.0\] and max \[1.0, 1.0, 1.0\]; min must be less"
    ):
        supple.Box(min=(0, 3, 0), max=(1, 1, 1))
    with pytest.raises(ValueError, match=r"have the shapes \(2,\) and \(3,\)"):
        supple.Box(min=(0, 3), max=(1, 1, 1))


def test_a_collider_is_enabled_and_disabled_by_keyframes_and_by_its_attribute(cube):
    def run(enabled):
        body = supple.Body(cube, lattice_vertices=64, material="rubber", translate=(0, 1, 0))
        ground = supple.Box((0, -1, 0), (5, 1, 5), enabled=enabled)
        return supple.Simulation([body], dt=1 / 120, colliders=ground)

    lowest = {}
    for enabled in (
        True,
        False,
        [(1, False)],
        [{"time": 0, "value": True}, (0.5, False), (0.75, True)],
        ((0.5, True),),
    ):
        sim = run(enabled)
        assert sim.colliders[0].is_enabled is (enabled not in (False, ((0.5, True),)))
        sim.step(90)
        lowest[str(enabled)] = sim.bodies[0].surface()[:, 1].min()
    held, fallen, not_yet, caught, late = lowest.values()
    # 0.75 s of free fall are 2.8.
    assert held > -0.1
    assert not_yet == held
    assert fallen < -2.6
    assert -0.5 < caught < -0.2
    assert late > -1.3

    sim = run(True)
    ground = sim.colliders[0]
    assert ground == sim.colliders[0]
    assert ground.enabled is True
    sim.step(150)
    assert sim.bodies[0].is_asleep
    ground.enabled = False
    assert (ground.enabled, ground.is_enabled, sim.bodies[0].is_asleep) == (False, False, False)
    assert sim.raycast((4, 5, 4), (0, -1, 0))["collider"] == -1
    sim.step(60)
    assert sim.bodies[0].surface()[:, 1].min() < -1
    ground.enabled = [(9, True)]
    assert ground.enabled == ((9, True),)
    assert not ground.is_enabled
    twin = pickle.loads(pickle.dumps(sim))
    assert twin.colliders[0].enabled == ((9, True),)
    assert not twin.colliders[0].is_enabled
    sim.time = 9
    assert ground.is_enabled


def test_only_enabled_of_a_collider_of_a_simulation_can_be_set(cube):
    ground = supple.Plane((0, 0, 0), (0, 1, 0), enabled=((1, False),))
    sim = supple.Simulation([supple.Body(cube, lattice_vertices=64)], colliders=ground)
    assert sim.colliders[0] == ground
    assert hash(sim.colliders[0]) == hash(ground)
    assert copy.deepcopy(ground) == ground
    assert dataclasses.replace(ground, enabled=True).enabled is True
    with pytest.raises(dataclasses.FrozenInstanceError, match=r"enabled can be set for an item of sim\.colliders only"):
        ground.enabled = True
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign to field 'friction'"):
        sim.colliders[0].friction = 0.1
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot delete field 'friction'"):
        del ground.friction
    with pytest.raises(RuntimeError, match="not a collider of a simulation"):
        ground.is_enabled  # noqa: B018
    for enabled, error, message in [
        (1, TypeError, "enabled must be True, False, or a list of keyframes"),
        ([], ValueError, "there are no keys"),
        ([(0,)], ValueError, r"enabled\[0\] must be \(time, value\)"),
        ([(0, 1)], TypeError, r"enabled\[0\].value must be True or False, not int"),
        ([(1, True), (1, False)], ValueError, "not after key 0 at 1"),
    ]:
        with pytest.raises(error, match=message):
            supple.Plane((0, 0, 0), (0, 1, 0), enabled=enabled)
        with pytest.raises(error, match=message):
            sim.colliders[0].enabled = enabled


def test_a_misspelled_attribute_of_a_collider_is_an_error():
    plane = supple.Plane((0, 0, 0), (0, 1, 0))
    with pytest.raises(dataclasses.FrozenInstanceError, match="tickness"):
        plane.tickness = 0.1


def test_a_collider_of_a_simulation_keeps_its_hash_when_it_is_disabled():
    body = supple.Body(supple.Lattice.from_cells(np.ones((2, 2, 2))))
    sim = supple.Simulation([body], colliders=supple.Sphere((0, -9, 0), 1))
    ball = sim.colliders[0]
    known = {ball: "ball"}
    ball.enabled = False
    assert known[ball] == "ball"


@pytest.mark.parametrize("build", [supple.Sphere, lambda x, y, z: supple.Plane(x, (0, 1, 0), y), supple.Box])
def test_three_numbers_in_place_of_a_vector_say_what_is_expected(build):
    with pytest.raises(ValueError, match=r"is 0; it must be three numbers in one argument, such as \(0, 0, 1\)"):
        build(0, 1, 2)
