#!/usr/bin/env python3
"""Write a bar of the example scenes: a closed mesh that lies on y = 0, with its length along x, centered at x = z = 0.

scripts/bar_mesh.py notch examples/scenes/notch.obj
scripts/bar_mesh.py chocolate examples/scenes/chocolate.obj

The bar `notch` has a notch across its upper side, and `chocolate` grooves between squares.
"""

import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

NOTCH_LENGTH, NOTCH_HEIGHT, NOTCH_DEPTH = 6.0, 1.2, 0.4
SQUARE, THICKNESS, GROOVE, TOP = 0.6, 0.4, 0.2, 0.08
"""Edge of a square of chocolate, thickness, depth of a groove, and distance from its middle at which its bevel ends."""


def notched(x: float, _z: float) -> float:
    """Return the height of the notched bar: a V of equal width and depth."""
    return NOTCH_HEIGHT - max(0.0, NOTCH_DEPTH - 2 * abs(x))


def chocolate(x: float, z: float) -> float:
    """Return the height of the chocolate: bevels about the grooves between squares, and about its edge."""
    nearest = min(abs(a / SQUARE - round(a / SQUARE)) * SQUARE for a in (x, z))
    return THICKNESS - GROOVE * max(0.0, 1 - nearest / TOP)


def ticks(length: float, count: int) -> list[float]:
    """Return places at equal distances, centered."""
    return [length * (k / count - 0.5) for k in range(count + 1)]


def grooves(squares: int) -> list[float]:
    """Return places along squares: their borders, the ends of their bevels, and two inside."""
    places = set()
    for square in range(squares):
        low = SQUARE * (square - squares / 2)
        places |= {low, low + TOP, low + 0.5 * SQUARE, low + SQUARE - TOP, low + SQUARE}
    places = sorted(places)
    return [a for a, b in pairwise(places) if b - a > 1e-9] + places[-1:]


def mesh(x: list[float], rows: int, z: list[float], height: Callable[[float, float], float]) -> str:
    """Return the bar as the text of an OBJ file."""
    sizes = (len(x) - 1, rows, len(z) - 1)
    numbers: dict[tuple[int, ...], int] = {}
    lines, faces = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, sizes[axis]):
            for i in range(sizes[u]):
                for j in range(sizes[v]):
                    corners = []
                    for step in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        place = [0, 0, 0]
                        place[axis], place[u], place[v] = side, i + step[0], j + step[1]
                        if tuple(place) not in numbers:
                            numbers[tuple(place)] = len(numbers) + 1
                            a, c = x[place[0]], z[place[2]]
                            lines.append(f"v {a:.6g} {height(a, c) * place[1] / rows:.6g} {c:.6g}")
                        corners.append(numbers[tuple(place)])
                    faces.append("f {} {} {} {}".format(*(corners if side else corners[::-1])))
    return "\n".join([*lines, *faces]) + "\n"


def main() -> None:
    """Write the bar and the file that the command line names."""
    name, path = sys.argv[1:]
    if name == "notch":
        text = mesh(ticks(NOTCH_LENGTH, 60), 12, ticks(1.2, 12), notched)
    else:
        text = mesh(grooves(8), 4, grooves(4), chocolate)
    Path(path).write_text(f"# Bar: by scripts/bar_mesh.py {name}\no {name}\n{text}", encoding="utf-8")


if __name__ == "__main__":
    main()
