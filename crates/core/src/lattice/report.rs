//! What became of the input on its way to a lattice.

/// What became of the input on its way to a lattice: what is unusual about it is told here and not refused.
#[derive(Clone, Debug, Default, PartialEq)]
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
