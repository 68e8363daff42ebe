//! Volume enclosed by a surface.

use nalgebra::Point3;

/// Triangles summed one after another before block sums are added: keeps rounding near that of pairwise summation.
const BLOCK: usize = 512;

/// Signed volume of the oriented triangles: `sum a . (b x c) / 6` about `centre`.
///
/// Positive where faces run counter-clockwise seen from outside. Exact (but for rounding) for closed surfaces; for
/// open ones it depends on `centre`.
pub(crate) fn signed_volume(vertices: &[Point3<f64>], triangles: &[[u32; 3]], centre: Point3<f64>) -> f64 {
    let six_fold = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| vertices[corner as usize] - centre);
        a.dot(&b.cross(&c))
    };
    let blocks = triangles.chunks(BLOCK).map(|block| block.iter().map(six_fold).sum::<f64>());
    blocks.sum::<f64>() / 6.0
}
