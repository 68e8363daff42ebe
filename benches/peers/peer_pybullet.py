"""Bullet: deformable bodies of neo-Hookean tetrahedra, by PyBullet."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
import pybullet as bullet
from tasks import FPS, FRICTION, GRAVITY, Task

from shapes import Points, Shape

LONGEST_STEP = 1e-3
DAMPING = 0.01
MARGIN = 0.005


class Peer:
    """PyBullet in the deformable world."""

    PACKAGE = "pybullet"
    SETTINGS = (
        "RESET_USE_DEFORMABLE_WORLD, useNeoHookean with the Lame constants of the material and NeoHookeanDamping 0.01 "
        "(as in the example deformable_torus.py), sparseSdfVoxelSize 0.25 and useFaceContact as in the examples; for "
        "self-contact useSelfCollision with repulsionStiffness 800 (deformable_torus.py). Steps of at most "
        "1 ms (deformable_ball.py), and of half the time in which a pressure wave crosses a cube, because the elastic "
        "forces are explicit. Held points by createSoftBodyAnchor. One thread: the package has no more."
    )

    def __init__(self, task: Task) -> None:
        """Build the simulation."""
        self.task = task
        shape = task.shape
        young, poisson = task.youngs_modulus, task.poissons_ratio
        shear = young / (2 * (1 + poisson))
        lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
        crossing = shape.cell_size / math.sqrt((lame + 2 * shear) / task.density)
        self.substeps = math.ceil(1 / FPS / min(LONGEST_STEP, crossing / 2))
        bullet.connect(bullet.DIRECT)
        bullet.resetSimulation(bullet.RESET_USE_DEFORMABLE_WORLD)
        bullet.setGravity(0, 0, -GRAVITY)
        for point, normal in task.planes:
            plane = bullet.createCollisionShape(bullet.GEOM_PLANE, planeNormal=normal)
            bullet.changeDynamics(bullet.createMultiBody(0, plane, basePosition=point), -1, lateralFriction=FRICTION)
        self.bodies = []
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "body.vtk"
            for points in task.bodies():
                write_vtk(path, points, shape)
                body = bullet.loadSoftBody(
                    str(path),
                    mass=task.density * len(shape.corners) * shape.cell_size**3,
                    useNeoHookean=1,
                    NeoHookeanMu=shear,
                    NeoHookeanLambda=lame,
                    NeoHookeanDamping=DAMPING,
                    collisionMargin=MARGIN,
                    frictionCoeff=FRICTION,
                    useFaceContact=1,
                    useSelfCollision=int(task.self_contact),
                    repulsionStiffness=800,
                )
                self.bodies.append(body)
        bullet.setTimeStep(1 / (FPS * self.substeps))
        bullet.setPhysicsEngineParameter(sparseSdfVoxelSize=0.25)
        self.rest = task.bodies()[0]
        self.held = [self.anchor(hold) for hold in task.holds]
        self.frame = 0

    def anchor(self, hold) -> tuple:
        """Anchor the points of a hold to a body without mass and contact, which moves them."""
        held = self.rest[hold.points]
        center = held.mean(axis=0)
        ball = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=0.01)
        mover = bullet.createMultiBody(0, ball, basePosition=center.tolist())
        bullet.setCollisionFilterGroupMask(mover, -1, 0, 0)
        anchors = [
            bullet.createSoftBodyAnchor(self.bodies[0], int(point), mover, -1, (place - center).tolist())
            for point, place in zip(hold.points, held, strict=True)
        ]
        return hold, mover, anchors, center

    def drive(self, frame: int) -> None:
        """Let go of what is held no longer."""
        self.frame = frame
        for _, mover, anchors, _ in [held for held in self.held if frame / FPS > held[0].end - 0.5 / FPS]:
            for constraint in anchors:
                bullet.removeConstraint(constraint)
            bullet.removeBody(mover)
        self.held = [held for held in self.held if frame / FPS < held[0].end - 0.5 / FPS]

    def advance(self) -> None:
        """Simulate a frame."""
        for step in range(self.substeps):
            time = (self.frame + (step + 1) / self.substeps) / FPS
            for hold, mover, _, center in self.held:
                turn = np.interp(time, [key[0] for key in hold.keys], [key[2] for key in hold.keys])
                place = hold.move(center[None], center, time)[0]
                bullet.resetBasePositionAndOrientation(
                    mover, place.tolist(), bullet.getQuaternionFromEuler([0, math.radians(turn), 0])
                )
            bullet.stepSimulation()

    def surface(self) -> Points:
        """Return the vertices on the surface."""
        meshes = [bullet.getMeshData(body, -1, flags=bullet.MESH_DATA_SIMULATION_MESH)[1] for body in self.bodies]
        return np.stack([np.array(mesh)[self.task.shape.surface] for mesh in meshes])

    def steps(self) -> int:
        """Return the steps per frame."""
        return self.substeps


def write_vtk(path: Path, points: Points, shape: Shape) -> None:
    """Write tetrahedra as a legacy VTK file."""
    count = len(shape.tetrahedra)
    lines = ["# vtk DataFile Version 2.0", "body", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(points)} double"]
    lines += [" ".join(map(repr, point)) for point in points.tolist()]
    lines.append(f"CELLS {count} {5 * count}")
    lines += [f"4 {a} {b} {c} {d}" for a, b, c, d in shape.tetrahedra.tolist()]
    lines += [f"CELL_TYPES {count}", *["10"] * count, ""]
    path.write_text("\n".join(lines))
