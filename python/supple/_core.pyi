"""Declares the types of the compiled module `supple._core`."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal, Protocol, SupportsIndex, TypeAlias, TypeVar, final, overload

import numpy as np
from _typeshed import ReadableBuffer
from numpy.typing import ArrayLike, NDArray
from trimesh import Scene, Trimesh

from .colliders import Collider, Enabled, Key, Rotate
from .edits import Edit
from .reports import Progress, RunReport, VolumeReport
from .types import (
    Accuracy,
    BoxShape,
    Curve,
    FractureOptions,
    Interpolation,
    KeyedVector,
    Material,
    PathLike,
    PlaneShape,
    PlasticOptions,
    Skin,
    SphereShape,
    VolumeMeasure,
    VolumeOptions,
)

__all__ = [
    "Body",
    "CacheFile",
    "ColliderMotion",
    "ForceField",
    "Hold",
    "Lattice",
    "Mesh",
    "Recording",
    "Simulation",
    "__version__",
    "body_keys",
    "check_collider",
    "film",
    "load_scene",
    "main",
    "read_obj",
    "reference_goals",
    "rotation_matrix",
    "rotations",
    "run",
    "simd_level",
    "step_all",
]
__version__: str

_Float = TypeVar("_Float", np.float32, np.float64)

class _PlaneLike(Protocol):
    @property
    def point(self) -> Any: ...
    @property
    def normal(self) -> Any: ...

class _MeshLike(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...

class _Open3dMesh(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def triangles(self) -> Any: ...

class _MeshioMesh(Protocol):
    @property
    def points(self) -> Any: ...
    @property
    def cells_dict(self) -> Any: ...

class _PyvistaMesh(Protocol):
    @property
    def points(self) -> Any: ...
    @property
    def faces(self) -> Any: ...

_MeshObject: TypeAlias = Trimesh | Scene | _MeshLike | _Open3dMesh | _MeshioMesh | _PyvistaMesh
_MeshArgument: TypeAlias = Mesh | PathLike | _MeshObject

@final
class Mesh:
    """A surface mesh: vertices and polygons.

    Mesh(vertices, faces)

    vertices : (n, 3) float
        Positions, finite. Vertices at exactly the same position are welded: they move together.
    faces : (m, 3) or (m, 4) int, or a list of faces of any size
        Vertex indices of each face, from 0, counter-clockwise seen from outside.

    Open, non-manifold, flipped and self-intersecting surfaces are valid. Raises MeshError for an index out of
    range, a position that is not finite, a mesh without faces or a mesh without extent.
    """
    def __new__(cls, vertices: ArrayLike, faces: ArrayLike | Sequence[Sequence[int]]) -> Mesh: ...
    @staticmethod
    def from_trimesh(mesh: _MeshArgument) -> Mesh:
        """Return the mesh of an object of another library; of a trimesh.Scene all meshes, at their places in the scene.

        mesh : trimesh.Trimesh, trimesh.Scene, meshio.Mesh, open3d.geometry.TriangleMesh, pyvista.PolyData, an object with
            vertices and faces, or a path

        The order of the vertices and faces is kept. Texture coordinates, materials and colors of trimesh are kept for
        Body.to_trimesh. A mesh argument, such as that of Body, may also be the object itself.
        """
    @property
    def vertices(self) -> NDArray[np.float64]:
        """Vertex positions in input order: (n, 3) float64, read-only."""
    @property
    def faces(self) -> NDArray[np.int64]:
        """Triangles: (m, 3) int64, read-only. Larger faces are fans from their first vertex, or ears if they are concave."""
    @property
    def volume(self) -> float:
        """Enclosed volume, never negative. The volume of an open mesh is not meaningful."""
    @property
    def is_closed(self) -> bool:
        """Whether the surface is closed: after welding equal positions, the directed uses of each edge cancel."""
    @property
    def groups(self) -> dict[str, NDArray[np.int64]]:
        """Named groups of vertices: dict of name to (k,) int64 array, in increasing order. A mesh from a file has those of the
        objects, groups and materials of the file. Body.pin(group=...) and its like select by them.
        """
    @property
    def maps(self) -> dict[str, NDArray[np.float64]]:
        """Numbers of the vertices by name: dict of name to (n,) float64 array. A mesh from a file has the colors of its vertices
        ("red", "green", "blue", "alpha", in [0, 1]) and other numbers of GLB and PLY. Body.pin(map=...) and its like take
        them as weights.
        """
    @property
    def bounds(self) -> NDArray[np.float64]:
        """Bounding box of the vertices that faces use: (2, 3) float64, the minimum and maximum corners."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    @classmethod
    def _restore(cls, data: bytes, visual: Any = None) -> Mesh: ...

def read_obj(path: PathLike, object: str | None = None) -> Mesh:
    """Read a mesh from an OBJ, GLB, glTF, STL or PLY file.

    path : str or os.PathLike
        The content of the file determines its format.
    object : str, optional
        Reads only the object or group with this name: of an `o` or `g` statement, a node of glTF or a solid of STL.

    Raises FileNotFoundError or another OSError for a file that cannot be read, and MeshError, with file and
    line or element, for an invalid mesh.
    """

@final
class Lattice:
    """A lattice of cubic cells. The corners of the cells are the simulated vertices.

    Create a lattice with Lattice.from_mesh or Lattice.from_cells. Vertices and cells are sorted by z, then y,
    then x; arrays with one row per vertex or cell have this order. len(lattice) is the number of vertices.
    """
    @classmethod
    def from_mesh(
        cls,
        mesh: _MeshArgument,
        *,
        vertices: int | None = None,
        cell_size: float | None = None,
        join: bool = True,
        memory_limit: int | None = None,
    ) -> Lattice:
        """Create the lattice of a mesh: the cells that the surface passes through or encloses.

        mesh : Mesh, path, an object with vertices and faces, or a mesh of trimesh, meshio, Open3D or PyVista
        vertices : int, default 1000
            Target number of lattice vertices, at least 8. The actual number is within 5 % of the target where
            the shape allows.
        cell_size : float
            Edge of a cell, > 0. Mutually exclusive with vertices.
        join : bool, default True
            Whether bridges of cells join separate parts. If False, each part is a separate component.
        memory_limit : int, default half of the machine's memory
            Limit in bytes of the memory of the lattice and a simulation of it.

        Raises LatticeError for a lattice that cannot be built or exceeds the memory limit, MeshError for an
        invalid mesh and ValueError for a value out of range.
        """
    @classmethod
    def from_cells(
        cls, cells: ArrayLike, cell_size: float = 1.0, origin: ArrayLike = (0, 0, 0), join: bool = True
    ) -> Lattice:
        """Create a lattice from an array of occupied cells.

        cells : (nx, ny, nz) bool
            True for occupied cells; the first axis is x.
        cell_size : float, default 1
            Edge of a cell, > 0.
        origin : (3,) float, default 0
            Position of the vertex with indices (0, 0, 0).
        join : bool, default True
            Whether bridges of cells join separate parts. If False, each part is a separate component.

        Raises LatticeError if no cell is occupied or a value is invalid.
        """
    @property
    def indices(self) -> NDArray[np.int64]:
        """Grid coordinates of the vertices: (n, 3) int64, read-only.

        If the lattice was created by from_cells, the vertex (0, 0, 0) is the corner of cells[0, 0, 0] with
        the smallest coordinates.
        """
    @property
    def rest_positions(self) -> NDArray[np.float64]:
        """Rest positions of the vertices, origin + cell_size * indices: (n, 3) float64, read-only."""
    @property
    def cells(self) -> NDArray[np.int64]:
        """Grid coordinates of the occupied cells: (m, 3) int64, read-only.

        The grid coordinates of a cell are the grid coordinates of its corner with the smallest coordinates.
        """
    @property
    def cell_corners(self) -> NDArray[np.int64]:
        """Vertices at the corners of the cells: (m, 8) int64, read-only. Corner i is at +x if i & 1, at +y if i & 2,
        and at +z if i & 4. Of a broken body, cells on the two sides of a crack have vertices of their own.
        """
    @property
    def cell_size(self) -> float:
        """Edge of a cell."""
    @property
    def origin(self) -> NDArray[np.float64]:
        """Position of the vertex with indices (0, 0, 0): (3,) float64."""
    @property
    def component_count(self) -> int:
        """Number of connected components of the graph of lattice vertices and links."""
    def __len__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @classmethod
    def _restore(cls, data: bytes) -> Lattice: ...

@final
class Body:
    """A soft body: a lattice with a material and a state, and the mesh that the lattice deforms.

    shape : Mesh, Lattice, path, an object with vertices and faces, or a mesh of trimesh, meshio, Open3D or PyVista
        Path of an OBJ, GLB, glTF, STL or PLY file, or of an OFF or 3MF file, which trimesh reads. A body from a Lattice
        has no mesh to display.
    name : str, default "body"
    object : str
        If the shape is a path: reads only the object or group with this name.
    scale : float or (3,) float, default 1
        Factor of the lengths of the shape, > 0, applied first; or, of a mesh, one for each of its axes, not 0, of which
        negative ones mirror it.
    refine : str, default "off"
        "auto": faces of the mesh that are larger than cells are divided, so that the surface bends between its vertices.
        The mesh of the body then has more vertices, after those of the given mesh.
    rotate : (3,), (4,) or (3, 3) float, or scipy Rotation, default 0
        Degrees about the fixed axes x, then y, then z; or a quaternion x, y, z, w, as in scipy; or a rotation matrix.
    translate : (3,) float, default 0
        Offset in scene units, applied last.
    rigid : bool, default False
        Whether the body is rigid: it moves with six degrees of freedom, and does not deform. Its mass and inertia are exact for
        a closed mesh, and those of the lattice for an open mesh and a Lattice. Arguments of soft bodies, from material to
        poisson_ratio, inflate, damping, plastic and fracture, and a volume measure exclude it.
    lattice_vertices : int, default 1000, and 300 if rigid; or cell_size : float
        Resolution of the lattice of a mesh: target number of vertices, at least 8, or edge of a cell, > 0.
    join : bool, default True
        Whether bridges of cells join separate parts of a mesh. If False, each part is a separate component.
    memory_limit : int, default half of the machine's memory
        Limit in bytes of the memory of the body.
    material : "jelly", "flesh" (default), "rubber" or "firm"; or youngs_modulus : float or keyframes
        What the body is made of. A named material keeps the shape of a body of any size under any gravity: its
        Young's modulus is k x density x L x max(g, 8 L/s^2), with k = 20, 80, 300 or 1500, the size L (cube root of
        the volume) and the gravity g, times (s/4)^(8/3) if the body is s > 4 times as long as it is wide.
        youngs_modulus: force per area in scene units, > 0, a number or keyframes as of inflate.
    half_width : 0.5 or int, default 2; or stiffness_radius : float
        In place of a material, the parameters of FastLSM. Half-width of the regions: in cells, at least 1, or 0.5 for
        regions of one cell; or as a length, > 0. Larger regions are stiffer.
    stiffness : float, default 1; or frequency : float
        Also in place of a material: alpha per step, in (0, 1], or the frequency of a vertex about its goal in Hz, > 0.
    accuracy : str, default "balanced"
        How the half-width of the regions is chosen for a material or youngs_modulus: "fast" (wide regions, narrower
        in thin bodies: the fewest steps), "balanced" (the least half-width with which a second of
        a scene takes at most 0.12 seconds, by an estimate; at most 1 in a body that is plastic or breaks by itself), or
        "exact" (regions of one cell: layers that are held or touched strain as the others do).
    poisson_ratio : float or keyframes
        In [0, 0.47]: stretched by the share s, the body becomes narrower by this times s. Default 0.45 for "jelly" and
        "flesh", 0.4 for "rubber", 0.3 for "firm", otherwise 0: it keeps its width.
        Steps are shorter for large ones: 2.6 times as many at 0.45.
    inflate : float or keyframes, default 1
        Ratio of the rest volume to that of the mesh, in [0.1, 10]: a number, a list of (time, value), or a dict with the keys
        keys and interpolation ("linear", "smooth" or "cubic"). The body grows or shrinks to it.
    damping_ratio : float or keyframes; or damping_rate : float
        Damping of the elastic modes; flight, spin, sliding and swinging are undamped. Damping ratio of the lowest
        mode, in [0, 1]; default 0.1 for "jelly", 0.3 for "flesh", otherwise 0.2. Or the rate in 1/s, >= 0, at which
        the amplitude of every mode decays.
    region_damping : float, default 0; or region_damping_rate : float
        Damping of the non-rigid velocity within regions: fraction removed per step, in [0, 1], or rate in
        1/s, >= 0.
    density : float, default 1000
        Mass per volume, > 0.
    plastic : dict or True, default None
        Makes the body plastic: parts that are strained beyond a limit keep a part of their deformation. A dict with the
        keys yield (strain, in (0, 1], beyond which it flows; default 0.05), creep (rate in 1/s, > 0, at which the
        strain beyond it becomes plastic; default 5) and max (greatest plastic strain, in (0, 2]; default 1); True for
        these defaults. The regions must be small beside the parts that are deformed.
    fracture : dict, default None
        Makes the body break. A dict with either strength (tensile stress, > 0, at which it breaks) or strain (tensile
        strain, > 0), and the keys rotation (degrees, in (0, 180], between neighboring cells at which it breaks too;
        default None), cracks (greatest number of cracks that grow at a time in each piece, from 1 to 1,000,000; default
        1), noise (relative variation of the limit, in [0, 0.5]; default 0.05), seed (of the noise; default 0) and
        surface (of the cracks: "smooth", the default, or "cells"). Arrays with one row per vertex grow when the body
        breaks: see topology_version.
    volume : str or dict, default "auto"
        Volume correction: "off", or the volume measure to preserve ("auto", "mesh", "cells" or "lattice"); or
        a dict with the keys measure, scope ("global", or "regional" to correct where the volume changed),
        field (deformation field of the correction: "auto", "surface", "cells" or "paper") and max_correction (cap of
        the scale, >= 0, as a fraction of the thickness of the body).
    skin : str, default "linear"
        How the mesh follows the lattice: "linear" (trilinear in each cell), or "smooth" (first derivatives are
        continuous across the faces of the cells, which reduces creases; trilinear where the lattice is bent or
        crushed very strongly).
    friction : float or keyframes, default 0.5
        Coulomb coefficient at other bodies, >= 0. That of two bodies is the geometric mean of theirs; at a collider,
        that of the collider holds.
    restitution : float, default 0
        Ratio of the speeds of the touching points after and before an impact on another body, in [0, 1]. That of two
        bodies is the greater of theirs; at a collider, that of the collider holds.
    rolling_resistance : float
        Coefficient of rolling resistance on colliders, >= 0: the greatest distance of the center of pressure of a contact from
        its middle, as a fraction of the radius of the contact. Default 0.08 times the damping ratio, or 0.016 with a damping_rate above 0.
    thickness : float, default 0
        Distance outside of the surface at which the body touches, in scene units, from 0 to half of the longest side of
        the body. Bodies rest at the sum of their thicknesses, and on a collider at the sum with its thickness.
    ignore : list of str, default empty
        Names of bodies that the body does not touch, whichever of the two names the other.
    self_contact : bool
        Whether parts of the body touch each other; by default the simulation decides.
    velocity : (3,) float, default 0
        Initial velocity in length/s.
    spin : (3,) float, default 0
        Initial angular velocity in rad/s about the center of mass.

    Arrays with one row per lattice vertex have the order of lattice.indices. A body belongs to at most one
    Simulation, and stays usable when it is in a Simulation. Raises ValueError for a value out of range,
    MeshError and LatticeError for an invalid mesh or lattice, and TypeError for a wrong type.
    """
    def __new__(
        cls,
        shape: _MeshArgument | Lattice,
        *,
        name: str = "body",
        object: str | None = None,
        scale: ArrayLike = 1.0,
        refine: Literal["off", "auto"] = "off",
        rotate: Rotate = (0, 0, 0),
        translate: ArrayLike = (0, 0, 0),
        rigid: bool = False,
        lattice_vertices: int | None = 1000,
        cell_size: float | None = None,
        join: bool = True,
        material: Material | None = "flesh",
        youngs_modulus: Curve | None = None,
        half_width: float | None = None,
        stiffness_radius: float | None = None,
        stiffness: float | None = None,
        frequency: float | None = None,
        accuracy: Accuracy = "balanced",
        poisson_ratio: Curve | None = None,
        inflate: Curve = 1.0,
        damping_ratio: Curve | None = None,
        damping_rate: float | None = None,
        region_damping: float | None = 0.0,
        region_damping_rate: float | None = None,
        density: float = 1000.0,
        plastic: PlasticOptions | bool | None = None,
        fracture: FractureOptions | None = None,
        volume: VolumeMeasure | VolumeOptions = "auto",
        skin: Skin = "linear",
        friction: Curve = 0.5,
        restitution: float = 0.0,
        rolling_resistance: float | None = None,
        thickness: float = 0.0,
        ignore: Iterable[str] = (),
        self_contact: bool | None = None,
        velocity: ArrayLike = (0, 0, 0),
        spin: ArrayLike = (0, 0, 0),
        memory_limit: int | None = None,
    ) -> Body: ...
    @property
    def name(self) -> str:
        """Name of the body, used in reports and file names."""
    @property
    def mesh(self) -> Mesh | None:
        """Mesh in the model's frame, at rest: after scale, before rotate and translate. None for a bare lattice. Of a
        broken body, the mesh of its pieces.
        """
    @property
    def lattice(self) -> Lattice:
        """Lattice in the model's frame: after scale, before rotate and translate. Of a broken body, the lattice of its
        pieces.
        """
    @property
    def simulation(self) -> Simulation | None:
        """Simulation of the body, which the body keeps alive. None outside a simulation."""
    @property
    def material(self) -> Material | None:
        """Name of the material: "jelly", "flesh", "rubber" or "firm". None if youngs_modulus or the regions are set.

        Settable; replaces youngs_modulus and the settings of the regions.
        """
    @material.setter
    def material(self, value: Material) -> None: ...
    @property
    def youngs_modulus(self) -> float:
        """Young's modulus, force per area in scene units (Pa if these are m, kg and s).

        In a simulation: the modulus in force. It is that of the material, or less if steps of this length cannot
        reach it; supple.MaterialWarning then tells both. Outside a simulation: the value that was set; raises
        ValueError if none was set, because it then depends on the gravity or the step length of a simulation.
        Settable, > 0, a number or keyframes (time, value); replaces material and the settings of the regions.
        """
    @youngs_modulus.setter
    def youngs_modulus(self, value: Curve) -> None: ...
    @property
    def half_width(self) -> float:
        """Half-width of the regions in cells: 0.5, so that each region is a cell, or a whole number of at least 1, at most the
        extent of the lattice.

        It is the value that was set. With a material or youngs_modulus, it is the one of the accuracy, or, if steps of the
        length that the simulation had when the body joined it are too long for that one, the least whole one that reaches
        Young's modulus; 2 outside a simulation. Settable; replaces stiffness_radius, material and youngs_modulus, and rebuilds the regions.
        """
    @half_width.setter
    def half_width(self, value: float) -> None: ...
    @property
    def stiffness_radius(self) -> float | None:
        """Half-width of the regions as a length, > 0; None unless it is set. Settable; replaces half_width, material
        and youngs_modulus.
        """
    @stiffness_radius.setter
    def stiffness_radius(self, value: float) -> None: ...
    @property
    def density(self) -> float:
        """Mass per volume, > 0. Settable: the masses change in proportion; Young's modulus stays the same."""
    @density.setter
    def density(self, value: float) -> None: ...
    @property
    def lowest_frequency(self) -> float:
        """Frequency of the lowest elastic mode of the body without pins, handles and colliders, in Hz, to 2 %.

        The first call computes the mode. Raises ValueError outside a simulation.
        """
    @property
    def volume(self) -> float:
        """Volume after the correction, in cubed scene units, never negative.

        The volume is by the measure of the correction or, with volume "off", by the measure that "auto" would
        choose.
        """
    @property
    def skin(self) -> Skin:
        """How the mesh follows the lattice: "linear" or "smooth"."""
    @property
    def friction(self) -> float:
        """Coulomb friction coefficient at other bodies, >= 0."""
    @property
    def restitution(self) -> float:
        """Coefficient of restitution at other bodies, in [0, 1]."""
    @property
    def ignore(self) -> tuple[str, ...]:
        """Names of bodies that the body does not touch: tuple of str."""
    @property
    def rolling_resistance(self) -> float:
        """Coefficient of rolling resistance on colliders, >= 0: the greatest distance of the center of pressure of a contact from its
        middle, as a fraction of the radius of the contact. Unless it is set, 0.08 times the damping ratio, or 0.016 with a
        damping_rate above 0.
        """
    @property
    def thickness(self) -> float:
        """Distance outside of the surface at which the body touches, in scene units, >= 0."""
    @property
    def self_contact(self) -> bool | None:
        """Whether parts of the body touch each other: bool, or None if the simulation decides."""
    @property
    def volume_options(self) -> VolumeOptions:
        """Options of the volume correction: a dict with measure, scope, field and max_correction.

        Settable to such a dict, the name of a measure, or "off". Setting the options rebuilds the correction.
        """
    @volume_options.setter
    def volume_options(self, value: VolumeMeasure | VolumeOptions) -> None: ...
    @property
    def fracture(self) -> FractureOptions | None:
        """Fracture: a dict with strength or strain, rotation, cracks, noise, seed and surface; None if the body breaks
        only where it is cut.
        """
    def cut(self, plane: _PlaneLike | PlaneShape) -> int:
        """Cut the body along a plane: break all joints between cells on different sides of it. Returns their number.

        plane : Plane, pair (point, normal), or dict with point and normal
            In world space. It is carried to the rest shape by the affine motion that fits the body best, so that it is
            met exactly where the body is not bent. The keyframes of a Plane have no effect.

        Vertices on the cut get copies, so that arrays with one row per lattice vertex or mesh vertex grow: see
        topology_version. Raises ValueError for a normal of zero.
        """
    @property
    def pieces(self) -> int:
        """Number of pieces: connected components of the lattice."""
    @property
    def broken_joints(self) -> int:
        """Number of broken joints. A joint is the common face of two cells."""
    @property
    def topology_version(self) -> int:
        """Number of steps and cuts in which joints broke.

        While it stays the same, so do faces, lattice, and the lengths of arrays. When it grows, the vertices of the whole
        body keep their numbers, in the lattice and in the mesh, and copies follow them. The numbers of copies can
        change each time. Restoring a state restores it too.
        """
    @property
    def faces(self) -> NDArray[np.int64]:
        """Triangles of the displayed surface as it is now: (m, 3) int64, read-only. Larger faces are fanned from their
        first vertex. The surfaces of cracks come last.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    @property
    def piece_of_vertex(self) -> NDArray[np.int64]:
        """Piece of each vertex of the displayed surface, from 0: (k,) int64, read-only. Pieces are numbered by their
        first lattice vertices.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    @property
    def plastic(self) -> PlasticOptions | None:
        """Plasticity: a dict with yield, creep and max; None if the body is elastic.

        Settable to such a dict, to True for its default values, or to None, from the next step on. None removes the
        plastic shapes, and the body returns to its rest shape; other values keep them.
        """
    @plastic.setter
    def plastic(self, value: PlasticOptions | bool | None) -> None: ...
    @property
    def plastic_strain(self) -> NDArray[np.float64]:
        """Plastic strain of the region around each vertex: (n,) float64, read-only. It is |S - 1|, the Frobenius norm,
        with the plastic shape S: 0 where the body has its rest shape, and everywhere without plasticity. If half_width is
        0.5, it is the mean of the cells around the vertex.
        """
    @property
    def plastic_shapes(self) -> NDArray[np.float64]:
        """Plastic shape S of the region around each vertex: (n, 3, 3) float64, read-only; if half_width is 0.5, of each cell:
        (m, 3, 3). It is a symmetric matrix of determinant 1, in the rest pose: the identity where the body has its rest shape, and everywhere without
        plasticity.
        """
    def reset_plastic(self) -> None:
        """Reset the plastic shapes: from the next step on, the body returns to its rest shape. Without plasticity,
        nothing changes.
        """
    @property
    def stiffness(self) -> float | None:
        """Stiffness alpha per step, in (0, 1]; None if a frequency, a material or youngs_modulus is set. Settable;
        replaces these.
        """
    @stiffness.setter
    def stiffness(self, value: float) -> None: ...
    @property
    def frequency(self) -> float | None:
        """Frequency of a vertex about its goal in Hz, > 0; None unless it is set. Settable; replaces stiffness,
        material and youngs_modulus.
        """
    @frequency.setter
    def frequency(self, value: float) -> None: ...
    @property
    def accuracy(self) -> Accuracy:
        """How the half-width of the regions is chosen for a material or youngs_modulus: "fast", "balanced" or "exact". Settable; the
        steps stay as long as they are.
        """
    @accuracy.setter
    def accuracy(self, value: Accuracy) -> None: ...
    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio, in [0, 0.47]: stretched by the share s, the body becomes narrower by this times s. Settable, a number or
        keyframes (time, value); None sets the one of the material.
        """
    @poisson_ratio.setter
    def poisson_ratio(self, value: Curve | None) -> None: ...
    @property
    def inflate(self) -> Any:
        """Ratio of the rest volume to that of the mesh, in [0.1, 10]: a float, or what keyframes were set. Settable: a number, a list
        of (time, value), or a dict with the keys keys and interpolation ("linear", "smooth" or "cubic").

        From the next step on the body grows or shrinks to it, and the volume correction keeps the volume of the mesh times
        this ratio. Zones have ratios of their own beside it.
        """
    @inflate.setter
    def inflate(self, value: Curve) -> None: ...
    @property
    def rest_volume_ratios(self) -> NDArray[np.float64]:
        """Ratios of the rest volume around each lattice vertex to that of the lattice, as of the last step: (n,) float64."""
    @property
    def damping_ratio(self) -> float | None:
        """Damping ratio of the lowest elastic mode, in [0, 1]; None if damping_rate is set. Settable; replaces
        damping_rate. Unless it is set, it is that of the material, and 0.2 without one.
        """
    @damping_ratio.setter
    def damping_ratio(self, value: float) -> None: ...
    @property
    def damping_rate(self) -> float | None:
        """Rate at which the elastic modes decay in 1/s, >= 0; None if damping_ratio is set. Settable; replaces
        damping_ratio.
        """
    @damping_rate.setter
    def damping_rate(self, value: float) -> None: ...
    @property
    def region_damping(self) -> float | None:
        """Region damping per step, in [0, 1]; None if a rate is set. Settable; replaces region_damping_rate."""
    @region_damping.setter
    def region_damping(self, value: float) -> None: ...
    @property
    def region_damping_rate(self) -> float | None:
        """Region damping as a rate in 1/s, >= 0; None if it is set per step. Settable; replaces region_damping."""
    @region_damping_rate.setter
    def region_damping_rate(self, value: float) -> None: ...
    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the lattice vertices: (n, 3) float64, a read-only copy.

        Assign a whole array to set them, or change entries with edit(). Velocities, pins and all other state
        are unchanged.
        """
    @positions.setter
    def positions(self, value: ArrayLike) -> None: ...
    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities of the lattice vertices in length/s: (n, 3) float64, a read-only copy.

        Assign a whole array to set them, or change entries with edit(). Positions, pins and all other state
        are unchanged.
        """
    @velocities.setter
    def velocities(self, value: ArrayLike) -> None: ...
    def edit(self) -> Edit:
        """Return a context manager for a change of single positions and velocities.

        It yields an object with the writable arrays positions and velocities: (n, 3) float64. At the end of
        the `with` block the arrays that differ from the state are written to the body, or nothing if the block
        raises an exception or an array has an invalid value.

            with body.edit() as state:
                state.positions[top, 1] += 0.1
        """
    @property
    def rotations(self) -> NDArray[np.float64]:
        """Rotation of the region around each vertex, from the rest pose, as of the last step: (n, 3, 3) float64,
        read-only. If half_width is 0.5, it is the mean of the cells around the vertex.
        """
    @property
    def masses(self) -> NDArray[np.float64]:
        """Masses of the lattice vertices: (n,) float64, read-only.

        A mass is density x cell_size^3 / 8 x the sum of the filled shares of the cells that share the vertex. The
        filled share of a cell is the part of it inside the mesh, at least 0.05; 1 with an open mesh and for a bare
        lattice.
        """
    @property
    def mass(self) -> float:
        """Mass: the sum of masses."""
    @property
    def center_of_mass(self) -> NDArray[np.float64]:
        """Center of mass: (3,) float64, read-only."""
    @property
    def pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rigid motion that fits the body best: a tuple of rotation (3, 3) and translation (3,), float64, read-only.

        It moves the mesh as it was given, after scale, close to its present place: mesh.vertices @ rotation.T +
        translation. At frame 0 it is the rotation and the translation of the body's placement.
        """
    @property
    def linear_momentum(self) -> NDArray[np.float64]:
        """Linear momentum in mass x length/s: (3,) float64, read-only."""
    @property
    def angular_momentum(self) -> NDArray[np.float64]:
        """Angular momentum about the center of mass in mass x length^2/s: (3,) float64, read-only."""
    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy in mass x length^2/s^2.

        Velocities are those of the middle of the last step, and positions those of its end. So the sum of the
        energies of an undamped body oscillates by the fraction dt x omega / 2, with the greatest angular frequency
        omega of its motion.
        """
    @property
    def elastic_energy(self) -> float:
        """Elastic energy in mass x length^2/s^2: the work that the elastic forces give back when the body returns to
        its shape. Raises ValueError outside a simulation.
        """
    @property
    def gravity_energy(self) -> float:
        """Energy in the gravity field, -mass gravity . center_of_mass, in mass x length^2/s^2: zero at the world
        origin. Raises ValueError outside a simulation.
        """
    @property
    def is_rigid(self) -> bool:
        """Whether the body is rigid: the argument rigid."""
    @property
    def is_asleep(self) -> bool:
        """Whether the body sleeps: it came to rest and is not stepped until something moves it, or wake() is called.

        A body falls asleep if every vertex was nearly still for half a second while the body was held or rested on a
        collider. See the argument sleep of Simulation.
        """
    def wake(self) -> None:
        """Wake the body up. It falls asleep again after half a second of rest."""
    @overload
    def lattice_positions(self, out: None = None) -> NDArray[np.float64]:
        """Copy the positions of the lattice vertices: (n, 3), as the attribute positions, and into a given array.

        out : (n, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.
        """
    @overload
    def lattice_positions(self, out: NDArray[_Float]) -> NDArray[_Float]:
        """Copy the positions of the lattice vertices: (n, 3), as the attribute positions, and into a given array.

        out : (n, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.
        """
    @overload
    def lattice_velocities(self, out: None = None) -> NDArray[np.float64]:
        """Copy the velocities of the lattice vertices in length/s: (n, 3), as the attribute velocities, and into a given
        array.

        out : (n, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.
        """
    @overload
    def lattice_velocities(self, out: NDArray[_Float]) -> NDArray[_Float]:
        """Copy the velocities of the lattice vertices in length/s: (n, 3), as the attribute velocities, and into a given
        array.

        out : (n, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.
        """
    def goals(self) -> NDArray[np.float64]:
        """Compute the goal positions at the current positions, without advancing time: (n, 3) float64."""
    def corrected_positions(self) -> NDArray[np.float64]:
        """Compute the lattice positions after the volume correction: (n, 3) float64.

        Without a correction, returns the positions before the correction. All positions are rounded to
        float32 relative to the origin of the body, as for the displayed surface.
        """
    @overload
    def surface(self, out: None = None) -> NDArray[np.float64]:
        """Evaluate the displayed surface, after the volume correction: (k, 3), mesh vertices in input order. When the
        body breaks, further vertices follow: see faces and topology_version.

        out : (k, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    @overload
    def surface(self, out: NDArray[_Float]) -> NDArray[_Float]:
        """Evaluate the displayed surface, after the volume correction: (k, 3), mesh vertices in input order. When the
        body breaks, further vertices follow: see faces and topology_version.

        out : (k, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    @overload
    def surface_normals(self, out: None = None) -> NDArray[np.float64]:
        """Evaluate the unit normals of the displayed surface: (k, 3).

        A normal is zero if all faces of its vertex are degenerate.

        out : (k, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    @overload
    def surface_normals(self, out: NDArray[_Float]) -> NDArray[_Float]:
        """Evaluate the unit normals of the displayed surface: (k, 3).

        A normal is zero if all faces of its vertex are degenerate.

        out : (k, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    @overload
    def surface_velocities(self, out: None = None) -> NDArray[np.float64]:
        """Evaluate the velocities of the vertices of the surface in scene units per second: (k, 3).

        They are the velocities of the lattice by the weights of the skin. The motion of the volume correction relative to
        the lattice is not in them.

        out : (k, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    @overload
    def surface_velocities(self, out: NDArray[_Float]) -> NDArray[_Float]:
        """Evaluate the velocities of the vertices of the surface in scene units per second: (k, 3).

        They are the velocities of the lattice by the weights of the skin. The motion of the volume correction relative to
        the lattice is not in them.

        out : (k, 3) float32 or float64, optional
            Array to write to and return. Default: a new float64 array.

        Raises ValueError for a bare lattice, which has no mesh.
        """
    def volume_report(self) -> VolumeReport:
        """Return a VolumeReport: the volume by each measure at rest, before and after the correction."""
    def to_trimesh(self, *, uv: bool = False) -> Trimesh:
        """Return the displayed surface as a trimesh.Trimesh.

        uv : bool, default False
            Whether the mesh has the texture coordinates and materials of the model file from which the body was read. A
            vertex with several texture coordinates is then several vertices, as in trimesh itself, and the vertex
            attribute "input_vertex" of the result is the index of each vertex in input order. The file is read again.

        Without uv, vertices are in input order. Faces with more than three corners are fanned into triangles. A body of
        a trimesh.Trimesh or of a file that trimesh reads keeps texture coordinates, materials and colors, and ignores
        uv. Needs trimesh (`pip install trimesh`). Raises ValueError for a bare lattice, which has no mesh, and
        MeshError if uv needs a file that has changed.
        """
    @property
    def _visual(self) -> Any: ...
    def _appearance(self) -> tuple[Any, ...] | None: ...
    def show(self) -> None:
        """Open a viewer window with the simulation of the body, or with only the body if it is not in a
        simulation: see supple.view.
        """
    def pin(
        self,
        *,
        box: BoxShape | None = None,
        sphere: SphereShape | None = None,
        plane: PlaneShape | None = None,
        vertices: ArrayLike | None = None,
        mesh_vertices: ArrayLike | None = None,
        group: str | None = None,
        map: ArrayLike | str | None = None,
        at: Literal["now", "start"] = "now",
        start: float = 0.0,
        end: float | None = None,
        weight: Curve = 1.0,
        goal_frequency: float = 5.0,
        goal_damping: float = 0.2,
    ) -> Hold:
        """Pin a part of the body: fix the part in the pose that it has at `start`. Returns a Hold.

        Exactly one of box, sphere, plane, vertices, mesh_vertices, group and map selects the part. A shape is in world space,
        and selects the corners of every cell that contains a mesh vertex inside the shape. On a bare lattice a shape selects the lattice
        vertices inside the shape.

        box : ((3,), (3,))
            Minimum and maximum corner.
        sphere : ((3,), float)
            Center and radius.
        plane : ((3,), (3,))
            Point and normal: selects the side that the normal points to.
        vertices : (k,) int, or (n,) bool
            Lattice vertices: indices, or a mask, also one of whole numbers 0 and 1.
        mesh_vertices : (k,) int, or (n,) bool
            Vertices of the mesh, in input order: selects the corners of their cells.
        group : str
            Name of a group of the mesh (Mesh.groups): selects as its mesh vertices do.
        map : (n,) float in [0, 1], (n,) bool, or str
            A weight for each mesh vertex, or the name of a map of the mesh (Mesh.maps): a factor of `weight` at each lattice
            vertex, see weights. Vertices with 1 are held, those below are pulled by springs, and those below 0.01 are free.
        at : "now" or "start", default "now"
            Pose of the body in which a shape selects: the current one, or that of frame 0.
        start, end : float, default 0 and None
            Time window of the pin in seconds. Without end the pin stays active.
        weight : float, or list of (time, value), default 1
            In (0, 1]. Below 1 the part is not held, but each vertex is pulled to its place by a spring of the frequency
            goal_frequency x sqrt(weight / (1 - weight)), the same at any step length and on any lattice.
        goal_frequency : float, default 5
            Frequency in Hz, above 0, that a weight of 0.5 gives.
        goal_damping : float, default 0.2
            Damping ratio of the springs, in [0, 1].

        Parts may overlap: of the pins and handles that are active, the one that was added last moves the
        common vertices, and when it ends, the one before it moves them again.

        Raises ValueError for an empty selection; the message gives the distance to the nearest vertex.
        """
    def handle(
        self,
        *,
        keys: Iterable[Key] | None = None,
        interpolation: Interpolation = "linear",
        follow: ArrayLike | PathLike | None = None,
        follow_fps: float = 30.0,
        follow_start: float | None = None,
        box: BoxShape | None = None,
        sphere: SphereShape | None = None,
        plane: PlaneShape | None = None,
        vertices: ArrayLike | None = None,
        mesh_vertices: ArrayLike | None = None,
        group: str | None = None,
        map: ArrayLike | str | None = None,
        at: Literal["now", "start"] = "now",
        start: float = 0.0,
        end: float | None = None,
        weight: Curve = 1.0,
        goal_frequency: float = 5.0,
        goal_damping: float = 0.2,
    ) -> Hold:
        """Move a part of the body along keyframes, or with an animated mesh. Returns a Hold. Exactly one of keys and
        follow is given.

        keys : list of (time, translate, rotate), or of dicts with these names
            Keyframes, relative to the pose that the part has at `start`. time: seconds, strictly increasing.
            translate: (3,) length, default 0. rotate: (3,) degrees about the fixed axes x, then y, then z
            through the mean position of the selected lattice vertices at `start`, default 0; or a quaternion x, y, z,
            w, a rotation matrix or a scipy Rotation, which become the angles nearest to those of the keyframe before.
        interpolation : "linear", "smooth" or "cubic", default "linear"
            How translations and angles go from one keyframe to the next: "linear", with constant velocity; "smooth",
            from rest to rest; "cubic", through the keyframes with a continuous velocity and without overshoot.

        follow : (f, n, 3) float, or path of a PC2 file
            Positions of the n vertices of the body's mesh at f times: the animation replaces the coordinates of the
            mesh that the body was built from, so that its scale, rotate and translate apply to the animation also. The
            selected lattice vertices move rigidly with the mesh vertices around them that a shape contains, or with
            those of the whole mesh if `vertices` selects the part. Between two frames the mesh moves linearly, before
            the first and after the last frame it is at rest. The part is at the animation's place at any time: it jumps
            at `start` if the body is elsewhere then.
        follow_fps : float, > 0, default 30
            Frames per second of the animation.
        follow_start : float, default 0, or the time of the first sample in the PC2 file
            Time of the first frame in seconds.

        The other arguments and the errors are the same as for pin, except that shapes select at frame 0 with follow.
        Raises ValueError for an animation of another shape,
        and for follow on a broken body.
        """
    @property
    def holds(self) -> tuple[Hold, ...]:
        """Pins and handles that were not released, in the order in which they were added: tuple of Hold.

        Pins and handles of a scene come first: the pins of the body, then its handles.
        """
    def zone(
        self,
        factor: float = 1.0,
        *,
        inflate: Curve | None = None,
        density_factor: float = 1.0,
        strength_factor: float = 1.0,
        damping_factor: float = 1.0,
        friction_factor: float = 1.0,
        yield_factor: float = 1.0,
        box: BoxShape | None = None,
        sphere: SphereShape | None = None,
        plane: PlaneShape | None = None,
        vertices: ArrayLike | None = None,
        mesh_vertices: ArrayLike | None = None,
        group: str | None = None,
        map: ArrayLike | str | None = None,
        at: Literal["now", "start"] = "now",
    ) -> None:
        """Multiply the Young's modulus of a part of the body by a factor, its rest volume by a ratio, or another quantity by a
        factor, from the next step on.

        Around a shape the logarithms of all decrease linearly to 0 over the length of a cell. With a map, a factor f counts as
        f^w at the weight w. The factors of overlapping zones multiply.

        factor : float, default 1
            In (0, 100], and so are the products of overlapping zones.
        inflate : float, or keyframes
            As of Body; the products of overlapping zones are limited to [0.1, 10].
        density_factor, strength_factor, damping_factor, friction_factor, yield_factor : float, default 1
            In (0, 100], and so are the products: of the density, of the limit at which the body breaks (fracture), of the rate
            of damping_ratio or damping_rate, of the coefficient of friction at colliders and bodies, and of the yield strain
            (plastic).
        box, sphere, plane, vertices, mesh_vertices, group, map, at :
            As for pin, but a shape selects the lattice vertices inside it, whether or not it contains mesh vertices.

        Raises ValueError if the shape contains no lattice vertex, for a strength_factor of a body without fracture, and for a
        yield_factor of a body that is not plastic.
        """
    @property
    def stiffness_factors(self) -> NDArray[np.float64] | None:
        """Stiffness factors of the lattice vertices: (n,) float64, read-only; None if the stiffness does not vary."""
    def weights(self, map: ArrayLike | str) -> NDArray[np.float64]:
        """Weights of the lattice vertices for a map of the mesh: (n,) float64.

        A vertex of a cell that the surface meets has the mean of the map over the surface around it, with the area and the
        trilinear weight of the vertex in its cell; in a face the map is linear. Any other vertex has the mean of its
        neighbors, so that a map that is linear in space stays linear inside. The weights depend on neither the size nor the
        order of the faces. The vertices of the map are those of the mesh of the body before it broke.

        map : (m,) float in [0, 1], (m,) bool, or str
            A weight for each mesh vertex, or the name of a map of the mesh (Mesh.maps).

        Raises ValueError for a name that the mesh does not have, a weight out of range, and a bare lattice.
        """
    def set_stiffness_factors(self, factors: ArrayLike | None) -> None:
        """Set the stiffness factors, from the next step on: the Young's modulus around each lattice vertex is that of
        the body times the factor of the vertex.

        Parts that are smaller than the regions, 2 x half_width + 1 vertices wide, are mixed with their surroundings. In
        a simulation, half_width is fixed again at the next step, for the greatest factor.

        factors : (n,) float, or None
            In (0, 100]; factors below 1e-6 act as 1e-6. None removes all factors, also those of zones.
        """
    def apply_force(
        self,
        force: ArrayLike,
        *,
        box: BoxShape | None = None,
        sphere: SphereShape | None = None,
        plane: PlaneShape | None = None,
        vertices: ArrayLike | None = None,
        mesh_vertices: ArrayLike | None = None,
        group: str | None = None,
        map: ArrayLike | str | None = None,
        at: Literal["now", "start"] = "now",
        point: ArrayLike | None = None,
        torque: ArrayLike | None = None,
        duration: float | None = None,
    ) -> None:
        """Apply a force in all steps of the next call of step or advance. Several forces add up.

        force : (3,) or (k, 3) float
            In kg length/s^2. (3,): the total force, which is distributed over the selected lattice vertices such that they
            would be accelerated like a rigid body: without point and torque, in proportion to their masses. (k, 3): one
            force for each of the k selected vertices, in the order of the indices `vertices`, otherwise in increasing
            order; without point and torque.
        box, sphere, plane, vertices, mesh_vertices, group, map, at
            Selection of a part, as for pin. Default: the whole body, k = n.
        point : (3,) float, optional
            World point at which the total force acts. Default: the center of mass of the part.
        torque : (3,) float, optional
            Torque about the center of mass of the part, in kg length^2/s^2, besides that of the force.
        duration : float, optional
            Seconds, above 0, for which the force acts. In a last step that is longer than the rest of the time it is as
            much smaller: the whole impulse is force x duration. Default: the next call of step(n) or advance(n), however
            long it is.

        Raises ValueError for an empty selection, a force that accelerates by more than 1e15 cells/s^2, or a torque about
        the line on which all selected vertices lie.
        """
    def apply_impulse(
        self,
        impulse: ArrayLike,
        *,
        box: BoxShape | None = None,
        sphere: SphereShape | None = None,
        plane: PlaneShape | None = None,
        vertices: ArrayLike | None = None,
        mesh_vertices: ArrayLike | None = None,
        group: str | None = None,
        map: ArrayLike | str | None = None,
        at: Literal["now", "start"] = "now",
        point: ArrayLike | None = None,
        torque: ArrayLike | None = None,
    ) -> None:
        """Apply an impulse in the next step: the momentum changes by it, whatever the length of the step.

        impulse : (3,) or (k, 3) float
            In kg length/s, distributed like the force of apply_force.
        box, sphere, plane, vertices, mesh_vertices, group, map, at
            Selection of a part, as for pin. Default: the whole body, k = n.
        point : (3,) float, optional
            World point at which the total impulse acts. Default: the center of mass of the part.
        torque : (3,) float, optional
            Angular impulse about the center of mass of the part, in kg length^2/s, besides that of the impulse.

        Raises ValueError as apply_force does.
        """
    def add_force_field(
        self,
        force: ArrayLike | Callable[[NDArray[np.float64], NDArray[np.float64], float], ArrayLike],
        *,
        box: BoxShape | None = None,
        sphere: SphereShape | None = None,
        plane: PlaneShape | None = None,
        vertices: ArrayLike | None = None,
        mesh_vertices: ArrayLike | None = None,
        group: str | None = None,
        map: ArrayLike | str | None = None,
        at: Literal["now", "start"] = "now",
    ) -> ForceField:
        """Apply a force in every step, until the field is removed. Returns a ForceField.

        force : (3,) or (k, 3) float, or callable
            A constant force as for apply_force; or a function force(positions, velocities, time) that returns it. It is
            called before each step, with the (k, 3) positions and velocities of the selected lattice vertices,
            read-only, and the time in seconds.
        box, sphere, plane, vertices, mesh_vertices, group, map, at
            Selection of a part, as for pin. Default: the whole body. It is made once, now.

        A field follows a body that breaks: it acts on all copies of its vertices, and k grows. A vertex and its copies
        share a constant force (k, 3) on the vertex in proportion to their masses. A function gets the rows of the
        selected vertices first, then those of their copies in increasing order, and returns one force for each.

        Several fields add up, with apply_force too. A body falls asleep under forces that stay the same, to a
        thousandth of the weight on each vertex, and wakes when they change. A function is called from step and advance,
        which let an exception pass: the step then is not made. Each step with fields takes some microseconds more, with
        a function some tens of microseconds for 1,000 lattice vertices. Pickles and copies contain fields, states of
        save_state do not.
        """
    @property
    def force_fields(self) -> tuple[ForceField, ...]:
        """Force fields that were not removed, in the order in which they were added: tuple of ForceField."""
    def __len__(self) -> int: ...
    def _repr_html_(self) -> str: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def _set_state(self, positions: ArrayLike | None, velocities: ArrayLike | None) -> None: ...
    @staticmethod
    def _of(simulation: Simulation, index: bytes) -> Body: ...
    @staticmethod
    def _restore(shape: Mesh | Lattice, data: bytes) -> Body: ...

@final
class ForceField:
    """A force that acts on a body in every step. Body.add_force_field returns it, and Body.force_fields lists those
    that were not removed.
    """
    @property
    def body(self) -> Body:
        """Body on which the force acts."""
    @property
    def force(self) -> NDArray[np.float64] | Callable[[NDArray[np.float64], NDArray[np.float64], float], ArrayLike]:
        """Force as it was given: (3,) or (k, 3) float64, read-only, or a callable. k is the number of vertices then."""
    @property
    def vertices(self) -> NDArray[np.int64]:
        """Lattice vertices on which the force acts: (k,) int64, read-only. Copies that a break made come last."""
    @property
    def removed(self) -> bool:
        """Whether the field was removed."""
    def remove(self) -> None:
        """Remove the field, from the next step on. A second call has no effect."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Hold:
    """A pin or a handle of a body.

    Body.pin and Body.handle return it, and Body.holds lists those that were not released. A Hold is pickled
    together with its body. Only active, body, release and released can be used after a release.
    """
    @property
    def body(self) -> Body:
        """Body that the pin or handle belongs to."""
    @property
    def vertices(self) -> NDArray[np.int64]:
        """Lattice vertices, in increasing order: (k,) int64, read-only."""
    @property
    def keys(self) -> tuple[tuple[float, tuple[float, float, float], tuple[float, float, float]], ...] | None:
        """Keyframes of a handle: tuple of (time, translate, rotate). None for a pin and for an animation. Replace them
        with set_keys.
        """
    @property
    def interpolation(self) -> Interpolation | None:
        """Interpolation between the keyframes of a handle: "linear", "smooth" or "cubic". None for a pin and for an
        animation.
        """
    @property
    def follow(self) -> NDArray[np.float32] | None:
        """Positions of the animation that a handle follows: (f, n, 3) float32, read-only. None for a pin and for
        keyframes.
        """
    @property
    def follow_fps(self) -> float | None:
        """Frames per second of the animation that a handle follows, or None."""
    @property
    def follow_start(self) -> float | None:
        """Time in seconds of the first frame of the animation that a handle follows, or None."""
    @property
    def active(self) -> bool:
        """Whether the pin or handle acted in the last step."""
    @property
    def released(self) -> bool:
        """Whether the pin or handle was released."""
    @property
    def start(self) -> float:
        """Start of the time window in seconds."""
    @property
    def end(self) -> float | None:
        """End of the time window in seconds, or None.

        A pin or handle whose window has ended acts again if the time of the simulation is set back.
        """
    @property
    def weight(self) -> float | list[tuple[float, float]] | dict[str, Any]:
        """Weight of a soft goal: a number, a list of (time, value), or a dict with the keys keys and interpolation; 1 if the
        positions are prescribed.
        """
    @property
    def force(self) -> NDArray[np.float64]:
        """Force that the pin or handle exerts on the body in the next step, in mass x length/s^2: (3,) float64,
        read-only.

        It is what the held part needs, beside the elastic forces and gravity, to move as prescribed; zero if the pin or
        handle did not act in the last step. The reaction of the elastic damping is included, contacts, external forces
        on the held part and region damping are not. Where keyframes change the velocity, the force is that of the
        change within one step. Computing it takes as long as a step. Raises ValueError outside a simulation.
        """
    @property
    def torque(self) -> NDArray[np.float64]:
        """Torque that belongs to force, about the mean position of the lattice vertices of the pin or handle, in
        mass x length^2/s^2: (3,) float64, read-only.
        """
    def release(self) -> None:
        """Release the part permanently, from the next step on. A second call has no effect.

        A released pin or handle takes no memory and no time. One whose window has ended does.
        """
    def set_keys(self, keys: Iterable[Key], interpolation: Interpolation | None = None) -> None:
        """Replace the keyframes, from the next step on. A pin that gets keyframes becomes a handle. A handle that
        followed an animation moves along them from the pose that the part has before the next step.

        keys : list of (time, translate, rotate), as for Body.handle
            Relative to the pose that the part had when the pin or handle became active.
        interpolation : "linear", "smooth" or "cubic", optional
            Default: as before, "linear" for a pin.

        Raises ValueError if the pin or handle was released.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _of(body: Body, index: bytes) -> Hold: ...

@final
class ColliderMotion:
    """The motion of a collider of a simulation. The methods of supple.Collider call its methods."""
    def move_to(self, translate: ArrayLike, rotate: Rotate, duration: float | None) -> None:
        """See supple.Collider.move_to."""
    def set_enabled(self, value: object) -> Enabled:
        """Enable or disable the collider: True, False or keyframes. Return the value that Collider.enabled has then."""
    @property
    def is_enabled(self) -> bool:
        """See supple.Collider.is_enabled."""
    @property
    def translation(self) -> NDArray[np.float64]:
        """See supple.Collider.translation."""
    @property
    def rotation(self) -> NDArray[np.float64]:
        """See supple.Collider.rotation."""
    @property
    def velocity(self) -> NDArray[np.float64]:
        """See supple.Collider.velocity."""
    @property
    def spin(self) -> NDArray[np.float64]:
        """See supple.Collider.spin."""
    @property
    def force(self) -> NDArray[np.float64]:
        """See supple.Collider.force."""

@final
class Simulation:
    """A simulation of bodies that touch colliders and each other.

    bodies : list of Body, or one Body
        The bodies move into this simulation and stay usable. A body belongs to at most one simulation.
    dt : float, default 1/60; or fps : float
        Length of a step in seconds, from 1e-12 to 1e6, or number of frames per second, > 0. With fps, dt is
        1 / (fps x steps per frame).
    substeps : int or "auto", default "auto" with fps, otherwise 1
        Number of steps per frame, at least 1. "auto" needs fps: the least number, at most 1000, with which bodies
        reach their material and fast motions are resolved. It is chosen at the first step and then stays the same. The
        volume correction of the displayed surface uses the contacts and external forces of all steps since the
        frame began.
    gravity : (3,) float, or keyframes, default (0, -9.81, 0)
        In scene units per second squared, each component at most 1e12 in magnitude. Keyframes are a list of
        (time, value), or a dict with keys and interpolation, as for inflate of Body. Where a material or a number of
        steps depends on gravity, the greatest one counts.
    colliders : list of Plane, Sphere, Box, Capsule, MeshCollider, or one of them
        Default: no colliders.
    fields : list of dict, or one dict
        Wind, drag and other accelerations, with the keys of [[field]] in a scene. Default: no fields.
    links : list of dict, or one dict
        Glue and springs between bodies, with the keys of [[link]] in a scene. Default: no links.
    threads : int, default 0
        Number of threads, at most 1024; 0 means one per processor. Results are bit-identical for any number
        of threads.
    contact : bool, default True
        Whether bodies touch each other. Pairs can be left out by Body(ignore=...).
    self_contact : bool, default False
        Whether parts of a body touch each other, for bodies that do not say so themselves.
    sleep : bool, default True
        Whether bodies at rest fall asleep: they are then not stepped until something moves them.

    sim["name"] is the body with this name, `"name" in sim` says whether there is one; len(sim) is the number of bodies, and
    iteration gives them. Bodies that overlap at the start are pushed apart by the first steps, and
    supple.ContactWarning names them.

    If steps are too long for the material of a body, the body is softer, and the first step warns with
    supple.MaterialWarning.

    Raises ValueError for a number out of range or a body that belongs to another simulation.
    """
    def __init__(
        self,
        bodies: Iterable[Body] | Body,
        *,
        dt: float | None = 0.016666666666666666,
        fps: float | None = None,
        substeps: int | Literal["auto"] | None = None,
        gravity: ArrayLike | KeyedVector = (0, -9.81, 0),
        colliders: Iterable[Collider] | Collider = (),
        fields: Iterable[Mapping[str, Any]] | Mapping[str, Any] = (),
        links: Iterable[Mapping[str, Any]] | Mapping[str, Any] = (),
        threads: int = 0,
        contact: bool = True,
        self_contact: bool = False,
        sleep: bool = True,
    ) -> None: ...
    @property
    def bodies(self) -> tuple[Body, ...]:
        """Bodies, in the given order: tuple of Body."""
    @property
    def dt(self) -> float:
        """Length of a step in seconds, from 1e-12 to 1e6.

        Settable without fps; the time stays the same. With fps it is 1 / (fps x steps_per_frame): set substeps.
        """
    @dt.setter
    def dt(self, value: float) -> None: ...
    @property
    def time(self) -> float:
        """Time in seconds. Settable.

        The time windows of pins and handles and the keyframes of handles and colliders refer to this time. The
        motion of Collider.move_to does not.
        """
    @time.setter
    def time(self, value: float) -> None: ...
    @property
    def gravity(self) -> NDArray[np.float64]:
        """Gravity in force, that of the current time, in scene units per second squared: (3,) float64. Settable, to a vector or
        keyframes.
        """
    @gravity.setter
    def gravity(self, value: ArrayLike | KeyedVector) -> None: ...
    @property
    def links(self) -> tuple[dict[str, Any], ...]:
        """Links between bodies: tuple of dict, with the keys of [[link]] in a scene, and force and broken.

        force, (3,) float64, is the force of the link on its body in the last step, in kg length/s^2, zero after
        restore_state; the other body has the opposite one. broken tells whether the link is broken.
        """
    @property
    def fields(self) -> tuple[dict[str, Any], ...]:
        """Fields of acceleration: tuple of dict, with the keys of [[field]] in a scene: one of gravity, wind, drag, vortex and
        attract; strength, bodies; and box, sphere or plane.

        Settable, to a list of dicts; effective from the next step on. Keyframes of a strength are also taken as tuples
        (time, value).
        """
    @fields.setter
    def fields(self, value: Iterable[Mapping[str, Any]] | Mapping[str, Any]) -> None: ...
    @property
    def colliders(self) -> tuple[Collider, ...]:
        """Colliders: tuple of Plane, Sphere, Box, Capsule, MeshCollider. Move one with colliders[i].move_to(translate,
        rotate).

        The colliders are copies of those that were given, equal to them, and have a pose and a velocity.
        Settable, to a list or one collider; effective from the next step on. Setting replaces all colliders:
        the new ones have their given poses, and the motion of the old ones ends.
        """
    @colliders.setter
    def colliders(self, value: Iterable[Collider] | Collider) -> None: ...
    @property
    def fps(self) -> float | None:
        """Number of frames per second, or None if the step length dt was given."""
    @property
    def steps_per_frame(self) -> int:
        """Number of steps per frame in force. If substeps is "auto", it can change until the first step."""
    @property
    def substeps(self) -> int | Literal["auto"]:
        """Number of steps per frame as it was set: "auto" or int, at least 1.

        Settable, also to "auto" with fps: the next step then chooses the number anew, for the bodies and motions at
        that time. With fps, dt changes.
        """
    @substeps.setter
    def substeps(self, value: int | Literal["auto"]) -> None: ...
    @property
    def sleep(self) -> bool:
        """Whether bodies at rest fall asleep. Settable."""
    @sleep.setter
    def sleep(self, value: bool) -> None: ...
    @property
    def threads(self) -> int:
        """Number of threads."""
    @property
    def contact(self) -> bool:
        """Whether bodies touch each other."""
    @property
    def self_contact(self) -> bool:
        """Whether parts of a body touch each other, for bodies that do not say so themselves."""
    def __getitem__(self, name: str, /) -> Body: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Body]: ...
    def __contains__(self, item: object, /) -> bool: ...
    def reset(self) -> None:
        """Set the simulation back to time 0, and the bodies to the state in which they were built.

        Placement, velocity and spin are those of the start; the bodies are whole, and have no plastic shapes, forces and
        contacts. Pins and handles capture positions anew, and colliders follow their keyframes. Settings, keyframes, pins,
        handles, fields, force fields and colliders stay as they are now. The next steps have the bits of a simulation that
        is built with them. With substeps="auto", the next step chooses the number of steps per frame.

        No copy of the first state is kept. It takes about as long as a step, and longer for a broken body.
        """
    def raycast(self, origins: ArrayLike, directions: ArrayLike, max_distance: float | None = None) -> Any:
        """Return what rays meet first: bodies as they are displayed, from either side, and colliders.

        origins : (3,) or (k, 3) float
            Where the rays start, in world space. (3,): all at one point.
        directions : (3,) or (k, 3) float
            Their directions, of any length but 0. (3,): all in one direction.
        max_distance : float, optional
            Greatest distance. Default: infinity.

        Returns a structured array with one entry per ray, or one entry without an axis if both are (3,), and the fields:

        body, collider : int32
            Index of the body in bodies, or of the collider in colliders; -1 for the other one. Both are -1 where a ray
            meets nothing.
        face : int32
            Index of the face of the displayed mesh; -1 for colliders and bare lattices.
        distance : float64
            Distance along the ray; infinity where it meets nothing. 0 for a ray that starts in a solid collider.
        point, normal : (3,) float64
            The point, and the unit normal, of bodies by the winding of their faces; zeros where a ray meets nothing.

        A call evaluates the surfaces of all bodies and builds a tree of each, which takes about 10 ms for 10,000 faces; a
        ray takes about a microsecond more. So many rays in one call are fast. Raises ValueError for a direction of length 0.
        """
    def nearest(self, points: ArrayLike) -> Any:
        """Return what is nearest to points: bodies as they are displayed, and colliders.

        points : (3,) or (k, 3) float
            In world space.

        Returns an array as raycast does; distance is that from the point, and never negative.
        """
    def contacts(
        self, body: str | SupportsIndex | Body | None = None, collider: SupportsIndex | Collider | None = None
    ) -> NDArray[np.void]:
        """Return the contacts of the last step: a structured array with one entry per contact and the fields below.

        body : str, int or Body, optional
            Only contacts of this body, given by name, index or itself: with bodies, also as the other one, and with
            colliders.
        collider : int or collider, optional
            Only contacts with this collider of colliders, given by index or itself.

        Fields:

        body : int32
            Index of the body in bodies; the lesser one of two bodies.
        other : int32
            Index of the other body, or of the collider. In self-contact it is the body itself.
        other_is_collider : bool
            Whether other is the index of a collider.
        point, normal : (3,) float64
            Position, and unit vector from the other towards the body. With a thickness, contacts act where the layers
            around both surfaces meet.
        depth : float64
            Greatest depth at which the surfaces overlap at the end of the step, in scene units; negative for a gap. The
            thicknesses count as part of the bodies and colliders.
        force : (3,) float64
            Force on the body during the step: pressure, friction, and what the damping takes from the contact. The force
            on the other is the opposite.

        Contacts with colliders come first. A body that sleeps has the contacts with which it fell asleep. Empty before
        the first step, and in a copy until its first step. Raises KeyError for an unknown name, IndexError for an index that
        does not exist, and ValueError for a body or a collider of another simulation.
        """
    @overload
    def surfaces(self, out: None = None) -> list[NDArray[np.float64]]:
        """Evaluate the displayed surfaces of all bodies, on all threads: a list of (k, 3) arrays in the order of
        bodies.

        out : list of (k, 3) float32 or float64, optional
            Arrays to write to and return, one per body. Default: new float64 arrays.

        The arrays are those of body.surface(), bit for bit. That of a bare lattice, which has no mesh, has no rows.
        """
    @overload
    def surfaces(self, out: Sequence[NDArray[_Float]]) -> list[NDArray[_Float]]:
        """Evaluate the displayed surfaces of all bodies, on all threads: a list of (k, 3) arrays in the order of
        bodies.

        out : list of (k, 3) float32 or float64, optional
            Arrays to write to and return, one per body. Default: new float64 arrays.

        The arrays are those of body.surface(), bit for bit. That of a bare lattice, which has no mesh, has no rows.
        """
    def save_state(self) -> bytes:
        """Return the state of the simulation as bytes, for restore_state.

        The state has positions, velocities, rotations, pins and handles with the poses that they captured, forces and
        impulses that still act, contacts, which bodies sleep, which links are broken, the motion of driven colliders,
        time, gravity, fields, the length and number of steps, and the settings of the bodies that can change between
        steps. It has neither sleep, threads, the shapes, keyframes and enabled of colliders, the animations that handles
        follow, links, nor the callbacks of add_force_field.
        """
    def restore_state(self, state: ReadableBuffer) -> None:
        """Restore a state that save_state returned. The simulation then continues bit-identically, and bodies that
        slept sleep.

        state : bytes-like
            A state of this simulation, or of one that was built with the same bodies, number of colliders, and fps.
            Pins and handles that were added after the state was saved no longer exist. A body must still have the
            handles that follow an animation, or others with the same selection and animation.

        fields and contacts() are those of the state. Raises ValueError for the state of another simulation, of another
        version of supple, and for damaged data; the simulation is then unchanged.
        """
    def plan(self) -> str:
        """Return a text that lists the stages of a step and of the evaluation of the displayed surface, with
        their parameters and memory.
        """
    def step(self, n: int = 1) -> None:
        """Advance the simulation by n steps of length dt.

        n : int, default 1
            Number of steps, at least 0.

        Other Python threads continue to run. Ctrl-C interrupts between two steps; steps that have begun end in the
        background, within about a second if a step is not longer. The first step warns with
        MaterialWarning if steps are too long for the material of a body, and so does the first one after the
        material or the step length changed.
        """
    def advance(self, frames: int = 1) -> None:
        """Advance the simulation by whole frames, of steps_per_frame steps each. It needs fps.

        frames : int, default 1
            Number of frames, at least 0.

        Other Python threads continue to run. Ctrl-C interrupts between two steps, and warnings are as for step.
        Raises ValueError without fps.
        """
    def _repr_html_(self) -> str: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @classmethod
    def _restore(cls, shapes: list[Mesh | Lattice], data: bytes) -> Simulation: ...

def rotation_matrix(rotate: Rotate) -> NDArray[np.float64]:
    """Return the matrix of a rotation: angles in degrees, a quaternion, a matrix or an object with as_matrix. (3, 3)
    float64.
    """

def rotations(a: ArrayLike) -> NDArray[np.float64]:
    """Compute the rotation factor of each 3x3 matrix A, with the algorithm of a step.

    The rotation factor is the rotation R that maximizes trace(R^T A).

    a : (n, 3, 3) float, or a single (3, 3)
        Finite, of any scale.

    Returns (n, 3, 3) float64, or (3, 3) for a single matrix. Each R is a proper rotation (det R = +1), also
    for a singular or inverted A. For det A < 0, R is U diag(1, 1, -1) V^T with the singular value
    decomposition A = U S V^T (Umeyama 1991). For A = 0, R is the identity.
    """

def reference_goals(
    lattice: Lattice,
    positions: ArrayLike,
    half_width: float,
    regions: Literal["staircase", "breadth_first"] = "staircase",
) -> NDArray[np.float64]:
    """Compute goal positions by naive sums in float64. The function is slow; it is the reference for Body.goals.

    lattice : Lattice
    positions : (n, 3) float
        One per lattice vertex, in the length unit of lattice.cell_size.
    half_width : int
        Half-width of the regions in cells, at least 1.
    regions : "staircase" or "breadth_first"
        "staircase": the regions of a step, up to half_width links along z, then y, then x.
        "breadth_first": all vertices that are reached by at most half_width steps, each between two corners
        of one cell (Rivers & James 2007).

    Returns (n, 3) float64. The mass m_i of vertex i is the number of occupied cells that share the vertex,
    divided by 8. The weight of the vertex in each of the n_i regions that contain it is m_i / n_i.
    """

def main() -> int:
    """Run the program `supple` with the arguments `sys.argv`, and return its exit code. It may be called once per
    process, because it handles Ctrl-C.
    """

def step_all(sims: Iterable[Simulation], n: int = 1) -> None:
    """Advance many simulations by n steps each, in parallel.

    sims : sequence of Simulation
        Each at most once. They need not be alike.
    n : int, default 1
        Number of steps of each, at least 0.

    The simulations are distributed over the processors, and each is stepped by one thread, whatever its threads are. The
    results have the bits of sim.step(n) for each. Forces of Body.apply_force act during the call, and functions of
    add_force_field are called before each step. Other Python threads continue to run. Ctrl-C and warnings are as for
    Simulation.step; after Ctrl-C, the simulations may have made different numbers of steps.

    Raises TypeError for an item that is no Simulation, and ValueError for one that is given twice.
    """

def simd_level() -> str:
    """Return the SIMD level of this process, such as "avx2" or "neon". Results have the same bits at each."""

def body_keys(table: str | None = None) -> list[str]:
    """Return the names of the keyword arguments of Body, or the keys of a table of `[[body]]` in a scene: "fracture" or
    "plastic".

    They are memory_limit, and the keys of `[[body]]` in a scene except mesh, zone, pin and handle.
    """

def check_collider(collider: Collider) -> dict[str, Any]:
    """Check a collider, and return its fields as plain numbers. Raises ValueError for an invalid field."""

@final
class CacheFile:
    """A file with the positions of a mesh; see supple.PointCache."""
    def __new__(cls, path: PathLike, mesh: Mesh, first_frame: int) -> CacheFile: ...
    def write(self, positions: ArrayLike) -> None:
        """Append a frame with the positions of all vertices."""
    @property
    def frames(self) -> int:
        """Number of frames so far."""
    def close(self) -> None:
        """Complete the file. Does nothing when it is complete."""

@final
class Recording:
    """A file with the surfaces of a simulation; see supple.Recorder."""
    def __new__(
        cls,
        simulation: Simulation,
        path: PathLike,
        *,
        up: str | None = None,
        scale: float = 1.0,
        fps: float | None = None,
        meters_per_unit: float = 1.0,
        glb_error: float = 0.001,
        usd_velocities: bool = False,
        film_size: tuple[int, int] = (800, 600),
        film_view: ArrayLike | None = None,
        film_color: str = "material",
    ) -> Recording: ...
    def record(self) -> None:
        """Append a frame with the present state."""
    @property
    def frames(self) -> int | None:
        """Number of frames so far; None when the recording has ended."""
    def close(self) -> list[str]:
        """Complete the file. Returns lines about what it holds approximately or not at all. Does nothing when the recording
        has ended.
        """

def film(
    run: PathLike,
    path: PathLike,
    *,
    up: str | None = None,
    fps: float | None = None,
    film_size: tuple[int, int] = (800, 600),
    film_view: ArrayLike | None = None,
    film_color: str = "material",
) -> int:
    """Write a film of a run on disk. Returns the number of frames."""

def load_scene(path: PathLike, overrides: list[str]) -> Simulation:
    """Load a scene file as a simulation at time zero. `overrides` contains strings `KEY=VALUE`."""

def run(
    path: PathLike,
    overrides: list[str],
    *,
    output: PathLike | None = None,
    format: str | Sequence[str] | None = None,
    frames: int | None = None,
    progress: Callable[[Progress], object] | None = None,
    every: int = 1,
    start_frame: int = 0,
    stats: PathLike | None = None,
    resume: bool | Literal["auto"] = False,
    from_frame: int | None = None,
    threads: int | None = None,
) -> RunReport:
    """Run a scene to frames on disk. `overrides` contains strings `KEY=VALUE`."""
