//! What lattice is wished for.

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
