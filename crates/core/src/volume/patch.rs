//! The triangles of one cell as one term of the measure `mesh`.

use fearless_simd::{Simd, SimdBase, f64x4};

use super::line::{CrossFactor, Determinants, Line, Moving, load};
use crate::lattice::{monomials, polynomial};

/// Number of the [`triples`] of indices of basis functions.
const MOMENTS: usize = 56;

/// Least number of triangles for which a patch is cheaper than separate triangles: a patch costs 21
/// determinants and 56 vector multiply-adds.
pub(super) const MIN_PATCH_TRIANGLES: usize = 16;

/// Patch: triangles whose corners all lie in one cell.
///
/// The point with the local coordinates `x, y, z` in a cell is `sum_i f_i m_i` over `i` in 0..8. The basis
/// functions `f_i` are `1, x, y, xy, z, xz, yz, xyz`. The vectors `m_i` are the coefficients of the trilinear
/// [`polynomial`], which are differences of the cell's corners. The sum of `det[a, b, c]` over the triangles
/// is then `sum_{i<j<k} M_ijk det[m_i, m_j, m_k]`. `M_ijk` is a sum over the triangles: each adds the
/// determinant of the 3 x 3 matrix of the values of `f_i`, `f_j` and `f_k` at the corners `a`, `b` and `c`.
/// It does not depend on the deformation.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Corners of the cell.
    corners: [u32; 8],
    /// `M_ijk`, in the order of [`triples`].
    moments: [f64; MOMENTS],
}

/// Returns the triples `i < j < k` of indices in 0..8: all pairs `j < k`, and for each pair all `i < j`.
fn triples() -> impl Iterator<Item = [usize; 3]> {
    (1..8).flat_map(|j| (j + 1..8).flat_map(move |k| (0..j).map(move |i| [i, j, k])))
}

impl Patch {
    /// Creates a patch. `corners`: corners of the cell. `triangles`: local coordinates of the corners of each
    /// triangle in the cell.
    pub(super) fn new(corners: [u32; 8], triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let mut moments = [0.0; MOMENTS];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|local| monomials(1.0, local.map(f64::from)));
            for (moment, [i, j, k]) in moments.iter_mut().zip(triples()) {
                *moment += a[i] * (b[j] * c[k] - b[k] * c[j])
                    + a[j] * (b[k] * c[i] - b[i] * c[k])
                    + a[k] * (b[i] * c[j] - b[j] * c[i]);
            }
        }
        Self { corners, moments }
    }

    /// Adds the sum of `det[a, b, c]` over the triangles of the patch to `sum`.
    #[inline(always)]
    pub(super) fn add_to<S: Simd>(&self, simd: S, lattice: &[Moving], sum: &mut Determinants<S>) {
        let terms = polynomial(load(simd, lattice, &self.corners));
        let (mut lines, mut factors) = ([Line::zero(simd); 8], [CrossFactor::new(simd, terms[0]); 8]);
        for k in 0..8 {
            lines[k] = Line::zxy(simd, terms[k]);
            factors[k] = CrossFactor::new(simd, terms[k]);
        }
        let mut moments = self.moments.iter();
        for j in 1..8 {
            for k in j + 1..8 {
                let mut weighted_sum = Line::zero(simd);
                for i in 0..j {
                    let moment = moments.next().copied().unwrap_or_default();
                    weighted_sum = weighted_sum.plus_times(lines[i], f64x4::splat(simd, moment));
                }
                sum.add(weighted_sum, factors[j], factors[k]);
            }
        }
    }
}
