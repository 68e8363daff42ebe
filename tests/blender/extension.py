"""Installs the extension into Blender and bakes: every frame against the same run from Python, undo, modifiers, errors.

    python extension.py ZIP [PICTURES]      ZIP of scripts/blender-extension

Needs the package bpy. Settings and extensions of Blender go to a temporary directory. Exits with an error at the first
difference.
"""

from __future__ import annotations

import itertools
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

SCRATCH = Path(tempfile.mkdtemp(prefix="supple_"))
os.environ["BLENDER_USER_RESOURCES"] = str(SCRATCH / "resources")

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402

#: Rounding of 32-bit numbers, relative to the size of the scene, in a chain of a few transformations.
ROUNDING = 1e-6


def install(path: str) -> None:
    """Install the extension from its file, with the wheel that it bundles."""
    file = str(Path(path).resolve())
    bpy.ops.extensions.package_install_files(filepath=file, repo="user_default", enable_on_install=True)
    import supple

    assert SCRATCH in Path(supple.__file__).parents, f"{supple.__file__} is not the wheel of the extension"


def module(name: str) -> Any:
    """Return a module of the extension."""
    return sys.modules[f"bl_ext.user_default.supple.{name}"]


def new_scene(frames: int = 12) -> bpy.types.Scene:
    """Return an empty scene of frames 1 to `frames`, in a saved file of its own."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.supple")
    folder = Path(tempfile.mkdtemp(dir=SCRATCH))
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.render.fps = 24
    return scene


def added(kind: Callable[..., object], name: str, **options: Any) -> bpy.types.Object:
    """Add a primitive and return its object."""
    kind(**options)
    found = bpy.context.object
    found.name = name
    return found


def cube(name: str, size: float = 1.0, cuts: int = 5, **options: Any) -> bpy.types.Object:
    """Add a cube of small faces."""
    found = added(bpy.ops.mesh.primitive_cube_add, name, size=size, **options)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=cuts)
    bpy.ops.object.mode_set(mode="OBJECT")
    return found


def soft(found: bpy.types.Object, **settings: Any) -> bpy.types.Object:
    """Make an object a soft body."""
    found.supple.enabled = True
    for name, value in {"lattice_vertices": 200, **settings}.items():
        setattr(found.supple, name, value)
    return found


def collider(found: bpy.types.Object) -> bpy.types.Object:
    """Give an object Blender's collision physics."""
    found.modifiers.new("Collision", "COLLISION")
    return found


def group(found: bpy.types.Object, name: str, is_in: Callable[[mathutils.Vector], bool]) -> None:
    """Add a vertex group of the vertices whose own position fulfills a condition."""
    vertices = [vertex.index for vertex in found.data.vertices if is_in(vertex.co)]
    found.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")


def attach(found: bpy.types.Object, vertex_group: str, **settings: Any) -> None:
    """Hold or move a vertex group."""
    attachment = found.supple.attachments.add()
    attachment.vertex_group = vertex_group
    for name, value in settings.items():
        setattr(attachment, name, value)


def local(found: bpy.types.Object) -> np.ndarray:
    """Return the evaluated vertices in the space of the object, in the current frame: (n, 3)."""
    current = found.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = current.to_mesh()
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    current.to_mesh_clear()
    return points.reshape(-1, 3)


def matrix(found: bpy.types.Object) -> np.ndarray:
    """Return the world matrix in the current frame: (4, 4)."""
    current = found.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array(current.matrix_world, float)


def world(found: bpy.types.Object) -> np.ndarray:
    """Return the evaluated vertices in world space, in the current frame: (n, 3)."""
    placed = matrix(found)
    return local(found).astype(float) @ placed[:3, :3].T + placed[:3, 3]


def faces(found: bpy.types.Object) -> list[list[int]]:
    """Return the polygons of the mesh."""
    return [list(polygon.vertices) for polygon in found.data.polygons]


def frames() -> Iterator[int]:
    """Go through the frames of the scene; the index is that of the bake."""
    scene = bpy.context.scene
    for index, frame in enumerate(range(scene.frame_start, scene.frame_end + 1)):
        scene.frame_set(frame)
        yield index


def surfaces(sim: Any) -> list[list[np.ndarray]]:
    """Return the surfaces of all bodies in all frames of the scene."""
    result = [sim.surfaces()]
    for _ in range(bpy.context.scene.frame_end - bpy.context.scene.frame_start):
        sim.advance()
        result.append(sim.surfaces())
    return result


def refused(*parts: str) -> None:
    """Check that a bake is refused with a message that has all parts, and leaves no modifier."""
    message = ""
    try:
        bpy.ops.supple.bake()
    except RuntimeError as error:
        message = str(error)
    assert all(part in message for part in parts), f'"{message}" lacks one of {parts}'
    assert not any(modifier.type == "MESH_CACHE" for found in bpy.data.objects for modifier in found.modifiers)
    assert module("session").Session.current is None


def check_two_bodies() -> None:
    """Two bodies that touch, a pin and a ground: every frame has the bits of the same run from Python."""
    import supple

    scene = new_scene(30)
    scene.render.fps, scene.render.fps_base = 25, 1.25  # 20 frames per second
    lower = soft(cube("lower", location=(0, 0, 0)), material="FLESH")
    upper = soft(cube("upper/1", location=(0, 0, 0)), friction=0.2)
    for found, height in ((lower, 0.55), (upper, 1.8)):
        # The vertices are moved, so that the objects have no transformation and the cache has the bits of the run.
        found.data.transform(mathutils.Matrix.Translation((0, 0, height)))
    group(lower, "side", lambda point: point.x < -0.45)
    attach(lower, "side", motion="PIN", use_release=True, release_frame=15)
    ground = collider(added(bpy.ops.mesh.primitive_plane_add, "ground", size=10))
    ground.supple_collider.friction = 0.8
    shapes = {found.name: world(found) for found in (lower, upper, ground)}
    untouched = [tuple(vertex.co) for vertex in lower.data.vertices]
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert scene.frame_current == 1
    assert untouched == [tuple(vertex.co) for vertex in lower.data.vertices]

    options = {"lattice_vertices": 200, "self_contact": False}
    first = supple.Body(supple.Mesh(shapes["lower"], faces(lower)), name="lower", material="flesh", **options)
    first.pin(box=((-1, -1, 0), (-0.45, 1, 2)), end=14 / 20)
    second = supple.Body(supple.Mesh(shapes["upper/1"], faces(upper)), name="upper", friction=0.2, **options)
    floor = supple.MeshCollider(supple.Mesh(shapes["ground"], faces(ground)), friction=0.8)
    sim = supple.Simulation([first, second], fps=20, gravity=(0, 0, scene.gravity[2]), colliders=[floor])
    run = surfaces(sim)
    assert np.abs(run[-1][0] - run[0][0]).max() > 0.01, "the scene moves"
    for index in frames():
        for found, expected in zip((lower, upper), run[index], strict=True):
            assert np.array_equal(local(found), expected.astype(np.float32)), f"{found.name} in frame {index}"
    caches = sorted(path.name for path in (Path(bpy.data.filepath).parent / "supple_scene").iterdir())
    assert len(caches) == 2, caches
    assert caches[0] == "lower.pc2"
    assert caches[1].startswith("upper_1-")
    assert lower.modifiers["Supple"].filepath == "//supple_scene/lower.pc2"


def check_transformed() -> None:
    """A rotated, mirrored, non-uniformly scaled child of an animated parent: world positions are those of the run."""
    import supple

    scene = new_scene(12)
    parent = added(bpy.ops.object.empty_add, "parent", location=(1, 2, 3), rotation=(0.3, 0.2, 0.5))
    parent.scale = (1.5, 1, 1)
    found = soft(cube("child", location=(0.5, 0, 0), rotation=(0.4, 1, 0)))
    found.scale = (-0.5, 1, 2)
    found.parent = parent
    for frame, x in ((1, 1.0), (12, 3.0)):
        parent.location.x = x
        parent.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    shape = world(found)
    assert bpy.ops.supple.bake() == {"FINISHED"}
    # The mirrored polygons are turned around; the body is the same, but for the numbers of the triangles.
    mesh = supple.Mesh(shape, [polygon[::-1] for polygon in faces(found)])
    sim = supple.Simulation([supple.Body(mesh, lattice_vertices=200)], fps=24, gravity=(0, 0, -9.81))
    size = np.abs(shape).max()
    for index, expected in zip(frames(), surfaces(sim), strict=True):
        # Gravity of the scene is a 32-bit number.
        assert np.abs(world(found) - expected[0]).max() < 10 * ROUNDING * size, f"frame {index}"
    assert matrix(found)[0, 3] - np.array(parent.matrix_world)[0, 3] < 1
    assert world(found)[:, 2].max() < shape[:, 2].max()


def check_undo() -> None:
    """Undo takes the bake away, and redo plays it again."""
    scene = new_scene(8)
    soft(cube("box"))
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.supple.bake() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="bake")
    scene.frame_set(8)
    fallen = local(bpy.data.objects["box"])
    bpy.ops.ed.undo()
    found = bpy.data.objects["box"]
    assert not found.modifiers
    assert not found.supple.cache
    bpy.ops.ed.redo()
    found = bpy.data.objects["box"]
    bpy.context.scene.frame_set(8)
    assert np.array_equal(local(found), fallen)
    assert fallen[:, 2].max() < 0.4
    assert bpy.ops.supple.clear() == {"FINISHED"}
    assert not found.modifiers


def check_modifiers() -> None:
    """Modifiers before the bake shape the body, those after it stay live, and a second bake begins as the first one."""
    scene = new_scene(8)
    found = soft(cube("box", cuts=2))
    mirror = found.modifiers.new("Mirror", "MIRROR")
    mirror.use_axis, mirror.use_bisect_axis = (True, False, False), (True, False, False)
    found.data.transform(mathutils.Matrix.Translation((0.25, 0, 0)))
    found.modifiers.new("Subdivision", "SUBSURF")
    before = local(found)
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert [modifier.name for modifier in found.modifiers] == ["Mirror", "Supple", "Subdivision"]
    assert all(modifier.show_viewport for modifier in found.modifiers)
    scene.frame_set(1)
    # The first frame is the shape that the modifiers gave, to the rounding of the displayed surface.
    assert np.abs(local(found) - before).max() < ROUNDING * 2
    scene.frame_set(8)
    fallen = local(found)
    assert fallen.shape == before.shape
    assert fallen[:, 2].max() < before[:, 2].min() + 1
    found.modifiers["Subdivision"].levels = 0
    assert len(local(found)) < len(before)
    found.modifiers["Subdivision"].levels = 1
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert [modifier.name for modifier in found.modifiers] == ["Mirror", "Supple", "Subdivision"]
    assert np.array_equal(local(found), fallen)
    # A cache that is not a bake is neither played for one nor removed.
    foreign = Path(bpy.data.filepath).parent / "other.pc2"
    shutil.copy(bpy.path.abspath(found.modifiers["Supple"].filepath), foreign)
    found.modifiers.new("Foreign", "MESH_CACHE").filepath = str(foreign)
    copied = found.copy()
    scene.collection.objects.link(copied)
    file = Path(bpy.path.abspath(found.modifiers["Supple"].filepath))
    copied.supple.enabled = False
    bpy.context.view_layer.objects.active = found
    assert bpy.ops.supple.remove() == {"FINISHED"}
    assert file.exists(), "the copy of the object plays the file"
    assert bpy.ops.supple.clear() == {"FINISHED"}
    assert not file.parent.exists()
    assert foreign.exists()
    assert [modifier.name for modifier in found.modifiers] == ["Mirror", "Subdivision", "Foreign"]


def check_handles() -> None:
    """Groups follow an empty, a bone and the animated mesh, and the rest of the body hangs on them."""
    scene = new_scene(16)
    empty = added(bpy.ops.object.empty_add, "empty", location=(0.5, 0, 0))
    for frame, angle in ((1, 0), (16, 2.5)):
        empty.rotation_euler = (0, angle / 2, angle)
        empty.location.z = angle / 3
        empty.keyframe_insert("rotation_euler", frame=frame)
        empty.keyframe_insert("location", frame=frame)
    bpy.ops.object.armature_add(location=(0, 3, 0))
    armature = bpy.context.object
    bone = armature.pose.bones[0]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.2), (16, 1.2)):
        bone.rotation_euler.x = angle
        bone.keyframe_insert("rotation_euler", frame=frame)
    led, boned, keyed = (soft(cube(name, location=(0, y, 0))) for name, y in (("led", 0), ("boned", 3), ("keyed", 6)))
    for found in (led, boned, keyed):
        group(found, "top", lambda point: point.z > 0.3)
    attach(led, "top", motion="OBJECT", target=empty)
    attach(boned, "top", motion="OBJECT", target=armature, bone=bone.name)
    attach(keyed, "top", motion="ANIMATION")
    keyed.shape_key_add(name="Basis")
    key = keyed.shape_key_add(name="lean")
    for point in key.data:
        point.co.x += 0.3 * (point.co.z + 0.5)
    for frame, value in ((1, 0.0), (16, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
        keyed.location.x = value
        keyed.keyframe_insert("location", frame=frame)
    drivers = {
        "led": lambda: matrix(empty),
        "boned": lambda: (
            matrix(armature)
            @ np.array(armature.evaluated_get(bpy.context.evaluated_depsgraph_get()).pose.bones[0].matrix, float)
        ),
    }
    animated = []
    for _ in frames():
        animated.append(world(keyed))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    scene.frame_set(1)
    rest = {found.name: world(found) for found in (led, boned, keyed)}
    start = {name: driver() for name, driver in drivers.items()}
    # All vertices of a held cell move with it; the cells of the group reach down to 0.3 at least.
    held = np.array([vertex.co.z > 0.3 for vertex in led.data.vertices])
    for index in frames():
        for name, driver in drivers.items():
            motion = driver() @ np.linalg.inv(start[name])
            expected = rest[name] @ motion[:3, :3].T + motion[:3, 3]
            error = np.abs(world(bpy.data.objects[name]) - expected)[held].max()
            assert error < 20 * ROUNDING * 4, f"{name} is {error} off its driver in frame {index}"
        # The lattice vertices approximate an animation that is not rigid.
        error = np.abs(world(keyed) - animated[index])[held].max()
        assert error < 0.01, f"keyed is {error} off its animation in frame {index}"
    assert np.abs(world(keyed) - animated[-1])[~held].max() > 0.01, "the free part swings"


def check_colliders() -> None:
    """A collider that moves rigidly, one that deforms and a ground push or carry a body; hidden ones do not."""
    scene = new_scene(30)
    found = soft(cube("box", location=(0, 0, 0.6)))
    ground = collider(added(bpy.ops.mesh.primitive_plane_add, "ground", size=1))
    ground.supple_collider.shape = "PLANE"
    hidden = collider(added(bpy.ops.mesh.primitive_plane_add, "hidden", size=10, location=(0, 0, 0.05)))
    hidden.hide_set(True)
    pusher = collider(added(bpy.ops.mesh.primitive_cube_add, "pusher", size=1, location=(-2, 0, 0.5)))
    for frame, x in ((1, -2.0), (30, -0.5)):
        pusher.location.x = x
        pusher.keyframe_insert("location", frame=frame)
    press = collider(added(bpy.ops.mesh.primitive_plane_add, "press", size=2, location=(3, 0, 1.2)))
    squeezed = soft(cube("squeezed", location=(3, 0, 0.51)))
    press.shape_key_add(name="Basis")
    key = press.shape_key_add(name="down")
    for point in key.data:
        point.co.z -= 0.5
    for frame, value in ((1, 0.0), (20, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    assert bpy.ops.supple.bake() == {"FINISHED"}
    scene.frame_set(10)
    assert world(found)[:, 2].min() < 0.04, "a hidden collider stops nothing"
    scene.frame_set(30)
    # Bodies touch within a small part of a cell, which is 0.2 here.
    assert world(found)[:, 2].min() > -0.02
    assert world(found)[:, 0].min() > -0.02, "the pusher ends at x = 0"
    assert world(squeezed)[:, 2].max() < 0.72, "the press ends at z = 0.7"
    pressed = world(squeezed)
    assert np.ptp(pressed[:, 0]) > 1.02, "the volume is kept"


def check_time() -> None:
    """A remapped time plays one sample per frame of the scene, and the file outlasts saving elsewhere."""
    import supple

    scene = new_scene(12)
    found = soft(cube("box"))
    found.data.transform(mathutils.Matrix.Translation((0, 0, 0)))
    scene.frame_start, scene.frame_end = 5, 12
    scene.render.frame_map_old, scene.render.frame_map_new = 100, 200
    shape = local(found)
    assert bpy.ops.supple.bake() == {"FINISHED"}
    body = supple.Body(supple.Mesh(shape, faces(found)), lattice_vertices=200, self_contact=False)
    sim = supple.Simulation([body], fps=24, gravity=(0, 0, scene.gravity[2]))
    run = surfaces(sim)
    for index in frames():
        # The place between two samples that Blender computes has a rounding error.
        assert np.abs(local(found) - run[index][0]).max() < ROUNDING * 4, f"frame {index}"
    scene.frame_set(2)
    assert np.array_equal(local(found), run[0][0].astype(np.float32)), "before the first frame"
    last = run[-1][0].astype(np.float32)
    folder = Path(bpy.data.filepath).parent / "supple_scene"
    assert [path.name for path in folder.iterdir()] == ["box.pc2"]
    found.name = "renamed"
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert [path.name for path in folder.iterdir()] == ["renamed.pc2"]
    moved = Path(tempfile.mkdtemp(dir=SCRATCH)) / "moved.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(moved))
    bpy.ops.wm.open_mainfile(filepath=str(moved))
    found = bpy.data.objects["renamed"]
    bpy.context.scene.frame_set(12)
    assert np.array_equal(local(found), last), "after the file was saved elsewhere"
    assert bpy.ops.supple.clear() == {"FINISHED"}
    assert not found.modifiers


def check_units() -> None:
    """A scene in centimeters gives the motion of the same scene in meters."""
    results = []
    for meters, units in ((1.0, 1.0), (0.01, 100.0)):
        scene = new_scene(10)
        scene.unit_settings.scale_length = meters
        scene.gravity = (0, 0, -9.81 * units)
        found = soft(cube("box"), material="CUSTOM", youngs_modulus=2e4, density=500)
        found.scale = (units, units, units)
        group(found, "top", lambda point: point.z > 0.4)
        attach(found, "top")
        assert bpy.ops.supple.bake() == {"FINISHED"}
        scene.frame_set(10)
        results.append(world(found) / units)
    sag = results[0][:, 2].min() + 0.5
    assert sag < -0.01
    # Rounding errors differ, since the units have no power of two as their ratio.
    assert np.abs(results[1] - results[0]).max() < 0.001 * abs(sag)


def check_stiffness() -> None:
    """A stiffness group makes a part softer."""
    sags = []
    for name in ("", "soft"):
        scene = new_scene(24)
        found = soft(cube("box"), material="FLESH", stiffness_factor=0.1)
        group(found, "top", lambda point: point.z > 0.4)
        group(found, "soft", lambda point: True)
        attach(found, "top")
        found.supple.stiffness_group = name
        assert bpy.ops.supple.bake() == {"FINISHED"}
        scene.frame_set(24)
        sags.append(-0.5 - world(found)[:, 2].min())
    # The sag of an elastic body is inversely proportional to its stiffness; the body still oscillates.
    assert sags[1] > 3 * sags[0] > 0, sags


def check_ignore() -> None:
    """Bodies of the collection that a body ignores pass through it."""
    heights = []
    for is_ignored in (False, True):
        scene = new_scene(12)
        lower, upper = soft(cube("lower")), soft(cube("upper", location=(0, 0, 1.05)))
        group(lower, "all", lambda point: True)
        attach(lower, "all")
        if is_ignored:
            lower.supple.ignore = bpy.data.collections.new("through")
            lower.supple.ignore.objects.link(upper)
            lower.supple.ignore.objects.link(lower)
        assert bpy.ops.supple.bake() == {"FINISHED"}
        scene.frame_set(12)
        heights.append(world(upper)[:, 2].min())
    assert heights[0] > 0.45
    assert heights[1] < 0.0, "it falls by 1.03 in 11 frames of 1/24 s"


def check_suzanne() -> None:
    """Suzanne, an open mesh with loose eyes, falls on a ground with the settings that she has by default."""
    scene = new_scene(24)
    found = added(bpy.ops.mesh.primitive_monkey_add, "Suzanne", location=(0, 0, 1.2))
    assert bpy.ops.supple.add() == {"FINISHED"}
    found.modifiers.new("Subdivision", "SUBSURF")
    collider(added(bpy.ops.mesh.primitive_plane_add, "ground", size=10))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    before = world(found)
    scene.frame_set(24)
    after = world(found)
    assert after.shape == before.shape
    assert np.isfinite(after).all()
    assert -0.05 < after[:, 2].min() < 0.1
    assert np.ptp(after[:, 2]) > 0.8 * np.ptp(before[:, 2])


def check_cancel() -> None:
    """A bake that is cancelled, while reading or simulating, changes neither the scene nor an earlier bake."""
    scene = new_scene(12)
    found = soft(cube("box"))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    file = Path(bpy.path.abspath(found.modifiers["Supple"].filepath))
    contents = file.read_bytes()
    found.supple.material = "JELLY"
    scene.frame_end = 2000
    scene.frame_set(7)
    session_module = module("session")
    cancelled = module("bake").BakeCancelledError
    for phase in (session_module.Phase.READING, session_module.Phase.SIMULATING):
        session = session_module.Session(bpy.context)
        texts = set()
        while session.phase is not phase or session.progress == 0:
            session.work(0.02)
            texts.add(session.text)
        assert 0 < session.progress < 1
        assert any(phase.value in text for text in texts)
        assert not bpy.ops.supple.bake.poll(), "one bake at a time"
        assert bpy.ops.supple.cancel() == {"FINISHED"}
        while not session.is_done:
            session.work(0.02)
        try:
            session.finish()
        except cancelled:
            pass
        else:
            raise AssertionError("the session was not cancelled")
        assert file.read_bytes() == contents
        assert len(list(file.parent.iterdir())) == 1
        assert scene.frame_current == 7
        assert found.modifiers["Supple"].show_viewport
        assert bpy.ops.supple.bake.poll()


def check_modal() -> None:
    """The operator that the button starts shows progress, restores the interface, adds results, and is ended by Esc."""
    scene = new_scene(300)
    found = soft(cube("box"))
    operators = module("operators")
    operators.PORTION = 0.0  # one frame per event; a scene as simple as this one is read in one portion otherwise

    # Without a window Blender sends no events, so that the methods of the operator are called directly.
    class Running:
        reports: ClassVar[list[tuple[set[str], str]]] = []
        _timer = bpy.context.window_manager.event_timer_add(0.1, window=bpy.context.window)
        _start, _finish, modal, cancel = (
            vars(operators.Bake)[name] for name in ("_start", "_finish", "modal", "cancel")
        )
        _has_module, _reported = (vars(operators.Command)[name] for name in ("_has_module", "_reported"))

        def report(self, kind: set[str], message: str) -> None:
            self.reports.append((kind, message))

    def run(events: Iterator[tuple[str, str]]) -> tuple[list[set[str]], list[str]]:
        operator, results, texts = Running(), [], []
        assert operator._start(bpy.context)
        while not results or results[-1] <= {"RUNNING_MODAL", "PASS_THROUGH"}:
            kind, value = next(events)
            results.append(operator.modal(bpy.context, SimpleNamespace(type=kind, value=value)))
            session = module("session").Session.current
            texts += [session.text] if session is not None else []
        assert module("session").Session.current is None
        return results, texts

    results, texts = run(itertools.repeat(("TIMER", "NOTHING")))
    assert results[0] == {"RUNNING_MODAL"}, "the interface is locked while the scene is read"
    assert {"PASS_THROUGH"} in results, "the interface is free during the simulation"
    assert results[-1] == {"FINISHED"}
    assert any("Reading frame" in text for text in texts)
    assert any("Simulating frame" in text for text in texts)
    assert Running.reports[-1][0] == {"INFO"}
    assert found.modifiers["Supple"].frame_start == 1
    assert scene.frame_current == 1
    assert bpy.ops.supple.clear() == {"FINISHED"}
    results, _ = run(itertools.chain([("ESC", "PRESS")], itertools.repeat(("TIMER", "NOTHING"))))
    assert results[-1] == {"CANCELLED"}
    assert "cancelled" in Running.reports[-1][1]
    assert not found.modifiers


def check_errors() -> None:
    """What cannot be baked is refused with the name of the object and the way out."""
    scene = new_scene(4)
    refused("No visible object is a soft body", "Physics properties")
    found = soft(cube("box"))
    attach(found, "missing")
    refused('"box"', 'no vertex group "missing"', "choose one")
    found.vertex_groups.new(name="missing")
    refused('"box", vertex group "missing"', "no vertex has a weight of 0.5", "assign vertices")
    found.supple.attachments.clear()
    attach(found, "")
    refused('"box"', "an attachment has no vertex group")
    found.supple.attachments[0].vertex_group = "missing"
    found.vertex_groups["missing"].add([0, 1], 1.0, "REPLACE")
    found.supple.attachments[0].motion = "OBJECT"
    refused('"box", vertex group "missing"', "choose the object that moves the group")
    empty = added(bpy.ops.object.empty_add, "empty")
    found.supple.attachments[0].target = empty
    found.supple.attachments[0].bone = "hand"
    refused('"empty" has no bone "hand"')
    found.supple.attachments[0].bone = ""
    empty.hide_set(True)
    refused('"empty" is hidden', "show it")
    empty.hide_set(False)
    found.supple.attachments[0].target = found
    refused("cannot move its own group", '"Animation"')
    found.supple.attachments.clear()
    found.scale.z = 0
    refused('"box" has no extent along an axis in frame 0', "scale")
    found.scale.z = 1
    scene.frame_end = 1
    refused("frame range", "later end frame")
    scene.frame_end = 4
    array = found.modifiers.new("Array", "ARRAY")
    for frame, array.count in ((1, 1), (4, 4)):
        array.keyframe_insert("count", frame=frame)
    attach(found, "missing")
    refused('"box" has', "vertices in frame", "remove the modifier")
    found.modifiers.clear()
    found.supple.attachments.clear()
    occupied = Path(bpy.data.filepath).parent / "occupied"
    occupied.write_text("a file, not a folder")
    scene.supple.directory = str(occupied / "bakes")
    refused('The cache of object "box" cannot be written', "choose another Cache Folder")
    scene.supple.directory = ""
    found.supple.lattice_vertices = 2_000_000_000
    refused('"box" cannot be a soft body')
    found.supple.lattice_vertices = 200
    bpy.context.view_layer.objects.active = found
    bpy.ops.object.mode_set(mode="EDIT")
    refused('"box" is in Edit Mode', "Tab")
    bpy.ops.object.mode_set(mode="OBJECT")
    found.data.clear_geometry()
    refused('"box" has no faces')
    missing = sys.modules.pop("supple")
    sys.modules["supple"] = None
    try:
        refused("module supple is not at hand", "zip file", "scripts/blender-extension")
    finally:
        sys.modules["supple"] = missing


class Layout:
    """Stands for the layout of a panel: notes what is drawn, and checks that properties and operators exist."""

    def __init__(self, drawn: list[str]) -> None:
        """Share the list of a parent."""
        self._drawn = drawn

    def prop(self, data: Any, name: str, **options: Any) -> None:
        """Note a property."""
        getattr(data, name)
        self._drawn.append(name)

    def prop_search(self, data: Any, name: str, source: Any, collection: str, **options: Any) -> None:
        """Note a property that is chosen from a collection."""
        getattr(source, collection)
        self.prop(data, name)

    def operator(self, name: str, **options: Any) -> None:
        """Note an operator."""
        category, operator = name.split(".")
        getattr(getattr(bpy.ops, category), operator).get_rna_type()
        self._drawn.append(name)

    def template_list(
        self, kind: str, name: str, data: Any, items: str, active_data: Any, active: str, **_: Any
    ) -> None:
        """Draw all items of a list."""
        for item in getattr(data, items):
            module("panels").AttachmentList.draw_item(None, bpy.context, self, data, item, 0, active_data, active)

    def label(self, **options: Any) -> None:
        """Note a text."""
        self._drawn.append(options["text"])

    def progress(self, **options: Any) -> None:
        """Note a progress bar."""
        self._drawn.append(options["text"])

    def row(self, **options: Any) -> Layout:
        """Return a part of the layout."""
        return Layout(self._drawn)

    column = row


def drawn() -> list[str]:
    """Draw all panels of the active object, and return what they show."""
    panels, shown = module("panels"), []
    panel = type("Panel", (), {"layout": Layout(shown)})()
    panels.draw_button(panel, bpy.context)
    for kind in panels.CLASSES:
        if issubclass(kind, bpy.types.Panel) and kind.poll(bpy.context):
            kind.draw(panel, bpy.context)
    return shown


def check_panels() -> None:
    """Panels show the settings of soft bodies and of colliders, and the progress of a bake."""
    scene = new_scene(6)
    found = cube("box")
    assert drawn() == ["supple.add"]
    assert bpy.ops.supple.add() == {"FINISHED"}
    group(found, "top", lambda point: point.z > 0.4)
    bpy.ops.supple.add_attachment()
    empty = bpy.data.objects.new("empty", bpy.data.objects.new("rig", bpy.data.armatures.new("rig")).data)
    scene.collection.objects.link(empty)
    attachment = found.supple.attachments[0]
    assert attachment.vertex_group == "top"
    attachment.motion, attachment.target = "OBJECT", empty
    shown = drawn()
    settings = set(type(found.supple).bl_rna.properties.keys()) - {"rna_type", "name"}
    hidden = {"enabled", "cache", "cell_size", "youngs_modulus", "attachments", "active_attachment"}
    assert settings - hidden <= set(shown), settings - hidden - set(shown)
    assert {"supple.remove", "supple.bake", "supple.clear", "target", "bone", "Object or Bone", "gravity"} <= set(shown)
    found.supple.material, found.supple.resolution = "CUSTOM", "CELL_SIZE"
    assert {"youngs_modulus", "cell_size"} <= set(drawn())
    bpy.ops.supple.remove_attachment()
    assert not found.supple.attachments
    assert "target" not in drawn()
    session = module("session").Session(bpy.context)
    session.work(0.0)
    assert {session.text, "supple.cancel"} <= set(drawn())
    session.close()
    collider(added(bpy.ops.mesh.primitive_plane_add, "ground"))
    assert drawn() == ["supple.add", "shape", "friction", "restitution"]
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.supple")
    assert not hasattr(bpy.types.Object, "supple")
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.supple")
    assert bpy.data.objects["box"].supple.enabled


def check_unsaved() -> None:
    """A file that is not saved has its bakes in Blender's temporary folder."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.supple")
    bpy.context.scene.frame_end = 4
    found = soft(cube("box"))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert Path(bpy.app.tempdir) in Path(found.modifiers["Supple"].filepath).parents


CHECKS = (
    check_two_bodies,
    check_transformed,
    check_undo,
    check_modifiers,
    check_handles,
    check_colliders,
    check_time,
    check_units,
    check_stiffness,
    check_ignore,
    check_suzanne,
    check_cancel,
    check_modal,
    check_errors,
    check_panels,
    check_unsaved,
)


if __name__ == "__main__":
    try:
        install(sys.argv[1])
        chosen = sys.argv[2:]
        for check in CHECKS:
            if not chosen or check.__name__ in chosen:
                check()
                print(f"{check.__name__.removeprefix('check_')}: {check.__doc__.splitlines()[0]}", flush=True)
        print(f"Blender {bpy.app.version_string}: all checks of the extension passed")
    finally:
        shutil.rmtree(SCRATCH, ignore_errors=True)
