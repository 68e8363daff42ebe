//! The part of a surface that lies within one cell, as constants: its volume without looking at its triangles.

use fearless_simd::{Simd, SimdBase, f64x4};

use super::line::{Arm, Determinants, Line, Moving, load};
use crate::lattice::polynomial;

/// Products of three different basis functions of eight.
const MOMENTS: usize = 56;

/// From how many triangles on a patch is cheaper than the triangles: it takes 21 determinants and 56 sums.
pub(super) const WORTHWHILE: usize = 16;

/// Triangles whose corners all lie in one cell.
///
/// In a cell a surface point is `sum_i f_i(x, y, z) m_i`, with `f = 1, x, y, xy, z, xz, yz, xyz` and `m_i` the
/// differences of the cell's corners along those axes. The sum of `det[a, b, c]` over triangles is then
/// `sum_{i<j<k} M_ijk det[m_i, m_j, m_k]`, and `M_ijk`, the sum of the minors of `f` at the corners, is constant.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    corners: [u32; 8],
    /// `M_ijk`, in the order of [`triples`].
    moments: [f64; MOMENTS],
}

/// The pairs `j < k`, for each the `i < j`.
fn triples() -> impl Iterator<Item = [usize; 3]> {
    (1..8).flat_map(|j| (j + 1..8).flat_map(move |k| (0..j).map(move |i| [i, j, k])))
}

impl Patch {
    /// `corners`: those of the cell. `triangles`: places of their corners in the cell.
    pub(super) fn new(corners: [u32; 8], triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let mut moments = [0.0; MOMENTS];
        for triangle in triangles {
            let [a, b, c] = triangle.map(basis);
            for (moment, [i, j, k]) in moments.iter_mut().zip(triples()) {
                *moment += a[i] * (b[j] * c[k] - b[k] * c[j])
                    + a[j] * (b[k] * c[i] - b[i] * c[k])
                    + a[k] * (b[i] * c[j] - b[j] * c[i]);
            }
        }
        Self { corners, moments }
    }

    /// Adds the sum of `det[a, b, c]`.
    #[inline(always)]
    pub(super) fn add_to<S: Simd>(&self, simd: S, lattice: &[Moving], sum: &mut Determinants<S>) {
        let terms = polynomial(load(simd, lattice, &self.corners));
        let (mut rows, mut arms) = ([Line::zero(simd); 8], [Arm::new(simd, terms[0]); 8]);
        for k in 0..8 {
            rows[k] = Line::zxy(simd, terms[k]);
            arms[k] = Arm::new(simd, terms[k]);
        }
        let mut moments = self.moments.iter();
        for j in 1..8 {
            for k in j + 1..8 {
                let mut weighted = Line::zero(simd);
                for i in 0..j {
                    let moment = moments.next().copied().unwrap_or_default();
                    weighted = weighted.plus_times(rows[i], f64x4::splat(simd, moment));
                }
                sum.add(weighted, arms[j], arms[k]);
            }
        }
    }
}

fn basis([x, y, z]: [f32; 3]) -> [f64; 8] {
    let [x, y, z] = [x, y, z].map(f64::from);
    [1.0, x, y, x * y, z, x * z, y * z, x * y * z]
}
