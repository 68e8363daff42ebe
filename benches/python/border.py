"""Measures the overhead of calls from Python to Rust, compared with numpy.

python benches/python/border.py [--quick]

Each row is the median of many calls within one run. Compared functions are called alternately, so that other load on
the machine affects all of them. `--quick` makes only one or two calls of each, as a smoke test.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import platform
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import supple

Floats = NDArray[np.floating]


def main() -> None:
    """Runs all cases and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="make only one or two calls of each function")
    quick = parser.parse_args().quick
    print(f"{platform.machine()}, {supple.simd_level()}, Python {platform.python_version()}, numpy {np.__version__}")
    step(quick)
    surface(quick)
    states(quick)
    fields(quick)
    rotations(quick)


def step(quick: bool) -> None:
    """Times many calls of one step each, and one call of many steps. The overhead is clearest for one cell."""
    for sides in (1, 9):
        body = supple.Body(supple.Lattice.from_cells(np.ones((sides, sides, sides), dtype=bool)), spin=(0, 0, 1))
        sim = supple.Simulation([body], gravity=(0, 0, 0), threads=1)
        count = 2 if quick else 500
        calls = [partial(step_by_step, sim, count), partial(sim.step, count)]
        one_step_per_call, one_call = (seconds / count for seconds in alternately(calls, 2 if quick else 41))
        row(f"step of {len(body)} lattice vertices, called from Python", one_step_per_call)
        row("the same within one call, in Rust", one_call)
        row("overhead of a call (target: at most 10 us)", one_step_per_call - one_call)


def step_by_step(sim: supple.Simulation, count: int) -> None:
    """Makes one call per step."""
    for _ in range(count):
        sim.step()


def surface(quick: bool) -> None:
    """Times the surface of 60,000 vertices: into `out=`, as a new array, in Rust; a copy and an update in numpy."""
    mesh = globe(20 if quick else 245)
    with tempfile.TemporaryDirectory() as directory:
        rust = rust_evaluation(mesh, Path(directory), 2 if quick else 60)
    body = supple.Body(mesh, lattice_vertices=1000, name="globe", spin=(0, 0, 1))
    sim = supple.Simulation([body], gravity=(0, 0, 0))
    sim.step(10)
    out = np.empty(mesh.vertices.shape, dtype=np.float32)
    source = out.copy()
    embedding = Embedding(body)
    calls: list[Callable[[], object]] = [
        lambda: body.surface(out=out),
        body.surface,
        lambda: np.copyto(out, source),
        embedding.surface,
    ]
    into, new, copy, numpy = alternately(calls, 2 if quick else 201)
    row(f"surface(out=) of {len(mesh.vertices)} vertices, float32, volume preserved", into)
    row("the same evaluation within a run, in Rust alone", rust)
    row("a numpy copy of that size", copy)
    row("surface(): a new float64 array", new)
    row("mesh update by numpy, float32, no volume correction", numpy)


def states(quick: bool) -> None:
    """Times saving and restoring the state of a body of 1,000 lattice vertices that rests on a collider."""
    body = supple.Body(globe(20), lattice_vertices=1000)
    ground = supple.Plane((0, body.positions[:, 1].min(), 0), (0, 1, 0))
    sim = supple.Simulation([body], fps=30, colliders=ground)
    sim.advance(20)
    state = sim.save_state()
    save, restore = alternately([sim.save_state, partial(sim.restore_state, state)], 2 if quick else 501)
    row(f"save_state() of {len(body)} lattice vertices, {len(state) / 1e3:.0f} kB (target: at most 0.2 ms)", save)
    row("restore_state() (target: at most 0.2 ms)", restore)


def fields(quick: bool) -> None:
    """Times steps without a force field, with a constant one and with a function."""
    steps = 2 if quick else 200
    calls: list[Callable[[], object]] = []
    for force in (None, (0, 1e-3, 0), lambda positions, velocities, time: np.full_like(positions, 1e-3)):
        body = supple.Body(globe(20), lattice_vertices=1000, material="jelly")
        if force is not None:
            body.add_force_field(force)
        calls.append(partial(supple.Simulation(body, gravity=(0, 0, 0), sleep=False).step, steps))
    times = [seconds / steps for seconds in alternately(calls, 2 if quick else 15)]
    row("step of 1,000 lattice vertices without force field", times[0])
    row("with a constant force field, more by", times[1] - times[0])
    row("with a function of positions and velocities, more by", times[2] - times[0])


def rotations(quick: bool) -> None:
    """Times the rotation factors of matrices, compared with numpy's singular value decomposition."""
    matrices = np.random.default_rng(0).normal(size=(100 if quick else 20_000, 3, 3))

    def by_numpy() -> Floats:
        u, _, vt = np.linalg.svd(matrices)
        u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
        rotations: Floats = u @ vt
        return rotations

    rust, numpy = alternately([lambda: supple.rotations(matrices), by_numpy], 2 if quick else 21)
    row(f"rotations of {len(matrices)} matrices", rust)
    row("the same by numpy.linalg.svd", numpy)


def alternately(calls: Sequence[Callable[[], object]], rounds: int) -> list[float]:
    """Calls the functions alternately and returns their median seconds. An untimed call precedes each timed call."""
    times: list[list[float]] = [[] for _ in calls]
    for _ in range(rounds):
        for call, samples in zip(calls, times, strict=True):
            call()
            start = time.perf_counter()
            call()
            samples.append(time.perf_counter() - start)
    return [statistics.median(samples) for samples in times]


def row(name: str, seconds: float) -> None:
    """Prints a line of the table."""
    print(f"{name:<66} {1e6 * seconds:10.1f} us")


def globe(sides: int) -> supple.Mesh:
    """Returns a ball of (sides + 1) x sides vertices, closed at its poles."""
    polar, around = np.linspace(0, np.pi, sides + 1), np.arange(sides) * 2 * np.pi / sides
    sin, cos = np.sin(polar)[:, None], np.cos(polar)[:, None]
    # The sine is set to exactly zero at the poles, so that all vertices of a pole coincide.
    sin[[0, -1]] = 0
    ones = np.ones_like(around)
    points = np.stack([sin * np.cos(around), sin * np.sin(around), cos * ones], axis=-1).reshape(-1, 3)
    ring, column = (index.ravel() for index in np.meshgrid(np.arange(sides), np.arange(sides), indexing="ij"))
    next_column = (column + 1) % sides
    a, b = ring * sides + column, ring * sides + next_column
    return supple.Mesh(points, np.stack([a, a + sides, b + sides, b], axis=1))


def rust_evaluation(mesh: supple.Mesh, directory: Path, frames: int) -> float:
    """Returns the median seconds of volume correction and mesh update in a run, from its statistics."""
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (mesh.faces + 1).tolist())
    (directory / "globe.obj").write_text(vertices + faces)
    (directory / "globe.toml").write_text(
        f"""
        [simulation]
        frames = {frames}
        gravity = [0, 0, 0]

        [[body]]
        name = "globe"
        mesh = "globe.obj"
        lattice_vertices = 1000
        spin = [0, 0, 1]
        """
    )
    supple.run(directory / "globe.toml", directory / "out", "pc2", stats=directory / "stats.csv")
    with (directory / "stats.csv").open() as file:
        rows = list(csv.DictReader(file))
    return statistics.median(float(row["ms_volume"]) + float(row["ms_embed"]) for row in rows) / 1e3


class Embedding:
    """Cells and trilinear weights of mesh vertices in a lattice, and the mesh update in numpy."""

    def __init__(self, body: supple.Body) -> None:
        """Computes cells and weights in the rest pose."""
        mesh, lattice = body.mesh, body.lattice
        assert mesh is not None
        in_cells = (mesh.vertices - lattice.origin) / lattice.cell_size
        low, high = lattice.cells.min(axis=0), lattice.cells.max(axis=0)
        cells = np.clip(np.floor(in_cells).astype(int), low, high)
        vertices = {tuple(index): vertex for vertex, index in enumerate(lattice.indices.tolist())}
        corners = list(itertools.product((0, 1), repeat=3))
        # A mesh vertex on the face of a missing cell would need the neighboring cell. For timing, vertex 0 suffices.
        self.corners = np.array([[vertices.get(tuple(cell + corner), 0) for corner in corners] for cell in cells])
        local = in_cells - cells
        weights = [np.where(corner, local, 1 - local).prod(axis=1) for corner in corners]
        self.weights = np.stack(weights, axis=1).astype(np.float32)
        self.positions = body.positions.astype(np.float32)

    def surface(self) -> Floats:
        """Returns the mesh vertices (k, 3) deformed by the lattice."""
        moved: Floats = np.einsum("kc,kci->ki", self.weights, self.positions[self.corners])
        return moved


if __name__ == "__main__":
    main()
