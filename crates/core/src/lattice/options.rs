//! Options of the construction of a lattice, and the report on it.

/// Resolution of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Edge length of a cell in the length unit of the mesh, positive and finite.
    CellSize(f64),
    /// Requested number of lattice vertices, at least 8. The result is within 5 % where the shape allows it;
    /// a cube, for example, has lattices of 8, 27, 64, ... vertices only.
    Vertices(usize),
}

/// Options of [`Lattice::from_mesh`](super::Lattice::from_mesh).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeOptions {
    /// Resolution. Default: about 1000 vertices.
    pub resolution: Resolution,
    /// Whether separate parts are joined, each to its nearest neighbor by a bridge of cells. If false, each
    /// part is a component of its own. Default: true.
    pub join: bool,
    /// Memory limit of the lattice and a simulation of it, in bytes. Default (`None`): half of the machine's
    /// memory, or 4 GiB if that is unknown.
    pub memory_limit: Option<u64>,
}

impl Default for LatticeOptions {
    fn default() -> Self {
        Self { resolution: Resolution::Vertices(1000), join: true, memory_limit: None }
    }
}

/// A report on the construction of a lattice. Unusual input is listed here and is not an error.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LatticeReport {
    /// Number of cells that were given, or that the surface passes through.
    pub surface_cells: usize,
    /// Number of further cells that the surface encloses. 0 if the cells were given.
    pub filled_cells: usize,
    /// Number of further cells, in the bridges that join separate parts. 0 if `join` is false.
    pub bridge_cells: usize,
    /// Whether the mesh has openings wider than a cell, so that the lattice is a layer along the surface and
    /// not the solid inside it.
    pub shell: bool,
    /// The parts that are separate from the largest one before joining, in the order of their first cell.
    pub floating: Vec<FloatingPart>,
    /// Groups of two or more mesh components (indices in
    /// [`Topology::components`](crate::mesh::Topology::components)) that are one part of the lattice without
    /// a bridge: they share cells, or their cells touch, or one encloses the other.
    pub glued: Vec<Vec<u32>>,
}

/// A connected part of the cells that is separate from the largest part before joining.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FloatingPart {
    /// Number of its cells.
    pub cells: usize,
    /// The mesh components (indices in [`Topology::components`](crate::mesh::Topology::components)) in this
    /// part. Empty if the cells were given.
    pub mesh_components: Vec<u32>,
    /// Whether a bridge joins it to another part (`join`).
    pub joined: bool,
    /// Number of cells of its own bridge. 0 if `join` is false, or if the bridge of another part joins it.
    pub bridge_cells: usize,
}
