//! What is asked of a lattice, and what became of the input.

/// How fine a lattice is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Edge of a cell, a positive length in the units of the mesh.
    CellSize(f64),
    /// Wished number of lattice vertices, at least 8; met within 5 % where the shape allows. A cube, say, has lattices of 8, 27, 64, ...
    /// vertices and nothing between.
    Vertices(usize),
}

/// What lattice is wished for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeOptions {
    /// How fine. Default: about 1000 vertices.
    pub resolution: Resolution,
    /// Whether parts that float apart ride along, each tied to its nearest neighbour by a bridge of cells. Default: true. If false, each
    /// is a component of its own.
    pub join: bool,
    /// Bytes that the lattice and a simulation of it may take. Default (`None`): half of the machine's memory, or 4 GiB where that is
    /// not known.
    pub memory_limit: Option<u64>,
}

impl Default for LatticeOptions {
    fn default() -> Self {
        Self { resolution: Resolution::Vertices(1000), join: true, memory_limit: None }
    }
}

/// What became of the input on its way to a lattice: what is unusual about it is told here and not refused.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LatticeReport {
    /// Cells that were given, or that the surface passes through.
    pub surface_cells: usize,
    /// Further cells that no way from outside leads to: the inside of the mesh. 0 where the cells were given.
    pub filled_cells: usize,
    /// Further cells that join parts which floated apart. 0 with `join` off.
    pub bridge_cells: usize,
    /// The mesh has openings wider than a cell, so that the lattice is a layer along the surface and not the solid inside it.
    pub shell: bool,
    /// The parts that float apart from the largest one, in the order of their first cell.
    pub floating: Vec<FloatingPart>,
    /// Groups of two or more mesh components (numbers as in the mesh) that the lattice holds together without a bridge, because
    /// they share cells, or their cells touch, or one lies within the other.
    pub glued: Vec<Vec<u32>>,
}

/// Connected cells that do not touch those of the largest part.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FloatingPart {
    /// Number of its cells.
    pub cells: usize,
    /// The mesh components (numbers as in the mesh) that lie in it; empty where the cells were given.
    pub mesh_components: Vec<u32>,
    /// Whether it rides along (`join`): a bridge ties it to another part.
    pub joined: bool,
    /// Length in cells of the bridge that it asked for. 0 with `join` off, or where the bridge of another part serves it.
    pub bridge_cells: usize,
}
