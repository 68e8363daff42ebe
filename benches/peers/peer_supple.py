"""supple: a lattice with the cells of the shape, and its surface as the mesh, with the volume kept."""

from __future__ import annotations

import numpy as np
from peer import THREADS
from tasks import FPS, FRICTION, GRAVITY, Task

import supple
from shapes import Points


class Peer:
    """supple with its default settings, but for the material, sleep and the accuracy."""

    PACKAGE = "supple"
    SETTINGS = (
        'youngs_modulus, poisson_ratio, accuracy="fast", fps=60, substeps="auto", volume="auto" (the volume of the '
        "mesh, exact), damping_ratio=0.2: all defaults but the material and the accuracy (docs/materials.md, "
        "docs/study.md). Held points by pin() and handle()."
    )

    def __init__(self, task: Task) -> None:
        """Build the simulation."""
        shape = task.shape
        mesh = supple.Mesh(shape.points[shape.surface], shape.triangles)
        self.bodies = []
        for index, (rotation, offset) in enumerate(task.places):
            body = supple.Body(
                mesh,
                name=f"body_{index}",
                cell_size=shape.cell_size,
                youngs_modulus=task.youngs_modulus,
                poisson_ratio=task.poissons_ratio,
                accuracy="fast",
                density=task.density,
                friction=FRICTION,
                self_contact=task.self_contact,
            )
            body.positions = body.positions @ rotation.T + offset
            self.bodies.append(body)
        for hold in task.holds:
            self.hold(task, hold)
        self.simulation = supple.Simulation(
            self.bodies,
            fps=FPS,
            substeps="auto",
            gravity=(0, 0, -GRAVITY),
            colliders=[supple.Plane(point, normal, friction=FRICTION) for point, normal in task.planes],
            threads=THREADS,
            sleep=False,
        )
        self.surfaces = np.empty((len(self.bodies), len(shape.surface), 3))

    def hold(self, task: Task, hold) -> None:
        """Hold the lattice vertices at the points of a hold."""
        body = self.bodies[0]
        _, offset = task.places[0]
        held = {tuple(point) for point in np.rint(task.shape.points[hold.points] / task.shape.cell_size).astype(int)}
        grid = np.rint((body.positions - offset) / task.shape.cell_size).astype(int)
        vertices = [index for index, point in enumerate(map(tuple, grid)) if point in held]
        assert len(vertices) == len(hold.points), "the lattice of supple has other points than the shape"
        keys = [(time, shift, (0, turn, 0)) for time, shift, turn in hold.keys]
        if all(key[1:] == keys[0][1:] for key in keys):
            body.pin(vertices=vertices, end=hold.end)
        else:
            body.handle(vertices=vertices, keys=keys, end=hold.end)

    def drive(self, frame: int) -> None:
        """Do nothing: pins and handles follow their keys."""

    def advance(self) -> None:
        """Simulate a frame."""
        self.simulation.advance()

    def surface(self) -> Points:
        """Return the displayed surfaces."""
        self.simulation.surfaces(out=list(self.surfaces))
        return self.surfaces.copy()

    def steps(self) -> int:
        """Return the steps per frame."""
        return self.simulation.steps_per_frame
