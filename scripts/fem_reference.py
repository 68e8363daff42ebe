"""Finite-element reference solutions: the shapes that nearly incompressible elastic solids take.

    pip install scikit-fem numpy scipy          # beside supple
    python scripts/fem_reference.py             # both cases, into tests/data/fem
    python scripts/fem_reference.py --case bar --refine

Two bodies are brought to rest, slowly, each held at both ends:

bar   4 x 1 x 1, both end faces held wholly, one of them moved along x until the length is 1.5 times what it was. It is
      symmetric in three planes, so that an eighth of it is solved.
bust  examples/scenes/bust.obj; the lowest 20 % of its height held, the highest 10 % moved up by half of the height.

The material is Neo-Hookean, energy density mu/2 (F:F - 3) - mu ln det F + kappa/2 (J - 1)^2, where J is the mean of
det F over the cell ("mean dilatation", Q1-P0: the volume of whole cells is kept, so that the elements do not lock), and
kappa = 2,000 mu. The equations are Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd
edition, 2008, chapters 6 to 9. The load is raised in steps; each is solved by Newton's method with a pressure of its
own in each cell, eliminated before the linear solve, and with steps shortened so that no cell turns inside out.

The cells are cubes, those of a supple lattice. Where the surface cuts a cell, each eighth of it counts by the share
that lies inside ("finite cell method"), so that the stairs of the lattice do not thicken the body.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

import supple

ROOT = Path(__file__).resolve().parents[1]
OUTPUT = ROOT / "tests" / "data" / "fem"
BUST = ROOT / "examples" / "scenes" / "bust.obj"

SHEAR = 1.0  # Only the ratio of the two moduli matters: the ends are moved, no force is given.
BULK = 2000.0

# Samples per edge of an eighth of a cell, to measure which share of it lies inside a surface.
SAMPLES = 3
# An eighth that lies outside keeps this share: with none, nothing would hold the outer corners of its cell.
LEAST_SHARE = 0.01

# In the order of scikit-fem's hexahedra.
CORNERS = np.array([[0, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0], [1, 1, 1]])

Floats = NDArray[np.float64]


class NotConverged(Exception):  # noqa: N818 - a load step too long, not an error
    """Newton's method did not settle."""


@dataclass
class Problem:
    """A solid of cubes and what is done to it.

    `shares` (cells, 2, 2, 2) is how much of each eighth of each cell is filled; `held` are degrees of freedom, `target`
    (all of them) is where the held ones go at full load.
    """

    mesh: skfem.MeshHex
    shares: Floats
    held: NDArray[np.int64]
    target: Floats


@dataclass
class Solution:
    """Displacements (nodes, 3), the part of the load that was reached, and the relative volume change of the solid."""

    basis: skfem.Basis
    displacement: Floats
    load: float
    volume_change: float

    def at(self, points: Floats) -> Floats:
        """Deformed positions of rest points (n, 3)."""
        return points + self.basis.interpolator(self.displacement)(points.T).T


def hexahedra(lattice: supple.Lattice) -> skfem.MeshHex:
    """The lattice's cells as a mesh; nodes are the lattice's vertices, in its order."""
    grid = np.full(lattice.indices.max(axis=0) + 1, -1)
    grid[tuple(lattice.indices.T)] = np.arange(len(lattice))
    corners = grid[tuple(np.moveaxis(lattice.cells[:, None] + CORNERS, -1, 0))]
    return skfem.MeshHex(lattice.rest_positions.T.copy(), corners.T.copy())


class Solid:
    """The discrete equations: forces and stiffness of all cells at given displacements."""

    def __init__(self, problem: Problem) -> None:
        """Tabulates what does not change with the displacement."""
        self.basis = skfem.Basis(problem.mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=3)
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


def dissection(positions: Floats, nodes: NDArray[np.int64], leaf: int = 60) -> NDArray[np.int64]:
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
    order = dissection(problem.mesh.p.T, np.arange(problem.mesh.nvertices))
    dofs = solid.basis.nodal_dofs[:, order].T.ravel()
    free = dofs[~np.isin(dofs, problem.held)]
    displacement, pressure = np.zeros(solid.basis.N), np.zeros(len(problem.shares))
    load, step = 0.0, first_step
    while load < 1 and step > first_step / 50:
        wanted = min(1.0, load + step)
        try:
            displacement, pressure, rounds = _equilibrium(solid, problem, free, wanted, displacement, pressure)
        except NotConverged:
            step /= 2
            continue
        load = wanted
        print(f"  load {load:.4f}, {rounds} rounds", flush=True)
        if rounds <= 5:
            step *= 1.5
    return Solution(solid.basis, displacement, load, solid.volume_change(displacement))


def _equilibrium(
    solid: Solid, problem: Problem, free: NDArray[np.int64], load: float, displacement: Floats, pressure: Floats
) -> tuple[Floats, Floats, int]:
    """Newton's method at one load: displacement, pressure, rounds."""
    held, cell = problem.held, np.ptp(problem.mesh.p[0, problem.mesh.t[:, 0]])
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
    raise NotConverged


def _step_length(solid: Solid, displacement: Floats, change: Floats) -> float:
    """The longest of 1, 1/2, 1/4, ... at which every cell keeps a good part of its det F at each point."""
    before = np.linalg.det(solid.deformation(displacement))
    for halvings in range(8):
        length = 0.5**halvings
        if (np.linalg.det(solid.deformation(displacement + length * change)) > 0.2 * before).all():
            return length
    raise NotConverged


def filled_shares(mesh: supple.Mesh, lattice: supple.Lattice) -> Floats:
    """Which share of each eighth of each cell lies inside the closed mesh, by parity along rays in x."""
    step = lattice.cell_size / (2 * SAMPLES)
    sizes = lattice.cells.max(axis=0) + 1
    inside = np.zeros(sizes * 2 * SAMPLES, dtype=bool)
    # In units of the sample spacing; the small shift keeps rays off the vertices and edges of symmetric models.
    triangles = (mesh.vertices[mesh.faces] - lattice.origin) / step - 0.5 + [0, 1.7e-6, 2.3e-6]
    for triangle in triangles:
        first = np.ceil(triangle[:, 1:].min(axis=0)).astype(int)
        last = np.floor(triangle[:, 1:].max(axis=0)).astype(int)
        rays = np.stack(np.meshgrid(*map(np.arange, first, last + 1), indexing="ij"), axis=-1).reshape(-1, 2)
        corners = np.column_stack([triangle[:, 1:], np.ones(3)])
        if len(rays) == 0 or abs(np.linalg.det(corners)) < 1e-12:
            continue
        barycentric = np.column_stack([rays, np.ones(len(rays))]) @ np.linalg.inv(corners)
        hits = (barycentric >= 0).all(axis=1)
        for (j, k), x in zip(rays[hits], barycentric[hits] @ triangle[:, 0], strict=True):
            inside[max(0, int(np.ceil(x))) :, j, k] ^= True
    eighths = inside.reshape([length for size in sizes for length in (size, 2, SAMPLES)]).mean(axis=(2, 5, 8))
    shares = eighths.transpose(0, 2, 4, 1, 3, 5)[tuple(lattice.cells.T)]
    return np.maximum(shares, LEAST_SHARE)


def bar(cells: int) -> Problem:
    """An eighth of the bar, `cells` cells to its width: the far half in x, the upper ones in y and z."""
    half = cells // 2
    lattice = supple.Lattice.from_cells(np.ones((4 * half, half, half), dtype=bool), cell_size=1 / cells)
    mesh = hexahedra(lattice)
    dofs = np.arange(3 * mesh.nvertices).reshape(-1, 3)
    end = mesh.p[0] > 2 - 1e-9
    target = np.zeros(dofs.shape)
    target[end, 0] = 1
    held = [dofs[end].ravel(), *(dofs[mesh.p[axis] < 1e-9, axis] for axis in range(3))]
    return Problem(mesh, np.ones((mesh.nelements, 2, 2, 2)), np.unique(np.concatenate(held)), target.ravel())


def bar_points(spacing: int = 8) -> Floats:
    """Points 1 / `spacing` apart on the surface of the bar, 0 <= x <= 4, |y|, |z| <= 1/2."""
    axes = np.arange(4 * spacing + 1), np.arange(spacing + 1), np.arange(spacing + 1)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    on_surface = ((grid == 0) | (grid == [4 * spacing, spacing, spacing])).any(axis=1)
    return grid[on_surface] / spacing - [0, 0.5, 0.5]


def bar_positions(solution: Solution, points: Floats) -> Floats:
    """Deformed positions, by the mirror images of the eighth; the end at x = 0 stays where it is."""
    centred = points - [2, 0, 0]
    sides = np.where(centred < 0, -1, 1)
    return solution.at(np.abs(centred)) * sides + [2 + solution.load, 0, 0]


def bust(mesh: supple.Mesh, cell_size: float) -> Problem:
    """The bust with its shoulders held and its crown moved up."""
    lattice = supple.Lattice.from_mesh(mesh, cell_size=cell_size)
    solid = hexahedra(lattice)
    low, high = mesh.bounds[:, 1]
    height = (solid.p[1] - low) / (high - low)
    dofs = np.arange(3 * solid.nvertices).reshape(-1, 3)
    crown = height > 0.9
    target = np.zeros(dofs.shape)
    target[crown, 1] = (high - low) / 2
    return Problem(solid, filled_shares(mesh, lattice), dofs[crown | (height < 0.2)].ravel(), target.ravel())


def spread(points: Floats, count: int) -> NDArray[np.int64]:
    """Numbers of `count` points, each chosen as the farthest from those before it, in ascending order."""
    chosen = [0]
    distance = np.linalg.norm(points - points[0], axis=1)
    while len(chosen) < count:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.sort(chosen)


def write(name: str, note: str, rest: Floats, deformed: Floats, numbers: NDArray[np.int64] | None = None) -> None:
    """One row a point: its vertex number, if it has one, its rest and its deformed position."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    columns = ["x", "y", "z", "deformed_x", "deformed_y", "deformed_z"]
    lines = [f"# {note}", ",".join(columns if numbers is None else ["vertex", *columns])]
    for row, numeric in enumerate(np.hstack([rest, deformed])):
        cells = [f"{value + 0.0:.5g}" for value in np.round(numeric, 9)]
        lines.append(",".join(cells if numbers is None else [str(numbers[row]), *cells]))
    (OUTPUT / f"{name}.csv").write_text("\n".join(lines) + "\n")


def timed(name: str, problem: Problem, first_step: float) -> Solution:
    """Solves and says how it went."""
    print(f"{name}: {problem.mesh.nelements} cells, {problem.mesh.nvertices} nodes", flush=True)
    began = time.perf_counter()
    solution = solve(problem, first_step)
    seconds = time.perf_counter() - began
    print(f"  load {solution.load:.4f}, solid's volume {solution.volume_change:+.1e}, {seconds:.0f} s", flush=True)
    return solution


def compare(fine: Floats, coarse: Floats) -> None:
    """Prints how far two solutions lie apart."""
    distance = np.linalg.norm(fine - coarse, axis=1)
    print(f"  twice the cell size: rms {np.sqrt(np.mean(distance**2)):.2e}, largest {distance.max():.2e} away")


def run_bar(cells: int, refine: bool) -> None:
    """Solves, compares, writes."""
    points = bar_points()
    solution = timed("bar", bar(cells), 0.25)
    deformed = bar_positions(solution, points)
    if refine:
        compare(deformed, bar_positions(timed("bar, coarse", bar(cells // 2), 0.25), points))
    write("bar", f"bar 4 x 1 x 1, x stretched to {1 + solution.load / 2:.4g} times", points, deformed)


def run_bust(cell_size: float, refine: bool) -> None:
    """Solves, compares, writes."""
    mesh = supple.read_obj(BUST)
    solution = timed("bust", bust(mesh, cell_size), 0.05)
    deformed = solution.at(mesh.vertices)
    print(f"  mesh's volume {supple.Mesh(deformed, mesh.faces).volume / mesh.volume - 1:+.1e}")
    if refine:
        coarse = timed("bust, coarse", bust(mesh, 2 * cell_size), 0.05)
        if coarse.load == solution.load:
            compare(deformed, coarse.at(mesh.vertices))
    numbers = spread(mesh.vertices, 1200)
    note = f"examples/scenes/bust.obj, crown moved up by {solution.load / 2:.4g} of the height"
    write("bust", note, mesh.vertices[numbers], deformed[numbers], numbers)


def main() -> None:
    """Reads the arguments and solves what they name."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", choices=["bar", "bust"], help="one of the two; both by default")
    parser.add_argument("--bar-cells", type=int, default=32, help="cells to the width of the bar, even (default 32)")
    parser.add_argument("--bust-cell", type=float, default=0.1, help="edge of the bust's cells (default 0.1)")
    parser.add_argument("--refine", action="store_true", help="solve with cells of twice the size too, and compare")
    arguments = parser.parse_args()
    if arguments.case != "bust":
        run_bar(arguments.bar_cells, arguments.refine)
    if arguments.case != "bar":
        run_bust(arguments.bust_cell, arguments.refine)


if __name__ == "__main__":
    main()
