"""Simulates soft bodies from plain arrays and settings, and writes their point caches. Nothing here needs Blender.

| module | contents |
|---|---|
| `job` | the data of a bake: bodies, colliders, time |
| `motion` | keyframes of objects that move rigidly, and of numbers |
| `groups` | vertex groups of a mesh as parts of its lattice |
| `build` | the simulation of a job |
| `run` | simulates a job to point caches, with progress and cancel |
"""

from .build import build
from .groups import held_vertices, inflated_zones, stiffness_factors
from .job import Attachment, BakeError, Body, Collider, Inflation, Job
from .motion import is_rigid, transformed
from .run import BakeCancelledError, Report, run

__all__ = [
    "Attachment",
    "BakeCancelledError",
    "BakeError",
    "Body",
    "Collider",
    "Inflation",
    "Job",
    "Report",
    "build",
    "held_vertices",
    "inflated_zones",
    "is_rigid",
    "run",
    "stiffness_factors",
    "transformed",
]
