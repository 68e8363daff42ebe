//! The lattice of a displayed body.

use crate::body::Body;
use crate::lattice::{SlopeWeights, Slopes, Smoothing};
use crate::simd::xyzx::{Xyzx, xyzx};

/// The positions of the lattice vertices in an evaluation, in vertex order and in cells from the origin of the body.
#[derive(Debug, Default)]
pub(super) struct DisplayedLattice {
    /// P^: before the correction. Where cells are inside out, it is untangled, and later the start of the next correction;
    /// `Untangling::deformed` then has the positions of the dynamics.
    pub(super) deformed: Vec<[f32; 3]>,
    /// P~: after the correction. Not in use without a correction.
    pub(super) corrected: Vec<[f32; 3]>,
    /// Slope weights of `deformed`, if the skin is smooth. They are also those of `corrected`.
    pub(super) slope_weights: SlopeWeights,
    /// P~, or P^ without a correction, as the mesh update reads it: (x, y, z, x) of each vertex.
    xyzx: Vec<Xyzx>,
    /// Slopes of `xyzx` along the axes, if the skin is smooth.
    slopes: Vec<[Xyzx; 3]>,
}

impl DisplayedLattice {
    /// Sets P^ to the positions of the dynamics.
    pub(super) fn begin(&mut self, body: &Body) {
        let (state, slots) = (body.state(), body.matching().layout.slots());
        self.deformed.clear();
        self.deformed.extend(slots.iter().map(|&slot| state.positions.get(slot)));
    }

    /// Updates the slope weights of P^, if the skin is smooth.
    pub(super) fn update_slope_weights(&mut self, body: &Body) {
        if let Some(smoothing) = body.smoothing() {
            smoothing.update_slope_weights(&self.deformed, &mut self.slope_weights);
        }
    }

    /// Returns P~, or P^ without a correction.
    pub(super) fn displayed(&self, body: &Body) -> &[[f32; 3]] {
        if body.correction().is_some() { &self.corrected } else { &self.deformed }
    }

    /// Returns the displayed positions and, if the skin is smooth, their slopes, as the mesh update reads them.
    pub(super) fn for_mesh(
        &mut self,
        body: &Body,
        smoothing: Option<&Smoothing>,
    ) -> (&[Xyzx], Option<Slopes<'_>>) {
        let Self { deformed, corrected, slope_weights, xyzx: lattice, slopes } = self;
        let displayed = if body.correction().is_some() { corrected } else { deformed };
        lattice.clear();
        lattice.extend(displayed.iter().map(|&point| xyzx(point)));
        if let Some(smoothing) = smoothing {
            smoothing.update_slopes(lattice, slopes);
        }
        (lattice, smoothing.map(|_| Slopes { slopes, slope_weights: slope_weights.values() }))
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { deformed, corrected, slope_weights, xyzx, slopes } = self;
        size_of_val(&**deformed)
            + size_of_val(&**corrected)
            + size_of_val(&**xyzx)
            + size_of_val(&**slopes)
            + slope_weights.bytes()
    }
}
