"""Simulates soft bodies from plain arrays and settings, and writes their point caches. Nothing here needs Blender.

| module | contents |
|---|---|
| `job` | the data of a bake: bodies, colliders, time |
| `motion` | keyframes of objects that move rigidly |
| `groups` | vertex groups of a mesh as parts of its lattice |
| `build` | the simulation of a job |
| `run` | simulates a job to point caches, with progress and cancel |
"""

from .build import build
from .groups import held_vertices, stiffness_factors
from .job import Attachment, BakeError, Body, Collider, Job
from .motion import is_rigid, transformed
from .run import BakeCancelledError, Report, run

__all__ = [
    "Attachment",
    "BakeCancelledError",
    "BakeError",
    "Body",
    "Collider",
    "Job",
    "Report",
    "build",
    "held_vertices",
    "is_rigid",
    "run",
    "stiffness_factors",
    "transformed",
]
