#!/usr/bin/env python3
"""Write the hammock of the example scenes: an open sheet that hangs between two ends along z.

scripts/hammock_mesh.py examples/scenes/hammock.obj
"""

import sys
from pathlib import Path

HALF_WIDTH, HALF_LENGTH = 3.5, 5.0
COLUMNS, ROWS = 14, 20
SAG, TROUGH = 2.5, 0.8
"""Height of the ends and of the sides above the middle."""


def height(x: float, z: float) -> float:
    """Return the height of the sheet: a parabola along z and one along x."""
    return SAG * (z / HALF_LENGTH) ** 2 + TROUGH * (x / HALF_WIDTH) ** 2


def main() -> None:
    """Write the file that the command line names."""
    lines = ["# Hammock: an open sheet, by scripts/hammock_mesh.py", "o hammock"]
    for row in range(ROWS + 1):
        for column in range(COLUMNS + 1):
            x = HALF_WIDTH * (2 * column / COLUMNS - 1)
            z = HALF_LENGTH * (2 * row / ROWS - 1)
            lines.append(f"v {x:.6g} {height(x, z):.6g} {z:.6g}")
    for row in range(ROWS):
        for column in range(COLUMNS):
            a = row * (COLUMNS + 1) + column + 1
            lines.append(f"f {a} {a + COLUMNS + 1} {a + COLUMNS + 2} {a + 1}")
    Path(sys.argv[1]).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
