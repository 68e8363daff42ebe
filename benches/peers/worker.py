"""Runs one task in one program, in this process, and writes the measurements as JSON.

python benches/peers/worker.py PEER TASK -o FILE [--shapes DIR] [--limit SECONDS]
"""

from __future__ import annotations

import argparse
import importlib
import importlib.metadata
import json
import math
import os
import resource
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import measures
import numpy as np
import tasks
from peer import THREADS, UnsupportedError
from tasks import FPS, Task

VARIANT_SEPARATOR = "-"
LIMIT = 300.0


@dataclass
class Measurements:
    """What a run gave, in SI units. A value that was not reached is None."""

    peer: str
    task: str
    package: str = ""
    version: str = ""
    settings: str = ""
    points: int = 0
    bodies: int = 0
    frames: int = 0
    steps_per_frame: int | None = None
    setup_s: float | None = None
    memory_mb: float | None = None
    """Growth of the resident memory over that after the imports, at its peak."""
    ms_median: float | None = None
    ms_90: float | None = None
    volume_error_stretched: float | None = None
    """Volume over rest volume less 1, at full stretch."""
    volume_error_rest: float | None = None
    """The one of greatest magnitude of all bodies, at the end."""
    shape_error_rest: float | None = None
    """Rms distance from the rest shape over the size, of the worst body, at the end."""
    stretch: float | None = None
    """Height over rest height at full stretch: 1.5 if what is held follows its targets."""
    speeds: dict[str, float] = field(default_factory=dict)
    """Rms speed of the surface points at these times."""
    depth_plane_m: float | None = None
    """How deep the deepest point was behind a plane."""
    depth_body_m: float | None = None
    """How deep the deepest point was in another body or another part of its own."""
    failed: str = ""


def main() -> None:
    """Run a task, and write the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("peer")
    parser.add_argument("task")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--shapes", type=Path, default=Path("target/peers/shapes"))
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds after which the run ends")
    parser.add_argument("--failed", metavar="REASON", help="run nothing, and write that it failed")
    arguments = parser.parse_args()
    if arguments.failed:
        result = Measurements(arguments.peer, arguments.task, failed=arguments.failed)
        arguments.output.write_text(json.dumps(asdict(result), indent=1) + "\n")
        return
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:THREADS])
    task = tasks.named(arguments.shapes)[arguments.task]()
    result = run(arguments.peer, task, arguments.limit)
    arguments.output.write_text(json.dumps(asdict(result), indent=1) + "\n")


def run(peer: str, task: Task, limit: float) -> Measurements:
    """Run a task in a program. What fails is part of the result."""
    result = Measurements(peer, task.name, points=len(task.shape.points), bodies=len(task.places))
    module, _, variant = peer.partition(VARIANT_SEPARATOR)
    factory: Any = getattr(importlib.import_module(f"peer_{module}"), variant.capitalize() or "Peer")
    result.package, result.settings = factory.PACKAGE, factory.SETTINGS
    result.version = importlib.metadata.version(factory.PACKAGE)
    before = resident_mb()
    began = time.perf_counter()
    try:
        simulation = factory(task)
    except UnsupportedError as error:
        result.failed = str(error)
        return result
    except Exception as error:
        result.failed = f"set-up: {type(error).__name__}: {error}"
        return result
    result.setup_s = time.perf_counter() - began
    result.steps_per_frame = simulation.steps()
    frames(simulation, task, result, began + limit)
    if result.memory_mb is not None:
        result.memory_mb -= before
    return result


def frames(simulation: Any, task: Task, result: Measurements, deadline: float) -> None:
    """Simulate all frames, or as many as the time allows, and fill in the measurements."""
    shape = task.shape
    rest = np.stack([points[shape.surface] for points in task.bodies()])
    rest_volume = measures.volume(rest[0], shape.triangles)
    extent = np.ptp(rest.reshape(-1, 3), axis=0).max()
    planes, kept, elapsed = [], [], []
    last = now = rest
    for frame in range(task.frames):
        simulation.drive(frame)
        start = time.perf_counter()
        try:
            simulation.advance()
            last, now = now, simulation.surface()
        except Exception as error:
            result.failed = f"frame {frame + 1}: {type(error).__name__}: {error}"
            break
        if frame < task.timed_frames:
            elapsed.append(1e3 * (time.perf_counter() - start))
        result.frames = frame + 1
        if not np.isfinite(now).all():
            result.failed = f"not finite at frame {frame + 1}"
            break
        if np.ptp(now.reshape(-1, 3), axis=0).max() > 20 * extent:
            result.failed = f"20 times its size at frame {frame + 1}"
            break
        if frame + 1 == task.full_stretch:
            result.volume_error_stretched = measures.volume(now[0], shape.triangles) / rest_volume - 1
            result.stretch = float(np.ptp(now[0][:, 2]) / np.ptp(rest[0][:, 2]))
        for moment in task.speeds:
            if frame + 1 == round(moment * FPS):
                result.speeds[f"{moment:g}"] = math.sqrt(np.mean(np.sum((now - last) ** 2, axis=2))) * FPS
        planes.append(measures.plane_depth(now.reshape(-1, 3), task.planes))
        if (frame + 1) % task.depth_every == 0 and (task.self_contact or len(now) > 1):
            kept.append(now)
        if time.perf_counter() > deadline and frame + 1 < task.frames:
            result.failed = f"ended after {frame + 1} of {task.frames} frames by the time limit"
            break
    result.ms_median, result.ms_90 = (float(np.percentile(elapsed, share)) if elapsed else None for share in (50, 90))
    result.depth_plane_m = max(planes, default=None)
    result.memory_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    if task.self_contact:
        depths = [measures.self_depth(then[0], rest[0], shape.triangles, 2.5 * shape.cell_size) for then in kept]
        result.depth_body_m = max(depths, default=None)
    elif len(now) > 1:
        result.depth_body_m = max((measures.body_depth(then, shape.triangles) for then in kept), default=None)
    if result.frames == task.frames and not result.failed:
        errors = [measures.volume(body, shape.triangles) / rest_volume - 1 for body in now]
        result.volume_error_rest = max(errors, key=abs)
        worst = max(measures.shape_error(body, home) for body, home in zip(now, rest, strict=True))
        result.shape_error_rest = worst / shape.size


def resident_mb() -> float:
    """Return the resident memory of this process."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 2**20


if __name__ == "__main__":
    main()
