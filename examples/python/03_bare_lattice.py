"""Simulate a lattice without a mesh: cells from a boolean array, goal positions, momentum.

python examples/python/03_bare_lattice.py
"""

from __future__ import annotations

import numpy as np

import supple


def main() -> None:
    """Lift one tip of a horseshoe and release it."""
    cells = np.zeros((5, 7, 1), dtype=bool)
    cells[:, 0] = cells[0] = cells[-1] = True  # the tips are close to each other, but not linked
    lattice = supple.Lattice.from_cells(cells, cell_size=0.1)
    print(f"{len(lattice.cells)} cells, {len(lattice)} lattice vertices")

    body = supple.Body(lattice, half_width=2)
    x, y, _ = lattice.indices.T
    with body.edit() as state:
        state.positions[(x >= 4) & (y >= 5), 2] += 0.15
    distances = np.linalg.norm(body.goals() - body.positions, axis=1)
    print(f"greatest distance of a vertex from its goal: {distances.max():.4f}")

    # Shape matching conserves momentum: without external forces the center of mass stays in place.
    before = np.average(body.positions, axis=0, weights=body.masses)
    sim = supple.Simulation([body], dt=1 / 60, gravity=(0, 0, 0))
    sim.step(600)
    displacement = np.linalg.norm(np.average(body.positions, axis=0, weights=body.masses) - before)
    print(f"center of mass after 600 steps: moved by {displacement:.1e}")


if __name__ == "__main__":
    main()
