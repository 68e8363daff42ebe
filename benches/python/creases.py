"""Measures the creases of the displayed surface at the faces of the lattice cells, with both skins.

python benches/python/creases.py [--quick] [--write FOLDER]

A body is held at one end and stretched at the other. The *jump* of an edge of the mesh is the change of the angle
between the normals of its two triangles since rest, in radians. The table has the 99th percentile of the jumps of edges
whose triangles have their centroids in different cells, the same of the other edges, and the ratio of the two.
`--write` writes the surfaces of the ball with 300 lattice vertices to the OBJ files `linear.obj` and `smooth.obj`, in
place of the table. `--quick` measures only 300 lattice vertices, as a smoke test.
"""

import argparse
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import supple

BUST = Path(__file__).parents[2] / "examples/scenes/bust.obj"
Vertices = NDArray[np.float64]
Triangles = NDArray[np.int64]


def sphere(n: int = 60) -> tuple[Vertices, Triangles]:
    """Return a sphere of radius 1: the faces of a cube, of n x n quads each, projected to it."""
    points: list[Vertices] = []
    triangles: list[list[int]] = []
    for axis in range(3):
        for sign in (-1, 1):
            first = len(points)
            for j in range(n + 1):
                for i in range(n + 1):
                    point = np.full(3, float(sign))
                    point[(axis + 1) % 3], point[(axis + 2) % 3] = np.tan(np.pi / 4 * (2 * np.array([i, j]) / n - 1))
                    points.append(point / np.linalg.norm(point))
            for j in range(n):
                for i in range(n):
                    a = first + j * (n + 1) + i
                    quad = [a, a + 1, a + n + 2, a + n + 1][::sign]
                    triangles += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    vertices, indices = np.unique(np.round(points, 9), axis=0, return_inverse=True)
    return vertices, indices.reshape(-1)[np.array(triangles)]


def normals(points: Vertices, triangles: Triangles) -> Vertices:
    """Return the unit normals of triangles."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    unit: Vertices = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300)
    return unit


def jumps(body: supple.Body, triangles: Triangles) -> tuple[float, float]:
    """Return the 99th percentile of the jumps across the faces of cells, and within cells."""
    assert body.mesh is not None
    rest, posed = body.mesh.vertices, body.surface()
    cells = np.floor((rest[triangles].mean(axis=1) - body.lattice.origin) / body.lattice.cell_size)
    welded = np.unique(np.round(rest, 9), axis=0, return_inverse=True)[1].reshape(-1)[triangles]
    pairs: list[tuple[int, int]] = []
    open_edges: dict[tuple[int, int], int] = {}
    for index, (a, b, c) in enumerate(welded.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            if edge[::-1] in open_edges:
                pairs.append((open_edges.pop(edge[::-1]), index))
            else:
                open_edges[edge] = index
    left, right = np.array(pairs).T
    angles = []
    for points in (rest, posed):
        unit = normals(points, triangles)
        angles.append(np.arccos(np.clip((unit[left] * unit[right]).sum(axis=1), -1, 1)))
    jump = np.abs(angles[1] - angles[0])
    within = (cells[left] == cells[right]).all(axis=1)
    return float(np.percentile(jump[~within], 99)), float(np.percentile(jump[within], 99))


def stretched(
    mesh: supple.Mesh, vertices: int, skin: Literal["linear", "smooth"], ends: tuple[float, float], distance: float
) -> supple.Body:
    """Return a body that is held below the first end and has been pulled up above the second one."""
    body = supple.Body(
        mesh, lattice_vertices=vertices, half_width=2, stiffness=0.8, region_damping=0.1, damping_ratio=0, skin=skin
    )
    body.pin(plane=([0, ends[0], 0], [0, -1, 0]))
    keys = [(0, [0, 0, 0]), (1, [0, distance, 0])]
    body.handle(plane=([0, ends[1], 0], [0, 1, 0]), keys=keys)
    supple.Simulation([body], dt=1 / 60, gravity=(0, 0, 0)).step(300)
    return body


def write(folder: Path, mesh: supple.Mesh, triangles: Triangles) -> None:
    """Write the surfaces of the stretched ball."""
    folder.mkdir(parents=True, exist_ok=True)
    for skin in ("linear", "smooth"):
        points = stretched(mesh, 300, skin, (-0.7, 0.7), 1.0).surface()
        lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points] + [f"f {a} {b} {c}" for a, b, c in triangles + 1]
        (folder / f"{skin}.obj").write_text("\n".join(lines) + "\n")


def main() -> None:
    """Print the table, or write the surfaces."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="write two surfaces as OBJ files")
    parser.add_argument("--quick", action="store_true", help="measure only 300 lattice vertices, as a smoke test")
    arguments = parser.parse_args()
    folder = arguments.write
    ball, triangles = sphere()
    if folder is not None:
        write(folder, supple.Mesh(ball, triangles), triangles)
        return
    turn = np.array([[np.cos(0.5), -np.sin(0.5), 0], [np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]])
    egg = ball * [1, 1.5, 0.8] @ turn.T
    bust = supple.read_obj(BUST)
    cases = [
        ("ball", supple.Mesh(ball, triangles), triangles, (-0.7, 0.7), 1.0),
        ("egg", supple.Mesh(egg, triangles), triangles, (-1.0, 1.0), 1.0),
        ("bust", bust, bust.faces, (6.183, 8.751), 1.834),
    ]
    print("body  vertices  skin    across  within  ratio")
    for name, mesh, faces, ends, distance in cases:
        for vertices in (300,) if arguments.quick else (300, 1000, 3000, 10000):
            for skin in ("linear", "smooth"):
                across, within = jumps(stretched(mesh, vertices, skin, ends, distance), faces)
                print(f"{name:5} {vertices:8}  {skin}  {across:6.3f}  {within:6.3f}  {across / within:5.2f}")


if __name__ == "__main__":
    main()
