"""Defines reports on simulations and runs: plain data that can be compared, printed and pickled."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from ._core import Simulation

__all__ = [
    "BodyReport",
    "ComponentReport",
    "Progress",
    "RunReport",
    "Softened",
    "UnkeptVolume",
    "VolumeReport",
]


@dataclass(frozen=True)
class ComponentReport:
    """Volume correction of one connected component of a lattice.

    Volumes are in cubed units of length.
    """

    #: Volume at rest.
    rest: float
    #: Volume before the correction.
    before: float
    #: Volume after the correction.
    after: float
    #: Scale of the correction: displacement of a free boundary vertex along its normal, as a length, positive outwards.
    #: With the scope "regional", the scale of the global correction that follows the regional correction. Where several
    #: passes restore the volume, the scale of the last pass.
    lambda_: float
    #: `(after - rest) / rest`.
    residual: float
    #: Whether the magnitude of the residual exceeds 1e-6: the correction is limited by `max_correction` below 1,
    #: the body is flat or inside out, or colliders or held vertices leave too little space.
    capped: bool


@dataclass(frozen=True)
class VolumeReport:
    """Volume of a body before and after the correction, in cubed units of length.

    For a lattice with several components, rest, before and after are sums over the components, and lambda_ and residual
    are the values of greatest magnitude.
    """

    #: Measure of the correction: "mesh", "cells" or "lattice". With volume "off", the measure that "auto" would choose.
    measure: str
    #: Volume at rest by this measure.
    rest: float
    #: Volume before the correction.
    before: float
    #: Volume after the correction. Without a correction it equals `before`.
    after: float
    #: Scale of the correction: displacement of a free boundary vertex along its normal, as a length, positive outwards.
    lambda_: float
    #: `(after - rest) / rest`.
    residual: float
    #: Whether any component is capped.
    capped: bool
    #: One report per component of the lattice.
    components: tuple[ComponentReport, ...]
    #: Volumes (rest, before, after) by each measure that is available for the body.
    volumes: dict[str, tuple[float, float, float]]


@dataclass(frozen=True)
class Progress:
    """Progress of a run, the argument of its `progress` callback after each frame."""

    #: Number of the completed frame, from 0.
    frame: int
    #: Number of the last frame.
    last: int
    #: Simulated time in seconds.
    time: float
    #: Wall-clock time since the start of the run, in seconds.
    elapsed: float
    #: The live simulation, which can be read and changed between two frames.
    simulation: Simulation = field(repr=False, compare=False)


@dataclass(frozen=True)
class UnkeptVolume:
    """Written frames of a run in which the displayed volume of a body was not kept.

    The volume of a frame is not kept if its relative error after the correction exceeds 0.001 in a component of the
    lattice. The reason is a `max_correction` below 1, pins, handles and colliders that leave too little space, or a
    weight that crushes the body.
    """

    #: Number of frames in which the volume was not kept, at least 1.
    frames: int
    #: Number of frames that the run wrote with the volume correction.
    written: int
    #: Number of the frame with the largest error, as in its file name.
    worst_frame: int
    #: Largest relative error, `(after - rest) / rest`; negative if volume was lost.
    worst_error: float


@dataclass(frozen=True)
class Softened:
    """A body that is softer than its material, because its steps are too long."""

    #: The quantity: "youngs_modulus" (also of a `material`) or "frequency".
    key: str
    #: Specified value: force per area in scene units, or Hz.
    specified: float
    #: Value in force.
    in_force: float
    #: The stiffness factor of the part that the values are of: the greatest of the body, and 1 without zones.
    factor: float
    #: Number of steps per frame of the run.
    substeps: int
    #: Number of steps per frame that reach the specified value; None if it exceeds 100,000.
    needed_substeps: int | None


@dataclass(frozen=True)
class BodyReport:
    """Result of a run for one body."""

    #: Name of the body.
    name: str
    #: Number of lattice vertices.
    lattice_vertices: int
    #: Report on the volume at the last frame.
    volume: VolumeReport
    #: The frames of this run in which the volume was not kept; None if it was kept in all, or is not preserved.
    unkept_volume: UnkeptVolume | None
    #: Number of frames of this run in which the body was crushed to less than a quarter of its volume, and is shown
    #: with cells inside out, so that the frames take no longer.
    crushed_frames: int
    #: Specified value and value in force, if the steps are too long for the material of the body; otherwise None.
    softened: Softened | None


@dataclass(frozen=True)
class RunReport:
    """Result of a run."""

    #: Directory of the frames.
    directory: Path
    #: "finished"; "stopped": the callback stopped the run, which can be resumed; or "already finished": an earlier run
    #: had finished, and nothing was written.
    outcome: Literal["finished", "stopped", "already finished"]
    #: Number of the frame after which the run resumed; None if the run started from frame 0.
    resumed_after: int | None
    #: Number of the last completed frame, from 0.
    last: int
    #: Number of frames that this run simulated, including frame 0.
    simulated: int
    #: Number of frames that this run wrote; a frame of all bodies counts once.
    written: int
    #: Number of steps per frame.
    substeps: int
    #: Wall-clock time of the run, in seconds.
    elapsed: float
    #: One report per body, in the order of the scene.
    bodies: tuple[BodyReport, ...]
    #: Lines about files that hold the frames approximately or incompletely: the error of a GLB file, and images that it
    #: cannot have.
    files: tuple[str, ...] = ()
