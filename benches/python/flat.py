"""Measures how flat the displayed surface is where a body is pressed between plates, or lies on the ground.

python benches/python/flat.py [--quick] [--vertices N ...] [--squeezes R ...] [--skins SKIN ...] [--bodies NAME ...]

Bodies with a height of 1 are pressed between two planes to R times their height, in half a second, and held for as
long, and bodies that are 0.02 above the ground fall on it and rest for a second. A vertex of the mesh *touches* a
plane if it is at most 1 % of a cell from it or behind it. The *patch* of a plane has the touching vertices, and those
at most 0.3 cells from the plane that lie in the convex hull of the touching vertices at most 2 cells around them; both
only where the normal of the surface is at most 45 degrees from the direction to the plane.
Columns in the last frame: vertices in the patches; share of them within 1 % of a cell of the plane; greatest gap, and
greatest depth of a vertex in a plane, in cells; error of the volume relative to the rest volume. Columns of all
frames: greatest displacement of a vertex from one frame to the next, in cells; median times of a frame's steps and of
`Body.surface`, in ms. `--quick` presses one body, as a smoke test.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import supple

SCENES = Path(__file__).parents[2] / "examples/scenes"
#: Distances in cells: of touching vertices from a plane, of the vertices of a patch, and of vertices that enclose it.
TOUCHING, NEAR, AROUND = 0.01, 0.3, 2.0
#: Cosine of the greatest angle between the normal of the surface and the direction to a plane in a patch.
FACING = 0.5**0.5
NAMES = ["ball", "box", "bust", "ring", "fish", "pear"]
Array = NDArray[np.float64]
Triangles = NDArray[np.int64]
Skin = Literal["linear", "smooth"]
Material = Literal["jelly", "rubber"]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="press one body, as a smoke test")
    parser.add_argument("--vertices", type=int, nargs="+", default=[1000, 4000], metavar="N")
    parser.add_argument("--squeezes", type=float, nargs="+", default=[0.6, 0.7, 0.8, 0.95], metavar="R")
    parser.add_argument("--skins", nargs="+", default=["linear", "smooth"], metavar="SKIN")
    parser.add_argument("--bodies", nargs="+", default=NAMES, choices=NAMES, metavar="NAME")
    arguments = parser.parse_args()
    if arguments.quick:
        arguments.bodies, arguments.vertices, arguments.squeezes, arguments.skins = ["ball"], [1000], [0.7], ["linear"]
    print("body                                  patch   share     gap   depth   volume  motion    step  surface")
    for name in arguments.bodies:
        mesh = shape(name)
        for vertices in arguments.vertices:
            for skin in arguments.skins:
                for squeeze in arguments.squeezes:
                    row(f"{name}, {vertices}, {skin}, {squeeze:g}", mesh, vertices, skin, squeeze, "rubber")
                materials: list[Material] = [] if arguments.quick else ["jelly", "rubber"]
                for material in materials:
                    row(f"{name}, {vertices}, {skin}, {material}", mesh, vertices, skin, None, material)


def shape(name: str) -> supple.Mesh:
    """Return a mesh with a height of 1. The fish is an ellipsoid with a tail, and lies on its side."""
    if name == "bust":
        mesh = supple.read_obj(SCENES / "bust.obj")
        vertices, faces = mesh.vertices, mesh.faces
    elif name == "ring":
        vertices, faces = grid(160, 80)
        around, along = vertices[:, 0] * 2 * np.pi, vertices[:, 1] * 2 * np.pi
        radius = 2 + np.cos(along)
        vertices = np.stack([radius * np.cos(around), np.sin(along), radius * np.sin(around)], axis=1)
    else:
        vertices, faces = cube(50)
        if name != "box":
            vertices = np.tan(np.pi / 4 * vertices)
            vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
        if name == "pear":
            width = 0.75 - 0.3 * vertices[:, 1:2]
            vertices = vertices * np.concatenate([width, np.ones_like(width), 0.8 * width], axis=1)
        if name == "fish":
            tail = np.clip(-vertices[:, :1], 0, 1)
            scale = [np.full_like(tail, 3), 1 - 0.6 * tail**2, 1.6 - 1.8 * tail + 1.5 * tail**3]
            vertices = vertices * np.concatenate(scale, axis=1)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices = (vertices - (low + high) / 2) / (high - low)[1]
    vertices, indices = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    return supple.Mesh(vertices, indices.reshape(-1)[faces])


def grid(columns: int, rows: int) -> tuple[Array, Triangles]:
    """Return the unit square, of columns x rows quads."""
    corner = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = np.concatenate([np.stack(quad, axis=-1).reshape(-1, 3) for quad in ((a, b, c), (a, c, d))])
    y, x = np.divmod(np.arange(corner.size), columns + 1)
    return np.stack([x / columns, y / rows], axis=1), triangles[:, ::-1]


def cube(n: int) -> tuple[Array, Triangles]:
    """Return the surface of the cube from -1 to 1, of n x n quads a face."""
    square, triangles = grid(n, n)
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            points = np.full((len(square), 3), sign)
            points[:, (axis + 1) % 3] = 2 * square[:, 0] - 1
            points[:, (axis + 2) % 3] = (2 * square[:, 1] - 1) * -sign
            sides.append(points)
    faces = [triangles + side * len(square) for side in range(6)]
    return np.concatenate(sides), np.concatenate(faces)


def simulate(
    mesh: supple.Mesh, vertices: int, skin: Skin, squeeze: float | None, material: Material
) -> Iterator[tuple[supple.Simulation, list[tuple[float, float]]]]:
    """Iterate over the simulation before each frame, with the height and normal of each plane after it."""
    body = supple.Body(mesh, lattice_vertices=vertices, material=material, accuracy="fast", skin=skin)
    if squeeze is None:
        ground = supple.Plane((0, -0.52, 0), (0, 1, 0))
        sim = supple.Simulation([body], fps=60, colliders=[ground], threads=1)
        heights = [(-0.52, 1.0)]
    else:
        way = 0.5 * (1 - squeeze)
        planes = [
            supple.Plane((0, -0.5 * side, 0), (0, side, 0), keys=[(0, (0, 0, 0)), (0.5, (0, side * way, 0))])
            for side in (1, -1)
        ]
        sim = supple.Simulation([body], fps=60, gravity=(0, 0, 0), colliders=planes, threads=1)
    for frame in range(60):
        if squeeze is not None:
            way = 0.5 * (1 - squeeze) * min(1.0, (frame + 1) / 30)
            heights = [(-0.5 + way, 1.0), (0.5 - way, -1.0)]
        yield sim, heights


def row(label: str, mesh: supple.Mesh, vertices: int, skin: Skin, squeeze: float | None, material: Material) -> None:
    """Simulate a body, and print its row."""
    steps, times, motion = [], [], 0.0
    planes: list[tuple[float, float]] = []
    before: Array | None = None
    for sim, heights in simulate(mesh, vertices, skin, squeeze, material):
        planes = heights
        body = sim.bodies[0]
        start = time.perf_counter()
        sim.advance()
        stepped = time.perf_counter()
        surface = body.surface()
        steps.append(1e3 * (stepped - start))
        times.append(1e3 * (time.perf_counter() - stepped))
        cell = body.lattice.cell_size
        if before is not None:
            motion = max(motion, float(np.linalg.norm(surface - before, axis=1).max()) / cell)
        before = surface
    upward = sim.bodies[0].surface_normals()[:, 1]
    gaps = np.concatenate([patch(surface[-side * upward > FACING], height, side, cell) for height, side in planes])
    depth = max(float((side * (height - surface[:, 1])).max()) / cell for height, side in planes)
    share, greatest = (np.mean(np.abs(gaps) <= 0.01), gaps.max()) if len(gaps) else (1.0, 0.0)
    residual = abs(body.volume_report().residual)
    print(
        f"{label:36} {len(gaps):6d} {100 * share:5.1f} % {greatest:7.3f} {max(depth, 0.0):7.4f} {residual:8.0e}"
        f" {motion:7.3f} {statistics.median(steps):7.2f} {statistics.median(times):8.2f}",
        flush=True,
    )


def patch(surface: Array, height: float, side: float, cell: float) -> Array:
    """Return the gaps of the vertices in the patch of a plane, in cells."""
    gaps = side * (surface[:, 1] - height) / cell
    points = surface[:, [0, 2]] / cell
    touching = points[gaps <= TOUCHING]
    near = np.flatnonzero(gaps < NEAR)
    inside = [bool(gaps[k] <= TOUCHING) or is_enclosed(points[k], touching) for k in near]
    found: Array = gaps[near[np.array(inside, dtype=bool)]]
    return found


def is_enclosed(point: Array, touching: Array) -> bool:
    """Return whether a point is inside the convex hull of the touching points around it."""
    offsets = touching - point
    offsets = offsets[np.hypot(offsets[:, 0], offsets[:, 1]) <= AROUND]
    angles = np.sort(np.arctan2(offsets[:, 1], offsets[:, 0]))
    return len(angles) > 2 and bool((np.diff(angles, append=angles[0] + 2 * np.pi) < np.pi).all())


if __name__ == "__main__":
    main()
