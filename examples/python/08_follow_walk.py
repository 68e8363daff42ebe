"""Make a walking character with bones, and let its belly, ears and tail swing. Writes a model, a PC2 file and a scene.

python examples/python/08_follow_walk.py [DIR [FRAMES]]

DIR then has walker.obj, walk.pc2 and walk.toml, as a studio would export them, and in DIR/frames the frames of the run.
`supple run DIR/walk.toml --format html` shows the run in a browser.
"""

from __future__ import annotations

import struct
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import supple

FPS, CYCLE = 30, 36
"""Frames per second, and frames of two steps."""
LATTICE_VERTICES = 2500
Array = NDArray[np.float64]
SCENE = """\
[simulation]
frames = {frames}
fps = {fps}

[[body]]
mesh = "walker.obj"
lattice_vertices = {lattice_vertices}
youngs_modulus = 1.5e5
damping_ratio = 0.1

[[body.handle]]
vertices = {held}
follow = "walk.pc2"
"""


class Bone(NamedTuple):
    """A bone from `a` to `b` in the rest pose, with the radius of the body around it at both ends."""

    parent: str
    a: tuple[float, float, float]
    b: tuple[float, float, float]
    radii: tuple[float, float]
    held: bool = True


def bones() -> dict[str, Bone]:
    """Return the skeleton, which faces x, with y up. Parents come before children."""
    skeleton = {
        "spine": Bone("", (0, 2.3, 0), (0.05, 3.4, 0), (0.6, 0.5)),
        "belly": Bone("spine", (0.3, 2.25, 0), (0.45, 2.3, 0), (0.78, 0.78), held=False),
        "head": Bone("spine", (0.1, 3.9, 0), (0.35, 4.5, 0), (0.25, 0.62)),
        "nose": Bone("head", (0.6, 4.45, 0), (1.1, 4.3, 0), (0.4, 0.28)),
        "tail": Bone("spine", (-0.5, 2.1, 0), (-2.0, 2.7, 0), (0.26, 0.34), held=False),
    }
    for side, name in ((1, "left"), (-1, "right")):
        skeleton |= {
            f"{name} ear": Bone("head", (0.1, 4.9, 0.35 * side), (-0.35, 6.1, 0.6 * side), (0.22, 0.3), held=False),
            f"{name} arm": Bone("spine", (0, 3.2, 0.6 * side), (0, 2.3, 1.05 * side), (0.24, 0.22)),
            f"{name} hand": Bone(f"{name} arm", (0, 2.3, 1.05 * side), (0.3, 1.75, 1.1 * side), (0.22, 0.28)),
            f"{name} thigh": Bone("spine", (0, 2.1, 0.45 * side), (0.08, 1.2, 0.45 * side), (0.42, 0.3)),
            f"{name} shin": Bone(f"{name} thigh", (0.08, 1.2, 0.45 * side), (0, 0.35, 0.45 * side), (0.3, 0.24)),
            f"{name} foot": Bone(f"{name} shin", (0, 0.28, 0.45 * side), (0.55, 0.24, 0.45 * side), (0.28, 0.24)),
        }
    return skeleton


def distances(points: Array, bone: Bone) -> Array:
    """Return the signed distances of points from the surface around a bone."""
    a, way = np.array(bone.a), np.subtract(bone.b, bone.a)
    along = np.clip((points - a) @ way / (way @ way), 0, 1)
    radius = bone.radii[0] + along * (bone.radii[1] - bone.radii[0])
    distance: Array = np.linalg.norm(points - a - along[:, None] * way, axis=1) - radius
    return distance


def nearest(points: Array, skeleton: dict[str, Bone]) -> NDArray[np.int64]:
    """Return the index of the nearest bone of each point."""
    index: NDArray[np.int64] = np.array([distances(points, bone) for bone in skeleton.values()]).argmin(axis=0)
    return index


def field(points: Array, skeleton: dict[str, Bone], blend: float = 0.12) -> Array:
    """Return a smooth union of the distances from all bones: negative inside the body."""
    each = np.array([distances(points, bone) for bone in skeleton.values()])
    union: Array = -blend * np.logaddexp.reduce(-each / blend, axis=0)
    return union


def surface_net(skeleton: dict[str, Bone], spacing: float = 0.14) -> tuple[Array, NDArray[np.int64]]:
    """Return the closed surface of the body: a vertex in each cell of a grid that it crosses, joined by quads."""
    low, high = np.array([-2.6, -0.3, -1.7]), np.array([1.8, 6.7, 1.7])
    shape = np.ceil((high - low) / spacing).astype(int) + 1
    grid = low + spacing * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    inside = (field(grid.reshape(-1, 3), skeleton) < 0).reshape(shape)
    corners = [inside[tuple(slice(k >> a & 1, n - 1 + (k >> a & 1)) for a, n in enumerate(shape))] for k in range(8)]
    crossed = np.any(corners, axis=0) & ~np.all(corners, axis=0)
    index = np.full(crossed.shape, -1)
    index[crossed] = np.arange(crossed.sum())
    vertices = low + spacing * (np.argwhere(crossed) + 0.5)
    for _ in range(4):  # Newton's method moves the vertices to the surface.
        value, steps = field(vertices, skeleton), 1e-4 * np.eye(3)
        slopes = np.stack([(field(vertices + step, skeleton) - value) / 1e-4 for step in steps], axis=1)
        vertices -= (value / (slopes**2).sum(axis=1))[:, None] * slopes
    faces, axes = [], np.eye(3, dtype=int)
    for axis in range(3):  # The four cells around an edge of the grid that leaves or enters the body are a quad.
        change = np.diff(inside.astype(int), axis=axis)
        u, v = axes[axis - 2], axes[axis - 1]
        for sign in (-1, 1):
            edges = np.argwhere(change == sign)
            quads = [index[tuple((edges - offset).T)] for offset in (0 * u, u, u + v, v)]
            faces.append(np.column_stack(quads)[:, ::-sign])
    return vertices, np.concatenate(faces)


def turn(degrees: float) -> Array:
    """Return the rotation about z, the axis across the body."""
    sin, cos = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])


def pose(skeleton: dict[str, Bone], frame: float, strength: float) -> dict[str, tuple[Array, Array]]:
    """Return the rotation and the translation of each bone in a frame of the walk."""
    phase = 2 * np.pi * frame / CYCLE
    angles = {"spine": -4.0, "head": 3 * np.sin(2 * phase)}
    for name, shift in (("left", 0.0), ("right", np.pi)):
        swing = np.sin(phase + shift)
        lifted = max(0.0, np.cos(phase + shift))
        angles |= {f"{name} thigh": 28 * swing, f"{name} shin": -50 * lifted, f"{name} foot": 18 * lifted - 8 * swing}
        angles |= {f"{name} arm": -30 * swing, f"{name} hand": 15 - 10 * swing}
    poses = {"": (np.eye(3), strength * np.array([0.055 * frame, 0.16 * np.cos(2 * phase) - 0.1, 0.0]))}
    for name, bone in skeleton.items():
        rotation, translation = poses[bone.parent]
        turned = rotation @ turn(strength * angles.get(name, 0.0))
        poses[name] = (turned, rotation @ np.array(bone.a) + translation - turned @ np.array(bone.a))
    return poses


def animate(vertices: Array, skeleton: dict[str, Bone], frames: int) -> NDArray[np.float32]:
    """Return the positions of the vertices in all frames, by linear blend skinning. The first one is the rest pose."""
    near = np.array([np.maximum(distances(vertices, bone), 0) for bone in skeleton.values()])
    weights = 1 / (near + 0.08) ** 4
    weights /= weights.sum(axis=0)
    positions = np.zeros((frames + 1, len(vertices), 3), dtype=np.float32)
    for frame in range(frames + 1):
        start = min(frame / 12, 1.0)
        poses = pose(skeleton, frame, start * start * (3 - 2 * start))
        for name, weight in zip(skeleton, weights, strict=True):
            rotation, translation = poses[name]
            positions[frame] += weight[:, None] * (vertices @ rotation.T + translation)
    return positions


def main(output: str = "walk", frames: str = "90") -> None:
    """Write the files, run the scene, and print how far the free parts are from the animation."""
    folder, skeleton = Path(output), bones()
    folder.mkdir(parents=True, exist_ok=True)
    vertices, faces = surface_net(skeleton)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices] + [f"f {' '.join(map(str, f + 1))}" for f in faces]
    (folder / "walker.obj").write_text("\n".join(lines) + "\n")
    positions = animate(vertices, skeleton, int(frames))
    header = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(vertices), 0.0, 1.0, len(positions))
    (folder / "walk.pc2").write_bytes(header + positions.tobytes())

    # The lattice vertices are held, except those of the belly, the ears and the tail.
    points = supple.Body(folder / "walker.obj", lattice_vertices=LATTICE_VERTICES).positions
    is_free = np.array([not bone.held for bone in skeleton.values()])
    held = np.flatnonzero(~is_free[nearest(points, skeleton)])
    scene = SCENE.format(frames=frames, fps=FPS, lattice_vertices=LATTICE_VERTICES, held=held.tolist())
    (folder / "walk.toml").write_text(scene)

    free, distance = is_free[nearest(vertices, skeleton)], np.zeros(len(vertices))

    def measure(progress: supple.Progress) -> None:
        assert progress.simulation is not None
        away = progress.simulation.bodies[0].surface() - positions[progress.frame]
        np.maximum(distance, np.linalg.norm(away, axis=1), out=distance)

    report = supple.run(folder / "walk.toml", folder / "frames", progress=measure)
    print(f"{report.directory}: {report.written} frames in {report.elapsed:.1f} s, {len(held)} lattice vertices held")
    print(f"greatest distance from the animation: {distance[free].max():.2f} of the free parts,")
    print(f"{np.median(distance[~free]):.4f} of half of the other vertices; the character is 6.5 high")
    assert distance[free].max() > 10 * np.median(distance[~free])


if __name__ == "__main__":
    main(*sys.argv[1:])
