"""Whether an installed supple works where there is nothing but numpy.

python tests/python/smoke.py
"""

from __future__ import annotations

import os
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import supple

CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)
QUADS = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def main() -> None:
    """Drops a cube, runs a scene, and asks for what is not installed."""
    body = supple.Body(supple.Mesh(CORNERS, QUADS), lattice_vertices=200, translate=(0, 0.2, 0))
    sim = supple.Simulation([body], dt=1 / 120, colliders=[supple.Plane((0, 0, 0), (0, 1, 0))])
    sim.step(120)
    assert -0.01 < body.surface()[:, 1].min() < 0.05
    assert abs(body.volume_report().after - 1) < 1e-5
    twin = pickle.loads(pickle.dumps(sim))
    sim.step(10)
    twin.step(10)
    assert np.array_equal(twin.bodies[0].positions, body.positions)

    with tempfile.TemporaryDirectory() as folder:
        vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
        faces = "".join(f"f {' '.join(str(corner + 1) for corner in quad)}\n" for quad in QUADS)
        Path(folder, "cube.obj").write_text(vertices + faces)
        report = supple.run(Path(folder, "cube.obj"), Path(folder, "out"), frames=2)
        assert report.written == 3
        assert len(os.listdir(report.directory)) >= 3

    for extra, call in [
        ("trimesh", body.to_trimesh),
        ("plot", lambda: supple.plot_volume(body.volume_report())),
        ("view", body.show),
    ]:
        assert f'pip install "supple[{extra}]"' in refusal(call)
    print(f"supple {supple.__version__} from {Path(supple.__file__).parent} works ({supple.simd_level()})")


def refusal(call: Callable[[], object]) -> str:
    """What a call says that needs what is not installed."""
    try:
        call()
    except ModuleNotFoundError as missing:
        return str(missing)
    return "nothing"


if __name__ == "__main__":
    main()
