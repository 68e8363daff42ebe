"""Closes the outlines that a cut leaves in a plane: `unmatched`, `chain`, `caps`."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from cut_delaunay import GRID, CrossingError, Edge, triangulate

Loop = list[int]


@dataclass(frozen=True)
class Cap:
    """A part of the plane inside an outline and outside its holes.

    `loops` has the outline first. `added` (m, 2) are points inside; `triangles` (k, 3) refer to the points of the
    plane by index, and to the added points by the indices after these.
    """

    loops: list[Loop]
    added: np.ndarray
    triangles: np.ndarray


def unmatched(polygons: Iterable[tuple[int, ...]]) -> Counter[Edge]:
    """Returns the directed edges of polygons that have no opposite edge, and how many of each."""
    edges = Counter((a, b) for polygon in polygons for a, b in pairwise((*polygon, polygon[0])) if a != b)
    return Counter({(a, b): count - edges[b, a] for (a, b), count in edges.items() if count > edges[b, a]})


def chain(edges: Counter[Edge], flat: np.ndarray) -> tuple[list[Loop], list[Edge]]:
    """Joins directed edges between points of the plane (n, 2) into simple loops.

    At a point with several edges a loop turns to the left as far as possible, so that loops stay apart which touch at a
    point. Also returns the edges that belong to no loop, because the surface is open there.
    """
    leaving = defaultdict(list)
    for a, b in sorted(edges.elements()):
        leaving[a].append(b)
    loops, rest = [], []
    # Open chains are walked from their start.
    balance = Counter(a for a, _ in edges.elements())
    balance.subtract(b for _, b in edges.elements())
    for start in sorted(leaving, key=lambda point: (-balance[point], point)):
        while leaving[start]:
            path = [start]
            while choices := leaving[path[-1]]:
                following = min(choices, key=lambda choice: turn(flat[path[-2:]], flat[choice]))
                choices.remove(following)
                if following in path:
                    begin = path.index(following)
                    loops.append(path[begin:])
                    path = path[:begin]
                path.append(following)
            rest += pairwise(path)
    return loops, rest


def turn(path: np.ndarray, choice: np.ndarray) -> float:
    """Returns the angle at the end of a path from the way back, clockwise, to the way to a point."""
    back, along = path[0] - path[-1], choice - path[-1]
    angle = math.atan2(along[0] * back[1] - along[1] * back[0], along @ back)
    return angle if angle > 0 else angle + 2 * math.pi


def caps(loops: list[Loop], flat: np.ndarray, spacing: float) -> list[Cap]:
    """Triangulates the regions inside loops, which are on the left of the loops, between points of the plane (n, 2).

    Each clockwise loop is a hole of the smallest counter-clockwise loop around it. A clockwise loop without such a loop
    is the outline of a surface that is inside out, and its triangles are clockwise.
    `spacing` is the length of interior edges, as a multiple of the mean edge of the loops of a cap.
    Raises `CrossingError` if the loops of a cap cross or touch.
    """
    areas = [signed_area(flat[loop]) for loop in loops]
    outlines = [index for index, area in enumerate(areas) if area > 0]
    groups = {index: [loops[index]] for index in outlines}
    reverse = []
    for index, loop in enumerate(loops):
        if areas[index] <= 0:
            around = [outline for outline in outlines if encloses(flat, loops[outline], loop)]
            if around:
                groups[min(around, key=lambda outline: areas[outline])].append(loop)
            else:
                reverse.append(loop)
    result = [cap(group, flat, spacing) for group in groups.values()]
    for loop in reverse:
        turned = cap([loop[::-1]], flat, spacing)
        result.append(Cap([loop], turned.added, turned.triangles[:, ::-1]))
    return result


def cap(loops: list[Loop], flat: np.ndarray, spacing: float) -> Cap:
    """Triangulates the region inside the first loop and outside the other loops."""
    used = sorted({index for loop in loops for index in loop})
    lengths = [np.linalg.norm(flat[b] - flat[a]) for loop in loops for a, b in pairwise([*loop, loop[0]])]
    if is_line(flat[loops[0]]):
        # The outline encloses nothing.
        fan = [(loops[0][0], a, b) for a, b in pairwise(loops[0][1:])]
        return Cap(loops, np.zeros((0, 2)), np.array(fan, dtype=int).reshape(-1, 3))
    local = {index: place for place, index in enumerate(used)}
    within = [[local[index] for index in loop] for loop in loops]
    try:
        added, triangles = triangulate(flat[used], within, spacing * float(np.mean(lengths)))
    except CrossingError as error:
        a, b = error.edge
        raise CrossingError((used[a], used[b])) from error
    names = np.concatenate([used, len(flat) + np.arange(len(added))]).astype(int)
    return Cap(loops, added, names[triangles])


def is_line(polygon: np.ndarray) -> bool:
    """Returns whether points (n, 2) are on one line, up to the rounding of `triangulate`."""
    offsets = polygon - polygon[0]
    farthest = offsets[np.argmax((offsets**2).sum(axis=1))]
    return bool((np.abs(offsets @ [-farthest[1], farthest[0]]) <= farthest @ farthest / GRID).all())


def signed_area(polygon: np.ndarray) -> float:
    """Returns the area of a polygon (n, 2): positive if it is counter-clockwise."""
    x, y = (polygon - polygon[0]).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def encloses(flat: np.ndarray, outline: Loop, loop: Loop) -> bool:
    """Returns whether an outline is around a loop: whether its first point that is not in the outline is inside."""
    outside = [index for index in loop if index not in outline]
    x, y = flat[outside[0]] if outside else flat[loop].mean(axis=0)
    (ax, ay), (bx, by) = flat[outline].T, np.roll(flat[outline], -1, axis=0).T
    crossing = (ay > y) != (by > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = x < ax + (y - ay) / (by - ay) * (bx - ax)
    return int((crossing & right).sum()) % 2 == 1
