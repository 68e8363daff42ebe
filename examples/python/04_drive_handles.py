"""Drive a handle and a wind force from numpy, frame by frame.

python examples/python/04_drive_handles.py
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import supple

FRAMES, STEPS = 90, 4


def main() -> None:
    """Move the crown along a circle, and print the distance of the tip of the nose from this motion."""
    body = supple.Body("examples/scenes/bust.obj", lattice_vertices=1000, frequency=6.0, region_damping_rate=3.0)
    surface = body.surface()
    low, high = surface[:, 1].min(), surface[:, 1].max()
    nose = int(np.argmax(surface[:, 2]))
    start = surface[nose].copy()
    sim = supple.Simulation([body], dt=1 / 30 / STEPS, substeps=STEPS)
    body.pin(plane=((0, low + 0.1 * (high - low), 0), (0, -1, 0)))
    crown = body.handle(plane=((0, high - 0.15 * (high - low), 0), (0, 1, 0)), keys=[(0,)])
    # The wind acts on the lattice vertices of this mask.
    windward = body.positions[:, 0] < 0

    angles = np.linspace(0, 2 * np.pi, FRAMES + 1)
    path = 0.2 * (high - low) * np.stack([np.sin(angles), np.zeros_like(angles), 1 - np.cos(angles)], axis=1)
    lag = []
    for current, target in pairwise(path):
        # The handle moves from `current` at the current time to `target` at the end of the frame.
        crown.set_keys([(sim.time, current), (sim.time + STEPS * sim.dt, target)])
        for _ in range(STEPS):
            body.apply_force((2.0 * body.masses.sum(), 0, 0), vertices=windward)
            sim.step()
        body.surface(out=surface)
        lag.append(np.linalg.norm(surface[nose] - start - target))
    print(f"{FRAMES} frames; the nose lags behind the crown by up to {max(lag):.3f}, at the end by {lag[-1]:.3f}")


if __name__ == "__main__":
    main()
