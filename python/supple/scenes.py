"""Scenes: loaded as a live simulation, or run to frames on disk."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from typing import Any, Literal

from . import _core
from ._core import Simulation
from .reports import Progress, RunReport

__all__ = ["load_scene", "run"]


def load_scene(path: str | os.PathLike[str], *, overrides: Mapping[str, Any] | None = None) -> Simulation:
    """Load a scene as a simulation at time zero.

    path : str or os.PathLike
        A scene (.toml), or a model (.obj) as the scene that it means alone: dropped on a ground just below it.
    overrides : dict, optional
        Changes to the scene by path of keys: `{"simulation.gravity": [0, 0, 0], "body.bust.half_width": 3}`; bodies by
        name, other lists by number.

    Returns a Simulation whose dt is 1 / (fps * substeps). FileNotFoundError for a missing file; SceneError for what no
    scene can say, with file, line and key; MeshError and LatticeError for a mesh that cannot be used.
    """
    return _core.load_scene(path, _assignments(overrides))


def run(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    format: Literal["obj", "ply", "pc2"] | None = None,
    frames: int | None = None,
    progress: Callable[[Progress], object] | None = None,
    *,
    every: int = 1,
    start_frame: int = 0,
    stats: str | os.PathLike[str] | None = None,
    resume: bool = False,
    threads: int | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> RunReport:
    """Run a scene to frames on disk.

    path : str or os.PathLike
        A scene (.toml) or a model (.obj), as for load_scene.
    output : str or os.PathLike, default the scene's `output.directory`
        The folder of the frames `NAME_0000.obj`; made if it is not there.
    format : "obj", "ply" or "pc2", default the scene's
    frames : int, default the scene's
        Frames after frame 0, the rest pose as placed.
    progress : callable, optional
        Called with a Progress after each frame, from frame 0 on. Its `simulation` is live: what can be changed between
        steps can be changed there, forces applied, surfaces read. If it returns False the run stops, and can be
        resumed; if it raises, the run stops and the exception comes out here. A resumed run keeps what was changed,
        but for colliders.
    every : int, default 1
        Keeps every so many frames.
    start_frame : int, default 0
        The number that frame 0 goes by.
    stats : str or os.PathLike, optional
        A .csv or .json file for one row a frame and body.
    resume : bool, default False
        Goes on where an earlier run ended; otherwise an existing sequence is replaced.
    threads : int, default the scene's
        0 takes one for each processor.
    overrides : dict, optional
        Changes to the scene, as for load_scene.

    Other Python threads run meanwhile, and Ctrl-C ends it after a frame. Errors are those of load_scene, and
    OutputError for frames that cannot be written.
    """
    return _core.run(
        path,
        _assignments(overrides),
        output=output,
        format=format,
        frames=frames,
        progress=progress,
        every=every,
        start_frame=start_frame,
        stats=stats,
        resume=resume,
        threads=threads,
    )


def _assignments(overrides: Mapping[str, Any] | None) -> list[str]:
    """`KEY=VALUE`, the values as TOML."""
    return [f"{key}={_toml(value)}" for key, value in (overrides or {}).items()]


def _toml(value: Any) -> str:
    if hasattr(value, "tolist"):  # numpy
        value = value.tolist()
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value))
    raise TypeError(f"overrides: {type(value).__name__} is no value that a scene can have")
