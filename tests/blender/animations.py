"""Imports animated GLB files into Blender, and compares every frame with the OBJ frames of the same run.

    python animations.py ERROR RUN [RUN ...]    folders of runs with --format obj,glb; ERROR is output.glb_error

Needs the package bpy. Exits with an error at the first difference.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import bpy
import numpy as np
from stages import evaluated, read_obj, render


def check(run: Path, error: float) -> None:
    """Compare the file of a run with its frames, and render its last frame."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    frames = sorted({int(path.stem.rpartition("_")[2]) for path in run.glob("*.obj")})
    names = sorted({path.stem.rpartition("_")[0] for path in run.glob("*.obj")})
    scene = bpy.context.scene
    scene.render.fps = 30  # that of the runs: frame k is at k / fps
    bpy.ops.import_scene.gltf(filepath=str(run / "supple.glb"), import_pack_images=True)
    meshes = {found.name: found for found in bpy.data.objects if found.type == "MESH"}
    assert set(names) <= set(meshes), f"{sorted(meshes)} are not {names}"
    group = bpy.data.objects.get("supple colliders")
    for collider in group.children if group else ():
        assert collider.name not in names, "colliders are no bodies"
        collider.hide_render = True
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    indices: dict[str, np.ndarray] = {}
    largest = 0.0
    for number, frame in enumerate(frames):
        scene.frame_set(number)
        for name in names:
            positions, _ = read_obj(run / f"{name}_{frame:04}.obj")
            # Blender's axes.
            expected = np.stack([positions[:, 0], -positions[:, 2], positions[:, 1]], axis=1).astype(np.float64)
            found = meshes[name]
            mesh = evaluated(found)
            points = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", points)
            matrix = np.array(found.matrix_world, np.float64)
            world = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
            if number == 0:
                indices[name] = nearest(world, expected)
                assert len(set(indices[name])) == len(expected), f"{name}: vertices are missing"
                size = np.ptp(expected, axis=0).max()
            distance = np.linalg.norm(world - expected[indices[name]], axis=1).max() / size
            largest = max(largest, distance)
            # Blender adds the targets in 32 bits, and the time of a frame is rounded to 32 bits.
            assert distance <= 1.02 * error + 1e-5, f"{name} in frame {frame}: {distance} of its size"
            low, high = np.minimum(low, world.min(axis=0)), np.maximum(high, world.max(axis=0))
    for name in names:
        check_surface(run, name, meshes[name], indices[name])
    render(run / "blender_glb.png", (low + high) / 2, float(np.linalg.norm(high - low)))
    print(f"{run.name}: {len(frames)} frames of {len(names)} bodies, {largest:.1e} of their size from the OBJ frames")


def nearest(points: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """Return the index of the nearest expected point of each point."""
    found = np.empty(len(points), int)
    for start in range(0, len(points), 256):
        distances = np.linalg.norm(points[start : start + 256, None] - expected[None], axis=2)
        found[start : start + 256] = distances.argmin(axis=1)
    return found


def check_surface(run: Path, name: str, found: bpy.types.Object, indices: np.ndarray) -> None:
    """Compare faces, materials, images and texture coordinates with those of the OBJ file."""
    path = next(run.glob(f"{name}_*.obj"))
    lines = [line.split() for line in path.read_text().splitlines()]
    coordinates = np.array([line[1:3] for line in lines if line[:1] == ["vt"]], np.float64).reshape(-1, 2)
    layer = found.data.uv_layers[0].data if len(coordinates) else None
    # The material, and the vertices with their texture coordinates, of each triangle that can be a part of a face.
    expected, count, material = set(), 0, None
    pairs: dict[int, set[tuple[float, ...]]] = {}
    for line in lines:
        if line[:1] == ["usemtl"]:
            material = " ".join(line[1:])
        elif line[:1] == ["f"]:
            parts = [corner.split("/") for corner in line[1:]]
            corners = [(int(part[0]) - 1, tuple(coordinates[int(part[1]) - 1]) if layer else ()) for part in parts]
            for vertex, pair in corners:
                pairs.setdefault(vertex, set()).add(pair)
            expected |= {(material, frozenset(triangle)) for triangle in combinations(corners, 3)}
            count += len(corners) - 2
    names = [slot.material.name for slot in found.material_slots]
    shown: set[tuple[str | None, frozenset[object]]] = set()
    for polygon in found.data.polygons:
        corners = frozenset(
            known(pairs, int(indices[found.data.loops[corner].vertex_index]), layer[corner].uv if layer else ())
            for corner in polygon.loop_indices
        )
        shown.add((names[polygon.material_index] if material else None, corners))
    assert len(shown) == len(found.data.polygons) == count, f"{name}: {len(shown)} triangles of {count}"
    assert shown <= expected, f"{name}: {len(shown - expected)} triangles, materials or texture coordinates differ"
    for slot in found.material_slots:
        image = image_of(path, lines, slot.material.name)
        if image is None:
            continue
        nodes = [node for node in slot.material.node_tree.nodes if node.type == "TEX_IMAGE"]
        assert [bytes(node.image.packed_file.data) for node in nodes] == [image], f"image of {slot.material.name}"


def known(
    pairs: dict[int, set[tuple[float, ...]]], vertex: int, pair: Sequence[float]
) -> tuple[int, tuple[float, ...]]:
    """Return a vertex with those of its texture coordinates that a pair is but for rounding to 32 bits."""
    for found in pairs[vertex]:
        # glTF has v from the other end of the image.
        if all(abs(a - b) <= 2e-7 * max(1, abs(a)) for a, b in zip(found, pair, strict=True)):
            return vertex, found
    raise AssertionError(f"vertex {vertex} has the texture coordinates {tuple(pair)}, not {pairs[vertex]}")


def image_of(path: Path, lines: list[list[str]], material: str) -> bytes | None:
    """Return the bytes of the image of a material of an OBJ file."""
    for library in [line[1] for line in lines if line[:1] == ["mtllib"]]:
        current = None
        for words in map(str.split, (path.parent / library).read_text().splitlines()):
            if words[:1] == ["newmtl"]:
                current = words[1]
            elif words[:1] == ["map_Kd"] and current == material:
                return (path.parent / library).parent.joinpath(words[1]).read_bytes()
    return None


if __name__ == "__main__":
    for argument in sys.argv[2:]:
        check(Path(argument).resolve(), float(sys.argv[1]))
