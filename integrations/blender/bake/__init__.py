"""Simulates soft bodies from plain arrays and settings, and writes their point caches. Nothing here needs Blender.

| module | contents |
|---|---|
| `job` | the data of a bake: bodies, colliders, time |
| `motion` | keyframes of objects that move rigidly, and of numbers |
| `build` | the simulation of a job |
| `run` | simulates a job to point caches, with progress and cancel |
"""

from .build import build
from .job import SURFACE_SETTINGS, Attachment, BakeError, Body, Collider, Inflation, Job, Stiffness
from .motion import is_rigid, transformed
from .run import BakeCancelledError, Report, run

__all__ = [
    "SURFACE_SETTINGS",
    "Attachment",
    "BakeCancelledError",
    "BakeError",
    "Body",
    "Collider",
    "Inflation",
    "Job",
    "Report",
    "Stiffness",
    "build",
    "is_rigid",
    "run",
    "transformed",
]
