"""Blender: soft bodies of mass points and springs, by the Python module bpy."""

from __future__ import annotations

import itertools
import math
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from peer import THREADS
from tasks import FPS, GRAVITY, Hold, Task

from shapes import Indices, Points, Shape

FIRST_FRAME = 1
TICK = 1 / math.sqrt(1000)
"""The unit of time of the solver in s: it accelerates by 0.001 times the gravity of the scene."""
FEWEST_STEPS = 10
"""Per frame: the default."""
CONTACT_DAMPING = 50.0
"""Rate at which a point of mass 1 in a collider loses its velocity, per unit of the setting Damping, in 1 / TICK."""
DRAG = 0.01
"""Force over velocity, of a point and between the ends of an edge, per unit of the settings Friction and Damp."""
PLANE = 20.0
"""Half the edge of the squares that stand for planes, in m."""


class Softbody:
    """Physics of the type Soft Body."""

    PACKAGE = "bpy"
    SETTINGS = (
        "Mesh edges along the cubes and both diagonals of their faces, also inside; the manual's page on interior "
        "forces calls additional edges the logical method against collapse. Pull and Push give a force per strain of "
        "an edge, 1 / (1 - Pull) - 1, not a modulus: both have the value with which all edges together have Young's "
        "modulus, with a Poisson's ratio of 0.23. Speed 0.53, the manual's 1.3 at 25 frames per second. Masses in a "
        "unit of choice, 3 x the edge of a cube in m per point, with which the forces of colliders, which do not "
        "depend on mass, stop a body within their zones. Min Step: the default 10, or more where a step were longer "
        "than a radian of the fastest wave; Error Limit: half the edge of a cube (the manual), of positions only (V "
        "off). Damp: takes the velocity of the fastest wave in a step. "
        "Friction: a drag of 0.16 / s, as by default. Held points: a goal with a vertex group, moved by hooks; keys of "
        "Goal Maximum let go. Ground and other bodies: the modifier Collision, whose friction is viscous. "
        "Self-collision: balls of the default size, about as stiff as the edges. Two threads."
    )

    def __init__(self, task: Task) -> None:
        """Build the scene."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        self.scene.gravity = (0, 0, -GRAVITY)
        self.scene.render.fps = FPS
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", THREADS
        self.scene.frame_start, self.scene.frame_end = FIRST_FRAME, FIRST_FRAME + task.frames
        self.task = task
        self.edges = springs(task.shape)
        # The forces of colliders are about 1 in units of the solver. With this mass in a unit of choice, a point weighs
        # far less, and a wave of impact presses a point with about 0.3.
        self.mass = 3 * task.shape.cell_size
        self.fit()
        for point, normal in task.planes:
            self.add_plane(np.array(point, float), np.array(normal, float))
        self.bodies = [self.add_body(points, () if index else task.holds) for index, points in enumerate(task.bodies())]
        self.frame = FIRST_FRAME
        self.scene.frame_set(self.frame)

    def fit(self) -> None:
        """Choose the force per strain of an edge, the steps per frame, and the damping of the edges.

        If the body deforms uniformly (Cauchy and Born), the edges have an elasticity whose Young's modulus along the
        axes is that of the task. Of the wave in which all points move against their neighbors, a step is one radian,
        and damping takes its velocity within a step.
        """
        task, shape = self.task, self.task.shape
        vectors = shape.points[self.edges[:, 1]] - shape.points[self.edges[:, 0]]
        lengths = np.linalg.norm(vectors, axis=1)
        squares = (vectors / lengths[:, None]) ** 2
        volume = len(shape.corners) * shape.cell_size**3
        tensor = (squares * lengths[:, None]).T @ squares / volume
        along = np.trace(tensor) / 3
        across = (tensor.sum() - np.trace(tensor)) / 6
        force = task.youngs_modulus / (along - 2 * across**2 / (along + across))
        mass = task.density * volume / len(shape.points)
        stiffness, directions = np.zeros_like(shape.points), np.zeros_like(shape.points)
        for end in (0, 1):
            np.add.at(stiffness, self.edges[:, end], squares * (force / lengths)[:, None])
            np.add.at(directions, self.edges[:, end], squares)
        self.stiffness = force * TICK**2 * self.mass / mass
        self.step_count = max(FEWEST_STEPS, math.ceil(math.sqrt(2 * stiffness.max() / mass) / FPS))
        self.step = 1 / (FPS * self.step_count * TICK)
        self.damping = self.mass / (2 * directions.max() * self.step)

    def add_plane(self, point: Points, normal: Points) -> None:
        """Add a large square that collides."""
        one = np.roll(normal, 1)
        other = np.cross(normal, one)
        corners = [point + PLANE * (i * one + j * other) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        plane = self.add_object("plane", np.array(corners), np.zeros((0, 2), int), np.array([[0, 1, 2, 3]]))
        self.collide(plane)

    def collide(self, item: Any) -> None:
        """Let an object push the points of soft bodies out, and stop them within a step."""
        item.modifiers.new("collision", "COLLISION")
        item.collision.damping = min(1.0, self.mass / (CONTACT_DAMPING * self.step))

    def add_object(self, name: str, points: Points, edges: Indices, faces: Indices) -> Any:
        """Add an object with a mesh."""
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(points, edges, faces)
        item = bpy.data.objects.new(name, mesh)
        self.scene.collection.objects.link(item)
        return item

    def add_body(self, points: Points, holds: tuple[Hold, ...]) -> Any:
        """Add a soft body."""
        task, shape = self.task, self.task.shape
        body = self.add_object("body", points, self.edges, shape.surface[shape.triangles])
        group = body.vertex_groups.new(name="held")
        for hold in holds:
            group.add(hold.points.tolist(), 1.0, "REPLACE")
            self.hook(body, points, hold)
        modifier = body.modifiers.new("soft", "SOFT_BODY")
        modifier.point_cache.frame_start, modifier.point_cache.frame_end = self.scene.frame_start, self.scene.frame_end
        soft = modifier.settings
        soft.speed = 1 / (FPS * TICK)
        soft.mass, soft.friction, soft.damping = self.mass, 0.5 * self.mass, self.damping / DRAG
        soft.pull = soft.push = 1 - 1 / (1 + self.stiffness)
        soft.step_min = self.step_count
        soft.use_auto_step = False
        soft.error_threshold = shape.cell_size / 2
        soft.use_goal = bool(holds)
        if holds:
            soft.vertex_group_goal, soft.goal_default = group.name, 1.0
            last = FIRST_FRAME + round(holds[0].end * FPS)
            for soft.goal_max, frame in ((1.0, last), (0.0, last + 1)):
                soft.keyframe_insert("goal_max", frame=frame)
        soft.use_self_collision = task.self_contact
        # At an overlap of a third the balls press about as strongly as edges that are a tenth shorter.
        soft.ball_stiff = 2 * self.stiffness * shape.cell_size
        if len(task.places) > 1:
            self.collide(body)
            body.collision.thickness_inner = shape.cell_size
        return body

    def hook(self, body: Any, points: Points, hold: Hold) -> None:
        """Let points follow an empty that is animated."""
        center = points[hold.points].mean(axis=0)
        empty = bpy.data.objects.new("empty", None)
        self.scene.collection.objects.link(empty)
        for time, shift, turn in hold.keys:
            frame = FIRST_FRAME + time * FPS
            empty.location = center + shift
            empty.rotation_euler = (0, math.radians(turn), 0)
            empty.keyframe_insert("location", frame=frame)
            empty.keyframe_insert("rotation_euler", frame=frame)
        for strip in empty.animation_data.action.layers[0].strips:
            for curve in strip.channelbags[0].fcurves:
                for key in curve.keyframe_points:
                    key.interpolation = "LINEAR"
        modifier = body.modifiers.new("hook", "HOOK")
        modifier.object = empty
        modifier.vertex_indices_set(hold.points.tolist())
        modifier.matrix_inverse = Matrix.Translation(-center)

    def drive(self, frame: int) -> None:
        """Choose the next frame; what is held follows its keys."""
        self.frame = FIRST_FRAME + 1 + frame

    def advance(self) -> None:
        """Simulate a frame."""
        self.scene.frame_set(self.frame)

    def surface(self) -> Points:
        """Return the vertices of the evaluated meshes on the surface."""
        graph = bpy.context.evaluated_depsgraph_get()
        out = np.empty((len(self.bodies), 3 * len(self.task.shape.points)), np.float32)
        for body, coordinates in zip(self.bodies, out, strict=True):
            body.evaluated_get(graph).data.vertices.foreach_get("co", coordinates)
        return out.reshape(len(self.bodies), -1, 3)[:, self.task.shape.surface].astype(float)

    def steps(self) -> int:
        """Return the least number of steps per frame."""
        return self.step_count


def springs(shape: Shape) -> Indices:
    """Return the edges of the cubes and the diagonals of their faces, each once: (e, 2)."""
    corners = list(itertools.product((0, 1), repeat=3))
    # Corners are numbered in binary; those of a pair differ in one bit on an edge, in two on a diagonal of a face.
    pairs = [pair for pair in itertools.combinations(range(8), 2) if (pair[0] ^ pair[1]).bit_count() < 3]
    grid = np.rint(shape.points / shape.cell_size).astype(int)
    number = np.full(grid.max(axis=0) + 1, -1)
    number[tuple(grid.T)] = np.arange(len(grid))
    cubes = np.stack([number[tuple((shape.corners + corner).T)] for corner in corners], axis=1)
    return np.unique(np.sort(cubes[:, pairs].reshape(-1, 2), axis=1), axis=0)
