"""Equilibrium of a nearly incompressible Neo-Hookean solid of cubes: `Problem`, `solve`.

The energy density is mu/2 (F:F - 3) - mu ln det F + kappa/2 (J - 1)^2, where J is the mean of det F over the cell
("mean dilatation", Q1-P0: the volume of whole cells is kept, so that the elements do not lock). The equations are Bonet
and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd edition, 2008, chapters 6 to 9. The load is
raised in steps; each is solved by Newton's method with a pressure of its own in each cell, eliminated before the linear
solve, and with steps shortened so that no cell turns inside out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import skfem
from fem_grid import Floats, Grid, Ints
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

SHEAR = 1.0  # Only the ratio of the two moduli matters: ends are moved, no force is given.
BULK = 2000.0


class ConvergenceError(Exception):
    """Newton's method did not settle: the load step was too long."""


@dataclass
class Problem:
    """A solid of cubes and what is done to it.

    `shares` (cells, 2, 2, 2) is how much of each eighth of each cell is filled; `held` are degrees of freedom, 3 node +
    axis, and `target` (all of them) is the displacement of the held ones at full load.
    """

    grid: Grid
    shares: Floats
    held: Ints
    target: Floats


@dataclass
class Solution:
    """Displacements (nodes, 3), the part of the load that was reached, and the relative volume change of the solid."""

    grid: Grid
    displacement: Floats
    load: float
    volume_change: float

    def at(self, points: Floats) -> Floats:
        """Deformed positions of rest points (n, 3)."""
        return points + self.grid.interpolate(self.displacement, points)


class Solid:
    """The discrete equations: forces and stiffness of all cells at given displacements."""

    def __init__(self, problem: Problem) -> None:
        """Tabulates what does not change with the displacement."""
        self.basis = skfem.Basis(problem.grid.mesh(), skfem.ElementVector(skfem.ElementHex1()), intorder=3)
        scalar = self.basis.with_element(skfem.ElementHex1())
        # All cells are the same cube: one table of gradients (corner, axis, point) serves all.
        self.gradients = np.array([scalar.basis[corner][0].grad[:, 0] for corner in range(8)])
        # There is one quadrature point in each eighth of a cell.
        eighths = (scalar.X > 0.5).astype(int)
        self.weights = scalar.dx * problem.shares[:, eighths[0], eighths[1], eighths[2]]
        self.cell_volumes = self.weights.sum(axis=1)
        laplacian = np.einsum("aJq,bJq,eq->eab", self.gradients, self.gradients, self.weights)
        self.shear_stiffness = SHEAR * np.kron(laplacian, np.eye(3))

    def deformation(self, displacement: Floats) -> Floats:
        """F at the quadrature points: (cells, points, 3, 3)."""
        corners = displacement[self.basis.element_dofs.T].reshape(-1, 8, 3)
        return np.eye(3) + np.einsum("eai,aJq->eqiJ", corners, self.gradients)

    def pressure(self, displacement: Floats) -> Floats:
        """The mean stress that resists dilatation, kappa (J - 1), in each cell; positive in tension."""
        volumes = (np.linalg.det(self.deformation(displacement)) * self.weights).sum(axis=1)
        return BULK * (volumes / self.cell_volumes - 1)

    def volume_change(self, displacement: Floats) -> float:
        """Relative, of the whole solid."""
        return float(np.average(self.pressure(displacement) / BULK, weights=self.cell_volumes))

    def linearise(self, displacement: Floats, pressure: Floats) -> tuple[csc_matrix, Floats, Floats]:
        """Stiffness, forces of the solid, and the gradient of each cell's volume (cells, 24).

        The stiffness is taken at the pressures given, the forces at those that follow from the displacement: that is
        Newton's method for both unknowns once the pressures are eliminated. With a pressure bound to the displacement
        throughout it would need far shorter load steps.
        """
        deformation = self.deformation(displacement)
        determinant = np.linalg.det(deformation)
        inverse = np.linalg.inv(deformation)
        count = len(deformation)
        # Gradients of the corner functions in deformed space, F^-T grad N.
        spatial = np.einsum("aJq,eqJi->eqai", self.gradients, inverse).reshape(count, -1, 24)
        volume_gradient = np.einsum("eqm,eq->em", spatial, determinant * self.weights)

        tension = pressure[:, None] * determinant
        along = _weighted_squares(spatial, tension * self.weights)
        across = _weighted_squares(spatial, (SHEAR - tension) * self.weights)
        across = across.reshape(count, 8, 3, 8, 3).swapaxes(2, 4).reshape(count, 24, 24)
        stiffness = self.shear_stiffness + along + across
        stiffness += (BULK / self.cell_volumes)[:, None, None] * volume_gradient[:, :, None] * volume_gradient[:, None]

        forces = SHEAR * np.einsum("eqiJ,aJq,eq->eai", deformation, self.gradients, self.weights).reshape(count, 24)
        forces -= SHEAR * np.einsum("eqm,eq->em", spatial, self.weights)
        forces += self.pressure(displacement)[:, None] * volume_gradient
        matrix = self._sum_cells(stiffness)
        total = np.bincount(self.basis.element_dofs.T.ravel(), forces.ravel())
        return matrix, total, volume_gradient

    def _sum_cells(self, matrices: Floats) -> csc_matrix:
        dofs = self.basis.element_dofs.T
        rows = np.repeat(dofs, 24, axis=1).ravel()
        columns = np.tile(dofs, 24).ravel()
        return coo_matrix((matrices.ravel(), (rows, columns)), shape=2 * (self.basis.N,)).tocsc()


def _weighted_squares(vectors: Floats, weights: Floats) -> Floats:
    """sum_q w_q v_q v_q^T of each cell."""
    return vectors.swapaxes(1, 2) @ (vectors * weights[:, :, None])


def dissection(positions: Floats, nodes: Ints, leaf: int = 60) -> Ints:
    """Order of elimination that keeps the factors small: halves first, the plane of nodes between them last."""
    if len(nodes) <= leaf:
        return nodes
    here = positions[nodes]
    axis = np.argmax(np.ptp(here, axis=0))
    middle = np.sort(here[:, axis])[len(nodes) // 2]
    below, above = here[:, axis] < middle - 1e-9, here[:, axis] > middle + 1e-9
    if not below.any() or not above.any():
        return nodes
    parts = dissection(positions, nodes[below], leaf), dissection(positions, nodes[above], leaf)
    return np.concatenate([*parts, nodes[~below & ~above]])


def solve(problem: Problem, first_step: float) -> Solution:
    """Raises the load from 0 to 1; stops short of 1 where even the shortest step fails."""
    solid = Solid(problem)
    order = dissection(problem.grid.nodes, np.arange(len(problem.grid.nodes)))
    dofs = solid.basis.nodal_dofs[:, order].T.ravel()
    free = dofs[~np.isin(dofs, problem.held)]
    displacement, pressure = np.zeros(solid.basis.N), np.zeros(len(problem.shares))
    load, step = 0.0, first_step
    while load < 1 and step > first_step / 50:
        wanted = min(1.0, load + step)
        try:
            displacement, pressure, rounds = _equilibrium(solid, problem, free, wanted, displacement, pressure)
        except ConvergenceError:
            step /= 2
            continue
        load = wanted
        print(f"  load {load:.4f}, {rounds} rounds", flush=True)
        if rounds <= 5:
            step *= 1.5
    return Solution(problem.grid, displacement.reshape(-1, 3), load, solid.volume_change(displacement))


def _equilibrium(
    solid: Solid, problem: Problem, free: Ints, load: float, displacement: Floats, pressure: Floats
) -> tuple[Floats, Floats, int]:
    """Newton's method at one load: displacement, pressure, rounds."""
    held, cell = problem.held, problem.grid.cell_size
    for rounds in range(1, 21):
        matrix, forces, volume_gradient = solid.linearise(displacement, pressure)
        change = np.zeros_like(displacement)
        change[held] = load * problem.target[held] - displacement[held]
        right = -forces - matrix @ change
        # Symmetric and in a good order already: pivoting would only fill the factors.
        options = {"SymmetricMode": True}
        factors = splu(matrix[free][:, free], permc_spec="NATURAL", diag_pivot_thresh=0.0, options=options)
        change[free] = factors.solve(right[free])
        dilatation = np.einsum("em,em->e", volume_gradient, change[solid.basis.element_dofs.T]) / solid.cell_volumes
        new_pressure = solid.pressure(displacement) + BULK * dilatation

        length = _step_length(solid, displacement, change)
        displacement = displacement + length * change
        pressure = pressure + length * (new_pressure - pressure)
        if length == 1 and np.abs(change).max() < 1e-6 * cell:
            return displacement, pressure, rounds
    raise ConvergenceError


def _step_length(solid: Solid, displacement: Floats, change: Floats) -> float:
    """The longest of 1, 1/2, 1/4, ... at which every cell keeps a good part of its det F at each point."""
    before = np.linalg.det(solid.deformation(displacement))
    for halvings in range(8):
        length = 0.5**halvings
        if (np.linalg.det(solid.deformation(displacement + length * change)) > 0.2 * before).all():
            return length
    raise ConvergenceError
