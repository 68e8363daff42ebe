//! Computes the volume inside a surface.

use nalgebra::Vector3;

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
