"""Squeeze a trimesh sphere between two plates and measure the result with trimesh.

python examples/python/07_trimesh.py [SQUEEZED.ply]
"""

from __future__ import annotations

import sys

import numpy as np
import trimesh

import supple


def main(output: str = "squeezed.ply") -> None:
    """Squeeze a ball to a height below its diameter, and write the result."""
    ball = trimesh.creation.icosphere(subdivisions=4)
    # Any object with `vertices` and `faces` is accepted as a mesh.
    body = supple.Body(ball, lattice_vertices=1500, half_width=2, region_damping_rate=5.0)
    floor = supple.Plane((0, -1, 0), (0, 1, 0), friction=0.2)
    press = supple.Plane((0, 1, 0), (0, -1, 0), friction=0.2, keys=[(0,), (1, (0, -0.6, 0))])
    sim = supple.Simulation([body], dt=1 / 120, gravity=(0, 0, 0), colliders=[floor, press])
    sim.step(150)

    squeezed = body.to_trimesh()
    width, height, depth = np.ptp(squeezed.vertices, axis=0)
    print(f"{width:.3f} wide, {height:.3f} high, {depth:.3f} deep; at rest {np.ptp(ball.vertices, axis=0)[0]:.3f}")
    print(f"volume {squeezed.volume:.6f}, at rest {ball.volume:.6f}; watertight: {squeezed.is_watertight}")
    assert abs(squeezed.volume / ball.volume - 1) < 1e-5
    squeezed.export(output)
    print(f"{output}: the squeezed ball")


if __name__ == "__main__":
    main(*sys.argv[1:])
