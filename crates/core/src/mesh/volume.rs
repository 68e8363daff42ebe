//! Computes the volume inside a surface.

use nalgebra::{Matrix3, Vector3};

/// Number of triangles per block. With sums of blocks, the rounding error is nearly as small as with pairwise
/// summation.
const BLOCK: usize = 512;

/// Computes the signed volume of oriented triangles about a center: the sum of `a . (b × c) / 6` over all
/// triangles with the corners `a`, `b`, `c` relative to the center.
///
/// `position`: returns the position of a vertex, relative to the center.
///
/// The result is positive if faces are counter-clockwise seen from outside. For a closed surface it does not
/// depend on the center, except for rounding. For an open surface it depends on the center.
pub(crate) fn signed_volume(triangles: &[[u32; 3]], position: impl Fn(u32) -> Vector3<f64>) -> f64 {
    let six_fold = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(&position);
        a.dot(&b.cross(&c))
    };
    let blocks = triangles.chunks(BLOCK).map(|block| block.iter().map(six_fold).sum::<f64>());
    blocks.sum::<f64>() / 6.0
}

/// Returns the volume inside triangles, its center, and its second moments about the center, relative to the volume.
///
/// With a corner at the origin, a tetrahedron of the volume V has the first moment V/4 (a + b + c) and the second moments
/// V/20 (a aᵀ + b bᵀ + c cᵀ + (a + b + c) (a + b + c)ᵀ).
pub(super) fn volume_moments(
    triangles: &[[u32; 3]],
    position: impl Fn(u32) -> Vector3<f64>,
) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for triangle in triangles {
        let [a, b, c] = triangle.map(&position);
        let (part, sum) = (a.dot(&b.cross(&c)) / 6.0, a + b + c);
        volume += part;
        first += part / 4.0 * sum;
        second +=
            part / 20.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
    let center = first / volume;
    (volume, center, second / volume - center * center.transpose())
}
