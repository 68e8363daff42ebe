"""Defines the exceptions and warnings of supple. Other invalid values raise `ValueError`, wrong types `TypeError`."""

__all__ = [
    "ContactWarning",
    "LatticeError",
    "MaterialWarning",
    "MeshError",
    "OutputError",
    "ResumeWarning",
    "SceneError",
    "SceneWarning",
    "SuppleError",
]


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


class ContactWarning(UserWarning):
    """Two bodies overlap at the start by more than a tenth of a cell, and the first steps push them apart.

    The message names the bodies, the depth, and the argument `ignore`, with which they pass through each other.
    """


class ResumeWarning(UserWarning):
    """A run that was to continue an earlier one starts at its first frame. The message has the reason."""


class SceneWarning(UserWarning):
    """A scene is probably a mistake: a handle jumps, or parts of a body far apart are joined by a bridge of cells.

    The message names the body, the numbers and the way out.
    """


class MaterialWarning(UserWarning):
    """A body is softer than its material because the steps are too long, or too soft to carry a weight.

    The message names the value that was asked for, the value in force, and a step length that is short enough. The
    first step warns once for each such body, and again after its material or the step length changed.
    """
