//! Finds the samples that touch a shape by their paths in the step: see `sides`.

use fearless_simd::{Simd, SimdBase, f64x4};
use nalgebra::{Point3, Vector3};

use super::field::{Aabb, Field, ShapeField};
use super::interpolant::monomials;
use super::memory::buffer_bytes;
use super::posed_collider::PosedCollider;
use super::samples::{SampleBlock, SampleCells};
use super::sides::{Side, SidedContact};
use super::vec4::{Vec4, read};
use crate::simd::lanes::{LANES, Lanes};

/// The paths of the samples of a body in a step, and their side points.
#[derive(Clone, Debug, Default)]
pub(super) struct Paths {
    /// Position before the step of the vertex of each row, in the body's frame. Empty until a collider is not a plane.
    starts: Vec<Vec4>,
    /// Displacement of the vertex of each row from the position before the step.
    displacements: Vec<Vec4>,
    /// Greatest displacement in the step, in cells.
    greatest: f64,
    /// Side points, in the order of collider and sample.
    sides: Vec<Side>,
    /// Side points of the next step.
    next: Vec<Side>,
}

/// Samples of a block that touch: by lane, `None` for the others.
pub(super) type BlockContacts = [Option<SidedContact>; LANES];

/// A search for the samples of a body that touch one collider.
pub(super) struct Sweep<'a> {
    pub(super) collider: &'a PosedCollider<'a>,
    pub(super) field: ShapeField<'a>,
    /// Displacements of the rows, as positions.
    displacements: ShapeField<'a>,
    /// Greatest displacement of a sample relative to the collider, in cells.
    motion: f64,
    /// Side points at this collider.
    sides: &'a [Side],
}

impl Paths {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let sides = buffer_bytes(&self.sides) + buffer_bytes(&self.next);
        buffer_bytes(&self.starts) + buffer_bytes(&self.displacements) + sides
    }

    /// Begins a step: computes the positions before the step from those at its end and the velocities.
    pub(super) fn begin(&mut self, positions: &[Vec4], velocities: &Lanes<3>, slots: &[u32], dt: f64) {
        let Self { starts, displacements, greatest, .. } = self;
        displacements.resize(positions.len(), Vec4::zeros());
        read(displacements, velocities, slots);
        let mut extent = [0.0_f32; 4];
        for displacement in displacements.iter_mut() {
            *displacement *= dt as f32;
            for c in 0..4 {
                let length = displacement[c].abs();
                extent[c] = if length > extent[c] { length } else { extent[c] };
            }
        }
        *greatest = extent.into_iter().map(|x| f64::from(x).powi(2)).sum::<f64>().sqrt();
        starts.clear();
        starts.extend(
            positions.iter().zip(&*displacements).map(|(position, displacement)| position - displacement),
        );
    }

    /// Updates the displacements after contacts changed the positions.
    pub(super) fn update(&mut self, positions: &[Vec4]) {
        for ((displacement, position), start) in
            self.displacements.iter_mut().zip(positions).zip(&self.starts)
        {
            *displacement = position - start;
        }
    }

    /// Returns the greatest displacement of a sample relative to a collider, in cells, or `None` if the collider does
    /// not need the sides of the samples. `bounds`: of the positions of the vertices.
    pub(super) fn motion(&self, collider: &PosedCollider<'_>, bounds: &Aabb) -> Option<f64> {
        if collider.shape.plane().is_some() || self.starts.is_empty() {
            return None;
        }
        let motion = self.greatest + collider.greatest_displacement(bounds);
        (collider.shape.needs_sides(motion) || !self.sides_at(collider.index).is_empty()).then_some(motion)
    }

    /// Returns the side points at a collider.
    pub(super) fn sides_at(&self, index: u32) -> &[Side] {
        let at = |index| self.sides.partition_point(|side| side.collider < index);
        if self.sides.is_empty() { &[] } else { &self.sides[at(index)..at(index + 1)] }
    }

    /// Returns the search at a collider for which [`motion`](Self::motion) returned a number.
    pub(super) fn sweep<'a>(
        &'a self,
        collider: &'a PosedCollider<'a>,
        field: ShapeField<'a>,
        motion: f64,
    ) -> Sweep<'a> {
        let displacements = ShapeField { positions: &self.displacements, slopes: None, ..field };
        Sweep { collider, field, displacements, motion, sides: self.sides_at(collider.index) }
    }

    /// Returns an empty buffer for the side points of the next step.
    pub(super) fn take_scratch(&mut self) -> Vec<Side> {
        std::mem::take(&mut self.next)
    }

    /// Replaces the side points. They must be in the order of collider and sample.
    pub(super) fn replace_sides(&mut self, sides: Vec<Side>) {
        self.next = std::mem::replace(&mut self.sides, sides);
        self.next.clear();
    }

    /// Removes all side points.
    pub(super) fn clear_sides(&mut self) {
        self.sides.clear();
    }

    /// Returns the side points, for a snapshot.
    pub(super) fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// Restores side points. Ignores side points of another body, one with more than `samples` samples.
    pub(super) fn set_sides(&mut self, sides: &[Side], samples: usize) {
        self.sides.clear();
        self.sides.extend(sides.iter().filter(|side| (side.sample as usize) < samples));
        self.sides.sort_unstable_by_key(|side| (side.collider, side.sample));
    }
}

impl Sweep<'_> {
    /// Calls `visit` for each block with touching samples, in order: with the rows of the corners of its cell, its
    /// index, the block, the positions of its samples, and the contacts.
    #[inline(always)]
    pub(super) fn search<S: Simd>(
        &self,
        simd: S,
        samples: &SampleCells,
        skin: f64,
        mut visit: impl FnMut(&[u32; 8], (u32, &SampleBlock), &[Point3<f64>; LANES], &BlockContacts),
    ) {
        let distance = skin + self.motion;
        for (rows, cells) in samples.strips() {
            let has_sides = !self.sides_in(samples.block_range(cells.clone())).is_empty();
            if !has_sides && !self.field.may_touch(rows, distance) {
                continue;
            }
            for cell in cells {
                let corners = &samples.corners[cell];
                let blocks = samples.block_range(cell..cell + 1);
                let sides = self.sides_in(blocks.clone());
                if sides.is_empty() && !self.field.may_touch(corners, distance) {
                    continue;
                }
                let interpolants = (self.field.cell(corners), self.displacements.cell(corners));
                for (index, block) in blocks.zip(samples.cell_blocks(cell)) {
                    let monomials: [_; 2] = monomials(simd, &block.positions);
                    let mut ends = [Point3::origin(); LANES];
                    let mut displaced = [Point3::origin(); LANES];
                    for half in 0..block.halves() {
                        let positions = self.field.positions(simd, &interpolants.0, &monomials[half]);
                        let moved = self.displacements.positions(simd, &interpolants.1, &monomials[half]);
                        ends[4 * half..4 * half + 4].copy_from_slice(&positions);
                        displaced[4 * half..4 * half + 4].copy_from_slice(&moved);
                    }
                    let mut contacts = [None; LANES];
                    let mut touches = false;
                    for lane in 0..LANES {
                        if block.fractions[lane] > 0.0 {
                            let sample = index * LANES as u32 + lane as u32;
                            contacts[lane] =
                                self.contact(sample, &ends[lane], &displaced[lane].coords, skin, sides);
                            touches |= contacts[lane].is_some();
                        }
                    }
                    if touches {
                        visit(corners, (index, block), &ends, &contacts);
                    }
                }
            }
        }
    }

    /// Returns the contact of a sample.
    fn contact(
        &self,
        sample: u32,
        end: &Point3<f64>,
        displacement: &Vector3<f64>,
        skin: f64,
        sides: &[Side],
    ) -> Option<SidedContact> {
        let start = match sides.iter().find(|side| side.sample == sample) {
            Some(side) => self.collider.posed_point(&side.point.into()),
            None => self.collider.carried(&(end - displacement)),
        };
        self.collider.shape.sided_contact(&start, end, skin)
    }

    /// Returns the side points of the samples in a range of blocks.
    fn sides_in(&self, blocks: std::ops::Range<u32>) -> &[Side] {
        let at = |block: u32| self.sides.partition_point(|side| side.sample / (LANES as u32) < block);
        if self.sides.is_empty() { self.sides } else { &self.sides[at(blocks.start)..at(blocks.end)] }
    }
}

/// Returns the distances of the contacts, infinite for samples that do not touch.
#[inline(always)]
pub(super) fn distances<S: Simd>(simd: S, contacts: &BlockContacts) -> [f64x4<S>; 2] {
    let mut distances = [f64::INFINITY; LANES];
    for lane in 0..LANES {
        if let Some(contact) = &contacts[lane] {
            distances[lane] = contact.distance;
        }
    }
    [f64x4::from_slice(simd, &distances[..4]), f64x4::from_slice(simd, &distances[4..])]
}
