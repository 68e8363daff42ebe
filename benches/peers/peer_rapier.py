"""Rapier: soft bodies of the Python package rapier3d, held together in three ways."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
import rapier3d as rapier
from peer import THREADS, lumped_masses
from tasks import FPS, FRICTION, GRAVITY, Task

from shapes import Points

COMMON = (
    "dt = 1/60 with the default 4 solver iterations (substeps) and the default adaptive extra substeps; two worker "
    "threads; can_sleep(False). Held particles: pinned, with kinematic targets. "
)


class Base(ABC):
    """What the variants share."""

    PACKAGE = "rapier3d"

    def __init__(self, task: Task) -> None:
        """Build the simulation."""
        self.task = task
        self.world = rapier.PhysicsWorld(gravity=(0.0, 0.0, -GRAVITY))
        self.world.integration_parameters.dt = 1 / FPS
        self.world.set_num_threads(THREADS)
        for point, normal in task.planes:
            collider = rapier.Collider.halfspace(normal).translation(point).friction(FRICTION)
            self.world.add_collider(collider)
        masses = lumped_masses(task.shape, task.density).tolist()
        triangles = task.shape.surface[task.shape.triangles]
        handles = []
        for index, points in enumerate(task.bodies()):
            builder = rapier.SoftBodyBuilder(points).masses(masses).surface(triangles).can_sleep(False)
            # The collider of the surface is the default one, whose friction is that of the planes, 0.5.
            builder = self.cohesion(builder.self_contacts(task.self_contact))
            if index == 0 and task.holds:
                builder = builder.pinned_particles(np.concatenate([hold.points for hold in task.holds]))
            handles.append(self.world.add_soft_body(builder))
        self.handles = handles
        self.held = list(task.holds)
        self.rest = task.bodies()[0]

    @abstractmethod
    def cohesion(self, builder: rapier.SoftBodyBuilder) -> rapier.SoftBodyBuilder:
        """Set what holds the body together."""

    def elastic_material(self) -> rapier.SoftBodyMaterial:
        """Return the material of the task, for elastic cells."""
        return rapier.SoftBodyMaterial(young_modulus=self.task.youngs_modulus, poisson_ratio=self.task.poissons_ratio)

    def drive(self, frame: int) -> None:
        """Set the kinematic targets, or let go."""
        time = (frame + 1) / FPS
        body = self.world.soft_bodies[self.handles[0]]
        for hold in list(self.held):
            if time > hold.end + 0.5 / FPS:
                for index in hold.points:
                    body.set_particle_pinned(int(index), False)
                self.held.remove(hold)
            else:
                for index, target in zip(hold.points, hold.positions(self.rest, time), strict=True):
                    body.set_particle_kinematic_target(int(index), target)

    def advance(self) -> None:
        """Simulate a frame."""
        self.world.step()

    def surface(self) -> Points:
        """Return the particles on the surface."""
        bodies = self.world.soft_bodies
        return np.stack([bodies[handle].particle_positions[self.task.shape.surface] for handle in self.handles])

    def steps(self) -> int:
        """Return the substeps per frame."""
        return self.world.integration_parameters.num_solver_iterations


class Shape(Base):
    """Shape matching of the whole body, with the enclosed volume preserved."""

    SETTINGS = (
        COMMON + "shape_matching(True), volume_preservation(True). The guide gives these springs a frequency, not a "
        "modulus: that of shape matching is the lowest longitudinal mode of the body, sqrt(E / density) / (2 L); that "
        "of the volume is 1000 Hz, far above the substep rate, where it saturates, because 30 Hz, the default, loses "
        "more volume and is not faster; damping ratio 1, the default."
    )

    def cohesion(self, builder: rapier.SoftBodyBuilder) -> rapier.SoftBodyBuilder:
        """Set shape matching and volume preservation."""
        speed = math.sqrt(self.task.youngs_modulus / self.task.density)
        softness = rapier.SpringCoefficients(speed / (2 * self.task.shape.size), 1.0)
        volume = rapier.SpringCoefficients(1000.0, 1.0)
        material = rapier.SoftBodyMaterial(shape_matching_softness=softness, volume_softness=volume)
        return builder.shape_matching(True).volume_preservation(True).material(material)


class Corotational(Base):
    """Corotational cells as constraints, the default solver."""

    SETTINGS = COMMON + "cells with the model COROTATIONAL; the default solver, CONSTRAINTS, and damping ratio, 1."

    def cohesion(self, builder: rapier.SoftBodyBuilder) -> rapier.SoftBodyBuilder:
        """Set corotational cells."""
        builder = builder.cells(self.task.shape.tetrahedra).cell_model(rapier.SoftBodyCellModel.COROTATIONAL)
        return builder.material(self.elastic_material())


class Fem(Base):
    """Corotational cells with the FEM solver."""

    SETTINGS = (
        COMMON + "cells with the model COROTATIONAL, the solver FEM, which the guide describes as the one whose "
        "stiffness does not depend on the number of iterations; default damping ratio 1, linear tolerance 1e-5 and at "
        "most 20 linear iterations."
    )

    def cohesion(self, builder: rapier.SoftBodyBuilder) -> rapier.SoftBodyBuilder:
        """Set corotational cells and the FEM solver."""
        builder = builder.cells(self.task.shape.tetrahedra).cell_model(rapier.SoftBodyCellModel.COROTATIONAL)
        return builder.solver(rapier.SoftBodySolver.FEM).material(self.elastic_material())
