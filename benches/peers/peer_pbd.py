"""PositionBasedDynamics: tetrahedra with the FEM constraints of extended position based dynamics, by pyPBD."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pypbd
from peer import lumped_masses
from tasks import FPS, FRICTION, Task

from shapes import Points

STEPS = 4
"""Per frame: steps of 4.2 ms, the longest that divide a frame and are not above the default of 5 ms."""
SUBSTEPS = 5
XPBD_FEM = 3
Y_UP = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""The package has no means to turn its gravity, which points along -y."""
CUBE = (
    "v -.5 -.5 -.5\nv .5 -.5 -.5\nv .5 .5 -.5\nv -.5 .5 -.5\nv -.5 -.5 .5\nv .5 -.5 .5\nv .5 .5 .5\nv -.5 .5 .5\n"
    "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n"
)


class Peer:
    """PositionBasedDynamics with its FEM constraints."""

    PACKAGE = "pypbd"
    SETTINGS = (
        "addSolidConstraints with the method 3, FEM based XPBD, which takes Young's modulus; 4 steps a frame (4.2 ms; "
        "default 5 ms) with 5 substeps and one iteration, contact tolerance 0.01 (the defaults of the scene format). "
        "Bodies that touch each other: generateCollisionObject. Held particles: mass 0, positions set in each step. "
        "Two threads by OpenMP."
    )

    def __init__(self, task: Task) -> None:
        """Build the simulation."""
        self.task = task
        self.simulation = pypbd.Simulation.getCurrent()
        self.simulation.initDefault()
        self.model = self.simulation.getModel()
        stepper = self.simulation.getTimeStep()
        stepper.setValueUInt(pypbd.TimeStepController.NUM_SUB_STEPS, SUBSTEPS)
        stepper.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS, 1)
        stepper.getCollisionDetection().setTolerance(0.01)
        pypbd.TimeManager.getCurrent().setTimeStepSize(1 / (FPS * STEPS))
        for point, normal in task.planes:
            self.add_plane(Y_UP @ point, Y_UP @ normal)
        self.rest = task.bodies()[0]
        self.particles = self.model.getParticles()
        for points in task.bodies():
            self.add_body(points)
        self.held = list(task.holds)
        for hold in self.held:
            for index in hold.points.tolist():
                self.particles.setMass(index, 0.0)
        self.frame = 0

    def add_body(self, points: Points) -> None:
        """Add a body, with a distance field of its rest shape where it touches others or itself."""
        task = self.task
        touches = task.self_contact or len(task.places) > 1
        indices = task.shape.tetrahedra.ravel().tolist()
        first = self.particles.size()
        body = self.model.addTetModel(list(points @ Y_UP.T), indices, testMesh=True, generateCollisionObject=touches)
        body.setFrictionCoeff(FRICTION)
        for index, mass in enumerate(lumped_masses(task.shape, task.density).tolist()):
            self.particles.setMass(first + index, mass)
        self.model.addSolidConstraints(body, XPBD_FEM, task.youngs_modulus, task.poissons_ratio, 1.0, False, False)

    def add_plane(self, point: Points, normal: Points) -> None:
        """Add a box, because there is no plane."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cube.obj"
            path.write_text(CUBE)
            vertices, mesh = pypbd.OBJLoader.loadObjToMesh(str(path), [1, 1, 1])
        size = 20.0 - 19.0 * np.abs(normal)
        ground = self.model.addRigidBody(1.0, vertices, mesh, point - 0.5 * normal, np.identity(3), size)
        ground.setMass(0.0)
        ground.setFrictionCoeff(FRICTION)
        detection = self.simulation.getTimeStep().getCollisionDetection()
        corners = ground.getGeometry().getVertexData()
        kind = pypbd.CollisionObject.RigidBodyCollisionObjectType
        index = len(self.model.getRigidBodies()) - 1
        detection.addCollisionBox(index, kind, corners, 0, corners.size(), size, False, False)

    def drive(self, frame: int) -> None:
        """Let go of what is held no longer."""
        self.frame = frame
        for hold in [hold for hold in self.held if frame / FPS > hold.end - 0.5 / FPS]:
            masses = lumped_masses(self.task.shape, self.task.density)
            for index in hold.points.tolist():
                self.particles.setMass(index, float(masses[index]))
            self.held.remove(hold)

    def advance(self) -> None:
        """Simulate a frame."""
        for step in range(STEPS):
            time = (self.frame + (step + 1) / STEPS) / FPS
            for hold in self.held:
                for index, place in zip(hold.points.tolist(), hold.positions(self.rest, time) @ Y_UP.T, strict=True):
                    self.particles.setPosition(index, place)
            self.simulation.getTimeStep().step(self.model)

    def surface(self) -> Points:
        """Return the particles on the surface."""
        positions = np.array(self.particles.getVertices()) @ Y_UP
        return positions.reshape(len(self.task.places), -1, 3)[:, self.task.shape.surface]

    def steps(self) -> int:
        """Return the steps per frame."""
        return STEPS * SUBSTEPS
