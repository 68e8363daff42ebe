//! Computes the volume and the area of a surface.

use nalgebra::Vector3;

use super::Mesh;

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

/// Volume and area of a surface, relative to the longest side of its bounding box.
pub(crate) struct RelativeMeasure {
    /// Length of the longest side of the bounding box.
    pub(crate) extent: f64,
    /// Magnitude of the signed volume about the center of the bounding box, divided by `extent^3`.
    pub(crate) volume: f64,
    /// Area, divided by `extent^2`.
    pub(crate) area: f64,
}

impl RelativeMeasure {
    /// Measures a mesh.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let extent = (high - low).amax();
        let (mut volume, mut area) = (0.0, 0.0);
        for triangle in mesh.surface() {
            let [a, b, c] =
                triangle.map(|vertex| (mesh.vertices()[vertex as usize] - mesh.center()) / extent);
            volume += a.dot(&b.cross(&c)) / 6.0;
            area += Vector3::cross(&(b - a), &(c - a)).norm() / 2.0;
        }
        Self { extent, volume: volume.abs(), area }
    }
}
