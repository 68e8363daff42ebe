"""Writes the positions of a mesh in all frames to one file, which other programs apply to the mesh."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

from numpy.typing import ArrayLike

from . import _core
from ._core import Mesh
from .types import PathLike

__all__ = ["PointCache"]


class PointCache:
    """A Point Cache 2 file (`.pc2`), which grows by a frame with each call of `write`.

        with supple.PointCache("soft.pc2", body.mesh) as cache:
            cache.write(body.surface())         # the state as it is now
            for _ in range(120):
                sim.advance()
                cache.write(body.surface())

    path : str or os.PathLike
        The file to write, which ends in `.pc2`; an existing one is removed at the start. Until the cache is closed,
        also by an exception in the `with` block, the file has `.part` appended to its name.
    mesh : Mesh
        The mesh whose vertices the frames have, in their order.
    first_frame : int, default 0
        Number of the first frame, which the file states, at least 0.

    Unlike runs of scenes, a cache has any positions that the program computes, such as those of an object's own frame.

    Raises ValueError for another extension, and OutputError if the file cannot be written.
    """

    def __init__(self, path: PathLike, mesh: Mesh, *, first_frame: int = 0) -> None:
        """Start the file."""
        self._path = Path(path).absolute()
        self._file = _core.CacheFile(path, mesh, first_frame)

    @property
    def frames(self) -> int:
        """Number of frames so far."""
        return self._file.frames

    def write(self, positions: ArrayLike) -> None:
        """Append a frame.

        positions : (n, 3) float
            Positions of all vertices of the mesh; the file has them as float32.
        """
        self._file.write(positions)

    def close(self) -> None:
        """Complete the file. Closing twice does nothing."""
        self._file.close()

    def __repr__(self) -> str:
        """Return a line with the file and the number of frames."""
        return f"<supple.PointCache of {self._path}: frames: {self.frames}>"

    def __enter__(self) -> PointCache:
        """Return the cache."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the cache; the frames that are written stay."""
        self.close()
