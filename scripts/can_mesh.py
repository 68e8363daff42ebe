#!/usr/bin/env python3
"""Write the can of the example scenes: a closed mesh with a rim and a sunk lid at both ends, standing on y = 0.

scripts/can_mesh.py examples/scenes/can.obj
"""

import math
import sys
from pathlib import Path

SEGMENTS = 48
PROFILE = [(0.0, 0.12), (0.4, 0.12), (0.72, 0.12), (0.76, 0.02), (0.8, 0.0), (0.84, 0.02), (0.86, 0.1)]
"""Radius and height of the lower end, from the axis to the beginning of the wall."""
WALL = [(1.0, 0.35)] + [(1.0, 0.35 + 2.7 * k / 24) for k in range(1, 24)] + [(1.0, 3.05)]
HEIGHT = 3.4


def main() -> None:
    """Write the file that the command line names."""
    upper = [(radius, HEIGHT - height) for radius, height in reversed(PROFILE)]
    rings = [*PROFILE, *WALL, *upper]
    lines = ["# Can: by scripts/can_mesh.py", "o can", f"v 0 {rings[0][1]:.6g} 0"]
    for radius, height in rings[1:-1]:
        for segment in range(SEGMENTS):
            angle = 2 * math.pi * segment / SEGMENTS
            lines.append(f"v {radius * math.cos(angle):.6g} {height:.6g} {radius * math.sin(angle):.6g}")
    lines.append(f"v 0 {rings[-1][1]:.6g} 0")
    count = len(rings) - 2

    def vertex(ring: int, segment: int) -> int:
        return 2 + ring * SEGMENTS + segment % SEGMENTS

    last = 2 + count * SEGMENTS
    lines += [f"f 1 {vertex(0, k)} {vertex(0, k + 1)}" for k in range(SEGMENTS)]
    for ring in range(count - 1):
        for k in range(SEGMENTS):
            corners = vertex(ring, k), vertex(ring + 1, k), vertex(ring + 1, k + 1), vertex(ring, k + 1)
            lines.append("f {} {} {} {}".format(*corners))
    lines += [f"f {last} {vertex(count - 1, k + 1)} {vertex(count - 1, k)}" for k in range(SEGMENTS)]
    Path(sys.argv[1]).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
