"""A bust is pulled by its crown: handles, and what the volume correction does.

python examples/python/02_stretch.py
"""

from __future__ import annotations

import supple


def main() -> None:
    """Prints a table of volumes."""
    mesh = supple.read_obj("examples/scenes/bust.obj")
    low, high = mesh.bounds[:, 1]
    height = high - low
    body = supple.Body(mesh, lattice_vertices=1000, half_width=2, damping_rate=6.0)
    # A plane takes what lies on the side that its normal points to.
    body.pin(plane=((0, low + 0.05 * height, 0), (0, -1, 0)))
    body.handle(
        plane=((0, high - 0.1 * height, 0), (0, 1, 0)),
        keys=[(0.0, (0, 0, 0), (0, 0, 0)), (1.0, (0, 0.35 * height, 0), (0, 0, 0))],
    )
    sim = supple.Simulation([body], dt=1 / 120, gravity=(0, 0, 0))

    print("  time   volume by shape matching   as shown       lambda")
    for _ in range(6):
        # Looking changes nothing that follows.
        report = body.volume_report()
        before, after = report.before / report.rest, report.after / report.rest
        print(f"{sim.time:5.2f}s {before:26.4f} {after:10.6f} {report.lambda_:12.4f}")
        sim.step(24)


if __name__ == "__main__":
    main()
