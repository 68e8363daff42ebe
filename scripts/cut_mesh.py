#!/usr/bin/env python3
"""Cuts a mesh by a plane, and closes the cut by a flat cap.

    scripts/cut_mesh.py INPUT.obj OUTPUT.obj --point 0 5.9 0 --normal 0 1 0

Needs numpy. Keeps the side that the normal points to. The result is closed if the input is closed.

* Vertices that remain keep their order and their text. The new vertices follow them: one for each edge that the plane
  crosses, then those inside the cap. Vertices at equal positions count as one vertex, so seams stay closed.
* A vertex whose distance from the plane is at most 1e-6 of the diagonal of the bounding box counts as in the plane.
* Texture coordinates, normals and further numbers of `v` are interpolated along cut edges; inside the cap, the further
  numbers are the means along its outline. Objects, groups, materials, smoothing groups and `mtllib` stay as they are.
  Elements that no face uses any more are removed, and so are statements other than faces, such as lines and points.
* The cap is in the object of the faces around it, in the group `cap`, in the material `cap` if these faces have a
  material (define it in a library of the file), and in no smoothing group. If they have texture coordinates, those of
  the cap are its shape in the plane, scaled to the unit square.
* A cut may have several outlines and holes. Where the input is open, the cut is left open.
* A plane that cuts nothing off or everything, and an outline that crosses itself, are errors with exit status 1.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from cut_cap import Cap, caps, chain, unmatched
from cut_clip import Clipper, plane_axes
from cut_delaunay import CrossingError
from cut_obj import Corner, Face, Model, ObjError, numbers, read, text, write


class CutError(Exception):
    """A plane that does not cut the mesh, or whose cut cannot be closed."""


def cut(model: Model, point: np.ndarray, normal: np.ndarray, spacing: float = 3.0) -> Model:
    """Returns the part of a model on the side of a plane that its normal points to, closed by a cap.

    spacing    length of the edges inside the cap, as a multiple of the mean edge of its outline

    Raises `CutError` if the plane cuts nothing off or everything, and if outlines of the cut cross.
    """
    length = np.linalg.norm(normal)
    if not (np.isfinite(point).all() and np.isfinite(length) and length > 0):
        raise CutError(f"point {point} and normal {normal} must be finite, and the normal not zero")
    clipper = Clipper(model, point, normal / length)
    signs = [clipper.signs[corner[0]] for face in model.faces for corner in face.corners]
    if not signs:
        raise CutError("the mesh has no faces")
    if min(signs) >= 0 or max(signs) <= 0:
        low, high = clipper.distances.min(), clipper.distances.max()
        raise CutError(f"the plane cuts no face: the vertices are at distances from {low:.6g} to {high:.6g}")
    result = replace(model, vertices=list(model.vertices), textures=list(model.textures), normals=list(model.normals))
    clipper.model = result
    result.faces = [part for face in model.faces for part in clipper.clip(face)]
    close(clipper, model.faces, spacing)
    return compact(result, model, clipper.signs)


def close(clipper: Clipper, uncut: list[Face], spacing: float) -> None:
    """Adds the caps to the model of a clipper, each after the last face of the object that it closes."""
    model = clipper.model
    faces = model.faces
    before = unmatched(map(clipper.polygon, uncut))
    # The edges of the caps are opposite to the open edges in the plane that were not open before.
    edges: Counter[tuple[int, int]] = Counter()
    for (a, b), number in unmatched(map(clipper.polygon, faces)).items():
        if clipper.signs[a] == clipper.signs[b] == 0 and not before[a, b]:
            edges[b, a] = number
    # The caps face away from the kept side.
    axes = plane_axes(-clipper.normal)
    positions = model.positions()
    flat = (positions - clipper.point) @ axes.T
    loops, rest = chain(edges, flat)
    if rest:
        print(f"warning: {len(rest)} edges of the cut stay open, because the mesh is open there", file=sys.stderr)
    try:
        parts = caps(loops, flat, spacing)
    except CrossingError as error:
        place = ", ".join(f"{x:.5g}" for x in positions[error.edge[0]])
        raise CutError(f"the outline of the cut crosses or touches itself near ({place}); move the plane") from error
    owners = {(b, a): face for face in faces for a, b in pairwise((*clipper.polygon(face), clipper.polygon(face)[0]))}
    after: dict[int, list[Face]] = {}
    for part in parts:
        owner = owners[part.loops[0][0], part.loops[0][1]]
        last = max(index for index, face in enumerate(faces) if face.state[0] == owner.state[0])
        after.setdefault(last, []).extend(cap_faces(clipper, part, owner, axes, flat))
    model.faces = [each for index, face in enumerate(faces) for each in (face, *after.get(index, []))]


def cap_faces(clipper: Clipper, part: Cap, owner: Face, axes: np.ndarray, flat: np.ndarray) -> list[Face]:
    """Adds the elements of a cap to the model of a clipper, and returns its faces. `owner` is a face beside it."""
    model = clipper.model
    with_texture, with_normal = (min(corner[kind] for corner in owner.corners) >= 0 for kind in (1, 2))
    names = np.concatenate([np.arange(len(flat)), len(model.vertices) + np.arange(len(part.added))])
    # Further numbers of vertices inside the cap, such as colors, are the means along its outline.
    outline = [numbers(model.vertices[index])[3:] for index in part.loops[0]]
    further = [sum(column) / len(outline) for column in zip(*outline, strict=False)]
    model.vertices += [text([*point, *further]) for point in part.added @ axes + clipper.point]
    used = np.unique(part.triangles)
    textures = dict.fromkeys(used.tolist(), -1)
    if with_texture:
        plane = np.concatenate([flat, part.added])[used]
        plane = (plane - plane.min(axis=0)) / np.ptp(plane, axis=0).max()
        textures = dict(zip(textures, range(len(model.textures), len(model.textures) + len(used)), strict=True))
        model.textures += [text(point) for point in plane]
    normal = -1
    if with_normal:
        # The triangles of a surface that is inside out are clockwise.
        a, b, c = np.concatenate([flat, part.added])[part.triangles[0]]
        front = np.sign((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
        normal = len(model.normals)
        model.normals.append(text(-front * clipper.normal))
    state = (owner.state[0], "cap", owner.state[2] and "cap", owner.state[3] and "off")
    triangles = part.triangles.tolist()
    return [Face(tuple((int(names[i]), textures[i], normal) for i in triangle), state) for triangle in triangles]


def compact(result: Model, original: Model, signs: list[int]) -> Model:
    """Returns a model without elements that no face uses any more, and without unused vertices on the removed side."""
    lists = []
    places = []
    for kind, elements in enumerate((result.vertices, result.textures, result.normals)):
        before = {corner[kind] for face in original.faces for corner in face.corners}
        now = {corner[kind] for face in result.faces for corner in face.corners}
        keep = [i for i in range(len(elements)) if i in now or (i not in before and (kind > 0 or signs[i] >= 0))]
        lists.append([elements[index] for index in keep])
        places.append({index: place for place, index in enumerate(keep)} | {-1: -1})

    def renamed(corner: Corner) -> Corner:
        vertex, texture, normal = (place[index] for place, index in zip(places, corner, strict=True))
        return vertex, texture, normal

    faces = [Face(tuple(map(renamed, face.corners)), face.state) for face in result.faces]
    return replace(result, vertices=lists[0], textures=lists[1], normals=lists[2], faces=faces)


def main() -> int:
    """Reads the arguments, cuts the file and writes the result."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--point", type=float, nargs=3, required=True, metavar=("X", "Y", "Z"), help="in the plane")
    parser.add_argument(
        "--normal", type=float, nargs=3, required=True, metavar=("X", "Y", "Z"), help="points to the side that is kept"
    )
    parser.add_argument(
        "--spacing", type=float, default=3.0, help="edges inside the cap, in mean edges of its outline (default 3)"
    )
    arguments = parser.parse_args()
    try:
        model = read(arguments.input)
        if model.ignored:
            print("warning: not written: " + ", ".join(f"{n} x {k}" for k, n in model.ignored.items()), file=sys.stderr)
        result = cut(model, np.array(arguments.point), np.array(arguments.normal), arguments.spacing)
        options = (f"--{name} {text(getattr(arguments, name))}" for name in ("point", "normal"))
        result.comments.append(f"# Cut by scripts/cut_mesh.py {' '.join(options)}")
        write(result, arguments.output)
    except (CutError, ObjError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(f"{arguments.output}: {len(result.vertices)} vertices, {len(result.faces)} faces")
    return 0


if __name__ == "__main__":
    sys.exit(main())
