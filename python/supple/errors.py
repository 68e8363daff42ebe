"""Defines the exceptions of supple. Other invalid values raise `ValueError`, and wrong types raise `TypeError`."""

__all__ = ["LatticeError", "MeshError", "OutputError", "SceneError", "SuppleError"]


class SuppleError(Exception):
    """Base class of the exceptions of supple."""


class MeshError(SuppleError, ValueError):
    """Invalid mesh or mesh file. For a file the message begins with `path:line:`."""


class LatticeError(SuppleError, ValueError):
    """A lattice that cannot be built: no cells, an invalid cell size, or too much memory."""


class SceneError(SuppleError, ValueError):
    """Invalid scene file. The message names file, line and key, and how to correct the error."""


class OutputError(SuppleError, OSError):
    """Frames that cannot be written: no space, no permission, or another run in the same directory."""
