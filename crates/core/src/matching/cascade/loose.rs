//! Loose cells, at the fronts of cracks: links do not join all of their corners, so that windows miss some of the
//! corners. Their sums are taken corner by corner, and so are the sums at their corners.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::lattice::LooseCells;
use crate::matching::windows::Weighted;
use crate::simd::lanes::{Block, block_and_lane};

/// The motion (b, X, Y, Z) of a loose cell. One thread writes each.
pub(super) type Motion = [AtomicU32; 12];

/// The loose cells of a layout and their motions.
#[derive(Clone, Copy)]
pub(super) struct Loose<'a> {
    pub(super) cells: &'a LooseCells,
    pub(super) motions: &'a [Motion],
}

impl Loose<'_> {
    /// Replaces the sums of the loose cells of consecutive blocks. `first` is the index of the first block in the
    /// layout.
    pub(super) fn gather(&self, field: Weighted, first: usize, sums: &mut [Block<12>]) {
        for cell in self.cells.of_blocks(first..first + sums.len()) {
            let mut values = [0.0; 12];
            for (k, &corner) in cell.corners.iter().enumerate() {
                let (block, lane) = block_and_lane(corner);
                for c in 0..3 {
                    let f = field.vectors[block][c][lane];
                    values[c] += f;
                    for axis in 0..3 {
                        values[3 + 3 * axis + c] += offset(k, axis) * f;
                    }
                }
            }
            let (block, lane) = block_and_lane(cell.slot);
            for (row, value) in sums[block - first].iter_mut().zip(values) {
                row[lane] = value;
            }
        }
    }

    /// Takes the motions of the loose cells out of the output of a transform.
    pub(super) fn take(&self, first: usize, sums: &mut [Block<12>]) {
        for cell in self.cells.of_blocks(first..first + sums.len()) {
            let (block, lane) = block_and_lane(cell.slot);
            for (row, number) in sums[block - first].iter_mut().zip(&self.motions[cell.number as usize]) {
                number.store(std::mem::take(&mut row[lane]).to_bits(), Ordering::Relaxed);
            }
        }
    }

    /// Adds the fields of the loose cells to the sums at the vertices of consecutive blocks.
    pub(super) fn add_fields(&self, first: usize, region_sums: &mut [Block<3>]) {
        for &(slot, number, k) in self.cells.corners_of_blocks(first..first + region_sums.len()) {
            let (block, lane) = block_and_lane(slot);
            let motion = &self.motions[number as usize];
            let number = |i: usize| f32::from_bits(motion[i].load(Ordering::Relaxed));
            for c in 0..3 {
                let turned: f32 =
                    (0..3).map(|axis| offset(k as usize, axis) * number(3 + 3 * axis + c)).sum();
                region_sums[block - first][c][lane] += number(c) + turned;
            }
        }
    }
}

/// Returns the offset of a corner of a cell from its center along an axis, in cells.
fn offset(corner: usize, axis: usize) -> f32 {
    (corner >> axis & 1) as f32 - 0.5
}
