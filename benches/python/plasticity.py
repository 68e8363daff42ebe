"""Measure how much of a pull, a press and a bend a plastic body keeps, for yield strains and sizes of the regions.

python benches/python/plasticity.py
"""

from __future__ import annotations

import numpy as np

import supple

Size = tuple[int, int, int]
FPS, SUBSTEPS = 30, 8
HELD, RESTED = 3.0, 6.0
"""Seconds for which the ends of a bar are moved and held, and for which it then rests."""


def block(size: Size, half_width: int, yield_strain: float) -> supple.Body:
    """Return a block of cells of edge 1."""
    lattice = supple.Lattice.from_cells(np.ones(size, bool))
    return supple.Body(lattice, half_width=half_width, damping_rate=8, plastic={"yield": yield_strain})


def released(body: supple.Body, axis: int, translate: np.ndarray, rotate: float) -> supple.Body:
    """Move both ends of a block apart along an axis, and turn them against each other about z, and release them."""
    ends = body.lattice.indices[:, axis]
    for side, end in ((-1, ends.min()), (1, ends.max())):
        keys = [(0.0, (0, 0, 0), (0, 0, 0)), (1.0, side * translate / 2, (0, 0, side * rotate / 2))]
        body.handle(vertices=np.flatnonzero(ends == end), keys=keys, end=HELD)
    simulation = supple.Simulation([body], fps=FPS, substeps=SUBSTEPS, gravity=(0, 0, 0))
    simulation.advance(round(FPS * (HELD + RESTED)))
    return body


def stretch(
    size: tuple[int, int, int], axis: int, by: float, half_width: int, yield_strain: float
) -> tuple[float, float]:
    """Return the part of a stretch along an axis that a block keeps, and its volume relative to that at rest."""
    translate = np.zeros(3)
    translate[axis] = by * size[axis]
    body = released(block(size, half_width, yield_strain), axis, translate, 0)
    ends, x = body.lattice.indices[:, axis], body.positions[:, axis]
    length = x[ends == ends.max()].mean() - x[ends == ends.min()].mean()
    report = body.volume_report()
    return (length / size[axis] - 1) / by, report.before / report.rest


def bend(size: Size, degrees: float, half_width: int, yield_strain: float) -> tuple[float, float]:
    """Return the part of a bend of a bar along x that it keeps, and its volume relative to that at rest."""
    body = released(block(size, half_width, yield_strain), 0, np.zeros(3), degrees)
    ends, angles = body.lattice.indices[:, 0], []
    for end in (ends.min(), ends.max()):
        face = body.positions[ends == end]
        rest = body.lattice.rest_positions[ends == end]
        slope = np.polyfit(rest[:, 1], face[:, 0], 1)[0]
        angles.append(np.degrees(np.arcsin(np.clip(-slope, -1, 1))))
    report = body.volume_report()
    return (angles[1] - angles[0]) / degrees, report.before / report.rest


def main() -> None:
    """Print a table."""
    print(f"{'case':34} {'radius/thickness':>16} {'yield':>6} {'kept':>6} {'volume':>7}")
    for half_width, yield_strain in ((1, 0.01), (1, 0.02), (1, 0.05), (2, 0.02), (3, 0.02)):
        cases = {
            "pull of 25 %, 24 x 8 x 8 cells": (8, stretch((24, 8, 8), 0, 0.25, half_width, yield_strain)),
            "press of 40 %, 10 x 10 x 10 cells": (10, stretch((10, 10, 10), 1, -0.4, half_width, yield_strain)),
            "bend by 60 degrees, 48 x 16 x 4 cells": (16, bend((48, 16, 4), 60, half_width, yield_strain)),
        }
        for name, (thickness, (kept, volume)) in cases.items():
            radius = np.sqrt(half_width * (half_width + 1)) / thickness
            print(f"{name:34} {radius:16.2f} {yield_strain:6} {kept:6.2f} {volume:7.4f}")
    for half_width in (4, 6, 8):
        kept, volume = bend((48, 16, 4), 60, half_width, 0.02)
        radius = np.sqrt(half_width * (half_width + 1)) / 16
        print(f"{'bend by 60 degrees, 48 x 16 x 4 cells':34} {radius:16.2f} {0.02:6} {kept:6.2f} {volume:7.4f}")


if __name__ == "__main__":
    main()
