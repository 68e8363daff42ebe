"""Render frames side by side: one row per run, one column per frame, with the same camera. Needs no display.

    supple run examples/scenes/stretch_and_drop.toml -o frames/kept
    supple run examples/scenes/stretch_and_drop.toml -o frames/plain --set 'body.bust.volume="off"' \
        --set body.bust.poisson_ratio=0
    supple run examples/scenes/stretch_and_drop.toml -o frames/regional \
        --set 'body.bust.volume={ scope = "regional" }'
    python examples/python/render_frames.py stretch.png "plain=frames/plain" "global=frames/kept" \
        "regional=frames/regional" --frames 0 24 48 240 --titles rest "half way" "full stretch" landed --ground 0

A row may also be an OBJ file: `before=old.obj after=new.obj` compares two models. With one frame, the runs are columns.
Several bodies of a frame are drawn together. Every triangle has one color, by the angle between its normal and the
light, so that creases are visible; `--smooth` blends the colors, and `--colored` gives the bodies different ones. Needs
the extra `plot`, and for PLY files `trimesh`.
"""

from __future__ import annotations

import argparse
import io
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np

import supple
from supple.pictures import fill, shades

matplotlib.use("Agg")
from matplotlib import colors
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from PIL import Image

SKIN, GROUND, SHADOW = (np.array(colors.to_rgb(name)) for name in ("#e0b090", "#e6e9ed", "#c3c9d0"))
COLORS = np.array([colors.to_rgb(name) for name in ("#e0b090", "#8fb4d9", "#d9908f", "#a3c78d", "#e3c878", "#b9a3d3")])
"""Colors of bodies, repeated."""
CELL = (480, 500)
"""Width and height of one picture in pixels."""
SAMPLES = 2
"""Samples per pixel along each axis."""
VIEW = (0.42, 0.26, 1.0)
"""Default direction from the surface to the camera."""


@dataclass(frozen=True)
class Surface:
    """Points (n, 3) and triangles (m, 3) of a surface; index of the body of each triangle (m,)."""

    points: np.ndarray
    triangles: np.ndarray
    bodies: np.ndarray | None = None

    @property
    def volume(self) -> float:
        """The signed volume inside the surface."""
        return float(np.linalg.det(self.points[self.triangles]).sum() / 6)


def load(source: Path, frame: int) -> Surface:
    """Read a file, or all bodies of one frame from the OBJ or PLY files of a directory."""
    paths = [source]
    if source.is_dir():
        names = source.glob(f"*_{frame:04d}.*")
        paths = sorted(path for path in names if path.suffix in (".ply", ".obj"))
    if not paths:
        raise SystemExit(f"{source} contains no frame {frame} (NAME_{frame:04d}.obj or .ply)")
    points, triangles, bodies, count = [], [], [], 0
    for body, path in enumerate(paths):
        vertices, faces = read(path)
        points.append(vertices)
        triangles.append(faces + count)
        bodies.append(np.full(len(faces), body))
        count += len(vertices)
    return Surface(np.concatenate(points), np.concatenate(triangles), np.concatenate(bodies))


def read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Read the vertices and the triangles of an OBJ or PLY file."""
    if path.suffix == ".obj":
        mesh = supple.read_obj(path)
        return mesh.vertices, mesh.faces
    import trimesh

    loaded = trimesh.load_mesh(path, process=False)
    return np.array(loaded.vertices), np.array(loaded.faces)


def bounds(surfaces: list[Surface]) -> tuple[np.ndarray, np.ndarray]:
    """Compute the common bounding box of all surfaces, so that one camera shows every frame completely."""
    points = np.concatenate([surface.points for surface in surfaces])
    return points.min(axis=0), points.max(axis=0)


def draw(
    surface: Surface,
    low: np.ndarray,
    high: np.ndarray,
    *,
    ground: float | None = None,
    view: tuple[float, ...] = VIEW,
    smooth: bool = False,
    colored: bool = False,
) -> np.ndarray:
    """Render a surface to a picture of shape (height, width, 3) with values from 0 to 1.

    `low` and `high` are the corners of the box that the picture shows. `ground` is the height of a disc with a shadow.
    If `colored`, bodies have different colors.
    """
    toward = np.array(view) / np.linalg.norm(view)
    # In a view from above or below, z is vertical in the picture.
    up = np.array([0, 1, 0]) if abs(toward[1]) < 0.99 else np.array([0, 0, -np.sign(toward[1])])
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    # Columns, rows downwards, and the distance toward the camera.
    axes = np.array([right, np.cross(right, toward), toward])
    # What the picture shows: the corners of the box, and the ground.
    shown = np.array([np.where([k & 1, k & 2, k & 4], high, low) for k in range(8)])
    if ground is not None:
        angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)
        disc = np.column_stack([np.cos(angles), np.zeros(96), np.sin(angles)]) * 0.54 * np.ptp(shown, axis=0).max()
        disc += [(low[0] + high[0]) / 2, ground, (low[2] + high[2]) / 2]
        shown = np.concatenate([shown, disc])
    extent = shown @ axes.T
    first, last = extent.min(axis=0), extent.max(axis=0)
    pixels = SAMPLES * np.array([*CELL, 0])
    scale = 0.96 * (pixels[:2] / (last - first)[:2]).min()

    def project(points: np.ndarray) -> np.ndarray:
        places: np.ndarray = (points @ axes.T - (first + last) / 2) * scale + pixels / 2
        return places

    picture, depth = np.ones((pixels[1], pixels[0], 3)), np.full((pixels[1], pixels[0]), -np.inf)
    if ground is not None:
        fan = np.array([[0, i, i + 1] for i in range(1, 95)])
        fill(picture, depth, project(disc)[fan], GROUND, np.ones((len(fan), 3)))
        flat = surface.points * [1, 0, 1] + [0, ground, 0]
        # The shadow is in front of the disc by a pixel, so that rounding does not hide it.
        fill(picture, depth, project(flat)[surface.triangles] + [0, 0, 1], SHADOW, np.ones((len(surface.triangles), 3)))
    bodies = surface.bodies if colored else None
    color = SKIN if bodies is None else COLORS[bodies % len(COLORS)]
    fill(
        picture,
        depth,
        project(surface.points)[surface.triangles],
        color,
        shades(surface.points, surface.triangles, axes, smooth),
    )
    averaged: np.ndarray = picture.reshape(CELL[1], SAMPLES, CELL[0], SAMPLES, 3).mean(axis=(1, 3))
    return averaged


def save(figure: Figure, path: Path) -> None:
    """Write a figure to a PNG file of 128 colors, which takes a quarter of the space of one with all colors."""
    data = io.BytesIO()
    figure.savefig(data, dpi=130)
    Image.open(data).convert("RGB").quantize(128).save(path, optimize=True)


def main() -> None:
    """Read the arguments, render the frames and write the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("picture", type=Path, help="PNG file to write")
    parser.add_argument("rows", nargs="+", metavar="LABEL=PATH", help="label of a run, and its directory or a file")
    parser.add_argument("--frames", type=int, nargs="+", default=[0], help="numbers of the frames (default 0)")
    parser.add_argument("--titles", nargs="+", help="one title per frame; default: the frame number")
    parser.add_argument("--ground", type=float, metavar="Y", help="draw a ground at this height")
    parser.add_argument("--view", type=float, nargs=3, default=VIEW, metavar=("X", "Y", "Z"), help="way to the camera")
    parser.add_argument("--smooth", action="store_true", help="blend the colors of triangles")
    parser.add_argument("--colored", action="store_true", help="give the bodies of a frame different colors")
    args = parser.parse_args()
    titles = args.titles or [f"frame {frame}" for frame in args.frames]
    if len(titles) != len(args.frames):
        parser.error(f"--titles has {len(titles)} titles, --frames {len(args.frames)} frames")

    rows = [row.rpartition("=")[::2] for row in args.rows]
    surfaces = [[load(Path(source), frame) for frame in args.frames] for _, source in rows]
    low, high = bounds([surface for row in surfaces for surface in row])
    shape = (len(rows), len(args.frames))
    if shape[1] == 1:
        shape, titles = (1, len(rows)), [label for label, _ in rows]
    size = (2.3 * shape[1], 2.45 * shape[0])
    figure, grid = plt.subplots(*shape, figsize=size, squeeze=False, layout="constrained")
    for (label, _), row, cells in zip(rows, surfaces, grid.reshape(len(rows), -1), strict=True):
        for column, (surface, cell) in enumerate(zip(row, cells, strict=True)):
            picture = draw(
                surface, low, high, ground=args.ground, view=args.view, smooth=args.smooth, colored=args.colored
            )
            cell.imshow(picture, interpolation="antialiased")
            cell.set(xticks=[], yticks=[])
            cell.spines[:].set_visible(False)
            cell.set_xlabel(f"volume {surface.volume / row[0].volume:.1%}", fontsize=10)
            if column == 0 and len(args.frames) > 1:
                cell.set_ylabel(label, fontsize=12)
    for cell, title in zip(grid[0], titles, strict=True):
        cell.set_title(title, fontsize=12)
    save(figure, args.picture)


if __name__ == "__main__":
    main()
