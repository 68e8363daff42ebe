//! Finds the gaps between the surface of a body and those of the bodies around it.
//!
//! The volume correction moves both surfaces at a gap, so each of them may take half of it. A gap is measured between samples
//! of two surfaces that face each other, along the normal of the own one. Positions and distances are in cells of the
//! body, from its origin.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};
use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;
use super::deformed_cell::DeformedCell;
use super::grid::Grid;
use super::search::are_near;
use super::surface::{ContactSurface, Sample};
use super::view::BodyView;
use crate::contact::rows::buffer_bytes;
use crate::lattice::Lattice;
use crate::simd::level;
use crate::state::BodyFrame;

/// Distance along the surface, in cells of the other body, up to which a sample is opposite to one of the other body, whose
/// samples are at most half a cell apart. Beyond it, the clearance grows by the distance, so that no gap begins or ends
/// suddenly.
const OPPOSITE: f64 = 0.5;

/// Product of two normals above which the clearance grows, for the same reason, by [`FACING_GROWTH`] times the difference.
/// Surfaces whose product is 0 or more do not face each other.
const FACING: f32 = -0.5;

/// See [`FACING`].
const FACING_GROWTH: f32 = 4.0;

/// Greatest overlap. Samples that are deeper face each other through a thin body.
const MAX_OVERLAP: f32 = 0.25;

/// A gap at a sample of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    pub(crate) sample: u32,
    /// Unit normal away from the other body, in world axes.
    pub(crate) normal: Vector3<f64>,
    /// Distance by which the sample may move against the normal: half of the gap.
    pub(crate) clearance: f64,
}

/// A body whose gaps are searched.
#[derive(Clone, Copy)]
pub(crate) struct GapBody<'a> {
    pub(crate) surface: &'a ContactSurface,
    pub(crate) lattice: &'a Lattice,
    /// Position of each lattice vertex.
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) frame: BodyFrame,
    /// Whether the parts of the body touch each other.
    pub(crate) touches_itself: bool,
}

/// The search for the gaps of one body after another. Its buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct GapSearch {
    /// Cells with samples of another surface that are near the body.
    cells: Vec<OtherCell>,
    /// The box of each of `cells`.
    boxes: Vec<(u32, Bounds)>,
    /// The bins of `boxes`.
    grid: Grid,
    /// The samples of those of `cells` that are near a cell of the body.
    blocks: Vec<Block>,
    /// Those of `cells` that are near the present cell of the body, as ranges of `blocks`.
    near: Vec<(u32, u32)>,
}

/// A cell with samples of another surface.
#[derive(Clone, Debug)]
struct OtherCell {
    cell: DeformedCell,
    /// Index in `ContactSurface::cells`.
    group: u32,
    /// Its samples, as a range of `GapSearch::blocks`; `None` before the first use.
    blocks: Option<(u32, u32)>,
    /// The cell of the body for which it was found last.
    found_for: Option<u32>,
}

/// Eight samples of a deformed surface, as rows of numbers: positions, unit normals, and distances up to which a sample is
/// opposite. Those that fill up a block have no normal.
type Block = [[f32; 8]; 7];

impl GapSearch {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let cells = buffer_bytes(&self.cells) + buffer_bytes(&self.boxes) + buffer_bytes(&self.near);
        cells + self.grid.bytes() + buffer_bytes(&self.blocks)
    }

    /// Calls `visit` for the samples of a body that have a clearance of less than `distance` to another body, or to the
    /// body itself. Surfaces that are not closed have no side that faces another one, and so no gaps.
    pub(crate) fn find<'a>(
        &mut self,
        body: &GapBody<'_>,
        others: impl Iterator<Item = (BodyView<'a>, &'a ContactSurface)>,
        distance: f64,
        mut visit: impl FnMut(Gap),
    ) {
        if !body.surface.is_closed {
            return;
        }
        let own = |vertex: u32| Point3::from(body.positions[vertex as usize].map(f64::from));
        let all = Bounds::of((0..body.positions.len() as u32).map(own)).enlarged(2.0 * distance);
        for (other, surface) in others.filter(|(_, surface)| surface.is_closed) {
            let opposite = OPPOSITE * other.lattice.cell_size() / body.lattice.cell_size();
            let position = |vertex| body.frame.to_local(&other.position(vertex)).into();
            self.add_cells(surface, position, &all);
            self.find_near(body, own, (surface, opposite, false), distance, &mut visit);
        }
        if body.touches_itself {
            self.add_cells(body.surface, own, &all);
            self.find_near(body, own, (body.surface, OPPOSITE, true), distance, &mut visit);
        }
    }

    /// Replaces the cells by those of a surface that are in a box.
    fn add_cells(&mut self, surface: &ContactSurface, position: impl Fn(u32) -> Point3<f64>, all: &Bounds) {
        let Self { cells, boxes, grid, blocks, .. } = self;
        cells.clear();
        boxes.clear();
        blocks.clear();
        for (group, sampled) in (0..).zip(&surface.cells) {
            let corners = surface.corners[sampled.cell as usize].map(&position);
            let bounds = Bounds::of(corners);
            if bounds.intersects(all) {
                let cell = DeformedCell::new(&corners);
                boxes.push((cells.len() as u32, bounds));
                cells.push(OtherCell { cell, group, blocks: None, found_for: None });
            }
        }
        grid.fill(boxes, all, 1.0);
    }

    /// Finds the gaps to the cells of a surface, which is that of the body itself or another one.
    fn find_near(
        &mut self,
        body: &GapBody<'_>,
        position: impl Fn(u32) -> Point3<f64>,
        (surface, opposite, is_own): (&ContactSurface, f64, bool),
        distance: f64,
        visit: &mut impl FnMut(Gap),
    ) {
        let Self { cells, boxes, grid, blocks, near } = self;
        for group in &body.surface.cells {
            let corners = body.surface.corners[group.cell as usize].map(&position);
            let bounds = Bounds::of(corners).enlarged(2.0 * distance);
            near.clear();
            for bin in grid.bins(&bounds) {
                for &index in grid.cells_of(bin) {
                    let OtherCell { cell, group: other, blocks: range, found_for } =
                        &mut cells[index as usize];
                    let sampled = &surface.cells[*other as usize];
                    let is_new =
                        *found_for != Some(group.cell) && boxes[index as usize].1.intersects(&bounds);
                    if !is_new || is_own && are_near(body.lattice, group.cell, sampled.cell) {
                        continue;
                    }
                    *found_for = Some(group.cell);
                    near.push(*range.get_or_insert_with(|| {
                        let samples =
                            &surface.samples[sampled.samples.start as usize..sampled.samples.end as usize];
                        add_blocks(blocks, cell, samples, opposite as f32)
                    }));
                }
            }
            if near.is_empty() {
                continue;
            }
            let cell = DeformedCell::new(&corners);
            for sample in group.samples.clone() {
                let posed = pose(&cell, &body.surface.samples[sample as usize]);
                let Some(surface @ (_, normal)) = posed else { continue };
                let distance = distance as f32;
                let clearance =
                    dispatch!(level(), simd => least_clearance(simd, surface, blocks, near, distance));
                if clearance < distance {
                    let normal = -Vector3::from(normal).map(f64::from);
                    visit(Gap { sample, normal, clearance: clearance.into() });
                }
            }
        }
    }
}

/// Adds the samples of a deformed cell. Returns the range of their blocks.
fn add_blocks(blocks: &mut Vec<Block>, cell: &DeformedCell, samples: &[Sample], opposite: f32) -> (u32, u32) {
    let first = blocks.len() as u32;
    for eight in samples.chunks(8) {
        let mut block = Block::default();
        for (lane, sample) in eight.iter().enumerate() {
            let Some(([x, y, z], [a, b, c])) = pose(cell, sample) else { continue };
            for (row, value) in block.iter_mut().zip([x, y, z, a, b, c, opposite]) {
                row[lane] = value;
            }
        }
        blocks.push(block);
    }
    (first, blocks.len() as u32)
}

/// Returns the position and the unit normal of a sample, or `None` where its cell is flat or inside out.
fn pose(cell: &DeformedCell, sample: &Sample) -> Option<([f32; 3], [f32; 3])> {
    let local = sample.local.map(f64::from);
    let normal = cell.gradient(local).normal(&Vector3::from(sample.normal.map(f64::from)))?;
    Some((cell.position(local).map(|x| x as f32).into(), normal.map(|x| x as f32).into()))
}

/// Returns the least clearance of a sample to those in some blocks, or `distance` if none is less. `surface` is the
/// position of the sample and its unit normal, and `near` has ranges of blocks.
#[inline(always)]
fn least_clearance<S: Simd>(
    simd: S,
    surface: ([f32; 3], [f32; 3]),
    blocks: &[Block],
    near: &[(u32, u32)],
    distance: f32,
) -> f32 {
    let (position, normal) = surface;
    let zero = f32x8::splat(simd, 0.0);
    let mut least = f32x8::splat(simd, distance);
    for &(first, end) in near {
        for block in &blocks[first as usize..end as usize] {
            let a = f32x8::load_array_ref(simd, &block[3]);
            let b = f32x8::load_array_ref(simd, &block[4]);
            let c = f32x8::load_array_ref(simd, &block[5]);
            let facing = a * normal[0] + b * normal[1] + c * normal[2];
            let faces = facing.simd_lt(zero);
            if !faces.any_true() {
                continue;
            }
            let x = f32x8::load_array_ref(simd, &block[0]) - position[0];
            let y = f32x8::load_array_ref(simd, &block[1]) - position[1];
            let z = f32x8::load_array_ref(simd, &block[2]) - position[2];
            let gap = x * normal[0] + y * normal[1] + z * normal[2];
            let aside = (x * x + y * y + z * z - gap * gap).max(zero).sqrt();
            let excess = (aside - f32x8::load_array_ref(simd, &block[6])).max(zero);
            let clearance = gap.max(zero) * 0.5 + excess + (facing - FACING).max(zero) * FACING_GROWTH;
            let counts = faces & gap.simd_ge(f32x8::splat(simd, -MAX_OVERLAP));
            least = counts.select(clearance.min(least), least);
        }
    }
    least.to_array().into_iter().fold(distance, f32::min)
}
