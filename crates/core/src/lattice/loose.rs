//! Loose cells, at the fronts of cracks: the cells whose corners links do not all join.

use std::ops::Range;

use super::Lattice;
use super::axis_links::AxisLinks;
use crate::simd::lanes::LANES;

/// A cell of which links do not join all corners to the first one: see `charts`.
#[derive(Clone, Debug)]
pub(crate) struct LooseCell {
    /// Slot of the first corner.
    pub slot: u32,
    /// Slots of the corners.
    pub corners: [u32; 8],
    /// Index among the loose cells.
    pub number: u32,
}

/// The loose cells of a layout.
#[derive(Clone, Debug, Default)]
pub(crate) struct LooseCells {
    /// Sorted by slot.
    cells: Vec<LooseCell>,
    /// The slot of each corner, the index of its cell and its number in the cell. Sorted.
    corners: Vec<(u32, u32, u8)>,
}

impl LooseCells {
    /// Finds the loose cells of a lattice.
    pub(super) fn new(lattice: &Lattice, slots: &[u32], axes: &[AxisLinks; 3]) -> Self {
        let mut cells: Vec<LooseCell> = (0..lattice.cells().len() as u32)
            .map(|cell| {
                let corners = lattice.cell_corners(cell).map(|corner| slots[corner as usize]);
                LooseCell { slot: corners[0], corners, number: 0 }
            })
            .filter(|cell| !cell.is_linked(axes))
            .collect();
        cells.sort_unstable_by_key(|cell| cell.slot);
        (0..).zip(&mut cells).for_each(|(number, cell)| cell.number = number);
        let mut corners: Vec<(u32, u32, u8)> = cells
            .iter()
            .flat_map(|cell| (0..).zip(cell.corners).map(|(k, corner)| (corner, cell.number, k)))
            .collect();
        corners.sort_unstable();
        Self { cells, corners }
    }

    /// Returns the cells whose sums are stored in a range of blocks.
    pub(crate) fn of_blocks(&self, blocks: Range<usize>) -> &[LooseCell] {
        let at = |block: usize| self.cells.partition_point(|cell| (cell.slot as usize) < block * LANES);
        if self.cells.is_empty() { &[] } else { &self.cells[at(blocks.start)..at(blocks.end)] }
    }

    /// Returns the corners whose vertices are in a range of blocks.
    pub(crate) fn corners_of_blocks(&self, blocks: Range<usize>) -> &[(u32, u32, u8)] {
        let at = |block: usize| self.corners.partition_point(|(slot, ..)| (*slot as usize) < block * LANES);
        &self.corners[at(blocks.start)..at(blocks.end)]
    }

    /// Returns the slots of the cells that have the vertex in a slot as a corner.
    pub(crate) fn around(&self, slot: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.corners.partition_point(|(corner, ..)| *corner < slot);
        let own = self.corners[first..].iter().take_while(move |(corner, ..)| *corner == slot);
        own.map(|&(_, number, _)| self.cells[number as usize].slot)
    }

    /// Returns whether the cell whose first corner is in a slot is loose.
    pub(crate) fn contains(&self, slot: u32) -> bool {
        self.cells.binary_search_by_key(&slot, |cell| cell.slot).is_ok()
    }

    /// Returns all cells.
    pub(crate) fn all(&self) -> &[LooseCell] {
        &self.cells
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice()) + size_of_val(self.corners.as_slice())
    }
}

impl LooseCell {
    /// Returns whether links along z, then y, then x lead from the first corner to all others, as in window sums.
    fn is_linked(&self, axes: &[AxisLinks; 3]) -> bool {
        self.corners.iter().enumerate().all(|(k, &corner)| {
            let along = |slot, &axis: &usize| match k >> axis & 1 {
                0 => Some(slot),
                _ => axes[axis].next_slot(slot),
            };
            [2, 1, 0].iter().try_fold(self.slot, along) == Some(corner)
        })
    }
}
