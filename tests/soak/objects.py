"""Random calls that build objects of the Python module, and calls of meshes, lattices, bodies and colliders."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np

import supple

from . import meshes
from .arguments import Arguments, OwnError
from .scenes import SHIPPED

#: Largest number of objects of one class that are kept.
KEPT = 6


class Objects:
    """The objects that the calls work on."""

    def __init__(self, draw: Arguments) -> None:
        self.draw = draw
        self.meshes: list[Any] = []
        self.lattices: list[Any] = []
        self.bodies: list[Any] = []
        self.simulations: list[Any] = []
        for build in (new_mesh, from_mesh, new_body, new_simulation):
            while not getattr(self, _PLACES[build]):
                try:
                    build(self)
                except (ValueError, TypeError, OSError, OwnError):
                    continue

    def keep(self, place: str, value: Any) -> Any:
        """Keep an object, in place of a random one if there are enough."""
        kept = getattr(self, place)
        if len(kept) >= KEPT:
            kept.pop(int(self.draw.random.integers(len(kept))))
        kept.append(value)
        return value

    def any(self, place: str) -> Any:
        """Return one of the objects of a class."""
        return self.draw.one_of(getattr(self, place))


def new_mesh(objects: Objects) -> Any:
    """Build a mesh."""
    draw = objects.draw
    vertices, faces = meshes.any_surface(draw.random)
    if draw.chance(0.3):
        faces = [face[:3] for face in faces]
    if draw.chance(0.05):
        faces[0] = [0, 1, len(vertices)]
    return objects.keep("meshes", supple.Mesh(draw.array(vertices), draw.or_invalid(faces)))


def read_obj(objects: Objects) -> Any:
    """Read a model."""
    draw = objects.draw
    path = draw.or_invalid(draw.one_of([SHIPPED / "bust.obj", str(SHIPPED / "bust_parts.obj")]))
    return objects.keep("meshes", supple.read_obj(path, *([draw.or_invalid("eyes")] if draw.chance(0.2) else [])))


def mesh_attributes(objects: Objects) -> Any:
    """Read all attributes of a mesh."""
    mesh = objects.any("meshes")
    return mesh.vertices, mesh.faces, mesh.volume, mesh.is_closed, mesh.bounds, repr(mesh)


def from_mesh(objects: Objects) -> Any:
    """Cover a mesh by a lattice."""
    draw = objects.draw
    size = {"vertices": draw.whole(8, 600)} if draw.chance(0.7) else {"cell_size": draw.number(0.3, 1)}
    more = draw.options(join=draw.or_invalid(draw.chance(0.5)), memory_limit=draw.whole(10**6, 10**9))
    return objects.keep("lattices", supple.Lattice.from_mesh(draw.or_invalid(objects.any("meshes")), **size, **more))


def from_cells(objects: Objects) -> Any:
    """Build a lattice from cells."""
    draw = objects.draw
    cells = draw.random.random(draw.random.integers(1, 7, 3)) < draw.random.uniform(0, 1.2)
    options = draw.options(cell_size=draw.number(0.1, 2), origin=draw.vector(3), join=draw.chance(0.5))
    return objects.keep("lattices", supple.Lattice.from_cells(draw.or_invalid(cells), **options))


def lattice_attributes(objects: Objects) -> Any:
    """Read all attributes of a lattice."""
    lattice = objects.any("lattices")
    arrays = lattice.indices, lattice.rest_positions, lattice.cells, lattice.origin
    return arrays, lattice.cell_size, lattice.component_count, len(lattice), repr(lattice)


def volume_option(draw: Arguments) -> Any:
    """Return a value of the option `volume`."""
    table = draw.options(
        measure=draw.or_invalid(draw.one_of(["mesh", "cells", "lattice"])),
        scope=draw.or_invalid(draw.one_of(["global", "regional"])),
        field=draw.or_invalid(draw.one_of(["paper", "surface", "smooth"])),
        max_correction=draw.number(0.01, 2),
    )
    return draw.or_invalid(draw.one_of(["auto", "off", "mesh", "cells", "lattice", table]))


def new_body(objects: Objects) -> Any:
    """Build a body."""
    draw = objects.draw
    shape = objects.any("meshes") if draw.chance(0.6) or not objects.lattices else objects.any("lattices")
    size = {"lattice_vertices": draw.whole(8, 600)} if not isinstance(shape, supple.Lattice) else {}
    options = draw.options(
        name=draw.or_invalid("body"),
        scale=draw.number(0.5, 2),
        rotate=draw.vector(180),
        translate=draw.vector(5),
        join=draw.chance(0.5),
        half_width=draw.or_invalid(0.5) if draw.chance(0.3) else draw.whole(1, 5),
        poisson_ratio=draw.number(0, 0.47),
        inflate=draw.curve(0.1, 10),
        stiffness_radius=draw.number(0.1, 2),
        stiffness=draw.number(0.01, 1),
        frequency=draw.number(1, 20),
        region_damping=draw.number(0, 1),
        region_damping_rate=draw.number(0, 10),
        density=draw.number(1, 2000),
        volume=volume_option(draw),
        velocity=draw.vector(10),
        spin=draw.vector(10),
    )
    return objects.keep("bodies", supple.Body(draw.or_invalid(shape), **size, **options))


def body_attributes(objects: Objects) -> Any:
    """Read all attributes of a body."""
    body = objects.any("bodies")
    names = [name for name in dir(supple.Body) if not name.startswith("_")]
    values = [getattr(body, name) for name in names]
    return [value for value in values if not callable(value)], len(body), repr(body)


def set_body(objects: Objects) -> Any:
    """Set an attribute of a body."""
    draw, body = objects.draw, objects.any("bodies")
    count = len(body)
    values = {
        "half_width": draw.or_invalid(0.5) if draw.chance(0.3) else draw.whole(1, 6),
        "poisson_ratio": draw.number(0, 0.47),
        "inflate": draw.curve(0.1, 10),
        "stiffness_radius": draw.number(0.1, 2),
        "stiffness": draw.number(0.01, 1),
        "frequency": draw.number(1, 20),
        "region_damping": draw.number(0, 1),
        "region_damping_rate": draw.number(0, 10),
        "volume_options": volume_option(draw),
        "positions": draw.array(body.positions + draw.random.normal(size=(count, 3)) * 0.05),
        "velocities": draw.array(draw.random.normal(size=(count, 3))),
        "masses": 1.0,
        "name": "other",
        "unknown": 1,
    }
    name = draw.one_of(list(values))
    setattr(body, name, values[name])


def edit_body(objects: Objects) -> Any:
    """Change positions or velocities in a block."""
    draw = objects.draw
    with objects.any("bodies").edit() as state:
        state.velocities[:3] = draw.number(-1, 1)
        if draw.chance(0.3):
            state.positions = draw.or_invalid(state.positions + 0.1)


def evaluate(objects: Objects) -> Any:
    """Evaluate the surface or another result of a body."""
    draw, body = objects.draw, objects.any("bodies")
    name = draw.one_of(
        ["goals", "corrected_positions", "surface", "surface_normals", "surface_velocities", "volume_report"]
    )
    if name.startswith("surface") and draw.chance(0.5):
        count = len(body.mesh.vertices) if body.mesh is not None else 5
        return getattr(body, name)(draw.or_invalid(np.empty((count, 3), draw.one_of(["f4", "f8"]))))
    return getattr(body, name)()


def pin(objects: Objects) -> Any:
    """Pin a part of a body."""
    draw, body = objects.draw, objects.any("bodies")
    return body.pin(**draw.selection(len(body)), **draw.window())


def handle(objects: Objects) -> Any:
    """Attach a handle to a body."""
    draw, body = objects.draw, objects.any("bodies")
    return body.handle(keys=draw.keys(), **draw.selection(len(body)), **draw.window())


def zone(objects: Objects) -> Any:
    """Give a part of a body another stiffness or rest volume."""
    draw, body = objects.draw, objects.any("bodies")
    values = draw.options(factor=draw.number(0.01, 100), inflate=draw.curve(0.1, 10))
    return body.zone(**values, **draw.selection(len(body)))


def apply_force(objects: Objects) -> Any:
    """Apply a force to a body."""
    draw, body = objects.draw, objects.any("bodies")
    return body.apply_force(draw.vector(100), **(draw.selection(len(body)) if draw.chance(0.7) else {}))


def hold(objects: Objects) -> Any:
    """Read and change a pin or a handle."""
    draw = objects.draw
    holds = objects.any("bodies").holds
    if not holds:
        return None
    hold = draw.one_of(holds)
    if draw.chance(0.2):
        return hold.release()
    if draw.chance(0.3):
        return hold.set_keys(draw.keys())
    assert hold == pickle.loads(pickle.dumps(hold)) or hold.body is not None
    hash(hold)
    return hold.vertices, hold.keys, hold.active, hold.released, hold.start, hold.end, repr(hold)


def new_collider(objects: Objects) -> Any:
    """Build a collider."""
    draw = objects.draw
    keys = {"keys": draw.keys()} if draw.chance(0.3) else {}
    options = draw.options(friction=draw.number(0, 1), restitution=draw.number(0, 1)) | keys
    shape = draw.random.integers(4)
    if shape == 0:
        return supple.Plane(draw.or_invalid((0, -2, 0)), draw.or_invalid((0, 1, 0)), **options)
    if shape == 1:
        return supple.Sphere(draw.vector(5), draw.number(0.1, 2), **options)
    if shape == 2:
        return supple.Box(draw.vector(5), draw.array(draw.random.uniform(0.1, 2, 3)), draw.vector(90), **options)
    return supple.Capsule(draw.vector(5), draw.vector(5), draw.number(0.1, 2), **options)


def new_simulation(objects: Objects) -> Any:
    """Build a simulation of bodies that have none."""
    draw = objects.draw
    free = [body for body in objects.bodies if body.simulation is None or draw.chance(0.03)]
    if not free:
        free = [new_body(objects)]
    options = draw.options(
        dt=draw.number(1e-3, 0.03),
        gravity=draw.vector(10),
        colliders=draw.or_invalid([new_collider(objects)]),
        threads=draw.one_of([0, 1, 2, 3, -1, 1.5, 2**40, "2"]),
        substeps=draw.whole(1, 5),
    )
    return objects.keep("simulations", supple.Simulation(draw.or_invalid(free[:3]), **options))


#: Places of the objects that the first operations build.
_PLACES: dict[Callable[[Objects], Any], str] = {
    new_mesh: "meshes",
    from_mesh: "lattices",
    new_body: "bodies",
    new_simulation: "simulations",
}
