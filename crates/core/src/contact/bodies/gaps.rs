//! Finds the gaps between the surfaces of a body and of the bodies around it.
//!
//! The volume correction moves both surfaces at a gap, so each of them may take half of it; the thicknesses of both
//! bodies are no part of a gap. A gap is measured between samples of two surfaces, along the normal of the other one.
//! Positions and distances are in cells of the body, from its origin.

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};
use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;
use super::deformed_cell::DeformedCell;
use super::grid::Grid;
use super::patch::{FACING, GROWTH, MAX_OVERLAP, Patch};
use super::surface::{ContactSurface, SIDES, Sample, side};
use super::view::BodyView;
use crate::contact::memory::buffer_bytes;
use crate::simd::level;
use crate::simd::vector::wide;

/// Distance along the surface, in cells of the other body, up to which a sample is opposite to one of the other body,
/// whose samples are at most half a cell apart. Beyond it, the clearance grows by the distance, so that no gap begins
/// or ends suddenly.
const OPPOSITE: f64 = 0.5;

/// Distance up to which a cell is searched again, as a multiple of the distance that counts. So displacements that grow
/// little from search to search need few searches.
const AGAIN_MARGIN: f64 = 1.25;

/// A gap at a sample of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    pub sample: u32,
    /// Unit normal away from the other body, in world axes.
    pub normal: Vector3<f64>,
    /// Distance by which the sample may move against the normal: half of the gap.
    pub clearance: f64,
    /// Whether it is a gap to the body itself.
    pub is_own: bool,
}

/// The search for the gaps of one body after another. Its buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct GapSearch {
    /// Positions of the lattice vertices of the body.
    own_positions: Vec<Point3<f64>>,
    /// The cells of the body with samples. Empty before the first search of a body.
    own: Vec<OwnCell>,
    /// The samples of the body.
    own_samples: Vec<OwnSample>,
    /// Positions of the lattice vertices of another body.
    positions: Vec<Point3<f64>>,
    /// Cells with samples of the other surface that are near the body.
    cells: Vec<OtherCell>,
    /// The box of each of `cells`.
    boxes: Vec<(u32, Bounds)>,
    /// The bins of `boxes`.
    grid: Grid,
    /// The samples of the `cells` that are near a cell of the body.
    blocks: Vec<Block>,
    /// The `blocks` near the present cell of the body, in increasing order of a lower bound of the clearance: the bound,
    /// and the index.
    near: Vec<(f32, u32)>,
}

/// A cell of the body with samples.
#[derive(Clone, Debug)]
struct OwnCell {
    /// Greatest clearance that counts, as far as gaps were searched.
    distance: f32,
    /// Its box enlarged by the greatest gap in the present search; empty if its gaps are known.
    bounds: Bounds,
    /// Its samples, as a range of `GapSearch::own_samples`, and their patch; `None` until another surface is near.
    samples: Option<((u32, u32), Patch)>,
}

/// A sample of the body.
#[derive(Clone, Copy, Debug)]
struct OwnSample {
    /// Index in `ContactSurface::samples`.
    index: u32,
    position: [f32; 3],
    /// Unit normal; zero where the cell is flat or inside out.
    normal: [f32; 3],
    /// The gap of least clearance for each [`side`] of its normal; `None` if its clearance is too great.
    gaps: [Option<Gap>; SIDES],
}

/// A cell with samples of another surface.
#[derive(Clone, Debug)]
struct OtherCell {
    cell: DeformedCell,
    /// Index in `ContactSurface::cells`.
    group: u32,
    /// Its samples, as a range of `GapSearch::blocks`; `None` before the first use.
    blocks: Option<(u32, u32)>,
}

/// Up to eight samples of a deformed surface, whose normals have one [`side`].
#[derive(Clone, Debug, Default)]
struct Block {
    /// Rows of numbers: positions, unit normals, and distances up to which a sample is opposite. These are negative and
    /// infinite for samples that fill up a block.
    rows: [[f32; 8]; 7],
    count: u8,
    side: u8,
    patch: Patch,
}

/// A body, and its surface.
type Surfaced<'a> = (BodyView<'a>, &'a ContactSurface);

impl GapSearch {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { own_positions, own, own_samples, positions, cells, boxes, grid, blocks, near } = self;
        let own = buffer_bytes(own_positions) + buffer_bytes(own) + buffer_bytes(own_samples);
        let others = buffer_bytes(positions) + buffer_bytes(cells) + buffer_bytes(boxes) + grid.bytes();
        own + others + buffer_bytes(blocks) + buffer_bytes(near)
    }

    /// Begins the search of a body: forgets the gaps that were found.
    pub(crate) fn begin(&mut self) {
        self.own.clear();
        self.own_samples.clear();
    }

    /// Calls `visit` for the gaps of a body to other bodies, and to the body itself if `touches_itself`: for each sample
    /// and [`side`] the one with the least clearance, if it is less than the greatest `distance` of a corner of the sample's
    /// cell, and some with a greater one. Surfaces that are not closed have no gaps.
    ///
    /// After [`begin`](Self::begin), it may be called several times for a body, while no body moves. Only cells with a greater
    /// distance than before are searched again.
    ///
    /// * `others`: returns the bodies that have a point within a distance of the body, in its cells.
    /// * `distance`: returns the greatest clearance that counts at a lattice vertex.
    pub(crate) fn find<'a, I: Iterator<Item = Surfaced<'a>>>(
        &mut self,
        body: Surfaced<'a>,
        others: impl FnOnce(f64) -> I,
        touches_itself: bool,
        distance: impl Fn(u32) -> f64,
        visit: impl FnMut(Gap),
    ) {
        if !body.1.is_closed {
            return;
        }
        if self.own.is_empty() {
            set_positions(&mut self.own_positions, &body.0, &body.0);
            let cell = OwnCell { distance: 0.0, bounds: Bounds::EMPTY, samples: None };
            self.own.resize(body.1.cells.len(), cell);
        }
        let (all, farthest) = self.extend(body.1, distance);
        if !all.is_empty() {
            for other in others(2.0 * farthest).filter(|(_, surface)| surface.is_closed) {
                set_positions(&mut self.positions, &other.0, &body.0);
                self.find_near(&body, &other, &all, false);
            }
            if touches_itself {
                self.positions.clone_from(&self.own_positions);
                self.find_near(&body, &body, &all, true);
            }
        }
        self.own_samples.iter().flat_map(|sample| sample.gaps).flatten().for_each(visit);
    }

    /// Increases the greatest clearances that count. Returns the box of all cells that must be searched again, and the
    /// greatest clearance of them.
    fn extend(&mut self, surface: &ContactSurface, distance: impl Fn(u32) -> f64) -> (Bounds, f64) {
        let (mut all, mut farthest) = (Bounds::EMPTY, 0.0_f64);
        for (own, group) in self.own.iter_mut().zip(&surface.cells) {
            let vertices = surface.corners[group.cell as usize];
            let distance = vertices.into_iter().map(&distance).fold(0.0, f64::max);
            own.bounds = Bounds::EMPTY;
            if distance as f32 > own.distance {
                let distance = if own.distance > 0.0 { AGAIN_MARGIN * distance } else { distance };
                farthest = farthest.max(distance);
                own.distance = distance as f32;
                let corners = vertices.map(|vertex| self.own_positions[vertex as usize]);
                own.bounds = Bounds::of(corners).enlarged(2.0 * distance);
                all = all.union(&own.bounds);
            }
        }
        (all, farthest)
    }

    /// Lists the cells of a surface that have points in a box.
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
                cells.push(OtherCell { cell, group, blocks: None });
            }
        }
        grid.fill(boxes, all, 1.0);
    }

    /// Finds the gaps to another body, or to the body itself, of the cells that must be searched.
    fn find_near(&mut self, body: &Surfaced<'_>, other: &Surfaced<'_>, all: &Bounds, is_own: bool) {
        // Parts of a body that touch each other are found without their thickness.
        let thickness = if is_own { 0.0 } else { thickness(body, other) };
        self.add_cells(other.1, &all.enlarged(thickness));
        if self.cells.is_empty() {
            return;
        }
        let opposite = (OPPOSITE * other.0.lattice.cell_size() / body.0.lattice.cell_size()) as f32;
        let Self { own, own_positions, own_samples, cells, boxes, grid, blocks, near, .. } = self;
        let lengths = [opposite, thickness as f32];
        for (index, (own, group)) in own.iter_mut().zip(&body.1.cells).enumerate() {
            if own.bounds.is_empty() {
                continue;
            }
            near.clear();
            let touchable = || body.1.touchable_cells(body.0.lattice, body.0.touches_itself, index);
            let touchable = is_own.then(touchable);
            let bounds = own.bounds.enlarged(thickness);
            grid.any_within(&bounds, |index| {
                let found = &mut cells[index as usize];
                let sampled = &other.1.cells[found.group as usize];
                if !boxes[index as usize].1.intersects(&bounds)
                    || touchable.is_some_and(|cells| !cells.contains(sampled.cell))
                {
                    return false;
                }
                let (first, end) = *found.blocks.get_or_insert_with(|| {
                    let samples = sampled.samples.start as usize..sampled.samples.end as usize;
                    add_blocks(blocks, &found.cell, &other.1.samples[samples], opposite)
                });
                let (_, patch) = own.samples.get_or_insert_with(|| {
                    let corners = body.1.corners[group.cell as usize];
                    let cell = DeformedCell::new(&corners.map(|vertex| own_positions[vertex as usize]));
                    add_own_samples(own_samples, &cell, body.1, group.samples.clone())
                });
                near.extend((first..end).filter_map(|block| {
                    let least = patch.least_clearance(&blocks[block as usize].patch, lengths);
                    (least < own.distance).then_some((least, block))
                }));
                false
            });
            let Some(((first, end), _)) = own.samples else { continue };
            near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for sample in &mut own_samples[first as usize..end as usize] {
                let blocks = near.iter().map(|&(least, block)| (least, &blocks[block as usize]));
                dispatch!(level(), simd => sample.add_gaps(simd, blocks, is_own, (own.distance, lengths)));
            }
        }
    }
}

/// Returns the sum of the thicknesses of two bodies, in cells of the first one.
fn thickness(body: &Surfaced<'_>, other: &Surfaced<'_>) -> f64 {
    (body.0.properties.thickness + other.0.properties.thickness) / body.0.lattice.cell_size()
}

/// Sets the positions of the vertices of a body in the frame of another one.
fn set_positions(positions: &mut Vec<Point3<f64>>, body: &BodyView<'_>, own: &BodyView<'_>) {
    let vertices = 0..body.lattice.len() as u32;
    positions.clear();
    positions.extend(vertices.map(|vertex| Point3::from(own.state.frame.to_local(body.position(vertex)))));
}

/// Adds the samples of a cell of the body. Returns their range, and their patch.
fn add_own_samples(
    own_samples: &mut Vec<OwnSample>,
    cell: &DeformedCell,
    surface: &ContactSurface,
    samples: Range<u32>,
) -> ((u32, u32), Patch) {
    let first = own_samples.len();
    own_samples.extend(samples.map(|index| {
        let (position, normal) = pose(cell, &surface.samples[index as usize]);
        OwnSample { index, position, normal: normal.unwrap_or_default(), gaps: [None; SIDES] }
    }));
    let added = own_samples[first..].iter().map(|sample| (sample.position, sample.normal));
    ((first as u32, own_samples.len() as u32), Patch::of(added))
}

/// Adds the samples of a deformed cell, except those without a normal. Returns the range of their blocks.
fn add_blocks(blocks: &mut Vec<Block>, cell: &DeformedCell, samples: &[Sample], opposite: f32) -> (u32, u32) {
    let first = blocks.len();
    let mut block_of_side = [None; SIDES];
    for sample in samples {
        let ([x, y, z], Some([a, b, c])) = pose(cell, sample) else { continue };
        let side = side(&wide([a, b, c]));
        let index =
            block_of_side[side].filter(|&index: &usize| blocks[index].count < 8).unwrap_or_else(|| {
                let mut block = Block { side: side as u8, ..Block::default() };
                block.rows[6] = [f32::NEG_INFINITY; 8];
                blocks.push(block);
                blocks.len() - 1
            });
        block_of_side[side] = Some(index);
        let block = &mut blocks[index];
        for (row, value) in block.rows.iter_mut().zip([x, y, z, a, b, c, opposite]) {
            row[block.count as usize] = value;
        }
        block.count += 1;
    }
    for block in &mut blocks[first..] {
        let column = |first: usize, lane: usize| [0, 1, 2].map(|k| block.rows[first + k][lane]);
        block.patch = Patch::of((0..block.count as usize).map(|lane| (column(0, lane), column(3, lane))));
    }
    (first as u32, blocks.len() as u32)
}

/// Returns the position and the unit normal of a sample; no normal where its cell is flat or inside out.
fn pose(cell: &DeformedCell, sample: &Sample) -> ([f32; 3], Option<[f32; 3]>) {
    let local = sample.local.map(f64::from);
    let normal = cell.gradient(local).normal(&wide(sample.normal));
    (cell.position(local).map(|x| x as f32).into(), normal.map(|normal| normal.map(|x| x as f32).into()))
}

impl OwnSample {
    /// Adds the gaps to the samples in some blocks, each with a lower bound of the clearance.
    #[inline(always)]
    fn add_gaps<'a, S: Simd>(
        &mut self,
        simd: S,
        blocks: impl Iterator<Item = (f32, &'a Block)>,
        is_own: bool,
        (distance, lengths): (f32, [f32; 2]),
    ) {
        let zero = f32x8::splat(simd, 0.0);
        let none = f32x8::splat(simd, f32::INFINITY);
        let patch = Patch::of_sample(self.position, self.normal);
        for (least, block) in blocks {
            let known = self.gaps[usize::from(block.side)].map_or(distance, |gap| gap.clearance as f32);
            if least >= known || patch.least_clearance(&block.patch, lengths) >= known {
                continue;
            }
            let row = |k: usize| f32x8::load_array_ref(simd, &block.rows[k]);
            let (a, b, c) = (row(3), row(4), row(5));
            // Not a `map`: its closure would be compiled without the instructions of the SIMD level.
            let along = |k: usize| f32x8::splat(simd, self.position[k]) - row(k);
            let (x, y, z) = (along(0), along(1), along(2));
            let facing = a * self.normal[0] + b * self.normal[1] + c * self.normal[2];
            let gap = x * a + y * b + z * c;
            let aside = (x * x + y * y + z * z - gap * gap).max(zero).sqrt();
            let excess = (aside - row(6)).max(zero);
            let beside = gap * facing - (x * self.normal[0] + y * self.normal[1] + z * self.normal[2]);
            let growth = ((facing - FACING).max(zero) + beside.max(zero)) * GROWTH;
            let clearance = (gap - lengths[1]).max(zero) * 0.5 + excess + growth;
            let clearance = gap.simd_ge(-MAX_OVERLAP).select(clearance, none);
            let counts = clearance.simd_lt(known).to_bitmask();
            if counts == 0 {
                continue;
            }
            let clearances: [f32; 8] = clearance.into();
            let found = &mut self.gaps[usize::from(block.side)];
            for lane in (0..8).filter(|lane| counts >> lane & 1 != 0) {
                let clearance = f64::from(clearances[lane]);
                if found.is_none_or(|found| clearance < found.clearance) {
                    let normal = Vector3::from([3, 4, 5].map(|k: usize| f64::from(block.rows[k][lane])));
                    *found = Some(Gap { sample: self.index, normal, clearance, is_own });
                }
            }
        }
    }
}
