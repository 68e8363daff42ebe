//! The buffers and results of a correction.

use nalgebra::Vector3;

use super::ramp::Ramp;
use crate::skin::ComponentMotion;
use crate::volume::ComponentReport;
use crate::volume::limits::Motion;
use crate::volume::line::Moving;
use crate::volume::regional::RegionalScratch;
use crate::volume::sums::Scratch;

/// Buffers and results of a [`Correction`](super::Correction).
///
/// One workspace may serve several corrections in sequence. It stops allocating once its buffers have the
/// size that the largest correction needs.
#[derive(Clone, Debug, Default)]
pub struct CorrectionWorkspace {
    /// Rest volume of each component in force, in cubed cells.
    pub(super) rest: Vec<f64>,
    pub(super) ramp: Option<Ramp>,
    pub(super) scratch: Scratch,
    pub(super) regional: RegionalScratch,
    /// Pairs `(vertex, index)` of the external forces, sorted.
    pub(super) order: Vec<(u32, u32)>,
    pub(super) passes: Passes,
    /// Displacement of each vertex, in cells, to which `lambda` times its direction is added. Empty if all are
    /// zero.
    pub(super) offsets: Vec<[f32; 3]>,
    /// Vertices with limits, in increasing order.
    pub(super) limited: Vec<LimitedVertex>,
    /// Whether the volume of each component is restored without limits.
    pub(super) restored: Vec<bool>,
    /// Whether the surface points of `scratch` move from the present points along the present field.
    pub(super) has_surface: bool,
    /// `lambda` of each component, in cells.
    pub(super) lambdas: Vec<f64>,
    /// Motions of the surface points of each component.
    pub(super) motions: Vec<ComponentMotion>,
    pub(super) reports: Vec<ComponentReport>,
}

impl CorrectionWorkspace {
    /// Returns the memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.rest)
            + self.ramp.as_ref().map_or(0, Ramp::bytes)
            + self.scratch.bytes()
            + self.regional.bytes()
            + size_of_val(&*self.order)
            + self.passes.bytes()
            + size_of_val(&*self.offsets)
            + size_of_val(&*self.limited)
            + size_of_val(&*self.restored)
            + size_of_val(&*self.lambdas)
            + size_of_val(&*self.motions)
            + size_of_val(&*self.reports)
    }
}

/// Vertex with limits, and its state in the active set.
#[derive(Clone, Copy, Debug)]
pub(super) struct LimitedVertex {
    pub(super) vertex: u32,
    /// The point of the vertex without limits.
    pub(super) free: Moving,
    pub(super) motion: Motion,
    /// Displacement at the current `lambda`, in cells.
    pub(super) displacement: Vector3<f64>,
}

/// Buffers of the passes.
#[derive(Clone, Debug, Default)]
pub(super) struct Passes {
    /// Points before the passes, with the rotated field.
    pub(super) start: Vec<Moving>,
    pub(super) components: Vec<Component>,
}

/// State of a component of the lattice.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Component {
    /// Whether the volume has not been restored.
    pub(super) unsolved: bool,
    /// Whether the component takes part in the next pass.
    pub(super) active: bool,
    /// Greatest sum of the magnitudes of the scales of further passes, in cells.
    pub(super) budget: f64,
    /// Volume error after the last pass, in cubed cells; infinite before the first pass.
    pub(super) excess: f64,
    /// Scale and volume error of the single cubic.
    pub(super) single: [f64; 2],
    /// Greatest length of a direction.
    pub(super) greatest: f64,
}

impl Passes {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.start) + size_of_val(&*self.components)
    }
}
