//! Finds the gaps between the surfaces of a body and of the bodies around it.
//!
//! The volume correction moves both surfaces at a gap, so each of them may take half of it. A gap is measured between
//! samples of two surfaces, along the normal of the other one. Positions and distances are in cells of the body, from its
//! origin.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};
use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;
use super::deformed_cell::DeformedCell;
use super::grid::Grid;
use super::surface::{ContactSurface, Sample};
use super::view::BodyView;
use crate::contact::memory::buffer_bytes;
use crate::simd::level;

/// Distance along the surface, in cells of the other body, up to which a sample is opposite to one of the other body,
/// whose samples are at most half a cell apart. Beyond it, the clearance grows by the distance, so that no gap begins
/// or ends suddenly.
const OPPOSITE: f64 = 0.5;

/// Product of two normals above which the clearance grows, for the same reason, by [`GROWTH`] times the difference. A
/// surface at a right angle to the other one can move into it sideways.
const FACING: f32 = 0.25;

/// Growth of the clearance with the product of the normals, and with the distance by which a sample of the other surface
/// lies in front of the own one sideways: the gap there is one to another side of the other body.
const GROWTH: f32 = 4.0;

/// Greatest overlap. Samples that are deeper face each other through a thin body.
const MAX_OVERLAP: f32 = 0.25;

/// Number of sides of normals.
pub(crate) const SIDES: usize = 6;

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

/// The search for the gaps of one body after another. Its buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct GapSearch {
    /// Positions of the lattice vertices of a body.
    positions: Vec<Point3<f64>>,
    /// The cells of the body with samples.
    own: Vec<OwnCell>,
    /// The samples of the body.
    own_samples: Vec<OwnSample>,
    /// Cells with samples of the other surface that are near the body.
    cells: Vec<OtherCell>,
    /// The box of each of `cells`.
    boxes: Vec<(u32, Bounds)>,
    /// The bins of `boxes`.
    grid: Grid,
    /// The samples of the `cells` that are near a cell of the body.
    blocks: Vec<Block>,
    /// The `cells` near the present cell of the body, in increasing order of the distance of the boxes: the distance, and
    /// the range of `blocks`.
    near: Vec<(f32, (u32, u32))>,
}

/// A cell of the body with samples.
#[derive(Clone, Debug)]
struct OwnCell {
    cell: DeformedCell,
    /// Greatest clearance that counts.
    distance: f32,
    /// Its box, and this box enlarged by the greatest gap.
    cell_bounds: Bounds,
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
    /// The cell of the body for which it was found last.
    found_for: Option<u32>,
}

/// Eight samples of a deformed surface.
#[derive(Clone, Debug, Default)]
struct Block {
    /// Rows of numbers: positions, unit normals, and distances up to which a sample is opposite.
    rows: [[f32; 8]; 7],
    /// The greatest of these distances.
    opposite: f32,
    /// The [`side`]s of the normals, one bit each.
    sides: u8,
    /// A sphere that contains the samples.
    center: Vector3<f32>,
    radius: f32,
}

/// A body, and its surface.
type Surfaced<'a> = (BodyView<'a>, &'a ContactSurface);

impl GapSearch {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { own, own_samples, positions, cells, boxes, grid, blocks, near } = self;
        let own = buffer_bytes(own) + buffer_bytes(own_samples);
        let others = buffer_bytes(positions) + buffer_bytes(cells) + buffer_bytes(boxes) + grid.bytes();
        own + others + buffer_bytes(blocks) + buffer_bytes(near)
    }

    /// Calls `visit` for the gaps of a body to another body, or to the body itself if `touches_itself`: for each sample
    /// and [`side`] the one with the least clearance, if it is less than the greatest `distance` of a corner of the sample's
    /// cell. Surfaces that are not closed have no gaps.
    ///
    /// * `distance`: returns the greatest clearance that counts at a lattice vertex.
    pub(crate) fn find<'a>(
        &mut self,
        body: Surfaced<'a>,
        others: impl Iterator<Item = Surfaced<'a>>,
        touches_itself: bool,
        distance: impl Fn(u32) -> f64,
        visit: impl FnMut(Gap),
    ) {
        if !body.1.is_closed {
            return;
        }
        self.begin(&body, distance);
        for other in others.filter(|(_, surface)| surface.is_closed) {
            self.set_positions(&other.0, &body.0);
            self.find_near(&body, &other, false);
        }
        if touches_itself {
            self.set_positions(&body.0, &body.0);
            self.find_near(&body, &body, true);
        }
        self.own_samples.iter().flat_map(|sample| sample.gaps).flatten().for_each(visit);
    }

    /// Begins the search of a body for clearances of at most `distance`.
    fn begin(&mut self, (body, surface): &Surfaced<'_>, distance: impl Fn(u32) -> f64) {
        self.set_positions(body, body);
        self.own_samples.clear();
        self.own.clear();
        self.own.extend(surface.cells.iter().map(|group| {
            let vertices = surface.corners[group.cell as usize];
            let corners = vertices.map(|vertex| self.positions[vertex as usize]);
            let distance = vertices.into_iter().map(&distance).fold(0.0, f64::max);
            let cell_bounds = Bounds::of(corners);
            let bounds = cell_bounds.enlarged(2.0 * distance);
            let cell = DeformedCell::new(&corners);
            OwnCell { cell, distance: distance as f32, cell_bounds, bounds, samples: None }
        }));
    }

    /// Sets the positions of the vertices of a body in the frame of another one.
    fn set_positions(&mut self, body: &BodyView<'_>, own: &BodyView<'_>) {
        let vertices = 0..body.lattice.len() as u32;
        self.positions.clear();
        self.positions
            .extend(vertices.map(|vertex| Point3::from(own.state.frame.to_local(body.position(vertex)))));
    }

    /// Lists the cells of a surface that are near the body.
    fn add_cells(&mut self, surface: &ContactSurface) {
        let Self { own, positions, cells, boxes, grid, blocks, .. } = self;
        let all = own.iter().fold(Bounds::EMPTY, |all, cell| all.union(&cell.bounds));
        cells.clear();
        boxes.clear();
        blocks.clear();
        for (group, sampled) in (0..).zip(&surface.cells) {
            let corners = surface.corners[sampled.cell as usize].map(|vertex| positions[vertex as usize]);
            let bounds = Bounds::of(corners);
            if bounds.intersects(&all) {
                let cell = DeformedCell::new(&corners);
                boxes.push((cells.len() as u32, bounds));
                cells.push(OtherCell { cell, group, blocks: None, found_for: None });
            }
        }
        grid.fill(boxes, &all, 1.0);
    }

    /// Finds the clearances to another body, or to the body itself.
    fn find_near(&mut self, body: &Surfaced<'_>, other: &Surfaced<'_>, is_own: bool) {
        self.add_cells(other.1);
        let opposite = (OPPOSITE * other.0.lattice.cell_size() / body.0.lattice.cell_size()) as f32;
        let Self { own, own_samples, cells, boxes, grid, blocks, near, .. } = self;
        let touch = |cells| body.1.cells_touch(body.0.lattice, body.0.touches_itself, cells);
        for (own, group) in own.iter_mut().zip(&body.1.cells) {
            near.clear();
            if own.distance <= 0.0 {
                continue;
            }
            for bin in grid.bins(&own.bounds) {
                for &index in grid.cells_of(bin) {
                    let found = &mut cells[index as usize];
                    let sampled = &other.1.cells[found.group as usize];
                    let is_new = found.found_for != Some(group.cell)
                        && (!is_own || touch([group.cell, sampled.cell]))
                        && boxes[index as usize].1.intersects(&own.bounds);
                    if is_new {
                        found.found_for = Some(group.cell);
                        let range = *found.blocks.get_or_insert_with(|| {
                            let samples = sampled.samples.start as usize..sampled.samples.end as usize;
                            add_blocks(blocks, &found.cell, &other.1.samples[samples], opposite)
                        });
                        near.push((own.cell_bounds.distance(&boxes[index as usize].1) as f32, range));
                    }
                }
            }
            if near.is_empty() {
                continue;
            }
            near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let (first, end) = *own.samples.get_or_insert_with(|| {
                let first = own_samples.len() as u32;
                own_samples.extend(group.samples.clone().map(|index| {
                    let (position, normal) = pose(&own.cell, &body.1.samples[index as usize]);
                    OwnSample { index, position, normal: normal.unwrap_or_default(), gaps: [None; SIDES] }
                }));
                (first, own_samples.len() as u32)
            });
            for sample in &mut own_samples[first as usize..end as usize] {
                let blocks = near.iter().flat_map(|&(_, (first, end))| &blocks[first as usize..end as usize]);
                dispatch!(level(), simd => sample.add_gaps(simd, blocks, is_own, own.distance));
            }
        }
    }
}

/// Returns the side of a unit normal: its dominant axis and the sign along it.
pub(crate) fn side(normal: &Vector3<f64>) -> usize {
    let axis = normal.iamax();
    axis + if normal[axis] < 0.0 { 3 } else { 0 }
}

/// Adds the samples of a deformed cell. Returns the range of their blocks.
fn add_blocks(blocks: &mut Vec<Block>, cell: &DeformedCell, samples: &[Sample], opposite: f32) -> (u32, u32) {
    let first = blocks.len() as u32;
    for eight in samples.chunks(8) {
        let mut block = Block { opposite, ..Block::default() };
        // Samples without a normal, and those that fill up a block, are opposite to none.
        block.rows[6] = [f32::NEG_INFINITY; 8];
        let mut bounds = Bounds::EMPTY;
        for (lane, sample) in eight.iter().enumerate() {
            if let ([x, y, z], Some([a, b, c])) = pose(cell, sample) {
                for (row, value) in block.rows.iter_mut().zip([x, y, z, a, b, c, opposite]) {
                    row[lane] = value;
                }
                block.sides |= 1 << side(&Vector3::new(a, b, c).map(f64::from));
                bounds = bounds.union(&Bounds::of([Point3::new(x, y, z).map(f64::from)]));
            }
        }
        if block.sides != 0 {
            (block.center, block.radius) = bounds.sphere();
            blocks.push(block);
        }
    }
    (first, blocks.len() as u32)
}

/// Returns the position and the unit normal of a sample; no normal where its cell is flat or inside out.
fn pose(cell: &DeformedCell, sample: &Sample) -> ([f32; 3], Option<[f32; 3]>) {
    let local = sample.local.map(f64::from);
    let normal = cell.gradient(local).normal(&Vector3::from(sample.normal.map(f64::from)));
    (cell.position(local).map(|x| x as f32).into(), normal.map(|normal| normal.map(|x| x as f32).into()))
}

impl OwnSample {
    /// Returns whether no sample of a block has a gap with less clearance than the gaps that are found, or than `distance`.
    fn is_beyond(&self, block: &Block, distance: f32) -> bool {
        let nearest = (Vector3::from(self.position) - block.center).norm() - block.radius;
        let Block { opposite, sides, .. } = *block;
        if nearest <= opposite {
            return false;
        }
        // Of samples at a distance r, the clearance is least either straight ahead, up to the distance at which they are
        // opposite, or sideways.
        let least = (nearest - opposite).min(0.5 * (nearest * nearest - opposite * opposite).sqrt());
        let is_farther = |gap: &Option<Gap>| gap.is_some_and(|gap| gap.clearance <= f64::from(least));
        let mut of_block = self.gaps.iter().enumerate().filter(|(side, _)| sides >> side & 1 != 0);
        least >= distance || of_block.all(|(_, gap)| is_farther(gap))
    }

    /// Adds the gaps to the samples in some blocks.
    #[inline(always)]
    fn add_gaps<'a, S: Simd>(
        &mut self,
        simd: S,
        blocks: impl Iterator<Item = &'a Block>,
        is_own: bool,
        distance: f32,
    ) {
        let zero = f32x8::splat(simd, 0.0);
        let none = f32x8::splat(simd, f32::INFINITY);
        for block in blocks {
            if self.is_beyond(block, distance) {
                continue;
            }
            let row = |k: usize| f32x8::load_array_ref(simd, &block.rows[k]);
            let (a, b, c) = (row(3), row(4), row(5));
            let [x, y, z] = [0, 1, 2].map(|k| f32x8::splat(simd, self.position[k]) - row(k));
            let facing = a * self.normal[0] + b * self.normal[1] + c * self.normal[2];
            let gap = x * a + y * b + z * c;
            let aside = (x * x + y * y + z * z - gap * gap).max(zero).sqrt();
            let excess = (aside - row(6)).max(zero);
            let beside = gap * facing - (x * self.normal[0] + y * self.normal[1] + z * self.normal[2]);
            let growth = ((facing - FACING).max(zero) + beside.max(zero)) * GROWTH;
            let clearance = gap.max(zero) * 0.5 + excess + growth;
            let clearance = gap.simd_ge(-MAX_OVERLAP).select(clearance, none);
            let counts = clearance.simd_lt(distance).to_bitmask();
            if counts == 0 {
                continue;
            }
            let clearances: [f32; 8] = clearance.into();
            for lane in (0..8).filter(|lane| counts >> lane & 1 != 0) {
                let normal = Vector3::from([3, 4, 5].map(|k: usize| f64::from(block.rows[k][lane])));
                let (found, clearance) = (&mut self.gaps[side(&normal)], f64::from(clearances[lane]));
                if found.is_none_or(|found| clearance < found.clearance) {
                    *found = Some(Gap { sample: self.index, normal, clearance, is_own });
                }
            }
        }
    }
}
