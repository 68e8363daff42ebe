"""A bake in progress: reads the scene in portions, then simulates in a thread that never touches Blender's data."""

from __future__ import annotations

import threading
import time
from enum import Enum

import bpy
from bpy.types import Context

from . import scene
from .bake import BakeCancelledError, BakeError, Job, Report, run


class Phase(Enum):
    """What a session does."""

    READING = "Reading"
    SIMULATING = "Simulating"
    DONE = "Done"


class Session:
    """A bake of all soft bodies of a scene.

    The thread of the interface calls `work` until `phase` is DONE, then `finish`, which adds the results.
    """

    #: The bake that is in progress, which panels show and the operator Cancel ends.
    current: Session | None = None

    def __init__(self, context: Context) -> None:
        """Check the scene and start to read it. Raises BakeError."""
        self._sampler = scene.Sampler(context)
        self._time_scale = scene.time_scale(context.scene)
        self._first_frame = context.scene.frame_start
        #: Whether the caches are lost when Blender ends.
        self.is_temporary = scene.is_temporary(context.scene)
        self._stop = threading.Event()
        self._simulated = 0
        self._thread: threading.Thread | None = None
        self._report: Report | None = None
        self._error: Exception | None = None
        self.phase = Phase.READING
        self._sampler.open()
        Session.current = self

    @property
    def is_reading(self) -> bool:
        """Whether the scene is being read, and must not change."""
        return self.phase is Phase.READING

    @property
    def is_done(self) -> bool:
        """Whether `finish` may be called."""
        return self.phase is Phase.DONE

    @property
    def progress(self) -> float:
        """Share of the frames of the present phase that are complete, from 0 to 1."""
        return self._done / self._sampler.frames

    @property
    def text(self) -> str:
        """The phase and its frames, for the user."""
        return f"{self.phase.value} frame {self._done} of {self._sampler.frames}"

    @property
    def _done(self) -> int:
        """Number of frames of the present phase that are complete."""
        return self._sampler.read_frames if self.phase is Phase.READING else self._simulated

    def cancel(self) -> None:
        """End the bake soon: after the frame that is being read or simulated."""
        self._stop.set()

    def work(self, seconds: float) -> None:
        """Go on for about a time in seconds, by at least a frame while reading. Return earlier if it is done."""
        until = time.monotonic() + seconds
        try:
            while self.phase is Phase.READING:
                self._read()
                if time.monotonic() >= until:
                    break
        except BaseException as error:
            self._end(error)
            if not isinstance(error, Exception):
                raise
        if self._thread is not None:
            self._thread.join(max(0.0, until - time.monotonic()))
            if not self._thread.is_alive():
                self.phase = Phase.DONE

    def finish(self) -> Report:
        """Play the caches on the objects, when the session is done. Raises BakeError and BakeCancelledError."""
        self.close()
        if self._error is not None:
            raise self._error
        assert self._report is not None, "a session without an error has a report"
        missing = []
        for body in self._job.bodies:
            found = bpy.data.objects.get(body.name)
            if found is None:
                missing.append(f'"{body.name}"')
            else:
                scene.apply(found, body.path, self._first_frame, self._time_scale)
        if missing:
            raise BakeError(f"removed or renamed during the bake: object {', '.join(missing)}; bake again")
        return self._report

    def close(self) -> None:
        """End the session, wherever it is: stop the thread and restore the scene."""
        self.cancel()
        if self._thread is not None:
            self._thread.join()
        self._sampler.close()
        if Session.current is self:
            Session.current = None

    def _read(self) -> None:
        """Read a frame; after the last one start the simulation."""
        if self._stop.is_set():
            raise BakeCancelledError
        self._sampler.read()
        if self._sampler.read_frames == self._sampler.frames:
            self._job = self._sampler.job()
            self._sampler.close()
            self.phase = Phase.SIMULATING
            self._thread = threading.Thread(target=self._simulate, args=(self._job,), daemon=True)
            self._thread.start()

    def _simulate(self, job: Job) -> None:
        """Simulate a job. Runs in the thread."""
        try:
            self._report = run(job, self._count, self._stop.is_set)
        except Exception as error:
            self._error = error

    def _count(self, frames: int) -> None:
        """Remember how many frames are complete."""
        self._simulated = frames

    def _end(self, error: BaseException) -> None:
        """End the session with an error."""
        if isinstance(error, Exception):
            self._error = error
        self.phase = Phase.DONE
        self._sampler.close()
