//! Untangles the displayed lattice of a body, within limits at colliders and at bodies that it touches or that are
//! near.

use super::untangle::Untangler;
use crate::body::{Body, BodyRef};
use crate::clearance::{Clearance, Mover};
use crate::volume::{ComponentReport, Limits};

/// Distance in cells within which limits at colliders are searched first.
const SEARCH_DISTANCE: f64 = 2.0;

/// The first correction of a frame, if its result has inverted cells.
#[derive(Debug, Default)]
pub(super) struct FirstCorrection {
    /// Positions that were corrected.
    pub(super) start: Vec<[f32; 3]>,
    /// Corrected positions. Empty in a frame without inverted cells.
    pub(super) corrected: Vec<[f32; 3]>,
    /// Results of the correction.
    pub(super) components: Vec<ComponentReport>,
    /// Sums of the scales of the first and the later corrections, and of their magnitudes.
    scales: Vec<[f64; 2]>,
}

impl FirstCorrection {
    /// Keeps a correction, if it is the first one of the frame.
    pub(super) fn keep(
        &mut self,
        start: &[[f32; 3]],
        corrected: &[[f32; 3]],
        components: &[ComponentReport],
    ) {
        if self.corrected.is_empty() {
            self.start.clear();
            self.start.extend_from_slice(start);
            self.corrected.extend_from_slice(corrected);
            self.components.clear();
            self.components.extend_from_slice(components);
            self.scales.clear();
            self.scales.extend(components.iter().map(|component| [component.lambda, component.lambda.abs()]));
        }
    }

    /// Adds the scales of a later correction.
    pub(super) fn add_scales(&mut self, components: &[ComponentReport]) {
        for ([sum, magnitude], component) in self.scales.iter_mut().zip(components) {
            *sum += component.lambda;
            *magnitude += component.lambda.abs();
        }
    }

    /// Replaces the scales of the last correction by the sums, if the first correction was kept.
    pub(super) fn write_scales(&self, components: &mut [ComponentReport]) {
        if !self.corrected.is_empty() {
            for ([sum, _], component) in self.scales.iter().zip(components) {
                component.lambda = *sum;
            }
        }
    }

    /// Returns whether the first correction was kept, and restores the volume of a component better than `last`, or the
    /// scales of all corrections exceed their caps, in scene units.
    pub(super) fn is_better_than(&self, last: &[ComponentReport], caps: impl Iterator<Item = f64>) -> bool {
        let is_better = |(first, last): (&ComponentReport, &ComponentReport)| {
            last.capped && first.residual.abs() < last.residual.abs()
        };
        let exceeds = |([_, magnitude], (first, cap)): (&[f64; 2], (&ComponentReport, f64))| {
            *magnitude > cap.max(first.lambda.abs())
        };
        !self.corrected.is_empty()
            && (self.components.iter().zip(last).any(is_better)
                || self.scales.iter().zip(self.components.iter().zip(caps)).any(exceeds))
    }

    /// Returns the memory in bytes.
    fn bytes(&self) -> usize {
        let positions = size_of_val(&*self.start) + size_of_val(&*self.corrected);
        positions + size_of_val(&*self.components) + size_of_val(&*self.scales)
    }
}

/// Buffers for frames in which cells of the lattice are inside out.
#[derive(Debug, Default)]
pub(super) struct Untangling {
    pub(super) untangler: Untangler,
    /// Positions before the untangling.
    start: Vec<[f32; 3]>,
    /// P^, the positions that the dynamics have given, if the present frame was untangled.
    pub(super) deformed: Vec<[f32; 3]>,
    /// Volume of each component at `deformed`, in cubed scene units, if the volume is preserved.
    pub(super) volumes: Vec<f64>,
    pub(super) first: FirstCorrection,
}

impl Untangling {
    /// Returns the buffers, prepared for the lattice of a body. New buffers are in the state at the begin of a frame.
    pub(super) fn prepared<'a>(untangling: &'a mut Option<Box<Self>>, body: &Body) -> &'a mut Self {
        let untangling = untangling.get_or_insert_with(|| {
            let mut untangling = Box::<Self>::default();
            untangling.begin(body.lattice().len());
            untangling
        });
        untangling.untangler.prepare(body.lattice(), body.constrained_vertices());
        untangling
    }

    /// Begins a frame of a lattice with this number of vertices.
    pub(super) fn begin(&mut self, vertices: usize) {
        self.untangler.begin(vertices);
        self.deformed.clear();
        self.volumes.clear();
        self.first.corrected.clear();
    }

    /// Returns whether the present frame was untangled.
    pub(super) fn is_present(&self) -> bool {
        !self.deformed.is_empty()
    }

    /// Returns P^, if the present frame was untangled.
    pub(super) fn deformed(&self) -> Option<&[[f32; 3]]> {
        self.is_present().then_some(&self.deformed)
    }

    /// Untangles a lattice within the limits of its displacements. If they are not complete after the last round, or when
    /// the frame has no displacement left, the lattice stays as it was.
    pub(super) fn untangle(
        &mut self,
        body: BodyRef<'_>,
        clearance: &mut Clearance,
        positions: &mut [[f32; 3]],
    ) {
        let Self { untangler, start, .. } = self;
        start.clear();
        start.extend_from_slice(positions);
        let mut untangled = Untangled { untangler, start, positions };
        if !clearance.move_clear(body, start, SEARCH_DISTANCE, &mut untangled) {
            positions.copy_from_slice(start);
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.untangler.bytes()
            + size_of_val(&*self.start)
            + size_of_val(&*self.deformed)
            + size_of_val(&*self.volumes)
            + self.first.bytes()
    }
}

/// A lattice that is untangled from a start.
struct Untangled<'a> {
    untangler: &'a mut Untangler,
    start: &'a [[f32; 3]],
    positions: &'a mut [[f32; 3]],
}

impl Mover for Untangled<'_> {
    fn move_within(&mut self, limits: &Limits) -> &[[f32; 3]] {
        self.positions.copy_from_slice(self.start);
        self.untangler.untangle(limits, self.start, self.positions);
        self.positions
    }
}
