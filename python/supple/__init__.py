"""Soft bodies from any surface mesh: lattice shape matching with volume preservation.

    import supple

    mesh = supple.read_obj("bust.obj")
    body = supple.Body(mesh, lattice_vertices=1000, material="rubber", volume="auto")
    sim = supple.Simulation([body], fps=30, colliders=[supple.Plane((0, -1, 0), (0, 1, 0))])
    for frame in range(120):
        sim.advance()                       # one frame, of as many steps as the material needs
        points = body.surface()             # (k, 3): the displayed surface, vertices in input order

A `Body` is a *lattice* of cubic cells that covers the mesh. Each step fits a rigid motion to the region around every
lattice vertex, moves the vertices towards the goal positions that these motions give, and integrates. The lattice
deforms the mesh, and a volume correction restores the volume of the displayed surface. The correction never feeds back
into the simulation, so evaluating a surface does not change later steps.

Contents:

    Mesh, read_obj                          surface meshes; a mesh argument may also be a path or another mesh
    Lattice                                 from_mesh, or from_cells for a boolean array
    Body                                    positions, velocities, rotations, masses: numpy arrays, one row per vertex;
                                            edit; pin, handle, holds, apply_force, add_force_field; goals, surface,
                                            volume_report;
                                            material, youngs_modulus, damping_ratio; mass, momenta, energies
    RigidBody                               a body that does not deform: Body(..., rigid=True)
    Simulation                              advance(frames), step(n); substeps, time, gravity, colliders, sleep can be
                                            set between steps
                                            save_state, restore_state, reset
                                            contacts lists the contacts of the last step; sim["name"] is a body
    step_all                                steps of many simulations in parallel
    Plane, Sphere, Box, Capsule, MeshCollider    colliders; sim.colliders[i].move_to moves one
    load_scene, run, sweep                  TOML scenes: load as a simulation, run to frames on disk, vary parameters
    film                                    a simulation, or a run on disk, as a moving picture
    save_usd, save_html, save_glb, Recorder    a live simulation as a USD stage, a page for browsers, or an animated GLB
    PointCache                              positions of a mesh in all frames, as a PC2 file
    screenshot                              picture of a simulation, without a display; notebooks show simulations,
                                            bodies and the page of a Recorder
    plot_volume, plot_study, view           plots of volumes and studies, viewer with controls; they need the optional
                                            packages of the extras plot and view
    rotations, reference.goals              rotations of matrices; goal positions by naive sums
    types                                   types of arguments, for annotations
    SuppleError                             base class of MeshError, LatticeError, SceneError (also ValueErrors) and
                                            OutputError (also an OSError)
    ContactWarning                          bodies overlap at the start
    ResumeWarning                           an earlier run cannot be continued, and a new one starts
    SceneWarning                            a handle jumps, or a bridge joins parts far apart
    MaterialWarning                         a body is softer than its material, because the steps are too long

Lengths are in the units of the mesh, times in seconds, masses in kilograms, angles in degrees (spin: rad/s). No axis is
special; only gravity defines a vertical direction. Array arguments may be lists, tuples or arrays of any real dtype,
strided or read-only. State is returned as a new read-only float64 array, and surfaces as a new array or in the array
`out=`. To change positions, assign the whole array, `body.positions = body.positions + offset`, or change entries:

    with body.edit() as state:
        state.velocities[top] = (0, 1, 0)

The GIL is released while Rust code runs, and Ctrl-C interrupts between steps. Results are bit-identical for any number
of threads. Bodies and simulations can be pickled and deep-copied; a copy continues bit-identically.
"""

from . import bodies, edits, errors, notebook, pictures, plots, point_cache, recorder, reference, reports, types, viewer
from ._core import (
    Body,
    ForceField,
    Hold,
    Lattice,
    Mesh,
    Simulation,
    __version__,
    read_obj,
    rotations,
    simd_level,
    step_all,
)
from .bodies import RigidBody
from .colliders import Box, Capsule, Collider, MeshCollider, Plane, Sphere
from .errors import (
    ContactWarning,
    LatticeError,
    MaterialWarning,
    MeshError,
    OutputError,
    ResumeWarning,
    SceneError,
    SceneWarning,
    SuppleError,
)
from .plots import plot_study, plot_volume
from .point_cache import PointCache
from .recorder import Recorder, film, save_glb, save_html, save_usd
from .reports import BodyReport, ComponentReport, Progress, RunReport, Softened, UnkeptVolume, VolumeReport
from .scenes import load_scene, run
from .screenshots import screenshot
from .sweeps import SweepProgress, SweepResult, sweep
from .viewer import view

__all__ = [
    "Body",
    "BodyReport",
    "Box",
    "Capsule",
    "Collider",
    "ComponentReport",
    "ContactWarning",
    "ForceField",
    "Hold",
    "Lattice",
    "LatticeError",
    "MaterialWarning",
    "Mesh",
    "MeshCollider",
    "MeshError",
    "OutputError",
    "Plane",
    "PointCache",
    "Progress",
    "Recorder",
    "ResumeWarning",
    "RigidBody",
    "RunReport",
    "SceneError",
    "SceneWarning",
    "Simulation",
    "Softened",
    "Sphere",
    "SuppleError",
    "SweepProgress",
    "SweepResult",
    "UnkeptVolume",
    "VolumeReport",
    "__version__",
    "bodies",
    "edits",
    "errors",
    "film",
    "load_scene",
    "notebook",
    "pictures",
    "plot_study",
    "plot_volume",
    "plots",
    "point_cache",
    "read_obj",
    "recorder",
    "reference",
    "reports",
    "rotations",
    "run",
    "save_glb",
    "save_html",
    "save_usd",
    "screenshot",
    "simd_level",
    "step_all",
    "sweep",
    "types",
    "view",
    "viewer",
]
