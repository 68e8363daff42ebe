"""Checks that an installed supple works without optional dependencies, and with the extra `plot`.

python tests/python/smoke.py            needs an environment without optional dependencies
python tests/python/smoke.py --plot     needs the extra `plot`
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import supple

CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)
QUADS = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def main() -> None:
    """Drops a cube, runs a model in Python and on the command line, and calls functions with optional dependencies."""
    body = supple.Body(supple.Mesh(CORNERS, QUADS), lattice_vertices=200, translate=(0, 0.2, 0))
    sim = supple.Simulation([body], dt=1 / 120, colliders=[supple.Plane((0, 0, 0), (0, 1, 0))])
    sim.step(120)
    assert -0.01 < body.surface()[:, 1].min() < 0.05  # a regression bound: at rest on the plane
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
        frames = {f"cube_{frame:04}.obj" for frame in range(3)}
        assert frames <= set(os.listdir(report.directory))
        program = Path(sysconfig.get_path("scripts"), "supple")
        subprocess.run([program, "run", "cube.obj", "-o", "typed", "--frames", "2", "--quiet"], cwd=folder, check=True)
        for frame in frames:
            assert Path(folder, "typed", frame).read_bytes() == Path(folder, "out", frame).read_bytes()

    for package, call in [
        ("trimesh", body.to_trimesh),
        ("matplotlib", lambda: supple.plot_volume(body.volume_report())),
        ("polyscope", body.show),
    ]:
        assert f"pip install {package}" in refusal(call)
    folder, python = Path(supple.__file__).parent, sys.version.split()[0]
    print(f"supple {supple.__version__} from {folder} works in Python {python} ({supple.simd_level()})")


def plot() -> None:
    """Plots the volume of a cube to a file."""
    import matplotlib

    matplotlib.use("Agg")
    report = supple.Body(supple.Mesh(CORNERS, QUADS), lattice_vertices=100).volume_report()
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder, "volume.png")
        supple.plot_volume(report).figure.savefig(picture)
        assert picture.read_bytes().startswith(b"\x89PNG")
    print(f"plots work with numpy {np.__version__} and matplotlib {matplotlib.__version__}")


def refusal(call: Callable[[], object]) -> str:
    """Returns the message of the ModuleNotFoundError that a call raises."""
    try:
        call()
    except ModuleNotFoundError as missing:
        return str(missing)
    return "no error"


if __name__ == "__main__":
    if sys.argv[1:] == ["--plot"]:
        plot()
    else:
        main()
