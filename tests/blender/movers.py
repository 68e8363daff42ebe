"""Checks what moves bodies: attachments and colliders."""

from __future__ import annotations

import bpy
import numpy as np
from scenes import (
    ROUNDING,
    added,
    attach,
    collider,
    cube,
    frames,
    group,
    matrix,
    new_scene,
    soft,
    world,
)


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


def check_rigged() -> None:
    """A part that follows a mesh with bones has the place of its Armature modifier, and the bake comes after it."""
    scene = new_scene(12)
    bpy.ops.object.armature_add(location=(0, 0, 0))
    armature = bpy.context.object
    bone = armature.pose.bones[0]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (12, 0.8)):
        bone.rotation_euler.z = angle
        bone.rotation_euler.x = angle / 2
        bone.keyframe_insert("rotation_euler", frame=frame)
    found = soft(cube("bar", location=(0, 0, 0.5)))
    group(found, bone.name, lambda point: True)
    group(found, "base", lambda point: point.z < 0)
    found.modifiers.new("Armature", "ARMATURE").object = armature
    found.modifiers.new("Subdivision", "SUBSURF").levels = 0
    attach(found, "base")
    animated = [world(found) for _ in frames()]
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert [modifier.name for modifier in found.modifiers] == ["Armature", "Supple", "Subdivision"]
    base = np.array([vertex.co.z < 0 for vertex in found.data.vertices])
    assert np.abs(animated[-1] - animated[0]).max() > 0.3
    for index in frames():
        # The bone moves the bar rigidly.
        assert np.abs(world(found) - animated[index])[base].max() < 20 * ROUNDING, f"frame {index}"
    assert np.abs(world(found) - animated[-1])[~base].max() > 1e-3, "the free part lags behind"
    scene.frame_set(1)


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


CHECKS = (check_handles, check_rigged, check_colliders)
