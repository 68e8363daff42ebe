"""Random calls of simulations and scenes, and the table of all operations.

Each operation calls one function or one attribute with random arguments.
"""

from __future__ import annotations

import copy
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import supple

from .objects import (
    Objects,
    apply_force,
    body_attributes,
    edit_body,
    evaluate,
    from_cells,
    from_mesh,
    handle,
    hold,
    lattice_attributes,
    mesh_attributes,
    new_body,
    new_collider,
    new_mesh,
    new_simulation,
    pin,
    read_obj,
    set_body,
    zone,
)
from .scenes import SHIPPED

SCENE = str(SHIPPED / "twist.toml")
SMALL = {"body.bust.lattice_vertices": 100, "simulation.substeps": 1}


def set_simulation(objects: Objects) -> Any:
    """Set an attribute of a simulation."""
    draw = objects.draw
    values = {
        "dt": draw.number(1e-3, 0.03),
        "time": draw.number(0, 1),
        "gravity": draw.vector(10),
        "colliders": draw.or_invalid([new_collider(objects) for _ in range(2)]),
        "threads": 2,
        "unknown": 1,
    }
    name = draw.one_of(list(values))
    setattr(objects.any("simulations"), name, values[name])


def simulation_attributes(objects: Objects) -> Any:
    """Read all attributes of a simulation."""
    simulation = objects.any("simulations")
    numbers = simulation.dt, simulation.time, simulation.gravity, simulation.steps_per_frame, simulation.threads
    return numbers, simulation.bodies, simulation.colliders, simulation.plan(), repr(simulation)


def step(objects: Objects) -> Any:
    """Step a simulation."""
    draw = objects.draw
    simulation = objects.any("simulations")
    count = draw.one_of([1, 2, 3, 5, 20, np.int64(4), 0, -1, 1.5, None, "1", 2**64, np.zeros(3), [1]])
    simulation.step(count)
    return [body.positions for body in simulation.bodies], [body.velocities for body in simulation.bodies]


def copied(objects: Objects) -> Any:
    """Copy an object by pickle or deepcopy."""
    draw = objects.draw
    place = draw.one_of(["meshes", "lattices", "bodies", "simulations"])
    value = objects.any(place)
    twin = copy.deepcopy(value) if draw.chance(0.5) else pickle.loads(pickle.dumps(value))
    return objects.keep(place, twin)


def damaged_pickle(objects: Objects) -> Any:
    """Load a damaged state."""
    draw = objects.draw
    restore, arguments = objects.any(draw.one_of(["meshes", "lattices", "simulations"])).__reduce__()[:2]
    *others, data = arguments
    if isinstance(data, bytes) and data:
        changed = bytearray(data)
        changed[draw.random.integers(len(changed))] ^= 1 << int(draw.random.integers(8))
        data = bytes(changed) if draw.chance(0.7) else data[: draw.random.integers(len(data))]
    return restore(*others, draw.or_invalid(data))


def rotations(objects: Objects) -> Any:
    """Compute rotations of matrices."""
    draw = objects.draw
    matrices = draw.random.normal(size=(int(draw.random.integers(0, 20)), 3, 3)) * 10.0 ** draw.random.integers(-20, 20)
    return supple.rotations(draw.array(matrices))


def reference_goals(objects: Objects) -> Any:
    """Compute goal positions by naive sums."""
    draw = objects.draw
    lattice = objects.any("lattices")
    if len(lattice) > 700:
        return None
    kind = {"regions": draw.or_invalid("breadth_first")} if draw.chance(0.2) else {}
    return supple.reference.goals(lattice, draw.array(lattice.rest_positions * 1.1), draw.whole(1, 4), **kind)


def load_scene(objects: Objects) -> Any:
    """Load a scene."""
    draw = objects.draw
    overrides = {**SMALL, "body.bust.half_width": draw.whole(1, 4), "simulation.gravity": draw.vector(10)}
    simulation = supple.load_scene(draw.or_invalid(SCENE), overrides=draw.or_invalid(overrides))
    if len(simulation.bodies[0]) < 700:
        objects.keep("simulations", simulation)
    return simulation.time


def run(objects: Objects) -> Any:
    """Run a scene to frames."""
    draw = objects.draw
    with tempfile.TemporaryDirectory() as folder:
        stats = {"stats": draw.or_invalid(Path(folder) / "a.csv")} if draw.chance(0.2) else {}
        options = draw.options(
            every=draw.whole(1, 3),
            start_frame=draw.whole(0, 10),
            resume=draw.or_invalid(draw.chance(0.5)),
            threads=draw.whole(1, 3),
            progress=draw.or_invalid(lambda progress: progress.frame < 1),
        )
        kind = draw.one_of(["obj", "ply", "pc2", "pc2", "png", 3])
        # An invalid output would put frames in the working directory, which is the folder of the case.
        return supple.run(SCENE, folder, kind, int(draw.random.integers(0, 3)), overrides=SMALL, **stats, **options)


def sweep(objects: Objects) -> Any:
    """Run a scene with several parameters."""
    draw = objects.draw
    lists = {
        "body.bust.lattice_vertices": [100],
        "body.bust.half_width": draw.or_invalid([1, 2]),
        "simulation.substeps": [draw.or_invalid(1)],
    }
    return supple.sweep(SCENE, draw.or_invalid(lists), draw.or_invalid(None), frames=draw.one_of([0, 1, 2, -1, "1"]))


#: The operations that read or write files, which can raise any error of the file system.
WITH_FILES = {read_obj, from_mesh, new_body, new_simulation, load_scene, run, sweep}

#: All operations, with their weights.
OPERATIONS: list[tuple[Callable[[Objects], Any], int]] = [
    *[(new_mesh, 4), (read_obj, 1), (mesh_attributes, 2), (from_mesh, 4), (from_cells, 4), (lattice_attributes, 2)],
    *[(new_body, 10), (body_attributes, 4), (set_body, 14), (edit_body, 3), (evaluate, 10), (pin, 6), (handle, 6)],
    *[(zone, 4), (apply_force, 6), (hold, 6), (new_collider, 6), (new_simulation, 6), (set_simulation, 6), (step, 14)],
    *[(simulation_attributes, 3), (copied, 4), (damaged_pickle, 4), (rotations, 3), (reference_goals, 2)],
    *[(load_scene, 1), (run, 2), (sweep, 1)],
]
