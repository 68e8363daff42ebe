"""Computes the equilibrium of a nearly incompressible Neo-Hookean solid of cubes: `Problem`, `solve`.

The energy density is mu/2 (F:F - 3) - mu ln det F + kappa/2 (J - 1)^2. F is the deformation gradient, mu the shear
modulus (`SHEAR`), kappa the bulk modulus (`BULK`), and J the mean of det F over the cell ("mean dilatation", Q1-P0:
only the volume of whole cells is constrained, so that the elements do not lock). See Bonet & Wood 2008, Nonlinear
Continuum Mechanics for Finite Element Analysis, 2nd edition, chapters 6 to 9. The load increases in steps. Each load
step is solved by Newton's method with one pressure per cell, which is eliminated before the linear solve. A line search
shortens the Newton steps so that no cell inverts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import skfem
from fem_grid import Floats, Grid, Ints
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

SHEAR = 1.0  # Only the ratio of the moduli matters, because no forces are prescribed.
BULK = 2000.0


class ConvergenceError(Exception):
    """Newton's method did not converge, because the load step is too long."""


@dataclass
class Problem:
    """A solid of cubes and its boundary conditions.

    A degree of freedom has the index 3 node + axis. `fractions` (cells, 2, 2, 2) are the filled fractions of the
    eighths of each cell. `constrained` are the indices of the constrained degrees of freedom. `target` has one entry
    per degree of freedom: for constrained degrees of freedom the displacement at full load, otherwise 0.
    """

    grid: Grid
    fractions: Floats
    constrained: Ints
    target: Floats


@dataclass
class Solution:
    """Displacements of the nodes (nodes, 3), final fraction of the load, and relative volume change of the solid."""

    grid: Grid
    displacement: Floats
    load: float
    volume_change: float

    def at(self, points: Floats) -> Floats:
        """Returns deformed positions of rest points (n, 3)."""
        return points + self.grid.interpolate(self.displacement, points)


class Solid:
    """The discrete equations: forces and stiffness of all cells at given displacements."""

    def __init__(self, problem: Problem) -> None:
        """Tabulates the quantities that do not depend on the displacement."""
        self.basis = skfem.Basis(problem.grid.mesh(), skfem.ElementVector(skfem.ElementHex1()), intorder=3)
        scalar = self.basis.with_element(skfem.ElementHex1())
        # All cells are equal cubes, so they share one table of gradients (corner, axis, point).
        self.gradients = np.array([scalar.basis[corner][0].grad[:, 0] for corner in range(8)])
        # There is one quadrature point in each eighth of a cell.
        eighths = (scalar.X > 0.5).astype(int)
        self.weights = scalar.dx * problem.fractions[:, eighths[0], eighths[1], eighths[2]]
        self.cell_volumes = self.weights.sum(axis=1)
        laplacian = np.einsum("aJq,bJq,eq->eab", self.gradients, self.gradients, self.weights)
        self.shear_stiffness = SHEAR * np.kron(laplacian, np.eye(3))

    def deformation(self, displacement: Floats) -> Floats:
        """Returns F at the quadrature points: (cells, points, 3, 3)."""
        corners = displacement[self.basis.element_dofs.T].reshape(-1, 8, 3)
        return np.eye(3) + np.einsum("eai,aJq->eqiJ", corners, self.gradients)

    def pressure(self, displacement: Floats) -> Floats:
        """Returns the mean stress kappa (J - 1) of each cell; positive in tension."""
        volumes = (np.linalg.det(self.deformation(displacement)) * self.weights).sum(axis=1)
        return BULK * (volumes / self.cell_volumes - 1)

    def volume_change(self, displacement: Floats) -> float:
        """Returns the relative volume change of the whole solid."""
        return float(np.average(self.pressure(displacement) / BULK, weights=self.cell_volumes))

    def linearize(self, displacement: Floats, pressure: Floats) -> tuple[csc_matrix, Floats, Floats]:
        """Returns the stiffness, the forces of the solid, and the gradient of each cell's volume (cells, 24).

        The stiffness uses the given pressures, the forces use the pressures that follow from the displacement. This is
        Newton's method for both unknowns after elimination of the pressures. Using the pressures of the displacement
        in both would require far shorter load steps.
        """
        deformation = self.deformation(displacement)
        determinant = np.linalg.det(deformation)
        inverse = np.linalg.inv(deformation)
        count = len(deformation)
        # Gradients of the corner functions in deformed space, F^-T grad N.
        spatial = np.einsum("aJq,eqJi->eqai", self.gradients, inverse).reshape(count, -1, 24)
        volume_gradient = np.einsum("eqm,eq->em", spatial, determinant * self.weights)

        tension = pressure[:, None] * determinant
        direct = _weighted_squares(spatial, tension * self.weights)
        transposed = _weighted_squares(spatial, (SHEAR - tension) * self.weights)
        # Exchange the coordinate axes of the two nodes of each entry.
        transposed = transposed.reshape(count, 8, 3, 8, 3).swapaxes(2, 4).reshape(count, 24, 24)
        stiffness = self.shear_stiffness + direct + transposed
        stiffness += (BULK / self.cell_volumes)[:, None, None] * volume_gradient[:, :, None] * volume_gradient[:, None]

        forces = SHEAR * np.einsum("eqiJ,aJq,eq->eai", deformation, self.gradients, self.weights).reshape(count, 24)
        forces -= SHEAR * np.einsum("eqm,eq->em", spatial, self.weights)
        forces += self.pressure(displacement)[:, None] * volume_gradient
        matrix = self._sum_cells(stiffness)
        total = np.bincount(self.basis.element_dofs.T.ravel(), forces.ravel())
        return matrix, total, volume_gradient

    def _sum_cells(self, matrices: Floats) -> csc_matrix:
        """Assembles the matrices of all cells."""
        dofs = self.basis.element_dofs.T
        rows = np.repeat(dofs, 24, axis=1).ravel()
        columns = np.tile(dofs, 24).ravel()
        return coo_matrix((matrices.ravel(), (rows, columns)), shape=2 * (self.basis.N,)).tocsc()


def _weighted_squares(vectors: Floats, weights: Floats) -> Floats:
    """Returns the sum of w v v^T over the quadrature points of each cell, with weights w and vectors v."""
    return vectors.swapaxes(1, 2) @ (vectors * weights[:, :, None])


def dissection(positions: Floats, nodes: Ints, leaf: int = 60) -> Ints:
    """Returns the nodes in nested-dissection order, which keeps the factors sparse: separating planes come last."""
    if len(nodes) <= leaf:
        return nodes
    points = positions[nodes]
    axis = np.argmax(np.ptp(points, axis=0))
    median = np.sort(points[:, axis])[len(nodes) // 2]
    below, above = points[:, axis] < median - 1e-9, points[:, axis] > median + 1e-9
    if not below.any() or not above.any():
        return nodes
    parts = dissection(positions, nodes[below], leaf), dissection(positions, nodes[above], leaf)
    return np.concatenate([*parts, nodes[~below & ~above]])


def solve(problem: Problem, first_step: float) -> Solution:
    """Solves for loads that increase from 0 to 1. Stops below 1 if even the shortest load step fails."""
    solid = Solid(problem)
    order = dissection(problem.grid.nodes, np.arange(len(problem.grid.nodes)))
    dofs = solid.basis.nodal_dofs[:, order].T.ravel()
    free = dofs[~np.isin(dofs, problem.constrained)]
    displacement, pressure = np.zeros(solid.basis.N), np.zeros(len(problem.fractions))
    load, step = 0.0, first_step
    while load < 1 and step > first_step / 50:
        next_load = min(1.0, load + step)
        try:
            displacement, pressure, iterations = _equilibrium(solid, problem, free, next_load, displacement, pressure)
        except ConvergenceError:
            step /= 2
            continue
        load = next_load
        print(f"  load {load:.4f}, {iterations} iterations", flush=True)
        if iterations <= 5:
            step *= 1.5
    return Solution(problem.grid, displacement.reshape(-1, 3), load, solid.volume_change(displacement))


def _equilibrium(
    solid: Solid, problem: Problem, free: Ints, load: float, displacement: Floats, pressure: Floats
) -> tuple[Floats, Floats, int]:
    """Solves for one load by Newton's method. Returns displacement, pressure and number of iterations."""
    constrained, cell_size = problem.constrained, problem.grid.cell_size
    for iterations in range(1, 21):
        matrix, forces, volume_gradient = solid.linearize(displacement, pressure)
        change = np.zeros_like(displacement)
        change[constrained] = load * problem.target[constrained] - displacement[constrained]
        right = -forces - matrix @ change
        # The matrix is symmetric and ordered; pivoting would only add fill-in.
        options = {"SymmetricMode": True}
        factors = splu(matrix[free][:, free], permc_spec="NATURAL", diag_pivot_thresh=0.0, options=options)
        change[free] = factors.solve(right[free])
        dilatation = np.einsum("em,em->e", volume_gradient, change[solid.basis.element_dofs.T]) / solid.cell_volumes
        new_pressure = solid.pressure(displacement) + BULK * dilatation

        length = _step_length(solid, displacement, change)
        displacement = displacement + length * change
        pressure = pressure + length * (new_pressure - pressure)
        if length == 1 and np.abs(change).max() < 1e-6 * cell_size:
            return displacement, pressure, iterations
    raise ConvergenceError


def _step_length(solid: Solid, displacement: Floats, change: Floats) -> float:
    """Returns the longest of 1, 1/2, 1/4, ... for which det F stays above 20 % of its value at each point."""
    before = np.linalg.det(solid.deformation(displacement))
    for halvings in range(8):
        length = 0.5**halvings
        if (np.linalg.det(solid.deformation(displacement + length * change)) > 0.2 * before).all():
            return length
    raise ConvergenceError
