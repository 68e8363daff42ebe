"""MuJoCo: 3D flexes with continuum elasticity."""

from __future__ import annotations

from abc import ABC, abstractmethod

import mujoco
import numpy as np
from peer import THREADS, UnsupportedError
from tasks import FPS, FRICTION, GRAVITY, Task

from shapes import Points

STEPS = 5
"""Per frame: steps of 3.3 ms. The manual calls 1 to 4 ms typical for flexes under `discrete`."""
DAMPING = 0.005
"""Of the elasticity in s, in the range 0.002 to 0.05 of the manual."""
HEAVY = 1e4
"""Armature in kg of the degrees of freedom that are held, ten thousand times the mass of a point: the forces
of the flex, up to 5e4 N a point, move them by less than 0.1 mm in a step. More makes the equations ill-conditioned."""
RADIUS = 0.002
CONTACT = 'solref="0.01 1" solimp=".95 .99 .0001"'
"""The softness of the contacts of the soft body in the manual's section on deformable objects."""
MANUAL = (
    'integrator="discrete", 5 steps per frame (3.3 ms; the manual: 1 to 4 ms), elasticity with young, poisson and '
    "damping 0.005 s (the manual: 0.002 to 0.05): the section Deformables of the modeling chapter; the contact of its "
    "example. Held nodes: positions and velocities set in each step, with an armature of 10 t. Two threads by "
    "mju_threadpool. "
)


class Base(ABC):
    """What the variants share."""

    PACKAGE = "mujoco"

    def __init__(self, task: Task) -> None:
        """Compile the model."""
        self.task = task
        bodies = task.bodies()
        self.model = mujoco.MjModel.from_xml_string(self.model_text(task, bodies))
        self.data = mujoco.MjData(self.model)
        mujoco.mju_threadpool(self.data, THREADS)
        mujoco.mj_forward(self.model, self.data)
        self.vertices = self.model.flex_vertadr[:, None] + task.shape.surface
        error = np.abs(self.data.flexvert_xpos[self.vertices[0]] - bodies[0][task.shape.surface]).max()
        assert error < 1e-4, f"the flex has its vertices elsewhere, by {error} m"
        self.held = [self.nodes(hold) for hold in task.holds]
        self.step = 0

    def model_text(self, task: Task, bodies: list[Points]) -> str:
        """Return the model as MJCF."""
        shape = task.shape
        elements = " ".join(map(str, shape.tetrahedra.ravel()))
        mass = task.density * len(shape.corners) * shape.cell_size**3
        contact = 'selfcollide="auto"' if task.self_contact else 'selfcollide="none"'
        flexes = "".join(
            f'<flexcomp name="body_{index}" type="direct" dim="3" mass="{mass}" radius="{RADIUS}" {self.dofs(task)} '
            f'point="{" ".join(map(repr, points.ravel().tolist()))}" element="{elements}">'
            f'<elasticity young="{task.youngs_modulus}" poisson="{task.poissons_ratio}" damping="{DAMPING}"/>'
            f'<contact {contact} condim="3" friction="{FRICTION} 0.005 0.0001" {CONTACT}/></flexcomp>'
            for index, points in enumerate(bodies)
        )
        planes = "".join(
            f'<geom type="plane" size="10 10 1" pos="{join(point)}" zaxis="{join(normal)}" friction="{FRICTION}"/>'
            for point, normal in task.planes
        )
        return (
            f'<mujoco><option timestep="{1 / (FPS * STEPS)}" gravity="0 0 {-GRAVITY}" integrator="discrete" '
            f'{self.solver(task)}/><size memory="4G"/><worldbody>{planes}{flexes}</worldbody></mujoco>'
        )

    @abstractmethod
    def dofs(self, task: Task) -> str:
        """Return the attributes of the flexcomp that choose its degrees of freedom."""

    @abstractmethod
    def solver(self, task: Task) -> str:
        """Return the options of the solver."""

    def nodes(self, hold) -> tuple:
        """Return a hold with its nodes, the bodies in the bounding box of the held points, and their rest positions."""
        rest = self.task.bodies()[0]
        held = rest[hold.points]
        margin = 0.25 * self.task.shape.cell_size
        movable = np.flatnonzero(self.model.body_dofnum == 3)
        places = self.data.xpos[movable]
        inside = np.all((places >= held.min(axis=0) - margin) & (places <= held.max(axis=0) + margin), axis=1)
        if not inside.any():
            raise UnsupportedError("no node of the flex is where the task holds the body")
        dofs = self.model.body_dofadr[movable[inside]][:, None] + np.arange(3)
        self.model.dof_armature[dofs] = HEAVY
        center = held.mean(axis=0)
        return hold, dofs, places[inside], center

    def drive(self, frame: int) -> None:
        """Let go of what is held no longer."""
        for hold, dofs, _, _ in self.held:
            if frame / FPS > hold.end - 0.5 / FPS:
                self.model.dof_armature[dofs] = 0
        self.held = [held for held in self.held if frame / FPS < held[0].end - 0.5 / FPS]

    def advance(self) -> None:
        """Simulate a frame."""
        step = self.model.opt.timestep
        for _ in range(STEPS):
            time = self.step * step
            for hold, dofs, places, center in self.held:
                now, then = (hold.move(places, center, moment) for moment in (time, time + step))
                self.data.qpos[dofs] = now - places
                self.data.qvel[dofs] = (then - now) / step
            mujoco.mj_step(self.model, self.data)
            self.step += 1

    def surface(self) -> Points:
        """Return the vertices of the flexes on the surface."""
        return self.data.flexvert_xpos[self.vertices].copy()

    def steps(self) -> int:
        """Return the steps per frame."""
        return STEPS


class Full(Base):
    """Three degrees of freedom for every point."""

    SETTINGS = MANUAL + (
        'dof="full"; solver="CG", which the manual prefers for large and relatively soft 3D meshes, and which took '
        'less than half of the time of "Newton" at 1,000 points; tolerance 1e-6.'
    )

    def dofs(self, task: Task) -> str:
        """Return the default."""
        return 'dof="full"'

    def solver(self, task: Task) -> str:
        """Return the conjugate gradients."""
        return 'solver="CG" tolerance="1e-6"'


class Trilinear(Base):
    """Trilinear cells that carry the points."""

    SETTINGS = MANUAL + (
        'dof="trilinear", which the manual recommends for bodies that are not thin, with cells of about a quarter of '
        'the longest side; solver="Newton", tolerance 1e-6. Its collisions and its surface have all points.'
    )

    def dofs(self, task: Task) -> str:
        """Return a grid of four cells along the longest side."""
        extent = np.ptp(task.shape.points, axis=0)
        cells = np.maximum(1, np.rint(4 * extent / extent.max())).astype(int)
        return f'dof="trilinear" cellcount="{join(cells)}"'

    def solver(self, task: Task) -> str:
        """Return the default solver."""
        return 'solver="Newton" tolerance="1e-6"'


def join(values) -> str:
    """Return numbers separated by spaces."""
    return " ".join(str(value) for value in values)
