//! Products, inverses and norms of symmetric matrices, one matrix in each lane. A symmetric matrix has the entries
//! xx, yy, zz, xy, xz, yz; other matrices are stored column by column.

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
        x[0].mul_add(xx, x[3].mul_add(xy, x[6] * xz)),
        x[1].mul_add(xy, x[4].mul_add(yy, x[7] * yz)),
        x[2].mul_add(xz, x[5].mul_add(yz, x[8] * zz)),
        x[0].mul_add(xy, x[3].mul_add(yy, x[6] * yz)),
        x[0].mul_add(xz, x[3].mul_add(yz, x[6] * zz)),
        x[1].mul_add(xz, x[4].mul_add(yz, x[7] * zz)),
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
        product[row] = p.mul_add(xx, q.mul_add(xy, r * xz));
        product[3 + row] = p.mul_add(xy, q.mul_add(yy, r * yz));
        product[6 + row] = p.mul_add(xz, q.mul_add(yz, r * zz));
    }
    product
}

/// Computes the adjugate of a symmetric matrix with the entries xx, yy, zz, xy, xz, yz.
#[inline(always)]
pub(super) fn adjugate<S: Simd, V: SimdFloat<S, Element = f32>>([xx, yy, zz, xy, xz, yz]: [V; 6]) -> [V; 6] {
    [
        yy.mul_add(zz, -(yz * yz)),
        xx.mul_add(zz, -(xz * xz)),
        xx.mul_add(yy, -(xy * xy)),
        xz.mul_add(yz, -(xy * zz)),
        xy.mul_add(yz, -(xz * yy)),
        xy.mul_add(xz, -(yz * xx)),
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
    let det = m[0].mul_add(inverse[0], m[3].mul_add(inverse[3], m[4] * inverse[4]));
    let factor = det.simd_gt(zero).select(V::splat(simd, 1.0) / det, zero);
    for i in 0..6 {
        inverse[i] *= factor;
    }
    inverse
}

/// Computes the square of the Frobenius norm of a symmetric matrix.
#[inline(always)]
pub(super) fn norm_squared<S: Simd>([xx, yy, zz, xy, xz, yz]: [f32x16<S>; 6]) -> f32x16<S> {
    let off_diagonal = xy.mul_add(xy, xz.mul_add(xz, yz * yz));
    xx.mul_add(xx, yy.mul_add(yy, zz.mul_add(zz, off_diagonal + off_diagonal)))
}
