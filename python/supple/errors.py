"""What can go wrong. Wrong values also raise plain `ValueError`, wrong types `TypeError`."""

__all__ = ["LatticeError", "MeshError", "OutputError", "SceneError", "SuppleError"]


class SuppleError(Exception):
    """Any error of supple's own."""


class MeshError(SuppleError, ValueError):
    """A mesh, or its file, that cannot be used. For a file the message begins with `path:line:`."""


class LatticeError(SuppleError, ValueError):
    """A lattice that cannot be built: nothing to build, an impossible cell size, too much memory."""


class SceneError(SuppleError, ValueError):
    """A scene that says what no scene can say. The message names file, line and key, and the way out."""


class OutputError(SuppleError, OSError):
    """Frames that cannot be written: no space, no permission, another run in the folder."""
