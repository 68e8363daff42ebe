//! Products, inverses and norms of symmetric matrices, one matrix in each lane. A symmetric matrix has the entries
//! xx, yy, zz, xy, xz, yz; other matrices are stored column by column.

use crate::simd::vector::Product;
use fearless_simd::{Select, Simd, SimdFloat, f32x16};

/// Returns all nine entries of a symmetric matrix.
#[inline(always)]
pub(crate) fn full<V: Copy>([xx, yy, zz, xy, xz, yz]: [V; 6]) -> [V; 9] {
    [xx, xy, xz, xy, yy, yz, xz, yz, zz]
}

/// Computes X T of a matrix X, column by column, and a symmetric matrix T, where the product is symmetric.
#[inline(always)]
pub(super) fn symmetric_product<S: Simd>(
    x: &[f32x16<S>; 9],
    [xx, yy, zz, xy, xz, yz]: [f32x16<S>; 6],
) -> [f32x16<S>; 6] {
    [
        x[0].times_plus(xx, x[3].times_plus(xy, x[6] * xz)),
        x[1].times_plus(xy, x[4].times_plus(yy, x[7] * yz)),
        x[2].times_plus(xz, x[5].times_plus(yz, x[8] * zz)),
        x[0].times_plus(xy, x[3].times_plus(yy, x[6] * yz)),
        x[0].times_plus(xz, x[3].times_plus(yz, x[6] * zz)),
        x[1].times_plus(xz, x[4].times_plus(yz, x[7] * zz)),
    ]
}

/// Computes X T of a matrix X, column by column, and a symmetric matrix T with the entries xx, yy, zz, xy, xz, yz.
#[inline(always)]
pub(crate) fn times<S: Simd, V: SimdFloat<S, Element = f32>>(
    x: &[V; 9],
    [xx, yy, zz, xy, xz, yz]: [V; 6],
) -> [V; 9] {
    let mut product = *x;
    for row in 0..3 {
        let [p, q, r] = [x[row], x[3 + row], x[6 + row]];
        product[row] = p.times_plus(xx, q.times_plus(xy, r * xz));
        product[3 + row] = p.times_plus(xy, q.times_plus(yy, r * yz));
        product[6 + row] = p.times_plus(xz, q.times_plus(yz, r * zz));
    }
    product
}

/// Computes the adjugate of a symmetric matrix with the entries xx, yy, zz, xy, xz, yz.
#[inline(always)]
pub(super) fn adjugate<S: Simd, V: SimdFloat<S, Element = f32>>([xx, yy, zz, xy, xz, yz]: [V; 6]) -> [V; 6] {
    [
        yy.times_plus(zz, -(yz * yz)),
        xx.times_plus(zz, -(xz * xz)),
        xx.times_plus(yy, -(xy * xy)),
        xz.times_plus(yz, -(xy * zz)),
        xy.times_plus(yz, -(xz * yy)),
        xy.times_plus(xz, -(yz * xx)),
    ]
}

/// Computes the inverse of a positive definite matrix with the entries xx, yy, zz, xy, xz, yz, and zero for zero, the
/// matrix of lanes without a vertex.
#[inline(always)]
pub(crate) fn inverse<S: Simd, V: SimdFloat<S, Element = f32>>(simd: S, m: [V; 6]) -> [V; 6]
where
    V::Mask: Select<V>,
{
    let zero = V::splat(simd, 0.0);
    let mut inverse = adjugate(m);
    let det = m[0].times_plus(inverse[0], m[3].times_plus(inverse[3], m[4] * inverse[4]));
    let factor = det.simd_gt(zero).select(V::splat(simd, 1.0) / det, zero);
    for i in 0..6 {
        inverse[i] *= factor;
    }
    inverse
}

/// Computes the square of the Frobenius norm of a symmetric matrix.
#[inline(always)]
pub(super) fn norm_squared<S: Simd>([xx, yy, zz, xy, xz, yz]: [f32x16<S>; 6]) -> f32x16<S> {
    let off_diagonal = xy.times_plus(xy, xz.times_plus(xz, yz * yz));
    xx.times_plus(xx, yy.times_plus(yy, zz.times_plus(zz, off_diagonal + off_diagonal)))
}
