"""Loads scenes as live simulations, or runs them to frames on disk."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from . import _core
from ._core import Simulation
from .reports import Progress, RunReport
from .types import PathLike

__all__ = ["load_scene", "run"]

if TYPE_CHECKING:
    _FrameFormat: TypeAlias = Literal["obj", "ply", "pc2", "usd", "usdz", "html", "glb", "vat", "vtu", "lattice"]


def load_scene(path: PathLike, *, overrides: Mapping[str, Any] | None = None) -> Simulation:
    """Load a scene as a simulation at time zero.

    path : str or os.PathLike
        A scene (.toml), or a model (.obj, .glb, .gltf, .stl, .ply), which is dropped on a ground plane just below it.
    overrides : dict, optional
        Changes to the scene by key path: `{"simulation.gravity": [0, 0, 0], "body.bust.half_width": 3}`. In a key
        path a body is given by its name, and an entry of another list by its index from 0.

    Returns a Simulation with the fps and the substeps of the scene: sim.advance() is one frame. Raises
    FileNotFoundError for a missing file, SceneError, with file, line and key, for an invalid scene, and MeshError or
    LatticeError for an invalid mesh or lattice.
    """
    return _core.load_scene(path, _assignments(overrides))


def run(
    path: PathLike,
    output: PathLike | None = None,
    format: _FrameFormat | Sequence[_FrameFormat] | None = None,
    frames: int | None = None,
    progress: Callable[[Progress], object] | None = None,
    *,
    every: int = 1,
    start_frame: int = 0,
    stats: PathLike | None = None,
    resume: bool | Literal["auto"] = False,
    from_frame: int | None = None,
    threads: int | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> RunReport:
    """Run a scene to frames on disk.

    path : str or os.PathLike
        A scene (.toml) or a model, as for load_scene.
    output : str or os.PathLike, default the scene's `output.directory`
        Directory of the frames `NAME_0000.obj`, ... The directory is created if it does not exist.
    format : "obj", "ply", "pc2", "usd", "usdz", "html", "glb", "vat", "vtu", "lattice", or a list, default the scene's
        File formats of the frames. "usd" writes one USD stage, `supple.usd`, "usdz" the same with its images,
        `supple.usdz`, "html" one page for browsers, `supple.html`, and "glb" one animated GLB file, `supple.glb`, with
        all bodies and frames; "vat" vertex animation textures, `NAME_vat/`, in PNG, or in OpenEXR with
        overrides={"output.vat_encoding": "exr"}; "vtu" and "lattice" grids of VTK, of the surface and of the cells.
    frames : int, default the scene's
        Number of frames after frame 0. Frame 0 is the rest pose in its initial placement.
    progress : callable, optional
        Called with a Progress after each frame, from frame 0 on. Its `simulation` is live: the callback can change
        settings, apply forces and evaluate surfaces. If the callback returns False, the run stops and can be resumed.
        If the callback raises an exception, the run stops and raises this exception. A resumed run keeps the changes
        that the callback made, also by Collider.move_to, but not new values of Simulation.colliders.
    every : int, default 1
        Interval between written frames, at least 1: every k-th frame is written.
    start_frame : int, default 0
        Number of frame 0 in the file names.
    stats : str or os.PathLike, optional
        A .csv or .json file to write, with one row per frame and body.
    resume : bool or "auto", default False
        Whether to continue an earlier run. If False, existing frames of the same names and format are replaced. If the
        earlier run had other settings or its checkpoint is damaged, True raises SceneError, and "auto" starts at the
        first frame and warns with ResumeWarning.
    from_frame : int, optional
        Number of a frame, as in file names: continue an earlier run with the scene as it is now, after the newest state
        or checkpoint at or before this frame. Frames up to there stay as they are, and later ones are written anew.
        States are kept with the key `output.states`. SceneError says which changes of the scene a state cannot have, if
        there is no state, and with `resume`.
    threads : int, default the scene's
        Number of threads; 0 means one per processor.
    overrides : dict, optional
        Changes to the scene, as for load_scene.

    Returns a RunReport. Other Python threads continue to run, and Ctrl-C stops the run after the current frame. Raises
    the errors of load_scene, and OutputError for frames that cannot be written.
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
        from_frame=from_frame,
        threads=threads,
    )


def _assignments(overrides: Mapping[str, Any] | None) -> list[str]:
    """Format overrides as `KEY=VALUE`, with TOML values."""
    if overrides is None:
        return []
    if not isinstance(overrides, Mapping):
        found = type(overrides).__name__
        raise TypeError(f'overrides must be a dict such as {{"body.bust.half_width": 3}}, not {found}')
    for key in overrides:
        if not isinstance(key, str):
            raise TypeError(f"overrides: a key path must be a string, not {type(key).__name__}: {key!r}")
    return [f"{key}={_toml(value)}" for key, value in overrides.items()]


def _toml(value: Any) -> str:
    """Format a value as TOML."""
    if hasattr(value, "tolist"):  # a numpy array or scalar
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
    raise TypeError(f"overrides: a scene cannot have a value of type {type(value).__name__}")
