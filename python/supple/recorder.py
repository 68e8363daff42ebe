"""Records a live simulation into a file that other programs, or a browser, show."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

from numpy.typing import ArrayLike

from . import _core
from ._core import Simulation
from .notebook import page_html
from .reports import RunReport
from .types import PathLike

__all__ = ["Recorder", "film", "save_glb", "save_html", "save_usd"]


class Recorder:
    """A file with the frames of `record`: USD stage (.usd, .usdz), page (.html), GLB (.glb) or film (.webp, .gif).

        with supple.Recorder(sim, "squeeze.usd") as recorder:
            recorder.record()               # the state as it is now
            for _ in range(120):
                sim.advance()
                recorder.record()

    sim : Simulation
        Its bodies have meshes.
    path : str or os.PathLike
        The file to write; an existing one is replaced. It is complete when the recorder is closed, also by an
        exception in the `with` block. Until then its frames are beside it, in a file with `.part`, `.data` or
        `.pc2.part` appended.
    up : "y" or "z", default that of the simulation
        Axis of the file that points up. That of the simulation is z if gravity points mainly against z, otherwise y.
    scale : float, default 1
        Length in the file of a length 1 of the simulation, > 0.
    fps : float, default that of the simulation, or one frame per step
        Frames per second at which the file is played, > 0.
    meters_per_unit : float, default 1
        Meters per unit of length of the file, > 0, which USD stages state; a GLB file is in meters.
    glb_error : float, default 0.001
        Largest distance of a vertex of a GLB file from its place, relative to the largest extent of its body, in
        [0, 1]. 0 keeps all frames exactly, with a morph target per frame.
    usd_velocities : bool, default False
        Whether a USD stage has the velocities of its points, for motion blur.
    film_size : (int, int), default (800, 600)
        Width and height of a film in pixels, in [16, 4096].
    film_view : (3,), default from the front, the right and above
        Direction from the bodies to the camera of a film, in the axes of the file; not zero.
    film_color : "material" or "volume", default "material"
        Colors of the bodies of a film: one each, as models of simulations have no materials; or blue where the volume
        is that at rest, and red from an error of 20 % on.

    In a notebook, the closed recorder of a page shows the page: `recorder` as the last line of a cell.

    Raises ValueError for another extension, a number out of range, or a body without a mesh, and OutputError if the
    file cannot be written. A GLB file and a film need at least one frame.
    """

    def __init__(
        self,
        sim: Simulation,
        path: PathLike,
        *,
        up: Literal["y", "z"] | None = None,
        scale: float = 1.0,
        fps: float | None = None,
        meters_per_unit: float = 1.0,
        glb_error: float = 0.001,
        usd_velocities: bool = False,
        film_size: tuple[int, int] = (800, 600),
        film_view: ArrayLike | None = None,
        film_color: Literal["material", "volume"] = "material",
    ) -> None:
        """Start the file."""
        self._path = Path(path).absolute()
        #: Lines about what the closed file holds approximately: the error of a GLB file.
        self.files: tuple[str, ...] = ()
        self._recording = _core.Recording(
            sim,
            path,
            up=up,
            scale=scale,
            fps=fps,
            meters_per_unit=meters_per_unit,
            glb_error=glb_error,
            usd_velocities=usd_velocities,
            film_size=film_size,
            film_view=film_view,
            film_color=film_color,
        )

    @property
    def frames(self) -> int | None:
        """Number of frames so far; None when the recorder is closed."""
        return self._recording.frames

    def record(self) -> None:
        """Append a frame with the present state of the simulation."""
        self._recording.record()

    def close(self) -> None:
        """Complete the file. Closing twice does nothing."""
        self.files += tuple(self._recording.close())

    def __repr__(self) -> str:
        """Return a line with the file and the number of frames."""
        state = "closed" if self.frames is None else f"open, frames: {self.frames}"
        return f"<supple.Recorder of {self._path}: {state}>"

    def _repr_html_(self) -> str | None:
        """Return the page for a notebook; None for a stage, and for a page that is not complete."""
        is_page = self._path.suffix == ".html" and self.frames is None and self._path.is_file()
        return page_html(self._path) if is_page else None

    def __enter__(self) -> Recorder:
        """Return the recorder."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the recorder; the frames that are recorded stay."""
        self.close()


def save_usd(
    sim: Simulation,
    path: PathLike,
    frames: int,
    *,
    up: Literal["y", "z"] | None = None,
    scale: float = 1.0,
    fps: float | None = None,
    meters_per_unit: float = 1.0,
    usd_velocities: bool = False,
) -> Recorder:
    """Advance a simulation by a number of frames and save it as a USD stage.

    sim : Simulation
        It needs fps. The present state becomes frame 0.
    path : str or os.PathLike
        The file to write, which ends in `.usd` or `.usdz`; an existing one is replaced.
    frames : int
        Number of frames after frame 0, at least 0.
    up, scale, fps, meters_per_unit, usd_velocities : optional
        As for Recorder.

    For runs of scenes, which are resumed and which keep texture coordinates, materials and groups of models, use
    `run(..., format="usd")`. Returns the closed Recorder. Raises its errors, and ValueError without fps.
    """
    options = {
        "up": up,
        "scale": scale,
        "fps": fps,
        "meters_per_unit": meters_per_unit,
        "usd_velocities": usd_velocities,
    }
    return _save(sim, path, (".usd", ".usdz"), frames, options)


def save_html(
    sim: Simulation,
    path: PathLike,
    frames: int,
    *,
    up: Literal["y", "z"] | None = None,
    scale: float = 1.0,
    fps: float | None = None,
) -> Recorder:
    """Advance a simulation by a number of frames and save it as a page for browsers.

    sim : Simulation
        It needs fps. The present state becomes frame 0.
    path : str or os.PathLike
        The page to write, which ends in `.html`; an existing one is replaced.
    frames : int
        Number of frames after frame 0, at least 0.
    up, scale, fps : optional
        As for Recorder.

    Returns the closed Recorder, which shows the page in a notebook. Raises its errors, and ValueError without fps.
    """
    return _save(sim, path, (".html",), frames, {"up": up, "scale": scale, "fps": fps})


def save_glb(
    sim: Simulation,
    path: PathLike,
    frames: int,
    *,
    scale: float = 1.0,
    fps: float | None = None,
    meters_per_unit: float = 1.0,
    glb_error: float = 0.001,
) -> Recorder:
    """Advance a simulation by a number of frames and save it as an animated GLB file.

    sim : Simulation
        It needs fps. The present state becomes frame 0.
    path : str or os.PathLike
        The file to write, which ends in `.glb`; an existing one is replaced.
    frames : int
        Number of frames after frame 0, at least 0.
    scale, fps, meters_per_unit, glb_error : optional
        As for Recorder. The axes are those of glTF: y points up.

    For runs of scenes, which are resumed and which keep texture coordinates and materials of models, use
    `run(..., format="glb")`. Returns the closed Recorder. Raises its errors, and ValueError without fps.
    """
    options = {"scale": scale, "fps": fps, "meters_per_unit": meters_per_unit, "glb_error": glb_error}
    return _save(sim, path, (".glb",), frames, options)


def film(
    run: Simulation | RunReport | PathLike,
    path: PathLike,
    frames: int | None = None,
    *,
    size: tuple[int, int] = (800, 600),
    view: ArrayLike | None = None,
    color: Literal["material", "volume"] = "material",
    fps: float | None = None,
    up: Literal["y", "z"] | None = None,
) -> Path:
    """Show a motion as a moving picture: animated WebP or GIF.

    run : Simulation, RunReport, str or os.PathLike
        A simulation, which needs fps and advances; its present state becomes the first frame. Or a run on disk: its
        report or folder with the page `supple.html`, or else with OBJ or PLY frames; or a page. Frames of a folder are
        shown without colliders, above a ground below their lowest point.
    path : str or os.PathLike
        The film, which ends in `.webp` or `.gif`; an existing one is replaced.
    frames : int, default 4 seconds
        Number of frames after the first one by which a simulation advances, at least 0; not for runs on disk.
    size : (int, int), default (800, 600)
        Width and height in pixels, in [16, 4096].
    view : (3,), default from the front, the right and above
        Direction from the bodies to the camera, in the axes of the simulation or the files; not zero.
    color : "material" or "volume", default "material"
        Colors of the bodies: those of their materials, of OBJ frames, or one each; or blue where the volume is that at
        rest, and red from an error of 20 % on, of simulations and pages.
    fps : float, default that of the run
        Frames per second at which the film is played, > 0. A frame of a GIF lasts 0.02 s or longer in most programs.
    up : "y" or "z", default that of the simulation or the page, and y for frames
        Axis that points up.

    The camera stands still. It shows the bodies in the first frame, and where they go, up to 8 times half the diagonal
    of their bounds. Returns the path.

    Raises ValueError for an argument out of range or a run without frames, FileNotFoundError for a missing run, and
    OutputError if the film cannot be written.
    """
    if Path(path).suffix.lower() not in (".webp", ".gif"):
        raise ValueError(f"path is {os.fspath(path)!r}; it must end in .webp or .gif")
    look: dict[str, Any] = {"up": up, "fps": fps, "film_size": size, "film_view": view, "film_color": color}
    if isinstance(run, Simulation):
        if frames is None:
            run.advance(0)  # raises if the simulation has no frames
            frames = round(4 / (run.dt * run.steps_per_frame))
        _save(run, path, (Path(path).suffix,), frames, look)
        return Path(path)
    if frames is not None:
        raise ValueError("frames is for simulations; a run on disk has its own")
    _core.film(run.directory if isinstance(run, RunReport) else run, path, **look)
    return Path(path)


def _save(
    sim: Simulation,
    path: PathLike,
    endings: tuple[str, ...],
    frames: int,
    options: dict[str, Any],
) -> Recorder:
    """Record the present state and a number of further frames."""
    if not os.fspath(path).endswith(endings):
        raise ValueError(f"path is {os.fspath(path)!r}; it must end in {' or '.join(endings)}")
    sim.advance(0)  # raises before the file is written if the simulation has no frames
    with Recorder(sim, path, **options) as recorder:
        recorder.record()
        for _ in range(frames):
            sim.advance()
            recorder.record()
    return recorder
