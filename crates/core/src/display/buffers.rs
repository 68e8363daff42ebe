//! The buffers of the evaluation of displayed surfaces.

use web_time::Duration;

use super::correcting::Correcting;
use super::lattice::DisplayedLattice;
use super::untangling::Untangling;
use crate::clearance::Clearance;
use crate::skin::SkinBuffers;

/// Evaluates displayed surfaces, and owns the buffers of the evaluation.
///
/// A `Display` that always evaluates the same body allocates in the first frame, when the constrained vertices
/// change, and in frames in which cells of the lattice are inside out.
/// [`Displayed::surface`](super::Displayed::surface) also allocates its result in each call;
/// [`Displayed::surface_into`](super::Displayed::surface_into) does not. A `Display` can evaluate several bodies, but
/// one `Display` per body is faster.
#[derive(Debug, Default)]
pub struct Display {
    pub(super) lattice: DisplayedLattice,
    pub(super) correcting: Correcting,
    /// Finds the limits of the untangling and of the correction.
    pub(super) clearance: Clearance,
    /// Present after the first frame in which a cell of the lattice was inside out.
    pub(super) untangling: Option<Box<Untangling>>,
    pub(super) skin: SkinBuffers,
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
        let Self { lattice, correcting, clearance, untangling, skin, times: _ } = self;
        let untangling = untangling.as_ref().map_or(0, |untangling| untangling.bytes());
        lattice.bytes() + correcting.bytes() + clearance.bytes() + untangling + skin.bytes()
    }
}
