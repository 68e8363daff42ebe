"""Runs one scene with different parameters."""

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

#: An interval between written frames that no run exceeds, so that only frame 0 is written.
_FRAME_0_ONLY = 2**32 - 1


@dataclass(frozen=True)
class SweepResult:
    """Result of one run of a sweep."""

    #: Changes to the scene in this run.
    parameters: dict[str, Any]
    #: Report of the run. If the sweep kept no frames, `report.directory` does not exist.
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
        A scene (.toml) or a model, as for load_scene.
    parameters : dict of lists, or list of dicts
        A dict such as `{"body.bust.half_width": [1, 2, 3]}` gives one run per combination of the values. A list of
        dicts gives one run per dict. The keys are key paths as for `overrides` of load_scene.
    executor : concurrent.futures.Executor, optional
        Executes the runs: threads, processes, `dask.distributed.Client.get_executor()`, ... The executor is not shut
        down. By default the runs are executed in this process, one after another.
    output : str or os.PathLike, optional
        Directory for the frames; run k, counted from 0, writes to `output/k`. By default no frames are kept.
    frames : int, default the scene's
        Number of frames after frame 0.
    threads : int, default 1
        Number of threads of each run; 0 means one per processor.

    Returns one SweepResult per set of parameters, in order. Results are bit-identical on all machines with the same
    SIMD level (`supple.simd_level()`). Raises the exception of a run that fails.
    """
    if not isinstance(scene, (str, os.PathLike)):
        raise TypeError(f"scene must be a path (str or os.PathLike), not {type(scene).__name__}")
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise TypeError(f"executor must be a concurrent.futures.Executor, not {type(executor).__name__}")
    path = os.path.abspath(os.fspath(scene))
    sets = _combinations(parameters)
    outputs = [None if output is None else os.path.abspath(Path(output, str(k))) for k in range(len(sets))]
    runs = [(path, values, directory, frames, threads) for values, directory in zip(sets, outputs, strict=True)]
    if executor is None:
        return [_run(*arguments) for arguments in runs]
    futures: list[Future[SweepResult]] = [executor.submit(_run, *arguments) for arguments in runs]
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


def _run(
    scene: str, parameters: dict[str, Any], directory: str | None, frames: int | None, threads: int
) -> SweepResult:
    """Run a scene with one set of parameters. Without a directory, the frames go to a temporary one."""
    if directory is not None:
        report = run(scene, directory, frames=frames, threads=threads, overrides=parameters)
        return SweepResult(parameters, report)
    with tempfile.TemporaryDirectory(prefix="supple-") as temporary:
        report = run(scene, temporary, "pc2", frames, every=_FRAME_0_ONLY, threads=threads, overrides=parameters)
    return SweepResult(parameters, report)
