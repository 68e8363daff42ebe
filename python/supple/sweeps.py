"""Runs of one scene with different parameters."""

from __future__ import annotations

import itertools
import os
import tempfile
from collections.abc import Iterable, Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .reports import RunReport
from .scenes import run

__all__ = ["SweepResult", "sweep"]

#: A frame interval greater than the length of any run, so that only frame 0 is written.
_FIRST_FRAME_ONLY = 2**32 - 1


@dataclass(frozen=True)
class SweepResult:
    """Result of one run of a sweep."""

    #: Changes to the scene in this run.
    parameters: dict[str, Any]
    #: Report of the run. Its directory does not exist if the sweep kept no frames.
    report: RunReport


def sweep(
    scene: str | os.PathLike[str],
    parameters: Mapping[str, Any] | Iterable[Mapping[str, Any]],
    executor: Executor | None = None,
    *,
    output: str | os.PathLike[str] | None = None,
    frames: int | None = None,
    threads: int = 1,
) -> list[SweepResult]:
    """Run a scene once for each set of parameters.

    scene : str or os.PathLike
        A scene (.toml) or a model (.obj).
    parameters : dict of lists, or list of dicts
        A dict such as `{"body.bust.half_width": [1, 2, 3]}` gives one run per combination of the values, a list of
        dicts one run per dict. Keys are the same as for `overrides` of load_scene.
    executor : concurrent.futures.Executor, optional
        Executes the runs: threads, processes, `dask.distributed.Client.get_executor()`, ... It is not shut down. By
        default the runs are executed in this process, one after another.
    output : str or os.PathLike, optional
        Folder for the frames; run k writes to `output/k`. By default no frames are kept.
    frames : int, default the scene's
        Number of frames after frame 0.
    threads : int, default 1
        Number of threads of each run; 0 means one per processor.

    Returns one SweepResult per set of parameters, in order. Results are bit-identical on all machines with the same
    SIMD level (`supple.simd_level()`). Raises the exception of a run that fails.
    """
    path = os.path.abspath(os.fspath(scene))
    sets = _combinations(parameters)
    folders = [None if output is None else os.path.abspath(Path(output, str(k))) for k in range(len(sets))]
    if executor is None:
        return [_run_one(path, one, folder, frames, threads) for one, folder in zip(sets, folders, strict=True)]
    futures: list[Future[SweepResult]] = [
        executor.submit(_run_one, path, one, folder, frames, threads) for one, folder in zip(sets, folders, strict=True)
    ]
    try:
        return [future.result() for future in futures]
    except BaseException:
        # Cancels the runs that have not started.
        for future in futures:
            future.cancel()
        raise


def _combinations(
    parameters: Mapping[str, Any] | Iterable[Mapping[str, Any]],
) -> list[dict[str, Any]]:
    """Return the parameters of each run."""
    if isinstance(parameters, Mapping):
        return [dict(zip(parameters, values, strict=True)) for values in itertools.product(*parameters.values())]
    return [dict(one) for one in parameters]


def _run_one(
    scene: str, parameters: dict[str, Any], folder: str | None, frames: int | None, threads: int
) -> SweepResult:
    if folder is not None:
        report = run(scene, folder, frames=frames, threads=threads, overrides=parameters)
        return SweepResult(parameters, report)
    with tempfile.TemporaryDirectory(prefix="supple-") as temporary:
        report = run(scene, temporary, "pc2", frames, every=_FIRST_FRAME_ONLY, threads=threads, overrides=parameters)
    return SweepResult(parameters, report)
