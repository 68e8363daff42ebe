"""Stretch a bust by its crown, with and without volume correction.

python examples/python/02_stretch.py
"""

from __future__ import annotations

import numpy as np

import supple

MODEL = "examples/scenes/bust.obj"


def main() -> None:
    """Print a table of volumes and heights."""
    mesh = supple.read_obj(MODEL)
    low, high = mesh.bounds[:, 1]
    height = high - low
    # The two bodies are at the same place, so they must not touch each other.
    corrected = supple.Body(mesh, name="corrected", lattice_vertices=1000, half_width=2, region_damping_rate=6.0)
    plain = supple.Body(mesh, name="plain", lattice_vertices=1000, half_width=2, region_damping_rate=6.0, volume="off")
    for body in (corrected, plain):
        # A plane selects the side that its normal points to.
        body.pin(plane=((0, low + 0.05 * height, 0), (0, -1, 0)))
        body.handle(
            plane=((0, high - 0.1 * height, 0), (0, 1, 0)),
            keys=[(0.0, (0, 0, 0), (0, 0, 0)), (1.0, (0, 0.35 * height, 0), (0, 0, 0))],
        )
    sim = supple.Simulation([corrected, plain], dt=1 / 120, gravity=(0, 0, 0), contact=False)

    print("  time   volume without   volume with   scale of the correction   height")
    for _ in range(6):
        # Evaluating the surface and its volume does not change the simulation.
        report, plain_report = corrected.volume_report(), plain.volume_report()
        relative_height = np.ptp(corrected.surface()[:, 1]) / height
        print(
            f"{sim.time:5.2f}s {plain_report.after / plain_report.rest:16.4f} {report.after / report.rest:13.6f}"
            f" {report.lambda_:25.4f} {relative_height:8.3f}"
        )
        sim.step(24)
    assert abs(report.residual) < 1e-5 < 0.1 < plain_report.after / plain_report.rest - 1


if __name__ == "__main__":
    main()
