//! Finds the gaps between the surfaces of a body and of the bodies around it.
//!
//! The volume correction moves both surfaces at a gap, so each of them may take half of it. A gap is measured between
//! samples of two surfaces that face each other, along the normal of the own one. Positions and distances are in cells
//! of the body, from its origin.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};
use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;
use super::deformed_cell::DeformedCell;
use super::grid::Grid;
use super::surface::{ContactSurface, Sample};
use super::view::BodyView;
use crate::contact::memory::buffer_bytes;
use crate::lattice::Lattice;
use crate::simd::level;
use crate::state::BodyFrame;

/// Distance along the surface, in cells of the other body, up to which a sample is opposite to one of the other body,
/// whose samples are at most half a cell apart. Beyond it, the clearance grows by the distance, so that no gap begins
/// or ends suddenly.
const OPPOSITE: f64 = 0.5;

/// Product of two normals above which the clearance grows, for the same reason, by [`FACING_GROWTH`] times the
/// difference. Surfaces whose product is 0 or more do not face each other.
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
    /// Whether it is a gap to the body itself.
    pub(crate) is_own: bool,
}

/// A body whose gaps are searched.
#[derive(Clone, Copy)]
pub(crate) struct GapBody<'a> {
    pub(crate) surface: &'a ContactSurface,
    pub(crate) lattice: &'a Lattice,
    /// Position of each lattice vertex.
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) frame: BodyFrame,
    /// Whether parts of the body touch each other.
    pub(crate) touches_itself: bool,
    /// Whether connected parts of the body touch each other.
    pub(crate) connected_parts_touch: bool,
}

/// The search for the gaps of one body after another. Its buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct GapSearch {
    /// The cells of the body with samples.
    own: Vec<OwnCell>,
    /// The samples of the cells in `own` that are near another surface.
    own_samples: Vec<OwnSample>,
    /// Positions of the lattice vertices of the other body.
    positions: Vec<Point3<f64>>,
    /// Cells with samples of the other surface that are near the body.
    cells: Vec<OtherCell>,
    /// The box of each of `cells`.
    boxes: Vec<(u32, Bounds)>,
    /// The bins of `boxes`.
    grid: Grid,
    /// The samples of the `cells` that are near a cell of the body.
    blocks: Vec<Block>,
    /// The `cells` near the present cell of the body, as ranges of `blocks`.
    near: Vec<(u32, u32)>,
}

/// A cell of the body with samples.
#[derive(Clone, Debug)]
struct OwnCell {
    /// Its box, enlarged by the greatest gap.
    bounds: Bounds,
    /// Its samples, as a range of `GapSearch::own_samples`; `None` until another surface is near.
    samples: Option<(u32, u32)>,
}

/// A sample of the body.
#[derive(Clone, Copy, Debug)]
struct OwnSample {
    /// Index in `ContactSurface::samples`.
    index: u32,
    position: [f32; 3],
    /// Unit normal.
    normal: [f32; 3],
    /// The least clearance found, or the greatest that counts.
    clearance: f32,
    /// As `clearance`, to other bodies only.
    to_others: f32,
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

/// Eight samples of a deformed surface, as rows of numbers: positions, unit normals, and distances up to which a sample
/// is opposite. Those that fill up a block have no normal.
type Block = [[f32; 8]; 7];

impl GapSearch {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { own, own_samples, positions, cells, boxes, grid, blocks, near } = self;
        let own = buffer_bytes(own) + buffer_bytes(own_samples);
        let others = buffer_bytes(positions) + buffer_bytes(cells) + buffer_bytes(boxes) + grid.bytes();
        own + others + buffer_bytes(blocks) + buffer_bytes(near)
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
        let all = self.begin(body, 2.0 * distance);
        for (other, surface) in others.filter(|(_, surface)| surface.is_closed) {
            let opposite = OPPOSITE * other.lattice.cell_size() / body.lattice.cell_size();
            self.positions.clear();
            let vertices = 0..other.lattice.len() as u32;
            self.positions
                .extend(vertices.map(|vertex| Point3::from(body.frame.to_local(&other.position(vertex)))));
            self.add_cells(surface, &all);
            self.find_near(body, surface, opposite, false, distance);
        }
        self.own_samples.iter_mut().for_each(|sample| sample.to_others = sample.clearance);
        if body.touches_itself {
            self.positions.clear();
            self.positions.extend(body.positions.iter().map(point));
            self.add_cells(body.surface, &all);
            self.find_near(body, body.surface, OPPOSITE, true, distance);
        }
        let greatest = distance as f32;
        for sample in self.own_samples.iter().filter(|sample| sample.clearance < greatest) {
            let normal = -Vector3::from(sample.normal).map(f64::from);
            let is_own = sample.clearance < sample.to_others;
            visit(Gap { sample: sample.index, normal, clearance: sample.clearance.into(), is_own });
        }
    }

    /// Begins the search of a body for gaps of at most `greatest`. Returns the box within which other surfaces are
    /// near.
    fn begin(&mut self, body: &GapBody<'_>, greatest: f64) -> Bounds {
        let Self { own, own_samples, .. } = self;
        own_samples.clear();
        own.clear();
        own.extend(body.surface.cells.iter().map(|group| OwnCell {
            bounds: Bounds::of(body.corners(group.cell)).enlarged(greatest),
            samples: None,
        }));
        own.iter().fold(Bounds::EMPTY, |all, cell| all.union(&cell.bounds))
    }

    /// Replaces the cells by the cells in a box of a surface with the vertices `positions`.
    fn add_cells(&mut self, surface: &ContactSurface, all: &Bounds) {
        let Self { positions, cells, boxes, grid, blocks, .. } = self;
        cells.clear();
        boxes.clear();
        blocks.clear();
        for (group, sampled) in (0..).zip(&surface.cells) {
            let corners = surface.corners[sampled.cell as usize].map(|vertex| positions[vertex as usize]);
            let bounds = Bounds::of(corners);
            if bounds.intersects(all) {
                let cell = DeformedCell::new(&corners);
                boxes.push((cells.len() as u32, bounds));
                cells.push(OtherCell { cell, group, blocks: None, found_for: None });
            }
        }
        grid.fill(boxes, all, 1.0);
    }

    /// Finds the clearances to the cells of a surface, of another body or of the body itself.
    fn find_near(
        &mut self,
        body: &GapBody<'_>,
        surface: &ContactSurface,
        opposite: f64,
        is_own: bool,
        distance: f64,
    ) {
        let Self { own, own_samples, cells, boxes, grid, blocks, near, .. } = self;
        let all = boxes.iter().fold(Bounds::EMPTY, |all, (_, bounds)| all.union(bounds));
        for (own, group) in own.iter_mut().zip(&body.surface.cells) {
            let bounds = own.bounds;
            if !bounds.intersects(&all) {
                continue;
            }
            near.clear();
            for bin in grid.bins(&bounds) {
                for &index in grid.cells_of(bin) {
                    let OtherCell { cell, group: other, blocks: range, found_for } =
                        &mut cells[index as usize];
                    let sampled = &surface.cells[*other as usize];
                    let is_new = *found_for != Some(group.cell)
                        && (!is_own || body.cells_touch([group.cell, sampled.cell]))
                        && boxes[index as usize].1.intersects(&bounds);
                    if !is_new {
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
            let (first, end) = *own.samples.get_or_insert_with(|| {
                let cell = DeformedCell::new(&body.corners(group.cell));
                let first = own_samples.len() as u32;
                own_samples.extend(group.samples.clone().filter_map(|index| {
                    let (position, normal) = pose(&cell, &body.surface.samples[index as usize])?;
                    let clearance = distance as f32;
                    Some(OwnSample { index, position, normal, clearance, to_others: clearance })
                }));
                (first, own_samples.len() as u32)
            });
            let samples = &mut own_samples[first as usize..end as usize];
            dispatch!(level(), simd => find_clearances(simd, samples, blocks, near));
        }
    }
}

impl GapBody<'_> {
    /// Returns the positions of the corners of a cell.
    fn corners(&self, cell: u32) -> [Point3<f64>; 8] {
        self.surface.corners[cell as usize].map(|vertex| point(&self.positions[vertex as usize]))
    }

    /// Returns whether two cells touch each other.
    fn cells_touch(&self, cells: [u32; 2]) -> bool {
        self.surface.cells_touch(self.lattice, self.connected_parts_touch, cells)
    }
}

fn point(position: &[f32; 3]) -> Point3<f64> {
    Point3::from(position.map(f64::from))
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

/// Reduces the clearances of samples to those to the samples in some blocks. `near` has ranges of `blocks`.
#[inline(always)]
fn find_clearances<S: Simd>(simd: S, samples: &mut [OwnSample], blocks: &[Block], near: &[(u32, u32)]) {
    let zero = f32x8::splat(simd, 0.0);
    for OwnSample { position, normal, clearance: least_clearance, .. } in samples {
        let mut least = f32x8::splat(simd, *least_clearance);
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
        let lanes: [f32; 8] = least.into();
        for clearance in lanes {
            *least_clearance = least_clearance.min(clearance);
        }
    }
}
