"""Runs the same tasks in supple and in its peers, and writes tables and a plot.

python benches/peers/run.py [--peers P ...] [--tasks T ...] [--limit SECONDS] [--write docs/measured/peers.md]

Makes a virtual environment in target/peers/venv, installs supple from this repository and the peers from their
packages, and runs each task in each program, one process each, on two processors. A run that takes longer than the
limit is ended, and counts as far as it got. Results: target/peers/runs/PEER__TASK.json, one per run;
target/peers/results.csv; target/peers/peers.svg. `--write FILE` replaces the tables between the markers of that page by
those of all runs that exist, keeps the rows of programs and tasks that have no run, and writes the plot to
../images/, seen from the page. `--keep` runs only what has no result yet. `--no-run` runs nothing.

--quick runs small tasks in supple alone, in this interpreter, without the network, as a smoke test.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import venv
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDER = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "peers"
THREADS = "2"
PACKAGES = ("mujoco", "rapier3d", "pybullet", "pypbd", "newton", "bpy")
PEERS = (
    "supple",
    "rapier-shape",
    "rapier-corotational",
    "rapier-fem",
    "mujoco-trilinear",
    "mujoco-full",
    "pybullet",
    "newton",
    "pbd",
    "blender-softbody",
)
SIZES = (1000, 10_000, 100_000)
TASKS = (*(f"{shape}-{points}" for points in SIZES for shape in ("box", "bust")), "pile", "fold")


def main() -> None:
    """Run what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", nargs="+", default=PEERS, choices=PEERS, metavar="P", help=", ".join(PEERS))
    parser.add_argument("--tasks", nargs="+", default=TASKS, choices=TASKS, metavar="T", help=", ".join(TASKS))
    parser.add_argument("--limit", type=float, default=300.0, help="seconds per run (300)")
    parser.add_argument("--keep", action="store_true", help="run only what has no result yet")
    parser.add_argument("--no-run", action="store_true", help="write tables and the plot from the results that exist")
    parser.add_argument("--write", type=Path, metavar="FILE", help="page whose tables are replaced")
    parser.add_argument("--quick", action="store_true", help="small tasks in supple alone, as a smoke test")
    arguments = parser.parse_args()
    if arguments.quick:
        quick()
        return
    python = FOLDER / "venv/bin/python"
    if not arguments.no_run:
        (FOLDER / "runs").mkdir(parents=True, exist_ok=True)
        install(python, arguments.peers)
        for task in arguments.tasks:
            for peer in arguments.peers:
                result = FOLDER / f"runs/{peer}__{task}.json"
                if not (arguments.keep and result.exists()):
                    run(python, peer, task, result, arguments.limit)
    page = ["--write", str(arguments.write)] if arguments.write else []
    subprocess.run([python, HERE / "report.py", FOLDER, *page], check=True)


def install(python: Path, peers: Sequence[str]) -> None:
    """Make the virtual environment, with supple and all peers that can be installed."""
    if not python.exists():
        venv.create(FOLDER / "venv", clear=True, with_pip=True)
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, f"{ROOT}[plot]"], check=True)
    reasons = FOLDER / "not-installed.txt"
    reasons.unlink(missing_ok=True)
    for package in PACKAGES:
        done = subprocess.run([*pip, package], capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            with reasons.open("a") as file:
                file.write(f"{package}: {last}\n")
            print(f"{package} cannot be installed: {last}")
    shapes = FOLDER / "shapes"
    shapes.mkdir(exist_ok=True)
    for points in SIZES:
        build = "import shapes, sys, pathlib; shapes.save(shapes.bust(int(sys.argv[1])), pathlib.Path(sys.argv[2]))"
        path = shapes / f"bust-{points}.npz"
        subprocess.run([python, "-c", build, str(points), path], cwd=HERE, check=True)
    if "newton" in peers:
        # Newton compiles its kernels at their first use and keeps them; that takes minutes and is no part of a run.
        for task in ("box-1000", "pile"):
            run(python, "newton", task, FOLDER / "compiled.json", 1.0)


def run(python: Path, peer: str, task: str, result: Path, limit: float) -> None:
    """Run one task in one program, and print how it went."""
    result.unlink(missing_ok=True)
    threads = dict.fromkeys(("OMP_NUM_THREADS", "RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS"), THREADS)
    worker = [python, HERE / "worker.py", peer, task, "-o", result]
    command = [*worker, "--shapes", FOLDER / "shapes", "--limit", str(limit)]
    with (FOLDER / "runs" / f"{peer}__{task}.log").open("w") as log:
        try:
            # A call of a program cannot be interrupted from within, so the process is given more time than the run.
            status = subprocess.run(
                command,
                cwd=FOLDER,
                env={**os.environ, **threads},
                stdout=log,
                stderr=log,
                timeout=2 * limit + 300,
                check=False,
            ).returncode
            reason = f"the process ended with status {status}"
        except subprocess.TimeoutExpired:
            reason = f"set-up or a single frame took longer than {limit:.0f} s"
    if not result.exists():
        subprocess.run([*worker, "--failed", reason], check=True)
    print(f"{task:12} {peer:20} done", flush=True)


def quick() -> None:
    """Check the measures on cubes, run small tasks in supple, and check the measurements."""
    import report
    import tasks
    import worker

    import shapes

    check_measures()
    small = [tasks.stretch("box-125", shapes.box(125)), tasks.pile(cells=2, bodies=6), tasks.fold(cells=2)]
    results = [worker.run("supple", task, limit=60.0) for task in small]
    print("\n".join(report.task_table(results)))
    for result in results:
        assert result.frames == 360, result.failed
        assert not result.failed, result.failed
        # The residual of the volume correction; positions are f32.
        assert abs(result.volume_error_rest or 0) < 1e-5, result
    assert abs((results[0].stretch or 0) - 1.5) < 1e-3, results[0]


def check_measures() -> None:
    """Check the measures on cubes whose volume, error and depth are known."""
    import measures
    import numpy as np
    import tasks

    import shapes

    cube = shapes.box(125)
    surface = cube.points[cube.surface]
    turned = 1.1 * surface @ tasks.about("x", 2.0).T + [3, 2, 1]
    radius = np.sqrt(np.mean(np.sum((surface - surface.mean(axis=0)) ** 2, axis=1)))
    # Two cubes that overlap by a tenth of their edge, once as two bodies and once as one that was longer at rest.
    both = np.stack([surface, np.add(surface, [0.9, 0, 0])])
    apart = np.concatenate([surface, np.add(surface, [9, 0, 0])])
    triangles = np.concatenate([cube.triangles, cube.triangles + len(surface)])
    for value, expected in (
        (measures.volume(turned, cube.triangles), 1.1**3),
        (measures.shape_error(turned, surface), 0.1 * radius),
        (measures.plane_depth(surface, (((0, 0, 0.3), (0, 0, 1)),)), 0.3),
        (measures.body_depth(both, cube.triangles), 0.1),
        (measures.self_depth(both.reshape(-1, 3), apart, triangles, 2.0), 0.1),
    ):
        # Rounding in f64.
        assert abs(value - expected) < 1e-9, (value, expected)


if __name__ == "__main__":
    main()
