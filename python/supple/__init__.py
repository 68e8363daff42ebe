"""Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

    import supple

    mesh = supple.read_obj("bust.obj")
    body = supple.Body(mesh, lattice_vertices=1000, half_width=2, volume="auto")
    sim = supple.Simulation([body], dt=1 / 60, colliders=[supple.Plane((0, -1, 0), (0, 1, 0))])
    for frame in range(120):
        sim.step()
        points = body.surface()             # (k, 3): the mesh as it is shown, vertices in input order

A `Body` is a *lattice* of cubic cells that covers the mesh. Each step fits a rigid motion to the region around every
lattice vertex, draws the vertices to the goal positions that these give, and integrates. The mesh is carried along, and
what is shown has its volume corrected; the correction never feeds back, so looking changes nothing that follows.

What there is:

    Mesh, read_obj                          surfaces; wherever a mesh is asked for, a path or a trimesh.Trimesh will do
    Lattice                                 from_mesh, or from_cells for a boolean array
    Body                                    positions, velocities, rotations, masses: numpy arrays, one row per vertex;
                                            pin, handle, apply_force; goals, surface, volume_report
    Simulation                              step(n); dt, time, gravity, colliders can be set between steps
    Plane, Sphere, Box, Capsule             colliders
    load_scene, run, sweep                  scenes (TOML): as a simulation, to frames on disk, in many variations
    plot_volume, plot_study, view           volumes and studies as pictures, a window with sliders; each needs an extra
    rotations, reference.goals              the parts of the method by themselves
    SuppleError                             and under it MeshError, LatticeError, SceneError (ValueErrors too) and
                                            OutputError (an OSError too)

Lengths are in the units of your meshes, times in seconds, masses in kilograms, angles in degrees (spin: rad/s). No axis
is "up" but for gravity. Lists, tuples and arrays of any number type are taken, strided or read-only. Arrays come out as
float64: state as a fresh copy, or written to your `out=`; constant data as read-only views. To change positions set all
of them: `body.positions = body.positions + shift`.

The GIL is released while Rust works, Ctrl-C comes through between steps, and results have the same bits for any number
of threads. Bodies and simulations pickle and deep-copy; a pickled simulation goes on bit for bit.
"""

from . import errors, plots, reference, reports, viewer
from ._core import Body, Hold, Lattice, Mesh, Simulation, __version__, read_obj, rotations, simd_level
from .colliders import Box, Capsule, Collider, Plane, Sphere
from .errors import LatticeError, MeshError, OutputError, SceneError, SuppleError
from .plots import plot_study, plot_volume
from .reports import BodyReport, ComponentReport, Progress, RunReport, VolumeReport
from .scenes import load_scene, run
from .sweeps import SweepResult, sweep
from .viewer import view

__all__ = [
    "Body",
    "BodyReport",
    "Box",
    "Capsule",
    "Collider",
    "ComponentReport",
    "Hold",
    "Lattice",
    "LatticeError",
    "Mesh",
    "MeshError",
    "OutputError",
    "Plane",
    "Progress",
    "RunReport",
    "SceneError",
    "Simulation",
    "Sphere",
    "SuppleError",
    "SweepResult",
    "VolumeReport",
    "__version__",
    "errors",
    "load_scene",
    "plot_study",
    "plot_volume",
    "plots",
    "read_obj",
    "reference",
    "reports",
    "rotations",
    "run",
    "simd_level",
    "sweep",
    "view",
    "viewer",
]
