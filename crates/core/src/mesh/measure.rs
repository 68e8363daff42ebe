//! Volume and area of a surface.

use nalgebra::Vector3;

use super::Mesh;

/// Triangles summed one after another before block sums are added: keeps rounding near that of pairwise summation.
const BLOCK: usize = 512;

/// Signed volume of oriented triangles: `sum a . (b x c) / 6` of the positions of their corners, relative to some center.
///
/// Positive where faces run counter-clockwise seen from outside. Exact (but for rounding) for closed surfaces; for
/// open ones it depends on the center.
pub(crate) fn signed_volume(triangles: &[[u32; 3]], position: impl Fn(u32) -> Vector3<f64>) -> f64 {
    let six_fold = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(&position);
        a.dot(&b.cross(&c))
    };
    let blocks = triangles.chunks(BLOCK).map(|block| block.iter().map(six_fold).sum::<f64>());
    blocks.sum::<f64>() / 6.0
}

/// Size of a surface, relative to the longest side of its bounding box.
pub(crate) struct RelativeMeasure {
    /// Longest side of the bounding box.
    pub(crate) extent: f64,
    /// Magnitude of the volume about the center of the box, over the cube of the extent.
    pub(crate) volume: f64,
    /// Area over the square of the extent.
    pub(crate) area: f64,
}

impl RelativeMeasure {
    /// That of a mesh.
    pub(crate) fn of(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let extent = (high - low).amax();
        let (mut volume, mut area) = (0.0, 0.0);
        for triangle in mesh.triangles() {
            let [a, b, c] =
                triangle.map(|vertex| (mesh.vertices()[vertex as usize] - mesh.center()) / extent);
            volume += a.dot(&b.cross(&c)) / 6.0;
            area += Vector3::cross(&(b - a), &(c - a)).norm() / 2.0;
        }
        Self { extent, volume: volume.abs(), area }
    }
}
