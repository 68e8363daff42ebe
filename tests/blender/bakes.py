"""Checks the results of bakes: every frame against the same run from Python, modifiers, time, units, settings."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import bpy
import mathutils
import numpy as np
from scenes import (
    ROUNDING,
    SCRATCH,
    added,
    attach,
    collider,
    cube,
    faces,
    frames,
    group,
    local,
    module,
    new_scene,
    soft,
    surfaces,
    world,
)


def check_two_bodies() -> None:
    """Two bodies that touch, a pin and a ground: every frame has the bits of the same run from Python."""
    import supple

    scene = new_scene(30)
    scene.render.fps, scene.render.fps_base = 25, 1.25  # 20 frames per second
    lower = soft(cube("lower", location=(0, 0, 0)), material="FLESH")
    upper = soft(cube("upper/1", location=(0, 0, 0)), friction=0.2, thickness=0.0625)
    for found, height in ((lower, 0.55), (upper, 1.8)):
        # The vertices are moved, so that the objects have no transformation and the cache has the bits of the run.
        found.data.transform(mathutils.Matrix.Translation((0, 0, height)))
    group(lower, "side", lambda point: point.x < -0.45)
    attach(lower, "side", motion="PIN", use_release=True, release_frame=15)
    ground = collider(added(bpy.ops.mesh.primitive_plane_add, "ground", size=10))
    ground.supple_collider.friction, ground.supple_collider.thickness = 0.8, 0.125
    shapes = {found.name: world(found) for found in (lower, upper, ground)}
    untouched = [tuple(vertex.co) for vertex in lower.data.vertices]
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert scene.frame_current == 1
    assert untouched == [tuple(vertex.co) for vertex in lower.data.vertices]

    options = {"lattice_vertices": 200, "self_contact": False}
    first = supple.Body(supple.Mesh(shapes["lower"], faces(lower)), name="lower", material="flesh", **options)
    first.pin(box=((-1, -1, 0), (-0.45, 1, 2)), end=14 / 20)
    shape = supple.Mesh(shapes["upper/1"], faces(upper))
    # Blender keeps 0.2 and 0.8 in single precision.
    second = supple.Body(shape, name="upper", friction=upper.supple.friction, thickness=0.0625, **options)
    friction = ground.supple_collider.friction
    floor = supple.MeshCollider(supple.Mesh(shapes["ground"], faces(ground)), friction=friction, thickness=0.125)
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
    fall = 9.81 / 2 * (11 / 24) ** 2
    assert abs(shape[:, 2].mean() - world(found)[:, 2].mean() - fall) < 0.1 * fall, "it falls freely"


def check_modifiers() -> None:
    """Modifiers before the bake shape the body, those after it stay live, and a second bake begins as the first one."""
    scene = new_scene(8)
    found = soft(cube("box", cuts=2))
    mirror = found.modifiers.new("Mirror", "MIRROR")
    mirror.use_axis, mirror.use_bisect_axis = (True, False, False), (True, False, False)
    found.data.transform(mathutils.Matrix.Translation((0.25, 0, 0)))
    found.modifiers.new("Subdivision", "SUBSURF")
    # As Shade Auto Smooth adds one.
    pinned = found.modifiers.new("Pinned", "NODES")
    pinned.use_pin_to_last = True
    before = local(found)
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert [modifier.name for modifier in found.modifiers] == ["Mirror", "Supple", "Subdivision", "Pinned"]
    found.modifiers.remove(found.modifiers["Pinned"])
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


def check_time() -> None:
    """A remapped time plays one sample per frame of the scene, and the file outlasts saving elsewhere."""
    import supple

    scene = new_scene(12)
    found = soft(cube("box"))
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


def check_inflation() -> None:
    """Ratios of rest volumes are animated, and every frame has the bits of the same run from Python."""
    import supple

    scene = new_scene(12)
    scene.use_gravity = False
    found = soft(cube("box"), inflation_ratio=1.5)
    group(found, "top", lambda point: point.z > 0.1)
    for frame, found.supple.inflate in ((1, 1.0), (12, 1.25)):
        assert found.keyframe_insert("supple.inflate", frame=frame)
    shape = world(found)
    mesh = supple.Mesh(shape, faces(found))
    for name in ("", "top"):
        found.supple.inflation_group = name
        assert bpy.ops.supple.bake() == {"FINISHED"}
        ratios = [found.supple.inflate for _ in frames()]
        assert (ratios[0], ratios[-1]) == (1.0, 1.25)
        assert 1.0 < ratios[1] < ratios[5] < 1.25, "the curve is sampled in each frame"
        keys = [(index / 24, ratio) for index, ratio in enumerate(ratios)]
        body = supple.Body(mesh, lattice_vertices=200, inflate=keys)
        if name:
            weights = np.array([float(vertex.co.z > 0.1) for vertex in found.data.vertices])
            body.zone(inflate=1.5, map=weights)
        sim = supple.Simulation([body], fps=24, gravity=(0, 0, 0))
        for index, expected in zip(frames(), surfaces(sim), strict=True):
            assert np.array_equal(local(found), expected[0].astype(np.float32)), f'group "{name}" in frame {index}'
        volume = supple.Mesh(world(found), faces(found)).volume
        expected = 1.25 if not name else body.volume_report().rest
        assert abs(volume - expected) < 1e-5 * expected
    assert volume > 1.25 * 1.1, "the top grows by half beside the body"


def check_materials() -> None:
    """A material has its own Poisson's ratio, and Young's modulus has the number beside it."""
    new_scene()
    found = soft(cube("box"), poisson_ratio=0.2)
    options = module("scene.settings").body_options
    for material in ("JELLY", "FLESH", "RUBBER", "FIRM"):
        found.supple.material = material
        assert "poisson_ratio" not in options(found, bpy.context.scene, [found])
    found.supple.material = "CUSTOM"
    assert abs(options(found, bpy.context.scene, [found])["poisson_ratio"] - 0.2) < ROUNDING


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


CHECKS = (
    check_two_bodies,
    check_transformed,
    check_modifiers,
    check_time,
    check_units,
    check_stiffness,
    check_inflation,
    check_materials,
    check_ignore,
    check_suzanne,
)
