"""Drop a model on the ground and save the surfaces as a numpy array.

python examples/python/01_drop.py [MODEL.obj [SURFACES.npy [FRAMES]]]
"""

from __future__ import annotations

import sys

import numpy as np

import supple


def main(model: str = "examples/scenes/bust.obj", output: str = "surfaces.npy", frames: str = "90") -> None:
    """Write the surfaces of all frames as one array of shape (frames + 1, vertices, 3)."""
    mesh = supple.read_obj(model)
    low, high = mesh.bounds
    body = supple.Body(mesh, lattice_vertices=1000, spin=(0, 0, 1))
    ground = supple.Plane((0, low[1] - 0.2 * (high[1] - low[1]), 0), (0, 1, 0))
    sim = supple.Simulation([body], fps=30, colliders=[ground])

    surfaces = np.empty((int(frames) + 1, len(mesh.vertices), 3), dtype=np.float32)
    for frame, surface in enumerate(surfaces):
        if frame > 0:
            sim.advance()
        body.surface(out=surface)
    np.save(output, surfaces)
    print(f"{output}: {surfaces.shape}, lowest point at the end {surfaces[-1, :, 1].min():.3f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
