"""The compiled part of supple."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, Protocol, TypeAlias, TypeVar, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .colliders import Collider, Key
from .reports import Progress, RunReport, VolumeReport

__all__ = [
    "Body",
    "Hold",
    "Lattice",
    "Mesh",
    "Simulation",
    "__version__",
    "check_collider",
    "load_scene",
    "read_obj",
    "reference_goals",
    "rotations",
    "run",
    "simd_level",
]
__version__: str

_Float = TypeVar("_Float", np.float32, np.float64)
_Path: TypeAlias = str | os.PathLike[str]
_Box: TypeAlias = Sequence[ArrayLike] | Mapping[str, ArrayLike] | NDArray[Any]
_Sphere: TypeAlias = tuple[ArrayLike, float] | Mapping[str, Any]
_Plane: TypeAlias = Sequence[ArrayLike] | Mapping[str, ArrayLike] | NDArray[Any]

class _MeshLike(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...

@final
class Mesh:
    def __new__(cls, vertices: ArrayLike, faces: ArrayLike | Sequence[Sequence[int]]) -> Mesh: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def faces(self) -> NDArray[np.int64]: ...
    @property
    def volume(self) -> float: ...
    @property
    def is_closed(self) -> bool: ...
    @property
    def bounds(self) -> NDArray[np.float64]: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @classmethod
    def _from_polygons(cls, vertices: ArrayLike, sizes: ArrayLike, corners: ArrayLike) -> Mesh: ...

def read_obj(path: _Path, object: str | None = None) -> Mesh: ...

@final
class Lattice:
    @classmethod
    def from_mesh(
        cls,
        mesh: Mesh | _Path | _MeshLike,
        *,
        vertices: int | None = None,
        cell_size: float | None = None,
        join: bool = True,
        memory_limit: int | None = None,
    ) -> Lattice: ...
    @classmethod
    def from_cells(
        cls, cells: ArrayLike, cell_size: float = 1.0, origin: ArrayLike = (0, 0, 0), join: bool = True
    ) -> Lattice: ...
    @property
    def indices(self) -> NDArray[np.int64]: ...
    @property
    def rest_positions(self) -> NDArray[np.float64]: ...
    @property
    def cells(self) -> NDArray[np.int64]: ...
    @property
    def cell_size(self) -> float: ...
    @property
    def origin(self) -> NDArray[np.float64]: ...
    @property
    def component_count(self) -> int: ...
    def __len__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @classmethod
    def _from_indices(cls, cells: ArrayLike, cell_size: float, origin: ArrayLike) -> Lattice: ...

@final
class Body:
    def __new__(
        cls,
        shape: Mesh | Lattice | _Path | _MeshLike,
        *,
        name: str = "body",
        object: str | None = None,
        scale: float = 1.0,
        rotate: ArrayLike = (0, 0, 0),
        translate: ArrayLike = (0, 0, 0),
        lattice_vertices: int | None = 1000,
        cell_size: float | None = None,
        join: bool = True,
        half_width: int | None = 2,
        stiffness_radius: float | None = None,
        stiffness: float | None = 1.0,
        frequency: float | None = None,
        damping: float | None = 0.0,
        damping_rate: float | None = None,
        density: float = 1000.0,
        volume: str | Mapping[str, Any] = "auto",
        velocity: ArrayLike = (0, 0, 0),
        spin: ArrayLike = (0, 0, 0),
        memory_limit: int | None = None,
    ) -> Body: ...
    @property
    def name(self) -> str: ...
    @property
    def mesh(self) -> Mesh | None: ...
    @property
    def lattice(self) -> Lattice: ...
    @property
    def half_width(self) -> int: ...
    @property
    def density(self) -> float: ...
    @property
    def stiffness(self) -> float | None: ...
    @stiffness.setter
    def stiffness(self, value: float) -> None: ...
    @property
    def frequency(self) -> float | None: ...
    @frequency.setter
    def frequency(self, value: float) -> None: ...
    @property
    def damping(self) -> float | None: ...
    @damping.setter
    def damping(self, value: float) -> None: ...
    @property
    def damping_rate(self) -> float | None: ...
    @damping_rate.setter
    def damping_rate(self, value: float) -> None: ...
    @property
    def positions(self) -> NDArray[np.float64]: ...
    @positions.setter
    def positions(self, value: ArrayLike) -> None: ...
    @property
    def velocities(self) -> NDArray[np.float64]: ...
    @velocities.setter
    def velocities(self, value: ArrayLike) -> None: ...
    @property
    def rotations(self) -> NDArray[np.float64]: ...
    @property
    def masses(self) -> NDArray[np.float64]: ...
    def goals(self) -> NDArray[np.float64]: ...
    def corrected_positions(self) -> NDArray[np.float64]: ...
    @overload
    def surface(self, out: None = None) -> NDArray[np.float64]: ...
    @overload
    def surface(self, out: NDArray[_Float]) -> NDArray[_Float]: ...
    @overload
    def surface_normals(self, out: None = None) -> NDArray[np.float64]: ...
    @overload
    def surface_normals(self, out: NDArray[_Float]) -> NDArray[_Float]: ...
    def volume_report(self) -> VolumeReport: ...
    def pin(
        self,
        *,
        box: _Box | None = None,
        sphere: _Sphere | None = None,
        plane: _Plane | None = None,
        vertices: ArrayLike | None = None,
        from_: float = 0.0,
        until: float | None = None,
    ) -> Hold: ...
    def handle(
        self,
        *,
        keys: Iterable[Key],
        box: _Box | None = None,
        sphere: _Sphere | None = None,
        plane: _Plane | None = None,
        vertices: ArrayLike | None = None,
        from_: float = 0.0,
        until: float | None = None,
    ) -> Hold: ...
    def apply_force(
        self,
        force: ArrayLike,
        *,
        box: _Box | None = None,
        sphere: _Sphere | None = None,
        plane: _Plane | None = None,
        vertices: ArrayLike | None = None,
    ) -> None: ...
    def __len__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _of(simulation: Simulation, index: int) -> Body: ...
    @staticmethod
    def _restore(shape: Mesh | Lattice, settings: dict[str, Any], state: bytes) -> Body: ...

@final
class Hold:
    @property
    def body(self) -> Body: ...
    def release(self) -> None: ...
    def set_keys(self, keys: Iterable[Key]) -> None: ...

@final
class Simulation:
    def __init__(
        self,
        bodies: Iterable[Body],
        *,
        dt: float = 0.016666666666666666,
        gravity: ArrayLike = (0, -9.81, 0),
        colliders: Iterable[Collider] = (),
        threads: int = 0,
        substeps: int = 1,
    ) -> None: ...
    @property
    def bodies(self) -> tuple[Body, ...]: ...
    @property
    def dt(self) -> float: ...
    @dt.setter
    def dt(self, value: float) -> None: ...
    @property
    def time(self) -> float: ...
    @time.setter
    def time(self, value: float) -> None: ...
    @property
    def gravity(self) -> NDArray[np.float64]: ...
    @gravity.setter
    def gravity(self, value: ArrayLike) -> None: ...
    @property
    def colliders(self) -> tuple[Collider, ...]: ...
    @colliders.setter
    def colliders(self, value: Iterable[Collider]) -> None: ...
    @property
    def substeps(self) -> int: ...
    @property
    def threads(self) -> int: ...
    def plan(self) -> str: ...
    def step(self, n: int = 1) -> None: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @classmethod
    def _restore(cls, bodies: list[Any], settings: dict[str, Any], state: bytes) -> Simulation: ...

def rotations(a: ArrayLike) -> NDArray[np.float64]: ...
def reference_goals(
    lattice: Lattice,
    positions: ArrayLike,
    half_width: int,
    regions: Literal["staircase", "breadth_first"] = "staircase",
) -> NDArray[np.float64]: ...
def simd_level() -> str: ...
def check_collider(collider: Collider) -> dict[str, Any]: ...
def load_scene(path: _Path, overrides: list[str]) -> Simulation: ...
def run(
    path: _Path,
    overrides: list[str],
    *,
    output: _Path | None = None,
    format: str | None = None,
    frames: int | None = None,
    progress: Callable[[Progress], object] | None = None,
    every: int = 1,
    start_frame: int = 0,
    stats: _Path | None = None,
    resume: bool = False,
    threads: int | None = None,
) -> RunReport: ...
