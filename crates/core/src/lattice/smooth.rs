//! Interpolation in a cell that is smooth across the faces of the cells.
//!
//! Corner i has the position `x_i` and the slopes `G_i`, a matrix of three columns ([`slopes`](super::slopes)). At the
//! local coordinates `t` of a cell, the position is
//!
//! ```text
//! sum over i of N_i(t) (x_i + G_i (t - t_i))
//! ```
//!
//! with the local coordinates `t_i` of corner i. `N_i` is the product over the axes of `s` or `1 - s`, with
//! `s = 3 t² - 2 t³`. The derivatives of `N_i` along an axis vanish on the faces perpendicular to the axis. The position
//! and its first derivatives are therefore continuous across the faces. Affine motions are exact, and the position is
//! linear in the positions of the lattice vertices.
//!
//! As a polynomial: `x_0 + P(s) + u X(s) + v Y(s) + w Z(s)` with `t = (u, v, w)`. Each of `P`, `X`, `Y`, `Z` is trilinear
//! in `s` ([`polynomial`]).
//!
//! Where the slopes are not trusted, the position is trilinear: it is `L + T (S - L)` with the trilinear position `L`, the
//! smooth position `S`, and the interpolated trust `T = sum over i of N_i(t) T_i`.

use std::ops::{Add, Mul, Sub};

use fearless_simd::{Simd, SimdFloat, f32x8};
use nalgebra::Vector3;

use super::trilinear::{monomials, polynomial, split};

/// Returns `3 t² - 2 t³`.
#[inline(always)]
pub(crate) fn smoothstep<T>(t: T) -> T
where
    T: Copy + Mul<Output = T> + Sub<Output = T> + Add<Output = T>,
{
    let square = t * t;
    let cube = square * t;
    (square - cube) + (square - cube) + square
}

/// Coefficients of the smooth interpolant of a cell: of `P`, `X`, `Y` and `Z`, without the position of corner 0.
#[derive(Clone, Copy)]
pub(crate) struct SmoothTerms<T>(pub(crate) [[T; 8]; 4]);

impl<T: Copy + Sub<Output = T>> SmoothTerms<T> {
    /// Builds the coefficients from the positions and the slopes of the corners.
    #[inline(always)]
    pub(crate) fn new(positions: [T; 8], slopes: [[T; 3]; 8]) -> Self {
        let mut terms = [positions, positions, positions, positions];
        for k in 0..8 {
            let mut offset = positions[k] - positions[0];
            for axis in 0..3 {
                terms[axis + 1][k] = slopes[k][axis];
                if k >> axis & 1 == 1 {
                    offset = offset - slopes[k][axis];
                }
            }
            terms[0][k] = offset;
        }
        for group in 0..4 {
            terms[group] = polynomial(terms[group]);
        }
        Self(terms)
    }
}

/// Returns the smooth position relative to corner 0, from the coefficients `terms`, the local coordinates `t`, and `s`
/// of each of them.
#[inline(always)]
pub(crate) fn smooth_value<S: Simd>(
    terms: &SmoothTerms<f32x8<S>>,
    t: [f32x8<S>; 3],
    s: [f32x8<S>; 3],
) -> f32x8<S> {
    let [position, x, y, z] = &terms.0;
    let offset = trilinear_value(x, s).mul_add(t[0], trilinear_value(position, s));
    let offset = trilinear_value(y, s).mul_add(t[1], offset);
    trilinear_value(z, s).mul_add(t[2], offset)
}

/// Returns the value of a trilinear polynomial.
#[inline(always)]
pub(crate) fn trilinear_value<S: Simd>(terms: &[f32x8<S>; 8], [u, v, w]: [f32x8<S>; 3]) -> f32x8<S> {
    let [one, x, y, xy, z, xz, yz, xyz] = *terms;
    let upper = u.mul_add(xyz, yz).mul_add(v, u.mul_add(xz, z));
    let lower = u.mul_add(xy, y).mul_add(v, u.mul_add(x, one));
    upper.mul_add(w, lower)
}

/// A smooth cell in f32, for single points.
pub(crate) struct SmoothCell {
    corner: Vector3<f32>,
    linear: [Vector3<f32>; 8],
    terms: SmoothTerms<Vector3<f32>>,
    trust: [f32; 8],
}

impl SmoothCell {
    /// Builds the map of a cell from the positions of its corners, their slopes, and the trust in them.
    pub(crate) fn new(
        corners: [Vector3<f32>; 8],
        slopes: [[Vector3<f32>; 3]; 8],
        trust: [f32; 8],
    ) -> Self {
        Self {
            corner: corners[0],
            linear: polynomial(corners),
            terms: SmoothTerms::new(corners, slopes),
            trust: polynomial(trust),
        }
    }

    /// Returns the position at local coordinates. Outside the cell the map continues linearly.
    pub(crate) fn at(&self, local: [f32; 3]) -> Vector3<f32> {
        let [inside, outside] = split(local);
        let (t, s) = (monomials(1.0, inside), monomials(1.0, inside.map(smoothstep)));
        let value = |terms: &[Vector3<f32>; 8], monomials: &[f32; 8]| -> Vector3<f32> {
            terms.iter().zip(monomials).map(|(term, monomial)| term * *monomial).sum()
        };
        let trust: f32 = self.trust.iter().zip(&s).map(|(term, monomial)| term * monomial).sum();
        // The offsets from corner 0.
        let mut linear: Vector3<f32> = (1..8).map(|k| self.linear[k] * t[k]).sum();
        let mut smooth = value(&self.terms.0[0], &s);
        for axis in 0..3 {
            let slope = value(&self.terms.0[axis + 1], &s);
            // The derivative of `s` along an axis vanishes at 0 and 1.
            smooth += slope * (inside[axis] + outside[axis]);
            if outside[axis] != 0.0 {
                let bit = 1 << axis;
                let rest = monomials(1.0, std::array::from_fn(|a| if a == axis { 1.0 } else { inside[a] }));
                let slope: Vector3<f32> =
                    (0..8).filter(|k| k & bit != 0).map(|k| self.linear[k] * rest[k]).sum();
                linear += slope * outside[axis];
            }
        }
        self.corner + linear + (smooth - linear) * trust
    }
}
