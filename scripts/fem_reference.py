"""Computes finite-element reference solutions: equilibrium shapes of nearly incompressible elastic solids.

    pip install scikit-fem numpy scipy          # in addition to supple
    python scripts/fem_reference.py             # both cases, into tests/data/fem
    python scripts/fem_reference.py --case bar --refine

The static equilibria of two bodies are computed, each constrained at both ends:

bar   4 x 1 x 1; both end faces are fixed, and one is moved along x until the length is 1.5 times the rest length. The
      bar is symmetric in three planes, so only an eighth of it is computed.
bust  examples/scenes/bust.obj; the lowest 20 % of its height is fixed, the highest 10 % is moved up by half the height.

The material is Neo-Hookean with a bulk modulus of 2,000 times the shear modulus; the elements are cubes (see
fem_solid.py). Where the surface cuts a cube, each eighth of the cube is weighted by the fraction of the eighth that is
inside the surface ("finite cell method"), so that the staircase boundary does not thicken the body. The
boundaries between the constrained and the free parts of the bust are planes of nodes.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from fem_grid import Floats, Grid, Ints, fill
from fem_solid import Problem, Solution, solve

import supple

ROOT = Path(__file__).resolve().parents[1]
OUTPUT = ROOT / "tests" / "data" / "fem"
BUST = ROOT / "examples" / "scenes" / "bust.obj"


def bar(cells: int) -> Problem:
    """Returns an eighth of the bar with `cells` cells per width: the far half in x, the upper halves in y and z."""
    half = cells // 2
    grid = Grid(np.argwhere(np.ones((4 * half, half, half))), 1 / cells, np.zeros(3))
    dofs = np.arange(grid.nodes.size).reshape(-1, 3)
    end = grid.nodes[:, 0] > 2 - 1e-9
    target = np.zeros(grid.nodes.shape)
    target[end, 0] = 1
    constrained = [dofs[end].ravel(), *(dofs[grid.nodes[:, axis] < 1e-9, axis] for axis in range(3))]
    return Problem(grid, np.ones((len(grid.cells), 2, 2, 2)), np.unique(np.concatenate(constrained)), target.ravel())


def bar_points(spacing: int = 8) -> Floats:
    """Returns points 1 / `spacing` apart on the surface of the bar 0 <= x <= 4, |y| <= 1/2, |z| <= 1/2."""
    axes = np.arange(4 * spacing + 1), np.arange(spacing + 1), np.arange(spacing + 1)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    on_surface = ((grid == 0) | (grid == [4 * spacing, spacing, spacing])).any(axis=1)
    return grid[on_surface] / spacing - [0, 0.5, 0.5]


def bar_positions(solution: Solution, points: Floats) -> Floats:
    """Returns deformed positions, from mirror images of the eighth. The end at x = 0 does not move."""
    centered = points - [2, 0, 0]
    sides = np.where(centered < 0, -1, 1)
    return solution.at(np.abs(centered)) * sides + [2 + solution.load, 0, 0]


def bust(mesh: supple.Mesh, cells: int) -> Problem:
    """Returns the bust with fixed shoulders and its crown moved up, with `cells` cells between shoulders and crown."""
    low, high = mesh.bounds
    height = high[1] - low[1]
    anchor = (low + high) / 2
    anchor[1] = low[1] + 0.2 * height
    grid, fractions = fill(mesh, 0.7 * height / cells, anchor)
    relative = (grid.nodes[:, 1] - low[1]) / height
    crown = relative > 0.9 - 1e-9
    target = np.zeros(grid.nodes.shape)
    target[crown, 1] = height / 2
    dofs = np.arange(grid.nodes.size).reshape(-1, 3)
    return Problem(grid, fractions, dofs[crown | (relative < 0.2 + 1e-9)].ravel(), target.ravel())


def spread(points: Floats, count: int) -> Ints:
    """Returns the indices of `count` points in ascending order, chosen by farthest-point sampling."""
    chosen = [0]
    distance = np.linalg.norm(points - points[0], axis=1)
    while len(chosen) < count:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.sort(chosen)


def write(name: str, note: str, rest: Floats, deformed: Floats, vertices: Ints | None = None) -> None:
    """Writes one row per point: its vertex index (if `vertices` is given), rest position and deformed position."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    columns = ["x", "y", "z", "deformed_x", "deformed_y", "deformed_z"]
    lines = [f"# {note}", ",".join(columns if vertices is None else ["vertex", *columns])]
    for row, coordinates in enumerate(np.hstack([rest, deformed])):
        # Rounding to 9 decimals turns values at rounding level into 0 or -0; adding 0.0 turns -0 into 0.
        values = [f"{value + 0.0:.5g}" for value in np.round(coordinates, 9)]
        lines.append(",".join(values if vertices is None else [str(vertices[row]), *values]))
    (OUTPUT / f"{name}.csv").write_text("\n".join(lines) + "\n")


def timed(name: str, problem: Problem, first_step: float) -> Solution:
    """Solves a problem. Prints its size, the final fraction of the load, the volume change and the run time."""
    print(f"{name}: {len(problem.grid.cells)} cells, {len(problem.grid.nodes)} nodes", flush=True)
    began = time.perf_counter()
    solution = solve(problem, first_step)
    seconds = time.perf_counter() - began
    print(f"  load {solution.load:.4f}, solid's volume {solution.volume_change:+.1e}, {seconds:.0f} s", flush=True)
    return solution


def compare(fine: Floats, coarse: Floats) -> None:
    """Prints the distance between two solutions at the same points."""
    distance = np.linalg.norm(fine - coarse, axis=1)
    print(f"  twice the cell size: rms {np.sqrt(np.mean(distance**2)):.2e}, largest {distance.max():.2e} away")


def run_bar(cells: int, refine: bool) -> None:
    """Solves the bar, also on a coarser grid for comparison if `refine` is set, and writes the result."""
    points = bar_points()
    solution = timed("bar", bar(cells), 0.25)
    deformed = bar_positions(solution, points)
    if refine:
        compare(deformed, bar_positions(timed("bar, coarse", bar(cells // 2), 0.25), points))
    write("bar", f"bar 4 x 1 x 1, x stretched to {1 + solution.load / 2:.4g} times", points, deformed)


def run_bust(cells: int, refine: bool) -> None:
    """Solves the bust, also on a coarser grid for comparison if `refine` is set, and writes the result."""
    mesh = supple.read_obj(BUST)
    solution = timed("bust", bust(mesh, cells), 0.1)
    deformed = solution.at(mesh.vertices)
    print(f"  mesh's volume {supple.Mesh(deformed, mesh.faces).volume / mesh.volume - 1:+.1e}")
    if refine:
        coarse = timed("bust, coarse", bust(mesh, cells // 2), 0.1)
        if coarse.load == solution.load:
            compare(deformed, coarse.at(mesh.vertices))
    vertices = spread(mesh.vertices, 1200)
    note = f"examples/scenes/bust.obj, crown moved up by {solution.load / 2:.4g} of the height"
    write("bust", note, mesh.vertices[vertices], deformed[vertices], vertices)


def main() -> None:
    """Reads the arguments and solves the selected cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", choices=["bar", "bust"], help="solve one case (default: both)")
    parser.add_argument("--bar-cells", type=int, default=32, help="cells per width of the bar, even (default 32)")
    parser.add_argument("--bust-cells", type=int, default=26, help="cells between the fixed ends, even (default 26)")
    parser.add_argument("--refine", action="store_true", help="also solve with cells of twice the size, and compare")
    arguments = parser.parse_args()
    if arguments.case != "bust":
        run_bar(arguments.bar_cells, arguments.refine)
    if arguments.case != "bar":
        run_bust(arguments.bust_cells, arguments.refine)


if __name__ == "__main__":
    main()
