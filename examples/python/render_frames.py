"""Render frames side by side: one row per run, one column per frame, with the same camera.

    supple run examples/scenes/stretch_and_drop.toml -o frames/kept --format ply
    supple run examples/scenes/stretch_and_drop.toml -o frames/plain --format ply --set 'body.bust.volume="off"'
    supple run examples/scenes/stretch_and_drop.toml -o frames/regional --format ply \
        --set 'body.bust.volume={ scope = "regional" }'
    python examples/python/render_frames.py stretch.png "plain=frames/plain" "global=frames/kept" \
        "regional=frames/regional" --frames 0 24 48 240 --titles rest "half way" "full stretch" landed

Needs pyvista, which installs matplotlib. On a machine without a display and without a software renderer, run the
program with `xvfb-run -a`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib
import numpy as np
import pyvista

matplotlib.use("Agg")
from matplotlib import pyplot as plt

SKIN = "#e0b090"
GROUND = "#e6e9ed"
SHADOW = "#c3c9d0"
CELL = (480, 500)


def load(directory: Path, frame: int) -> pyvista.PolyData:
    """Read the surface of one frame from its PLY or OBJ file."""
    paths = sorted(p for p in directory.glob(f"*_{frame:04d}.*") if p.suffix in (".ply", ".obj"))
    if not paths:
        raise SystemExit(f"{directory} contains no frame {frame} (NAME_{frame:04d}.ply or .obj)")
    return pyvista.read(paths[0])


def bounds(meshes: list[pyvista.PolyData]) -> tuple[np.ndarray, np.ndarray]:
    """Compute the common bounding box of all meshes, so that one camera shows every frame completely."""
    limits = np.array([mesh.bounds for mesh in meshes])
    return limits[:, 0::2].min(axis=0), limits[:, 1::2].max(axis=0)


def draw(mesh: pyvista.PolyData, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Render one frame to a picture of shape (height, width, 3)."""
    plotter = pyvista.Plotter(off_screen=True, window_size=CELL, lighting="light_kit")
    plotter.set_background("white")
    plotter.add_mesh(mesh, color=SKIN, smooth_shading=True, ambient=0.12, specular=0.12, specular_power=20)
    center, size = (low + high) / 2, (high - low).max()
    ground = pyvista.Disc(center=(center[0], -0.01, center[2]), inner=0, outer=0.535 * size, normal=(0, 1, 0), c_res=96)
    plotter.add_mesh(ground, color=GROUND, lighting=False)
    shadow = mesh.copy()
    shadow.points[:, 1] = 0
    plotter.add_mesh(shadow, color=SHADOW, lighting=False)
    away = np.array([0.42, 0.26, 1.0])
    aim = center - [0, 0.05 * size, 0]
    plotter.camera_position = [aim + 4 * size * away, aim, (0, 1, 0)]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 0.58 * size
    plotter.enable_anti_aliasing("ssaa")
    picture: np.ndarray = plotter.screenshot(return_img=True)
    plotter.close()
    return picture


def main() -> None:
    """Read the arguments, render the frames and write the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("picture", type=Path, help="PNG file to write")
    parser.add_argument("rows", nargs="+", metavar="LABEL=DIR", help="label of a run and the directory of its frames")
    parser.add_argument("--frames", type=int, nargs="+", default=[0, 20, 40, 210])
    parser.add_argument("--titles", nargs="+", help="one title per frame; default: the frame number")
    args = parser.parse_args()
    titles = args.titles or [f"frame {frame}" for frame in args.frames]

    rows = [row.rpartition("=")[::2] for row in args.rows]
    meshes = [[load(Path(directory), frame) for frame in args.frames] for _, directory in rows]
    low, high = bounds([mesh for row in meshes for mesh in row])

    shape = (len(rows), len(args.frames))
    size = (2.3 * shape[1], 2.45 * shape[0])
    figure, grid = plt.subplots(*shape, figsize=size, squeeze=False, layout="constrained")
    for (label, _), row, cells in zip(rows, meshes, grid, strict=True):
        rest = row[0].triangulate().volume
        for column, (mesh, cell) in enumerate(zip(row, cells, strict=True)):
            cell.imshow(draw(mesh, low, high), interpolation="none")
            cell.set(xticks=[], yticks=[])
            cell.spines[:].set_visible(False)
            cell.set_xlabel(f"volume {mesh.triangulate().volume / rest:.1%}", fontsize=10)
            if column == 0:
                cell.set_ylabel(label, fontsize=12)
    for cell, title in zip(grid[0], titles, strict=True):
        cell.set_title(title, fontsize=12)
    figure.savefig(args.picture, dpi=130)


if __name__ == "__main__":
    main()
