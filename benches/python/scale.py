"""Measures what docs/measured/scale.md says: many small scenes, many bodies each alone, and what a large body needs.

python benches/python/scale.py [--quick] [--scenes N] [--workers W ...] [--bodies N] [--sides S ...]

The first table runs N scenes of 1,000 lattice vertices: one after another in this process, on processes of
`concurrent.futures`, and on Dask with W local worker processes of one thread each. Columns: seconds in total,
milliseconds per scene, speed relative to the first row, and milliseconds per task that does nothing on the same
workers, submitted in the same way. The workers are started, and have imported supple, before the time counts.

The second table steps N cubes of 1,000 lattice vertices, each alone above a plane: all in one simulation on one
thread and on all, and each in a simulation of its own, on 1, 2, ... processes of one thread. Columns: frames of a body
and steps of a body per second, and memory per body.

The third table steps solid blocks with S lattice vertices along each edge, and half-width 2: seconds to build the
lattice and the body, memory per lattice vertex, nanoseconds of a step per lattice vertex on one thread and on all,
and the size of a saved state.

`--quick` runs few scenes and bodies, and a small block, as a smoke test. Needs the package `distributed`.
"""

from __future__ import annotations

import argparse
import importlib
import multiprocessing
import os
import statistics
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import numpy as np

import supple

SCENE = Path(__file__).parents[2] / "examples/scenes/drop.toml"
FRAMES = 60
BODY_FRAMES = 10
TIMEOUT = 600.0
"""Seconds after which a process that does not answer ends the bench."""


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few scenes and bodies, as a smoke test")
    parser.add_argument("--scenes", type=int, default=1000, metavar="N")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4], metavar="W")
    parser.add_argument("--bodies", type=int, default=4096, metavar="N")
    parser.add_argument("--sides", type=int, nargs="+", default=[46, 100, 160], metavar="S")
    arguments = parser.parse_args()
    if arguments.quick:
        arguments.scenes, arguments.workers, arguments.bodies, arguments.sides = 4, [1], 4, [10]
    batches(arguments.scenes, arguments.workers, 2 if arguments.quick else FRAMES)
    bodies(arguments.bodies, arguments.workers)
    blocks(arguments.sides)


def batches(count: int, workers: list[int], frames: int) -> None:
    """Run the scenes in all ways."""
    parameters = list(scenes(count))
    print(f"{count} scenes of {frames} frames, {os.cpu_count()} processors")
    print("way                              s   ms a scene   speed   ms an empty task")
    start = time.perf_counter()
    expected = supple.sweep(SCENE, parameters, frames=frames)
    alone = time.perf_counter() - start
    print(f"{'one process':25} {alone:8.1f} {1e3 * alone / count:12.2f} {1:7.2f} {'-':>18}", flush=True)
    ways: list[tuple[str, AbstractContextManager[Executor]]] = [
        (f"{max(workers)} workers, futures", ProcessPoolExecutor(max(workers))),
        *((f"{number} workers, Dask", dask_executor(number)) for number in workers),
    ]
    for name, opened in ways:
        with opened as executor:
            warm_up(executor, max(workers))
            start = time.perf_counter()
            results = supple.sweep(SCENE, parameters, executor, frames=frames)
            seconds = time.perf_counter() - start
            empty = seconds_of_empty_tasks(executor, parameters)
        assert [volume(result) for result in results] == [volume(result) for result in expected]
        row = f"{name:25} {seconds:8.1f} {1e3 * seconds / count:12.2f} {alone / seconds:7.2f}"
        print(f"{row} {1e3 * empty / count:18.2f}", flush=True)


def scenes(count: int) -> Iterator[dict[str, Any]]:
    """Iterate over the changes to the scene: each bust starts elsewhere with another spin."""
    random = np.random.default_rng(0)
    for _ in range(count):
        x, y, z = random.uniform(-0.2, 0.2, 3)
        yield {"body.bust.translate": [x, -2.6 + y, z], "body.bust.spin": random.uniform(-2, 2, 3).tolist()}


@contextmanager
def dask_executor(workers: int) -> Iterator[Executor]:
    """Start a local cluster."""
    # The package has no types.
    distributed: Any = importlib.import_module("distributed")
    settings = {"n_workers": workers, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(processes=True, **settings) as cluster, distributed.Client(cluster) as client:
        yield client.get_executor()


def warm_up(executor: Executor, workers: int) -> None:
    """Let all workers import supple."""
    for future in [executor.submit(first_task, number) for number in range(4 * workers)]:
        future.result()


def first_task(number: int) -> None:
    """Read a mesh, and give the other workers the time to take a task as well."""
    supple.read_obj(SCENE.with_name("box.obj"))
    time.sleep(0.2)


def nothing(scene: str, parameters: dict[str, Any], number: int) -> dict[str, Any]:
    """Do nothing. The number makes each task another one, so that Dask does not merge them."""
    return parameters


def seconds_of_empty_tasks(executor: Executor, parameters: list[dict[str, Any]]) -> float:
    """Return the time of tasks that do nothing, with the same arguments."""
    start = time.perf_counter()
    futures = [executor.submit(nothing, str(SCENE), values, number) for number, values in enumerate(parameters)]
    for future in futures:
        future.result()
    return time.perf_counter() - start


def volume(result: supple.SweepResult) -> float:
    """Return the displayed volume at the end."""
    return result.report.bodies[0].volume.after


def bodies(count: int, workers: list[int]) -> None:
    """Step the bodies in all ways, each in new processes, so that none has the memory of another."""
    print(f"\n{count} bodies of 1,000 vertices, {BODY_FRAMES} frames")
    print("way                            frames of a body/s   steps of a body/s   KB a body")
    threads_of = sorted({1, os.cpu_count() or 1})
    ways = [(f"one simulation, {threads} threads", [count], threads) for threads in threads_of]
    for number in workers:
        shares = [count * (index + 1) // number - count * index // number for index in range(number)]
        ways.append((f"own simulations, {number} processes", [share for share in shares if share], 0))
    context = multiprocessing.get_context("spawn")
    for name, shares, threads in ways:
        barrier, results = context.Barrier(len(shares)), context.Queue()
        arguments = [(share, threads, barrier, results) for share in shares]
        processes = [context.Process(target=step_bodies, args=each, daemon=True) for each in arguments]
        for process in processes:
            process.start()
        found = [results.get(timeout=TIMEOUT) for _ in processes]
        for process in processes:
            process.join()
        seconds, steps, memory = max(each[0] for each in found), found[0][1], sum(each[2] for each in found)
        rate = sum(shares) * BODY_FRAMES / seconds
        print(f"{name:30} {rate:18.0f} {rate * steps:19.0f} {memory / sum(shares) / 1e3:11.0f}", flush=True)


def step_bodies(count: int, threads: int, barrier: Barrier, results: Queue[tuple[float, int, int]]) -> None:
    """Step bodies at the same time as other processes do, in one simulation, or with 0 threads each in its own.

    Puts the seconds of the frames, the steps of a frame, and the growth of the resident memory.
    """
    before = resident()
    simulations = [falling(count, threads)] if threads else [falling(1, threads=1) for _ in range(count)]
    for simulation in simulations:
        simulation.advance()
    barrier.wait(timeout=TIMEOUT)
    start = time.perf_counter()
    for _ in range(BODY_FRAMES):
        for simulation in simulations:
            simulation.advance()
    results.put((time.perf_counter() - start, simulations[0].steps_per_frame, resident() - before))


def falling(count: int, threads: int) -> supple.Simulation:
    """Return cubes that fall onto a plane, and do not touch each other."""
    lattice = supple.Lattice.from_cells(np.ones((9, 9, 9), dtype=bool), cell_size=1 / 9, origin=(0, 0.1, 0))
    cubes = [supple.Body(lattice, material="flesh") for _ in range(count)]
    plane = supple.Plane((0, 0, 0), (0, 1, 0))
    return supple.Simulation(
        cubes, fps=60, substeps="auto", colliders=[plane], threads=threads, contact=False, sleep=False
    )


def blocks(sides: list[int]) -> None:
    """Step the blocks."""
    print("\nblock of        vertices   lattice, s   body, s   B/vertex   ns, 1 thread   ns, all   state, B/vertex")
    for side in sides:
        cells = np.ones((side - 1,) * 3, dtype=bool)
        before = resident()
        start = time.perf_counter()
        lattice = supple.Lattice.from_cells(cells)
        lattice_seconds = time.perf_counter() - start
        simulation = spinning(lattice, threads=0)
        body_seconds = time.perf_counter() - start - lattice_seconds
        all_threads = step_time(simulation)
        memory = resident() - before
        state = len(simulation.save_state())
        del simulation
        one_thread = step_time(spinning(lattice, threads=1))
        count = len(lattice)
        print(
            f"{side:8d}^3 {count:15,d} {lattice_seconds:12.2f} {body_seconds:9.2f} {memory / count:10.0f} "
            f"{1e9 * one_thread / count:14.1f} {1e9 * all_threads / count:9.1f} {state / count:17.1f}",
            flush=True,
        )


def spinning(lattice: supple.Lattice, threads: int) -> supple.Simulation:
    """Return the simulation of a block that spins."""
    body = supple.Body(lattice, half_width=2, stiffness=0.5, spin=(0.1, 0.2, 0.3))
    return supple.Simulation([body], gravity=(0, 0, 0), threads=threads)


def step_time(simulation: supple.Simulation) -> float:
    """Return the median time of a step."""
    simulation.step(2)
    times = []
    for _ in range(7):
        start = time.perf_counter()
        simulation.step()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def resident() -> int:
    """Return the resident memory of this process in bytes."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


if __name__ == "__main__":
    main()
