//! Slopes of the lattice at the rows of the samples, for a body with a smooth skin.
//!
//! A row is an index into `SampleCells::vertices`.

use super::memory::buffer_bytes;
use super::vec4::Vec4;
use crate::lattice::Stencil;

/// Slopes of the lattice vertices of all rows, and the trust in them; see `lattice::slopes`.
#[derive(Clone, Debug, Default)]
pub(crate) struct SmoothRows {
    slopes: Vec<[Vec4; 3]>,
    /// See `Stencil::bend`.
    bends: Vec<f32>,
    trust: Vec<f32>,
}

/// Slopes and trust of all rows, as an interpolation reads them.
#[derive(Clone, Copy)]
pub(crate) struct RowSlopes<'a> {
    pub(crate) slopes: &'a [[Vec4; 3]],
    pub(crate) trust: &'a [f32],
}

impl SmoothRows {
    /// Computes the slopes of the positions of all rows.
    pub(crate) fn update_slopes(&mut self, stencils: &[Stencil], positions: &[Vec4]) {
        self.slopes.clear();
        self.slopes.extend(stencils.iter().map(|stencil| stencil.slopes(|row| positions[row as usize])));
    }

    /// Computes the trust in the slopes of the positions of all rows.
    pub(crate) fn update_trust(&mut self, stencils: &[Stencil], positions: &[Vec4]) {
        let Self { bends, trust, .. } = self;
        let bend = |stencil: &Stencil| match stencil.is_isolated() {
            true => 0.0,
            false => stencil.bend(|row| positions[row as usize].xyz()),
        };
        bends.clear();
        bends.extend(stencils.iter().map(bend));
        trust.clear();
        trust.extend(stencils.iter().map(|stencil| stencil.trust(|row| bends[row as usize])));
    }

    /// Returns the slopes of the last update, with the trust in the slopes of `trusted`.
    pub(crate) fn with_trust_of<'a>(&'a self, trusted: &'a Self) -> RowSlopes<'a> {
        RowSlopes { slopes: &self.slopes, trust: &trusted.trust }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        buffer_bytes(&self.slopes) + buffer_bytes(&self.bends) + buffer_bytes(&self.trust)
    }
}
