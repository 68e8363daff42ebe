"""Runs one scene with different parameters."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import tempfile
import time
from collections.abc import Callable, Generator, Iterable, Mapping
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .reports import Progress, RunReport
from .scenes import run
from .types import PathLike

if TYPE_CHECKING:
    from ._core import Simulation

__all__ = ["SweepProgress", "SweepResult", "sweep"]

#: An interval between written frames that no run exceeds, so that only frame 0 is written.
_FRAME_0_ONLY = 2**32 - 1

#: Name of the file with the parameters and outcomes of all runs, in the output directory.
_MANIFEST = "sweep.json"

#: Least time between two versions of this file, in seconds.
_MANIFEST_INTERVAL = 1.0


@dataclass(frozen=True)
class SweepResult:
    """Result of one run of a sweep."""

    #: Changes to the scene in this run.
    parameters: dict[str, Any]
    _report: RunReport | None = field(repr=False)
    #: Number of the run, from 0: the place of its parameters in the sweep.
    index: int = 0
    #: The exception of a run that failed; None if it succeeded.
    error: Exception | None = None
    #: What the function `measure` returned for this run.
    measured: Any = None
    #: How often the run was started: 1, and more with `retries`.
    attempts: int = 1

    @property
    def report(self) -> RunReport:
        """Report of the run. Raises the exception of a run that failed.

        If the sweep kept no frames, `report.directory` does not exist. The report of a run that an earlier sweep had
        finished has no bodies.
        """
        if self._report is None:
            raise self.error or RuntimeError(f"run {self.index} of the sweep has no report")
        return self._report


@dataclass(frozen=True)
class SweepProgress:
    """Progress of a sweep, the argument of its `progress` callback after each run."""

    #: Number of runs that ended.
    done: int
    #: Number of all runs.
    total: int
    #: Wall-clock time since the start of the sweep, in seconds.
    elapsed: float
    #: Result of the run that ended last.
    result: SweepResult


@dataclass(frozen=True)
class _Job:
    """A run of a sweep, as its executor gets it."""

    scene: str
    index: int
    parameters: dict[str, Any]
    #: Directory of the frames; None if no frames are kept.
    directory: str | None
    frames: int | None
    threads: int
    measure: Callable[[Simulation], Any] | None
    resume: bool
    retries: int
    #: The result of `measure` in an earlier sweep, and the scene and the last frame of this run; None if not known.
    measured: tuple[Any, dict[str, Any]] | None = None


def sweep(
    scene: PathLike,
    parameters: Mapping[str, Any] | Iterable[Mapping[str, Any]],
    executor: Executor | None = None,
    *,
    output: PathLike | None = None,
    frames: int | None = None,
    threads: int = 1,
    measure: Callable[[Simulation], Any] | None = None,
    resume: bool = False,
    progress: Callable[[SweepProgress], object] | None = None,
    retries: int = 0,
) -> list[SweepResult]:
    """Run a scene once for each set of parameters.

    scene : str or os.PathLike
        A scene (.toml) or a model, as for load_scene.
    parameters : dict of lists, or list of dicts
        A dict such as `{"body.bust.half_width": [1, 2, 3]}` gives one run per combination of the values. A list of
        dicts gives one run per dict. The keys are key paths as for `overrides` of load_scene.
    executor : concurrent.futures.Executor, optional
        Executes the runs: threads, processes, `dask.distributed.Client.get_executor()`, ... The executor is not shut
        down. By default the runs are executed in this process, one after another.
    output : str or os.PathLike, optional
        Directory for the frames; run k, counted from 0, writes to `output/k`, and the parameters and outcomes of all
        runs are in `output/sweep.json`. By default no frames are kept.
    frames : int, default the scene's
        Number of frames after frame 0.
    threads : int, default 1
        Number of threads of each run; 0 means one per processor.
    measure : callable, optional
        Called with the Simulation after the last frame of each run; what it returns is `measured` of the result. With
        processes it must be a function of a module, and with `resume` its results must be possible in JSON (of numpy
        arrays, the lists).
    resume : bool, default False
        Whether to continue an earlier sweep in `output`: runs that are finished with the same parameters are kept,
        stopped ones continue, and all others start at their first frame.
    progress : callable, optional
        Called with a SweepProgress after each run, in this process. If it raises an exception, the runs that have not
        started are cancelled, and sweep raises this exception.
    retries : int, default 0
        How often a run is started again if it fails. With `output` it continues after its last checkpoint. A
        ValueError or TypeError, such as of an invalid scene, is not retried.

    Returns one SweepResult per set of parameters, in order. A run that fails does not stop the others: the `error` of
    its result is the exception, and its `report` raises it. Results are bit-identical on all machines.
    """
    if not isinstance(scene, (str, os.PathLike)):
        raise TypeError(f"scene must be a path (str or os.PathLike), not {type(scene).__name__}")
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise TypeError(f"executor must be a concurrent.futures.Executor, not {type(executor).__name__}")
    for name, function in (("measure", measure), ("progress", progress)):
        if function is not None and not callable(function):
            raise TypeError(f"{name} must be callable, not {type(function).__name__}")
    if not isinstance(resume, bool):
        raise TypeError(f"resume must be True or False, not {type(resume).__name__}")
    if isinstance(retries, bool) or not isinstance(retries, int):
        raise TypeError(f"retries must be a whole number, not {type(retries).__name__}")
    if retries < 0:
        raise ValueError(f"retries is {retries}; it must be at least 0")
    if resume and output is None:
        raise ValueError("resume needs output, the directory of the earlier sweep")
    path = os.path.abspath(os.fspath(scene))
    jobs = [
        _Job(path, index, values, _directory(output, index), frames, threads, measure, resume, retries)
        for index, values in enumerate(_combinations(parameters))
    ]
    manifest = None if output is None else _Manifest(Path(output), path, jobs, resume=resume)
    if manifest is not None:
        jobs = [replace(job, measured=manifest.measured(job)) for job in jobs]
    started = time.monotonic()
    results: dict[int, SweepResult] = {}
    try:
        with contextlib.closing(_results(jobs, executor)) as ended:
            for result in ended:
                results[result.index] = result
                if manifest is not None:
                    manifest.add(result)
                if progress is not None:
                    progress(SweepProgress(len(results), len(jobs), time.monotonic() - started, result))
    finally:
        if manifest is not None:
            manifest.write()
    return [results[index] for index in range(len(jobs))]


def _directory(output: PathLike | None, index: int) -> str | None:
    """Return the directory of a run."""
    return None if output is None else os.path.abspath(Path(output, str(index)))


def _results(jobs: list[_Job], executor: Executor | None) -> Generator[SweepResult, None, None]:
    """Yield the results of runs in the order in which they end."""
    if executor is None:
        yield from map(_run, jobs)
        return
    futures = {_submit(executor, job): job for job in jobs}
    try:
        for future in as_completed(futures):
            try:
                yield future.result()
            except Exception as error:  # of the executor, such as a process that was killed
                yield _failed(futures[future], error, 1)
    finally:
        # Cancels the runs that have not started, after an exception.
        for future in futures:
            future.cancel()


def _submit(executor: Executor, job: _Job) -> Future[SweepResult]:
    """Submit a run. If the executor takes none, because a process was killed, return a failed future."""
    try:
        return executor.submit(_run, job)
    except Exception as error:
        failed: Future[SweepResult] = Future()
        failed.set_exception(error)
        return failed


def _combinations(
    parameters: Mapping[str, Any] | Iterable[Mapping[str, Any]],
) -> list[dict[str, Any]]:
    """Return one dict of parameters for each run."""
    if isinstance(parameters, Mapping):
        lists = [_values(key, values) for key, values in parameters.items()]
        return [dict(zip(parameters, values, strict=True)) for values in itertools.product(*lists)]
    if isinstance(parameters, (str, bytes)) or not isinstance(parameters, Iterable):
        raise TypeError(f"parameters must be a dict of lists or a list of dicts, not {type(parameters).__name__}")
    sets = list(parameters)
    for k, values in enumerate(sets):
        if not isinstance(values, Mapping):
            raise TypeError(f"parameters[{k}] must be a dict, not {type(values).__name__}")
    return [dict(values) for values in sets]


def _values(key: str, values: Any) -> list[Any]:
    """Return the values of a parameter as a list."""
    if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
        raise TypeError(
            f"parameters: {key} must be a list of values, not {type(values).__name__}; pass [{values!r}] for one value"
        )
    return list(values)


def _run(job: _Job) -> SweepResult:
    """Run a scene with one set of parameters, again if it fails and may be retried."""
    for attempt in itertools.count(1):
        try:
            # An attempt after the first one continues the one before.
            report, measured = _attempt(job, resume=job.resume or attempt > 1)
        except Exception as error:
            if attempt > job.retries or isinstance(error, (ValueError, TypeError)):
                return _failed(job, error, attempt)
        except BaseException as error:
            # An error in the compiled module, which is no Exception, so that programs do not catch it by chance.
            if type(error).__name__ != "PanicException":
                raise
            return _failed(job, RuntimeError(f"an error in supple; please report it: {error}"), attempt)
        else:
            return SweepResult(job.parameters, report, job.index, None, measured, attempt)
    raise AssertionError("unreachable")


def _attempt(job: _Job, *, resume: bool) -> tuple[RunReport, Any]:
    """Run a scene once. Return the report and what was measured."""
    measured: list[Any] = []

    def after_frame(progress: Progress) -> None:
        if job.measure is not None and progress.frame == progress.last:
            measured.append(job.measure(progress.simulation))

    def start(directory: str, *, resume: bool) -> RunReport:
        return run(
            job.scene,
            directory,
            "pc2" if job.directory is None else None,
            job.frames,
            None if job.measure is None else after_frame,
            every=_FRAME_0_ONLY if job.directory is None else 1,
            resume="auto" if resume else False,
            threads=job.threads,
            overrides=job.parameters,
        )

    if job.directory is None:
        # Without an output directory, the frames go to a temporary one.
        with tempfile.TemporaryDirectory(prefix="supple-") as temporary:
            report = start(temporary, resume=False)
    else:
        report = start(job.directory, resume=resume)
        if job.measure is not None and report.outcome == "already finished":
            if job.measured is not None and job.measured[1] == _identity(job.directory, report.last):
                measured.append(job.measured[0])
            else:
                report = start(job.directory, resume=False)
    return report, measured[-1] if measured else None


def _identity(directory: str, last: int) -> dict[str, Any]:
    """Return what a measurement in a directory of frames depends on: the scene, by its fingerprint, and the frame."""
    try:
        fingerprint = json.loads(Path(directory, "manifest.json").read_text())["fingerprint"]
    except (OSError, ValueError, KeyError, TypeError):
        fingerprint = None
    return {"fingerprint": fingerprint, "last": last}


def _failed(job: _Job, error: Exception, attempts: int) -> SweepResult:
    """Return the result of a run that failed."""
    if hasattr(error, "add_note"):  # from Python 3.11 on
        error.add_note(f"in run {job.index} of the sweep, with the parameters {job.parameters}")
    return SweepResult(job.parameters, None, job.index, error, None, attempts)


class _Manifest:
    """The file with the parameters and outcomes of all runs, which is written while the sweep runs."""

    def __init__(self, output: Path, scene: str, jobs: list[_Job], *, resume: bool) -> None:
        self._path = output / _MANIFEST
        self._scene = os.path.basename(scene)
        self._runs: list[dict[str, Any]] = [
            {"index": job.index, "directory": str(job.index), "parameters": _plain(job.parameters), "outcome": None}
            for job in jobs
        ]
        earlier = _read_runs(self._path) if resume else {}
        for entry in self._runs:
            before = earlier.get(entry["index"], {})
            if before.get("parameters") == entry["parameters"] and "measured" in before:
                entry.update({key: before[key] for key in ("measured", "measured_in") if key in before})
        self._written = 0.0
        output.mkdir(parents=True, exist_ok=True)
        self.write()

    def measured(self, job: _Job) -> tuple[Any, dict[str, Any]] | None:
        """Return what an earlier sweep measured with the same parameters, and in which run; None without it."""
        entry = self._runs[job.index]
        return (entry["measured"], entry.get("measured_in", {})) if "measured" in entry else None

    def add(self, result: SweepResult) -> None:
        """Add a result."""
        entry = self._runs[result.index]
        entry.pop("measured", None)
        entry.pop("measured_in", None)
        if result.error is not None:
            entry.update(outcome="failed", error=f"{type(result.error).__name__}: {result.error}")
        else:
            outcome = result.report.outcome
            entry["outcome"] = "finished" if outcome == "already finished" else outcome
            if result.measured is not None:
                with contextlib.suppress(TypeError, ValueError):  # of values that JSON does not have
                    entry["measured"] = json.loads(json.dumps(result.measured, default=_convert, allow_nan=False))
                    entry["measured_in"] = _identity(str(self._path.parent / entry["directory"]), result.report.last)
        if time.monotonic() - self._written >= _MANIFEST_INTERVAL:
            self.write()

    def write(self) -> None:
        """Write the file under a temporary name, and rename it."""
        from . import __version__

        content = {"program": "supple", "version": __version__, "scene": self._scene, "runs": self._runs}
        part = self._path.with_name(f"{_MANIFEST}.part")
        part.write_text(json.dumps(content, indent=2) + "\n")
        os.replace(part, self._path)
        self._written = time.monotonic()


def _read_runs(path: Path) -> dict[int, dict[str, Any]]:
    """Return the runs of an earlier sweep by their numbers; empty if there was none."""
    try:
        return {entry["index"]: entry for entry in json.loads(path.read_text())["runs"]}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def _plain(parameters: dict[str, Any]) -> Any:
    """Return parameters as JSON reads them again."""

    def convert(value: Any) -> Any:
        return os.fspath(value) if isinstance(value, os.PathLike) else getattr(value, "tolist", value.__repr__)()

    return json.loads(json.dumps(parameters, default=convert))


def _convert(value: Any) -> Any:
    """Convert an array of numpy to lists."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"JSON has no {type(value).__name__}")
