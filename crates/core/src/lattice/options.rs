//! Options of the construction of a lattice, and the report on the construction.

/// Resolution of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Edge length of a cell in the length unit of the mesh, positive and finite.
    CellSize(f64),
    /// Requested number of lattice vertices, at least 8. The lattice has this number within 5 % if the shape
    /// allows it. A cube, for example, only has lattices of 8, 27, 64, ... vertices.
    Vertices(usize),
}

/// Options of [`Lattice::from_mesh`](super::Lattice::from_mesh).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeOptions {
    /// Resolution. Default: approximately 1000 vertices.
    pub resolution: Resolution,
    /// Whether parts (connected components of the cells) are joined, each to the nearest other part by a
    /// bridge of cells. If false, each part is a component of the lattice. Default: true.
    pub join: bool,
    /// Memory limit of the lattice and a simulation of it, in bytes. Default (`None`):
    /// [`DEFAULT_MEMORY_LIMIT`](Self::DEFAULT_MEMORY_LIMIT). `supple_io::memory_limit` returns a limit that suits the
    /// machine.
    pub memory_limit: Option<u64>,
}

impl LatticeOptions {
    /// Memory limit of a lattice and a simulation of it if none is given: 4 GiB, enough for 17 million vertices.
    pub const DEFAULT_MEMORY_LIMIT: u64 = 4 << 30;
}

impl Default for LatticeOptions {
    fn default() -> Self {
        Self { resolution: Resolution::Vertices(1000), join: true, memory_limit: None }
    }
}

/// A report on the construction of a lattice. It lists unusual input, which is not an error.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LatticeReport {
    /// Number of cells that the surface passes through. For a lattice of given cells, the number of these.
    pub surface_cells: usize,
    /// Number of further cells that the surface encloses. 0 for a lattice of given cells.
    pub filled_cells: usize,
    /// Number of cells that only bridges occupy. 0 if `join` is false.
    pub bridge_cells: usize,
    /// Whether the lattice is a shell: a layer of cells along the surface, and not the solid inside it. True
    /// if the mesh is a sheet.
    pub shell: bool,
    /// All parts (connected components of the cells before joining) except the largest part, in the order of
    /// their first cell.
    pub floating: Vec<FloatingPart>,
    /// Groups of two or more mesh components (indices in
    /// [`Topology::components`](crate::mesh::Topology::components)) whose cells are in the same part before
    /// joining: the components share cells, or their cells touch, or one component encloses another.
    pub glued: Vec<Vec<u32>>,
}

/// A connected component of the cells before joining that is not the largest one.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FloatingPart {
    /// Number of its cells.
    pub cells: usize,
    /// The mesh components (indices in [`Topology::components`](crate::mesh::Topology::components)) in this
    /// part. Empty for a lattice of given cells.
    pub mesh_components: Vec<u32>,
    /// Whether a bridge joins this part to another part: true iff `join` is set.
    pub joined: bool,
    /// Number of cells of the bridge that starts at this part. 0 if `join` is false, or if this part is only
    /// joined by the bridge of another part.
    pub bridge_cells: usize,
}
