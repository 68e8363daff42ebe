//! The buffers of the evaluation of displayed surfaces.

use web_time::Duration;

use super::body_limits::BodyLimits;
use super::untangling::Untangling;
use crate::lattice::Trust;
use crate::matching::Workspace;
use crate::simd::lanes::Lanes;
use crate::simd::xyzx::Xyzx;
use crate::skin::SkinBuffers;
use crate::volume::{ComponentReport, CorrectionWorkspace, ExternalForce};

/// Evaluates displayed surfaces, and owns the buffers of the evaluation.
///
/// A `Display` that always evaluates the same body allocates in the first frame, when the constrained vertices
/// change, and in frames in which cells of the lattice are inside out.
/// [`Displayed::surface`](super::Displayed::surface) also allocates its result in each call;
/// [`Displayed::surface_into`](super::Displayed::surface_into) does not. A `Display` can evaluate several bodies, but one
/// `Display` per body is faster.
#[derive(Debug, Default)]
pub struct Display {
    pub(super) matching_workspace: Workspace,
    pub(super) correction: CorrectionWorkspace,
    pub(super) skin: SkinBuffers,
    /// P^: lattice positions before the correction, in cells from the origin of the body, in vertex order.
    pub(super) deformed: Vec<[f32; 3]>,
    /// P~: lattice positions after the correction, in the units and the order of `deformed`.
    pub(super) corrected: Vec<[f32; 3]>,
    /// P~, or P^ without a correction, as the mesh update reads it: (x, y, z, x) of each vertex.
    pub(super) xyzx: Vec<Xyzx>,
    /// Slopes of `xyzx` along the axes, if the skin is smooth.
    pub(super) slopes: Vec<[Xyzx; 3]>,
    /// Trust in the slopes of `deformed`, if the skin is smooth. It also holds for `corrected`.
    pub(super) trust: Trust,
    /// Rotations fitted to the current positions, by slot (see [`Lanes`]). The rotations of the state are
    /// fitted to the positions one step earlier.
    pub(super) slot_rotations: Lanes<4>,
    /// `slot_rotations` in vertex order.
    pub(super) rotations: Vec<[f32; 4]>,
    pub(super) external_forces: Vec<ExternalForce>,
    /// Finds the limits of the correction at other bodies.
    pub(super) body_limits: BodyLimits,
    pub(super) components: Vec<ComponentReport>,
    /// Present after the first frame in which a cell of the lattice was inside out.
    pub(super) untangling: Option<Box<Untangling>>,
    pub(super) times: DisplayTimes,
}

/// Run times of the evaluation of the displayed surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DisplayTimes {
    /// Time of the volume correction, including the fit of the region rotations, by which the field V is
    /// rotated, and of the untangling of a lattice with cells inside out.
    pub volume: Duration,
    /// Time of the last mesh update (interpolation, and normals if they were requested). Zero
    /// before the first mesh update of an evaluation.
    pub mesh_update: Duration,
}

impl Display {
    /// Creates a display with empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the memory of the buffers, in bytes.
    pub fn bytes(&self) -> usize {
        let slopes = size_of_val(&*self.slopes) + self.trust.bytes();
        let lattice =
            size_of_val(&*self.deformed) + size_of_val(&*self.corrected) + size_of_val(&*self.xyzx) + slopes;
        let correction = self.correction.bytes() + size_of_val(&*self.external_forces);
        let correction = correction + self.body_limits.bytes();
        let rotations = self.slot_rotations.bytes() + size_of_val(&*self.rotations);
        let untangling = self.untangling.as_ref().map_or(0, |untangling| untangling.bytes());
        lattice + correction + self.matching_workspace.bytes() + rotations + self.skin.bytes() + untangling
    }
}
