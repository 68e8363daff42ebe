//! Slopes of the lattice at the rows of the samples, for a body with a smooth skin.
//!
//! A row is an index into `SampleCells::vertices`.

use super::memory::buffer_bytes;
use super::samples::SampleCells;
use super::vec4::Vec4;
use crate::lattice::Stencil;

/// Slopes and slope weights of the lattice vertices of all rows; see `lattice::slopes`.
#[derive(Clone, Debug, Default)]
pub(super) struct SmoothRows {
    slopes: Vec<[Vec4; 3]>,
    /// See `Stencil::bend`.
    bends: Vec<f32>,
    slope_weights: Vec<f32>,
}

/// Slopes and slope weights of all rows, as an interpolation reads them.
#[derive(Clone, Copy)]
pub(super) struct RowSlopes<'a> {
    pub(super) slopes: &'a [[Vec4; 3]],
    pub(super) slope_weights: &'a [f32],
}

impl SmoothRows {
    /// Computes the slopes of the positions of all rows.
    pub(super) fn update_slopes(&mut self, stencils: &[Stencil], positions: &[Vec4]) {
        self.slopes.clear();
        self.slopes.extend(stencils.iter().map(|stencil| stencil.slopes(|row| positions[row as usize])));
    }

    /// Computes the slope weights of the positions of all rows.
    pub(super) fn update_slope_weights(&mut self, stencils: &[Stencil], positions: &[Vec4]) {
        let Self { bends, slope_weights, .. } = self;
        let bend = |stencil: &Stencil| match stencil.is_isolated() {
            true => 0.0,
            false => stencil.bend(|row| positions[row as usize].xyz()),
        };
        bends.clear();
        bends.extend(stencils.iter().map(bend));
        slope_weights.clear();
        slope_weights.extend(stencils.iter().map(|stencil| stencil.slope_weight(|row| bends[row as usize])));
    }

    /// Returns the slopes and slope weights of the last updates, if the skin is smooth.
    pub(super) fn of(&self, samples: &SampleCells) -> Option<RowSlopes<'_>> {
        samples.stencils().map(|_| self.with_weights_of(self))
    }

    /// Returns the slopes of the last update, with the slope weights of `weighted`.
    pub(super) fn with_weights_of<'a>(&'a self, weighted: &'a Self) -> RowSlopes<'a> {
        RowSlopes { slopes: &self.slopes, slope_weights: &weighted.slope_weights }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        buffer_bytes(&self.slopes) + buffer_bytes(&self.bends) + buffer_bytes(&self.slope_weights)
    }
}
