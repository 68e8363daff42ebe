"""Simulates a job and writes its point caches."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

import supple

from .build import build
from .job import BakeError, Body, Job
from .motion import transformed


class BakeCancelledError(Exception):
    """The bake was cancelled. No cache has changed."""


@dataclass
class Report:
    """What a bake did."""

    #: Warnings for the user.
    warnings: list[str]
    #: Number of steps per frame.
    steps_per_frame: int
    #: Run time in seconds.
    seconds: float


def run(
    job: Job,
    progress: Callable[[int], object] = lambda frames: None,
    is_cancelled: Callable[[], bool] = lambda: False,
) -> Report:
    """Simulate a job, and write the point caches of its bodies.

    progress : callable
        Is called with the number of complete frames after each one.
    is_cancelled : callable
        Is called before each frame; if it returns True, the bake ends with BakeCancelledError.

    The caches replace existing files when all frames of all bodies are written. If the bake ends before, existing files
    are unchanged, and no others are left.

    Raises BakeError for a job that cannot be simulated or files that cannot be written, and BakeCancelledError.
    """
    began = time.monotonic()
    notes: list[str] = []
    inverses = [_inverses(body) for body in job.bodies]
    with _collected_warnings(notes):
        sim = build(job)
    with ExitStack() as stack:
        writing = zip(job.bodies, sim.bodies, strict=True)
        caches = [stack.enter_context(_Cache(data, body.mesh, job.first_frame)) for data, body in writing]
        for frame in range(job.frames):
            if is_cancelled():
                raise BakeCancelledError
            if frame > 0:
                # Warnings of materials come with the first step.
                with _collected_warnings(notes if frame == 1 else None):
                    sim.advance()
            for cache, surface, inverse in zip(caches, sim.surfaces(), inverses, strict=True):
                cache.write(transformed(inverse[frame], surface))
            progress(frame + 1)
        for cache in caches:
            cache.complete()
        for cache in caches:
            cache.publish()
    return Report(notes, sim.steps_per_frame, time.monotonic() - began)


class _Cache:
    """A point cache under a temporary name, which is removed at the end of the `with` block unless it was published."""

    def __init__(self, data: Body, mesh: supple.Mesh | None, first_frame: int) -> None:
        """Prepare the cache of a body."""
        assert mesh is not None, "bodies of a bake have meshes"
        self._data, self._mesh, self._first = data, mesh, first_frame
        self._partial = data.path.with_name(f"{data.path.stem}.baking.pc2")

    def __enter__(self) -> _Cache:
        """Create the file, and its directory."""
        with self._reported():
            self._cache = supple.PointCache(self._partial, self._mesh, first_frame=max(self._first, 0))
        return self

    def write(self, positions: NDArray[np.float64]) -> None:
        """Append a frame."""
        with self._reported():
            self._cache.write(positions)

    def complete(self) -> None:
        """Complete the file under its temporary name."""
        with self._reported():
            self._cache.close()

    def publish(self) -> None:
        """Give the file its name."""
        with self._reported():
            os.replace(self._partial, self._data.path)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Remove the temporary file."""
        self.complete()
        self._partial.unlink(missing_ok=True)

    @contextmanager
    def _reported(self) -> Iterator[None]:
        """Convert errors of files and positions."""
        try:
            yield
        except (OSError, ValueError) as error:
            raise BakeError(
                f'the cache of object "{self._data.name}" cannot be written to "{self._data.path.parent}": {error}; '
                "choose another Cache Folder, or free space"
            ) from error


def _inverses(body: Body) -> NDArray[np.float64]:
    """Return the matrices from world space to the object of a body: (f, 4, 4)."""
    finite = np.isfinite(body.matrices).all(axis=(1, 2))
    if not finite.all():
        frame = finite.argmin()
        raise BakeError(f'object "{body.name}" has no place in frame {frame} of the bake; look at its drivers')
    flat = np.flatnonzero(np.linalg.cond(body.matrices[:, :3, :3]) > 1e6)
    if len(flat):
        raise BakeError(
            f'object "{body.name}" has no extent along an axis in frame {flat[0]} of the bake, '
            "because its scale, or that of a parent, is zero; set a scale above 0"
        )
    return np.asarray(np.linalg.inv(body.matrices), np.float64)


@contextmanager
def _collected_warnings(notes: list[str] | None) -> Iterator[None]:
    """Append warnings of supple to a list, and show others as usual. Without a list this does nothing."""
    if notes is None:
        yield
        return
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    for warning in caught:
        if issubclass(warning.category, (supple.ContactWarning, supple.MaterialWarning)):
            notes.append(str(warning.message))
        else:
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
