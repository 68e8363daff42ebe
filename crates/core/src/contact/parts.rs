//! The parts of a body that touch: a whole body is one part, and each piece of a broken body is one.

use crate::lattice::{Components, Lattice};

/// The parts of a body.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub(super) lattice: &'a Lattice,
    /// Number of parts.
    pub(super) count: usize,
    /// Distance in cells from the cells of a part up to which its surface lies: the smooth surface of a crack leaves
    /// them.
    pub(super) overhang: f64,
    /// Part of each lattice vertex; empty if there is one part.
    of_vertex: &'a [u32],
}

impl<'a> Parts<'a> {
    pub(crate) fn new(lattice: &'a Lattice) -> Self {
        let Components { count, of_vertex } = lattice.components();
        let is_broken = !lattice.broken_joints().is_empty();
        let (count, of_vertex): (_, &[u32]) =
            if is_broken && *count > 1 { (*count, of_vertex) } else { (1, &[]) };
        Self { lattice, count, overhang: if is_broken { 1.0 } else { 0.0 }, of_vertex }
    }

    /// Returns whether there are several parts.
    pub(crate) fn are_several(&self) -> bool {
        self.count > 1
    }

    /// Returns the part of a lattice vertex.
    pub(super) fn of_vertex(&self, vertex: u32) -> u32 {
        self.of_vertex.get(vertex as usize).copied().unwrap_or(0)
    }

    /// Returns the part of a cell.
    pub(super) fn of_cell(&self, cell: u32) -> u32 {
        if self.of_vertex.is_empty() { 0 } else { self.lattice.component_of_cell(cell) }
    }

    /// Returns the cell of a part that is nearest to a position in cells, among the cells around one.
    pub(super) fn nearest_cell(&self, (cell, part): (u32, u32), position: [f64; 3]) -> Option<u32> {
        let center = self.lattice.cells()[cell as usize];
        let around = (0..27).filter_map(|k| {
            let index = [0, 1, 2].map(|a| center[a] + k / [1, 3, 9][a] % 3 - 1);
            let cell = self.lattice.cell_at(index).filter(|&cell| self.of_cell(cell) == part)?;
            let outside =
                |a: usize| (f64::from(index[a]) - position[a]).max(position[a] - f64::from(index[a]) - 1.0);
            Some(((0..3).map(|a| outside(a).max(0.0).powi(2)).sum::<f64>(), cell))
        });
        around.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, cell)| cell)
    }

    /// Returns the part of each cell; empty if there is one part.
    pub(super) fn of_cells(&self) -> Vec<u32> {
        let cells = if self.of_vertex.is_empty() { 0 } else { self.lattice.cells().len() as u32 };
        (0..cells).map(|cell| self.lattice.component_of_cell(cell)).collect()
    }
}
