"""Newton: soft meshes of tetrahedra, solved by vertex block descent on the CPU."""

from __future__ import annotations

import newton
import numpy as np
import warp
from tasks import FPS, FRICTION, GRAVITY, Task

from shapes import Points

SUBSTEPS = 10
ITERATIONS = 10
VISCOSITY = 5e-4
"""Damping over Young's modulus in s, as in the example softbody_render_mesh."""


class Peer:
    """Newton with its solver for soft bodies."""

    PACKAGE = "newton"
    SETTINGS = (
        "SolverVBD with 10 substeps and 10 iterations, particle_enable_tile_solve=False, k_damp/E = 5e-4 s, as in the "
        "examples softbody_hanging and softbody_render_mesh; the tuning page has no numbers for soft bodies yet. "
        "soft_contact_ke = E x cell size. Held particles: not active, positions set in each substep. On the CPU, "
        "where Newton uses one thread; it is made for GPUs. Kernels were compiled before the run."
    )

    def __init__(self, task: Task) -> None:
        """Build the model."""
        warp.config.quiet = True
        self.task = task
        shape = task.shape
        young, poisson = task.youngs_modulus, task.poissons_ratio
        radius = 0.05 * shape.cell_size
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=(0.0, 0.0, -GRAVITY))
        config = newton.ModelBuilder.ShapeConfig(mu=FRICTION)
        for point, normal in task.planes:
            offset = -float(np.dot(point, normal))
            builder.add_shape_plane(plane=(*map(float, normal), offset), width=0.0, length=0.0, cfg=config)
        for points in task.bodies():
            builder.add_soft_mesh(
                pos=(0.0, 0.0, 0.0),
                rot=warp.quat_identity(),
                scale=1.0,
                vel=(0.0, 0.0, 0.0),
                vertices=points.astype(np.float32),
                indices=shape.tetrahedra.ravel().tolist(),
                density=task.density,
                k_mu=young / (2 * (1 + poisson)),
                k_lambda=young * poisson / ((1 + poisson) * (1 - 2 * poisson)),
                k_damp=VISCOSITY * young,
                particle_radius=radius,
            )
        builder.color()
        self.model = builder.finalize(device="cpu")
        self.model.soft_contact_ke = young * shape.cell_size
        self.model.soft_contact_kd = 0.0
        self.model.soft_contact_mu = FRICTION
        self.solver = newton.solvers.SolverVBD(
            model=self.model,
            iterations=ITERATIONS,
            particle_enable_self_contact=task.self_contact or len(task.places) > 1,
            particle_self_contact_radius=2 * radius,
            particle_self_contact_margin=3 * radius,
            particle_enable_tile_solve=False,
        )
        self.now, self.next = self.model.state(), self.model.state()
        self.control = self.model.control()
        self.pipeline = newton.CollisionPipeline(self.model)
        self.contacts = self.pipeline.contacts()
        self.rest = task.bodies()[0]
        self.held = list(task.holds)
        # Arrays on the CPU share their memory with NumPy.
        self.flags = self.model.particle_flags.numpy()
        for hold in self.held:
            self.flags[hold.points] &= ~int(newton.ParticleFlags.ACTIVE)
        self.frame = 0

    def drive(self, frame: int) -> None:
        """Let go of what is held no longer."""
        self.frame = frame
        for hold in [hold for hold in self.held if frame / FPS > hold.end - 0.5 / FPS]:
            self.flags[hold.points] |= int(newton.ParticleFlags.ACTIVE)
            self.held.remove(hold)

    def advance(self) -> None:
        """Simulate a frame."""
        for step in range(SUBSTEPS):
            time = (self.frame + (step + 1) / SUBSTEPS) / FPS
            for hold in self.held:
                self.now.particle_q.numpy()[hold.points] = hold.positions(self.rest, time)
            self.now.clear_forces()
            self.pipeline.collide(self.now, self.contacts)
            self.solver.step(self.now, self.next, self.control, self.contacts, 1 / (FPS * SUBSTEPS))
            self.now, self.next = self.next, self.now

    def surface(self) -> Points:
        """Return the particles on the surface."""
        positions = self.now.particle_q.numpy().astype(float)
        return positions.reshape(len(self.task.places), -1, 3)[:, self.task.shape.surface]

    def steps(self) -> int:
        """Return the substeps per frame."""
        return SUBSTEPS
