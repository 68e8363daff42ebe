"""What simulations and runs tell: plain data that can be compared, printed and pickled."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from ._core import Simulation

__all__ = ["BodyReport", "ComponentReport", "Progress", "RunReport", "VolumeReport"]


@dataclass(frozen=True)
class ComponentReport:
    """What the volume correction did to one component of a lattice: a part that nothing joins to the others.

    Volumes are cubed units of length.
    """

    #: Volume at rest.
    rest: float
    #: Volume before the correction.
    before: float
    #: Volume after it.
    after: float
    #: How far a free boundary vertex moved along its normal, as a length, outwards if positive; with the scope
    #: "regional" for what the regions left.
    lambda_: float
    #: `(after - rest) / rest`.
    residual: float
    #: Whether no scale within the cap keeps the volume.
    capped: bool


@dataclass(frozen=True)
class VolumeReport:
    """The volume of a body, in cubed units of length, and what the correction did to it.

    With several components, rest, before and after are their sums; lambda_ and residual are those of greatest
    magnitude.
    """

    #: The measure that is kept, `"mesh"`, `"cells"` or `"lattice"`; with volume "off" what "auto" would keep.
    measure: str
    #: Volume at rest by that measure.
    rest: float
    #: Volume before the correction.
    before: float
    #: Volume after it; without correction the same as before.
    after: float
    #: How far a free boundary vertex moved along its normal, as a length, outwards if positive.
    lambda_: float
    #: `(after - rest) / rest`.
    residual: float
    #: Whether any component is capped.
    capped: bool
    #: Each component of the lattice.
    components: tuple[ComponentReport, ...]
    #: (rest, before, after) by each measure that the body has.
    volumes: dict[str, tuple[float, float, float]]


@dataclass(frozen=True)
class Progress:
    """How far a run is, as its `progress` callback is told after each frame."""

    #: The frame that is done, counted from 0.
    frame: int
    #: The last frame.
    last: int
    #: Simulated time in seconds.
    time: float
    #: Seconds of wall clock since the run began.
    elapsed: float
    #: The live simulation, to be looked at and changed between two frames.
    simulation: Simulation = field(repr=False, compare=False)


@dataclass(frozen=True)
class BodyReport:
    """What became of a body in a run."""

    #: Its name.
    name: str
    #: Lattice vertices.
    lattice_vertices: int
    #: Its volume at the last frame.
    volume: VolumeReport


@dataclass(frozen=True)
class RunReport:
    """How a run ended."""

    #: The folder of the frames.
    directory: Path
    #: "finished"; "stopped" by its callback, to be resumed; or "already finished", with nothing written.
    outcome: Literal["finished", "stopped", "already finished"]
    #: The frame after which a resumed run went on; None if it started from frame 0.
    resumed_after: int | None
    #: The last frame that is done, counted from 0.
    last: int
    #: Frames that this run simulated, frame 0 included.
    simulated: int
    #: Frames that this run wrote, of all bodies together.
    written: int
    #: Steps in a frame.
    substeps: int
    #: Seconds of wall clock.
    elapsed: float
    #: One for each body, in the order of the scene.
    bodies: tuple[BodyReport, ...]
