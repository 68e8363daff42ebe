"""Counts inverted cells in hard drops, before and after the display untangles the lattice.

python benches/python/crushed.py [--quick] [--heights H ...] [--softness S ...]

Bodies of about 1,000 lattice vertices and a height of 1 fall on a plane, from H times their height (2 by default),
straight and turned by 30 degrees about two axes, with the Young's modulus of `jelly` divided by S (1 by default). A
cell is inverted if the determinant at one of its corners or at its center is not positive. Columns: frames and
cells that are inverted before the display, and in the displayed lattice; the greatest error of the displayed volume
relative to the rest volume; the time of `Body.surface` in ms, as the median of frames without and with inverted
cells, and the maximum. `--quick` drops one body, as a smoke test.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import supple

SCENES = Path(__file__).parents[2] / "examples/scenes"
Positions = NDArray[np.float64]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="drop one body, as a smoke test")
    parser.add_argument("--heights", type=float, nargs="+", default=[2.0], metavar="H")
    parser.add_argument("--softness", type=float, nargs="+", default=[1.0], metavar="S")
    arguments = parser.parse_args()
    print(
        "body                          before: frames, cells  displayed: frames, cells  volume  ms: clean  crushed  max"
    )
    for height in arguments.heights:
        for softness in arguments.softness:
            for label, shape, options in cases(arguments.quick):
                row(f"{label}, {height:g} high, 1/{softness:g}", shape, height, softness, options)


def cases(quick: bool) -> Iterator[tuple[str, supple.Mesh, dict[str, Any]]]:
    """Iterate over the shapes, straight and turned, with their options."""
    for name, shape in shapes(quick):
        yield name, shape, {}
        if not quick:
            yield f"{name}, turned", turned(shape), {}
            yield f"{name}, smooth", shape, {"skin": "smooth"}
            yield f"{name}, regional", shape, {"volume": {"scope": "regional"}}
            yield f"{name}, volume off", shape, {"volume": "off"}


def shapes(quick: bool) -> Iterator[tuple[str, supple.Mesh]]:
    """Iterate over meshes with a height of 1."""
    for name in ("box",) if quick else ("box", "ball", "ring", "bust"):
        mesh = supple.read_obj(SCENES / f"{name}.obj")
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        yield name, supple.Mesh((mesh.vertices - (low + high) / 2) / (high - low)[1], mesh.faces)


def turned(mesh: supple.Mesh) -> supple.Mesh:
    """Return a mesh that is turned by 30 degrees about x, then about z."""
    cos, sin = np.cos(np.pi / 6), np.sin(np.pi / 6)
    about_x = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
    about_z = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    return supple.Mesh(mesh.vertices @ (about_z @ about_x).T, mesh.faces)


def row(label: str, mesh: supple.Mesh, height: float, softness: float, options: dict[str, Any]) -> None:
    """Drop a body, and print its row."""
    ground = mesh.vertices[:, 1].min() - 0.02
    velocity = (0, -np.sqrt(2 * 9.81 * height), 0)
    body = supple.Body(mesh, lattice_vertices=1000, material="jelly", accuracy="fast", velocity=velocity, **options)
    sim = supple.Simulation([body], fps=60, colliders=[supple.Plane((0, ground, 0), (0, 1, 0))], threads=1)
    body.youngs_modulus = body.youngs_modulus / softness
    before: list[int] = []
    displayed: list[int] = []
    errors = [0.0]
    clean: list[float] = []
    crushed: list[float] = []
    for _ in range(60):
        sim.advance()
        start = time.perf_counter()
        body.surface()
        elapsed = 1e3 * (time.perf_counter() - start)
        before.append(inverted_cells(body, body.positions))
        displayed.append(inverted_cells(body, body.corrected_positions()))
        (crushed if before[-1] else clean).append(elapsed)
        if body.volume_options is not None:
            report = body.volume_report()
            rest, _, after = report.volumes[report.measure]
            errors.append(abs(after / rest - 1))
    counts = [np.count_nonzero(before), sum(before), np.count_nonzero(displayed), sum(displayed)]
    print(
        f"{label:30} {counts[0]:13d} {counts[1]:7d} {counts[2]:17d} {counts[3]:7d}"
        f" {max(errors):8.0e} {statistics.median(clean or [0]):10.2f} {statistics.median(crushed or [0]):8.2f}"
        f" {max(clean + crushed):6.1f}"
    )


def inverted_cells(body: supple.Body, positions: Positions) -> int:
    """Return the number of cells with a determinant that is not positive, at a corner or at the center."""
    lattice = body.lattice
    index = {tuple(vertex): number for number, vertex in enumerate(lattice.indices.tolist())}
    offsets = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)])
    corners = (lattice.cells[:, None] + offsets).reshape(-1, 3).tolist()
    points = positions[[index[tuple(corner)] for corner in corners]].reshape(-1, 8, 3)
    edges = np.stack([[points[:, k | 1 << axis] - points[:, k & ~(1 << axis)] for axis in range(3)] for k in range(8)])
    edges = np.concatenate([edges, edges.mean(axis=0, keepdims=True)])
    determinants = np.linalg.det(edges.transpose(0, 2, 1, 3))
    return int(np.count_nonzero((determinants <= 0).any(axis=0)))


if __name__ == "__main__":
    main()
