"""Supple Soft Bodies: a Blender extension.

| module | contents |
|---|---|
| `bake` | simulates plain arrays to point caches; needs no Blender |
| `scene` | reads the scene into these arrays, and adds and removes the results |
| `session` | a bake in progress: reading, the thread of the simulation, results |
| `properties`, `operators`, `panels` | settings, commands and their place in the Physics properties |
"""

from . import operators, panels, properties


def register() -> None:
    """Add the classes of the extension to Blender."""
    properties.register()
    operators.register()
    panels.register()


def unregister() -> None:
    """Remove the classes of the extension, and end a bake that is in progress."""
    operators.unregister()
    panels.unregister()
    properties.unregister()
