//! The flow of plastic shapes: see [`plastic`](super::plastic) for the formulas.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, mask32x16};

use super::algebra::{adjugate, full, norm_squared, symmetric_product, times};
use crate::simd::vector::Product;

/// Least mean stretch: strains of regions that are crushed below it, or inverted, are relative to it. It is the mean
/// stretch of a cube that is compressed evenly to a twentieth of its volume.
pub(super) const LEAST_STRETCH: f32 = 0.37;

/// Greatest |k D| of a step. The eigenvalues of 1 + H are then at least 3/4, so that S stays positive definite.
const GREATEST_CHANGE: f32 = 0.5;

/// Parameters of the plastic flow in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    /// c, the part of the strain beyond the yield strain that becomes plastic.
    pub fraction: f32,
    /// The strain |D| beyond which a region flows.
    pub yield_strain: f32,
    /// Greatest |S - 1|.
    pub max: f32,
}

/// Returns 1 + `t`.
#[inline(always)]
pub(crate) fn shape<S: Simd, V: SimdFloat<S, Element = f32>>(simd: S, mut t: [V; 6]) -> [V; 6] {
    for i in 0..3 {
        t[i] += V::splat(simd, 1.0);
    }
    t
}

/// The elastic strain of regions, not yet divided by the mean stretch.
pub(super) struct Strain<S: Simd> {
    /// The deviatoric part of E.
    deviator: [f32x16<S>; 6],
    /// |D|² e².
    squared: f32x16<S>,
    /// e, at least [`LEAST_STRETCH`].
    stretch: f32x16<S>,
}

impl<S: Simd> Strain<S> {
    /// Computes the strain of regions with the elastic stretch E.
    #[inline(always)]
    pub(super) fn new(simd: S, e: [f32x16<S>; 6]) -> Self {
        let mean = (e[0] + e[1] + e[2]) * (1.0 / 3.0);
        let mut deviator = e;
        for i in 0..3 {
            deviator[i] = e[i] - mean;
        }
        let squared = norm_squared(deviator);
        Self { deviator, squared, stretch: mean.max(f32x16::splat(simd, LEAST_STRETCH)) }
    }

    /// Returns the lanes in which |D| is above `limit`. A strain that is not a number is not.
    #[inline(always)]
    pub(super) fn exceeds(&self, limit: f32x16<S>) -> mask32x16<S> {
        let limit = self.stretch * limit;
        self.squared.simd_gt(limit * limit)
    }

    /// Returns T of the plastic shapes after a step of flow, in the lanes in which the regions yield. `limit`: the yield
    /// strain of each region.
    #[inline(always)]
    pub(super) fn flow(
        &self,
        simd: S,
        t: [f32x16<S>; 6],
        (flow, limit): (Flow, f32x16<S>),
    ) -> [f32x16<S>; 6] {
        let norm = self.squared.sqrt();
        // |k D| = fraction (|D| - yield), and H is half of k D = |k D| (E - e)/(e |D|), with e |D| = |E - e|.
        let excess = norm - self.stretch * limit;
        let change = (excess * flow.fraction).min(self.stretch * GREATEST_CHANGE);
        let scale = change * 0.5 / (norm * self.stretch);
        let mut h = self.deviator;
        for i in 0..6 {
            h[i] *= scale;
        }
        // (1 + H) S (1 + H) - 1 = T + W + Wᵀ + W H with W = H S.
        let w = times(&full(h), shape(simd, t));
        let wh = symmetric_product(&w, h);
        let flowed = [
            t[0] + (w[0] + w[0] + wh[0]),
            t[1] + (w[4] + w[4] + wh[1]),
            t[2] + (w[8] + w[8] + wh[2]),
            t[3] + (w[1] + w[3] + wh[3]),
            t[4] + (w[2] + w[6] + wh[4]),
            t[5] + (w[5] + w[7] + wh[5]),
        ];
        let mut t = of_volume_one(simd, flowed);
        let squared = norm_squared(t);
        let beyond = squared.simd_gt(f32x16::splat(simd, flow.max * flow.max));
        if beyond.any_true() {
            let share = f32x16::splat(simd, flow.max) / squared.sqrt();
            for i in 0..6 {
                t[i] = beyond.select(t[i] * share, t[i]);
            }
            // log det is concave, so that the determinant is at least 1 on the segment back to 1, and the scaling to
            // the determinant 1 shrinks the shape further. Two times, because the determinant may be up to 2.
            t = of_volume_one(simd, of_volume_one(simd, t));
        }
        t
    }
}

/// Scales the shape 1 + `t` to the determinant 1, and returns it minus 1.
#[inline(always)]
fn of_volume_one<S: Simd>(simd: S, mut t: [f32x16<S>; 6]) -> [f32x16<S>; 6] {
    // det(1 + T) - 1 = tr T + tr adj T + det T.
    let adjugate = adjugate(t);
    let det_t = t[0].times_plus(adjugate[0], t[3].times_plus(adjugate[3], t[4] * adjugate[4]));
    let excess = (t[0] + t[1] + t[2]) + ((adjugate[0] + adjugate[1] + adjugate[2]) + det_t);
    // (1 + x)^(-1/3) - 1 by its series. After a step of flow, x is between -0.07 and 0, and the error below 2e-7.
    let mut series = f32x16::splat(simd, SERIES[3]);
    for i in [2, 1, 0] {
        series = series.times_plus(excess, f32x16::splat(simd, SERIES[i]));
    }
    let change = series * excess;
    for i in 0..6 {
        t[i] = change.times_plus(t[i], t[i]);
    }
    for i in 0..3 {
        t[i] += change;
    }
    t
}

/// Coefficients of x, x², x³ and x⁴ in the series of (1 + x)^(-1/3).
const SERIES: [f32; 4] = [-1.0 / 3.0, 2.0 / 9.0, -14.0 / 81.0, 35.0 / 243.0];
