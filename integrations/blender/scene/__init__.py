"""Reads the scene of Blender into the data of a bake, and adds and removes the results.

| module | contents |
|---|---|
| `stack` | the place of the bake among the modifiers of an object |
| `caches` | the folder, the files and the modifiers of bakes |
| `meshes` | evaluated meshes and vertex groups as arrays |
| `settings` | the settings of an object as arguments of supple |
| `tracks` | what is read from one object in every frame |
| `sampler` | reads all frames |
"""

from .caches import apply, clear, is_temporary
from .sampler import Sampler, time_scale

__all__ = ["Sampler", "apply", "clear", "is_temporary", "time_scale"]
