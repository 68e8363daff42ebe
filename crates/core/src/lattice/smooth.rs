//! Interpolation in a cell that is smooth across the faces of the cells.
//!
//! Corner i has the position `x_i` and the slopes `G_ia`, one vector per axis a ([`slopes`](super::slopes)). At the
//! local coordinates `t` of a cell, the position is the cubic Hermite interpolant along each axis, without the terms of
//! mixed derivatives (Ferguson 1964 has it for surfaces):
//!
//! ```text
//! sum over i of N_i x_i + sum over i and axes a of K_ia G_ia
//! N_i = product over the axes of H,        H = s or 1 - s,                s = 3 t² - 2 t³
//! K_ia = K(t_a) times the H of other axes, K = t (1 - t)² or -t² (1 - t)
//! ```
//!
//! with the second form of H and the first form of K for a corner whose local coordinate along the axis is 0. On a
//! face, the derivatives of H vanish and those of K are 1 or 0. The position and its first derivatives are therefore
//! continuous across the faces. Affine motions, and quadratic ones along each axis with central slopes, are exact. The
//! position is linear in the positions of the lattice vertices.
//!
//! As a polynomial: the offset from corner 0 is trilinear in `s` ([`polynomial`]), and the terms of axis a are
//! `e_a A + k_a B`, with `e = t - s`, `k = -t² (1 - t)`, and A and B bilinear in the `s` of the other axes. The
//! [`polynomial`] of the slopes has the coefficients of both.
//!
//! Where the slope weights are 0, the position is trilinear: it is `L + T (S - L)` with the trilinear position `L`,
//! the smooth position `S`, and the interpolated slope weight `T = sum over i of N_i T_i`.

use std::ops::{Add, Mul, Sub};

use nalgebra::Vector3;

use super::trilinear::{monomials, polynomial, split};
use crate::simd::vector::Product;

/// The functions of one local coordinate `t` of which the smooth interpolant consists.
#[derive(Clone, Copy)]
pub(crate) struct SmoothCoordinate<T> {
    /// `3 t² - 2 t³`.
    pub s: T,
    /// `t - s`.
    pub e: T,
    /// `t³ - t²`.
    pub k: T,
}

impl<T: Copy + Add<Output = T> + Mul<Output = T> + Sub<Output = T>> SmoothCoordinate<T> {
    #[inline(always)]
    pub(crate) fn new(t: T) -> Self {
        let square = t * t;
        let k = square * t - square;
        // 3 t² - 2 t³ = t² - 2 (t³ - t²)
        let s = square - (k + k);
        Self { s, e: t - s, k }
    }
}

/// Coefficients of the smooth interpolant of a cell: of the offset from corner 0, and of the slopes along x, y and z.
#[derive(Clone, Copy)]
pub(crate) struct SmoothTerms<T>(pub(crate) [[T; 8]; 4]);

impl<T: Copy + Sub<Output = T>> SmoothTerms<T> {
    /// Builds the coefficients from the positions and the slopes of the corners.
    #[inline(always)]
    pub(crate) fn new(positions: [T; 8], slopes: [[T; 3]; 8]) -> Self {
        let mut terms = [positions, positions, positions, positions];
        for k in 0..8 {
            terms[0][k] = positions[k] - positions[0];
            for axis in 0..3 {
                terms[axis + 1][k] = slopes[k][axis];
            }
        }
        for group in 0..4 {
            terms[group] = polynomial(terms[group]);
        }
        Self(terms)
    }

    /// Returns the coefficients of the slopes along an axis: the four of A, and the four of B, each in the order of the
    /// monomials 1, u, v, uv of the other two axes.
    #[inline(always)]
    pub(crate) fn along(&self, axis: usize) -> [[T; 4]; 2] {
        let [one, x, y, xy, z, xz, yz, xyz] = self.0[axis + 1];
        match axis {
            0 => [[one, y, z, yz], [x, xy, xz, xyz]],
            1 => [[one, x, z, xz], [y, xy, yz, xyz]],
            _ => [[one, x, y, xy], [z, xz, yz, xyz]],
        }
    }
}

/// A variable of a polynomial with coefficients of the type `C`: a number for each lane, or one for all of them.
pub(crate) trait Variable<C>:
    Copy + Add<Output = Self> + Mul<Output = Self> + Add<C, Output = Self> + Mul<C, Output = Self>
{
}

impl<C, V> Variable<C> for V where
    V: Copy + Add<Output = V> + Mul<Output = V> + Add<C, Output = V> + Mul<C, Output = V>
{
}

/// Returns the smooth position relative to corner 0, from the coefficients and the local coordinates.
#[inline(always)]
pub(crate) fn smooth_value<V: Variable<C>, C: Copy + Sub<Output = C>>(
    terms: &SmoothTerms<C>,
    [x, y, z]: [SmoothCoordinate<V>; 3],
) -> V {
    let offset = trilinear_value(&terms.0[0], [x.s, y.s, z.s]);
    let [[a, b], [c, d], [e, f]] = [terms.along(0), terms.along(1), terms.along(2)];
    let offset =
        bilinear_value(a, y.s, z.s).times_plus(x.e, bilinear_value(b, y.s, z.s).times_plus(x.k, offset));
    let offset =
        bilinear_value(c, x.s, z.s).times_plus(y.e, bilinear_value(d, x.s, z.s).times_plus(y.k, offset));
    bilinear_value(e, x.s, y.s).times_plus(z.e, bilinear_value(f, x.s, y.s).times_plus(z.k, offset))
}

/// Returns the value of a trilinear polynomial.
#[inline(always)]
pub(crate) fn trilinear_value<V: Variable<C>, C: Copy>(terms: &[C; 8], [u, v, w]: [V; 3]) -> V {
    let [one, x, y, xy, z, xz, yz, xyz] = *terms;
    bilinear_value([z, xz, yz, xyz], u, v).times_plus(w, bilinear_value([one, x, y, xy], u, v))
}

/// Returns the value of a bilinear polynomial.
#[inline(always)]
fn bilinear_value<V: Variable<C>, C: Copy>([one, x, y, xy]: [C; 4], u: V, v: V) -> V {
    u.times_plus(xy, y).times_plus(v, u.times_plus(x, one))
}

/// A smooth cell in f32, for single points.
pub(crate) struct SmoothCell {
    corner: Vector3<f32>,
    linear: [Vector3<f32>; 8],
    terms: SmoothTerms<Vector3<f32>>,
    slope_weights: [f32; 8],
}

impl SmoothCell {
    /// Builds the map of a cell from the positions of its corners, their slopes and slope weights.
    pub(super) fn new(
        corners: [Vector3<f32>; 8],
        slopes: [[Vector3<f32>; 3]; 8],
        slope_weights: [f32; 8],
    ) -> Self {
        Self {
            corner: corners[0],
            linear: polynomial(corners),
            terms: SmoothTerms::new(corners, slopes),
            slope_weights: polynomial(slope_weights),
        }
    }

    /// Returns the position at local coordinates. Outside the cell the map continues linearly.
    pub(super) fn at(&self, local: [f32; 3]) -> Vector3<f32> {
        let [inside, outside] = split(local);
        let coordinates = inside.map(SmoothCoordinate::new);
        let steps = coordinates.map(|coordinate| coordinate.s);
        let (t, s) = (monomials(1.0, inside), monomials(1.0, steps));
        let slope_weights: f32 =
            self.slope_weights.iter().zip(&s).map(|(term, monomial)| term * monomial).sum();
        // The offsets from corner 0.
        let mut linear: Vector3<f32> = (1..8).map(|k| self.linear[k] * t[k]).sum();
        let mut smooth: Vector3<f32> = (1..8).map(|k| self.terms.0[0][k] * s[k]).sum();
        for axis in 0..3 {
            let [u, v] = [[1, 2], [0, 2], [0, 1]][axis].map(|other: usize| steps[other]);
            let [a, b] = self.terms.along(axis).map(|[one, x, y, xy]| one + x * u + y * v + xy * (u * v));
            let SmoothCoordinate { e, k, .. } = coordinates[axis];
            smooth += a * e + b * k;
            if outside[axis] != 0.0 {
                // At 0 and 1 the derivative of `s` is 0, of `e` 1, and of `k` 0 and 1.
                smooth += (a + b * inside[axis]) * outside[axis];
                let rest = monomials(1.0, std::array::from_fn(|a| if a == axis { 1.0 } else { inside[a] }));
                let slope: Vector3<f32> =
                    (0..8).filter(|k| k >> axis & 1 == 1).map(|k| self.linear[k] * rest[k]).sum();
                linear += slope * outside[axis];
            }
        }
        self.corner + linear + (smooth - linear) * slope_weights
    }
}
