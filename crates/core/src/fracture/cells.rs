//! Finds the cells of a deformed lattice that are stretched so far that a joint beside them may break.
//!
//! The gradient F of a cell is the mean of the derivatives at its corners: each column is the mean of the four edges
//! along an axis. The mean of the gradients of two cells has a spectral norm of at most the greater norm of both, so
//! that a joint can break only beside a cell whose own norm exceeds the limit. With the mean m of the eigenvalues of
//! C = FᵀF and p² = |C - m I|²/6, the greatest eigenvalue of C is at most m + 2 p, and is m + 2 p if the other two are
//! equal.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};
use nalgebra::{Matrix3, Vector3};

use crate::lattice::{Lattice, Layout};
use crate::parallel::Executor;
use crate::simd::lanes::{Block, LANES, Lanes, between, lane_stride};
use crate::simd::level;

/// The cells of a lattice, by the slots of their corners 0.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    /// For each block, the bit mask of the lanes that are corner 0 of a cell whose corners follow from the links of
    /// blocks.
    lanes: Vec<u8>,
    /// Cell of each slot; not used for other slots.
    of_slot: Vec<u32>,
    /// All other cells, beside the fronts of cracks.
    others: Vec<u32>,
    /// Bit mask of the cells of each block that are stretched beyond the limit.
    stretched: Vec<u8>,
}

impl Cells {
    pub(super) fn new(lattice: &Lattice, layout: &Layout) -> Self {
        let slots = layout.slots();
        let (mut lanes, mut of_slot) = (vec![0; layout.blocks()], vec![0; layout.blocks() * LANES]);
        let mut others = Vec::new();
        for cell in 0..lattice.cells().len() as u32 {
            let corners = lattice.cell_corners(cell).map(|corner| slots[corner as usize]);
            let first = corners[0] as usize;
            if corners == corners_of(layout, first) {
                lanes[first / LANES] |= 1 << (first % LANES);
                of_slot[first] = cell;
            } else {
                others.push(cell);
            }
        }
        Self { stretched: vec![0; lanes.len()], lanes, of_slot, others }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.lanes)
            + size_of_val(&*self.of_slot)
            + size_of_val(&*self.others)
            + size_of_val(&*self.stretched)
    }

    /// Finds the cells with a stretch above `limit` at `positions`, and adds them to `found`. Some of them may be
    /// stretched less. `task_blocks`: first block of each task.
    pub(super) fn find_stretched(
        &mut self,
        (layout, positions): (&Layout, &Lanes<3>),
        limit: f32,
        (executor, task_blocks): (&Executor, &[usize]),
        found: &mut Vec<u32>,
    ) {
        let Self { lanes, of_slot, others, stretched } = self;
        let lanes = &*lanes;
        executor.tasks(
            task_blocks,
            (&mut **stretched, (), &mut []),
            |task, out: &mut [u8], (), _: &mut [()]| {
                let first = task_blocks[task];
                dispatch!(level(), simd => {
                    for (block, out) in (first..).zip(out) {
                        *out = if lanes[block] == 0 { 0 } else {
                            lanes[block] & beyond(simd, layout, positions.blocks(), block, limit)
                        };
                    }
                });
            },
        );
        for (block, &lanes) in self.stretched.iter().enumerate().filter(|(_, lanes)| **lanes != 0) {
            found.extend(
                (0..LANES).filter(|lane| lanes >> lane & 1 != 0).map(|lane| of_slot[block * LANES + lane]),
            );
        }
        found.extend_from_slice(others);
    }
}

/// Returns the slots that [`beyond`] takes for the corners of the cell with corner 0 in a slot.
fn corners_of(layout: &Layout, slot: usize) -> [u32; 8] {
    let (block, lane) = (slot / LANES, slot % LANES);
    std::array::from_fn(|corner| {
        let (mut block, mut lane) = (block, lane);
        for axis in [1, 2, 0] {
            if corner >> axis & 1 != 0 {
                let stride = lane_stride(axis);
                if lane & stride == 0 {
                    lane += stride;
                } else {
                    lane -= stride;
                    block = layout.axis(axis).next(block);
                }
            }
        }
        (block * LANES + lane) as u32
    })
}

/// Returns the bit mask of the lanes whose cells have a squared norm that may exceed the square of `limit`.
#[inline(always)]
fn beyond<S: Simd>(simd: S, layout: &Layout, positions: &[Block<3>], block: usize, limit: f32) -> u8 {
    let [x, y, z] = [layout.axis(0), layout.axis(1), layout.axis(2)];
    let next_y = y.next(block);
    // The blocks at (y, z), then those after them along x.
    let near = [block, next_y, z.next(block), z.next(next_y)];
    let mut columns = [[f32x8::splat(simd, 0.0); 3]; 3];
    for c in 0..3 {
        // Rows of the corners at (x, y, z) with x lower and upper, for the four blocks at (y, z).
        let mut low = [columns[0][0]; 4];
        let mut high = low;
        for k in 0..4 {
            let own = f32x8::load_array_ref(simd, &positions[near[k]][c]);
            let after = f32x8::load_array_ref(simd, &positions[x.next(near[k])][c]);
            low[k] = own;
            high[k] = between::<S, 0>(simd, own, after);
        }
        // Sums over x, and differences along x.
        let (mut sums, mut differences) = (low, low);
        for k in 0..4 {
            sums[k] = low[k] + high[k];
            differences[k] = high[k] - low[k];
        }
        let mut along_y = [sums[0]; 2];
        let mut over_y = along_y;
        let mut x_over_y = along_y;
        for k in 0..2 {
            let upper = between::<S, 1>(simd, sums[2 * k], sums[2 * k + 1]);
            along_y[k] = upper - sums[2 * k];
            over_y[k] = upper + sums[2 * k];
            x_over_y[k] =
                differences[2 * k] + between::<S, 1>(simd, differences[2 * k], differences[2 * k + 1]);
        }
        columns[0][c] = x_over_y[0] + between::<S, 2>(simd, x_over_y[0], x_over_y[1]);
        columns[1][c] = along_y[0] + between::<S, 2>(simd, along_y[0], along_y[1]);
        columns[2][c] = between::<S, 2>(simd, over_y[0], over_y[1]) - over_y[0];
    }
    // C times 16, because the columns are sums over four edges.
    let dot = |a: usize, b: usize| {
        let [a, b] = [columns[a], columns[b]];
        a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
    };
    let (xx, yy, zz, xy, xz, yz) = (dot(0, 0), dot(1, 1), dot(2, 2), dot(0, 1), dot(0, 2), dot(1, 2));
    let mean = (xx + yy + zz) * (1.0 / 3.0);
    let (dx, dy, dz) = (xx - mean, yy - mean, zz - mean);
    let diagonal = dx.mul_add(dx, dy.mul_add(dy, dz * dz));
    let beside = xy.mul_add(xy, xz.mul_add(xz, yz * yz));
    let spread = (beside + beside + diagonal) * (1.0 / 6.0);
    let greatest = spread.sqrt().mul_add(f32x8::splat(simd, 2.0), mean);
    greatest.simd_gt(f32x8::splat(simd, 16.0 * limit * limit)).to_bitmask() as u8
}

/// Returns the gradient of a cell from the positions of its corners.
pub(super) fn gradient(corners: &[Vector3<f64>; 8]) -> Matrix3<f64> {
    let column = |axis: usize| {
        let edges = (0..8).filter(|k| k >> axis & 1 == 0);
        edges.map(|k| corners[k | 1 << axis] - corners[k]).sum::<Vector3<f64>>() / 4.0
    };
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

/// Returns the greatest stretch of a gradient, and its direction at rest.
pub(super) fn greatest_stretch(gradient: &Matrix3<f64>) -> (f64, Vector3<f64>) {
    let eigen = (gradient.transpose() * gradient).symmetric_eigen();
    let greatest = eigen.eigenvalues.imax();
    (eigen.eigenvalues[greatest].max(0.0).sqrt(), eigen.eigenvectors.column(greatest).into_owned())
}
