"""Many runs of one scene, with different parameters."""

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

#: More than any run has: of the frames only the first is kept.
_FIRST_FRAME_ONLY = 2**32 - 1


@dataclass(frozen=True)
class SweepResult:
    """One run of a sweep."""

    #: The changes to the scene that this run was made with.
    parameters: dict[str, Any]
    #: How it ended. Its directory is gone if the sweep kept no frames.
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
        `{"body.bust.half_width": [1, 2, 3]}` runs all combinations of the values; a list of dicts runs each of them.
        The keys are those of `overrides` in load_scene.
    executor : concurrent.futures.Executor, optional
        Does the runs: threads, processes, `dask.distributed.Client.get_executor()`, ... By default they are done here,
        one after another. It is not shut down.
    output : str or os.PathLike, optional
        Keeps the frames of run k in the folder `output/k`. By default none are kept.
    frames : int, default the scene's
    threads : int, default 1
        Threads of each run; 0 takes one for each processor.

    Returns one SweepResult for each set of parameters, in their order; the same bits wherever they ran, as long as the
    machines have the same vector instructions (`supple.simd_level()`). An exception of a run comes out here.
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
        # What has not begun need not begin any more.
        for future in futures:
            future.cancel()
        raise


def _combinations(
    parameters: Mapping[str, Any] | Iterable[Mapping[str, Any]],
) -> list[dict[str, Any]]:
    if isinstance(parameters, Mapping):
        return [dict(zip(parameters, values, strict=True)) for values in itertools.product(*parameters.values())]
    return [dict(one) for one in parameters]


def _run_one(
    scene: str, parameters: dict[str, Any], folder: str | None, frames: int | None, threads: int
) -> SweepResult:
    if folder is not None:
        report = run(scene, folder, frames=frames, threads=threads, overrides=parameters)
        return SweepResult(parameters, report)
    with tempfile.TemporaryDirectory(prefix="supple-") as nowhere:
        report = run(scene, nowhere, "pc2", frames, every=_FIRST_FRAME_ONLY, threads=threads, overrides=parameters)
    return SweepResult(parameters, report)
