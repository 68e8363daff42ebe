//! The part of a surface that lies within one cell, as constants: its volume without looking at its triangles.

use super::line::{Line, Moving, determinant};

/// Products of three different basis functions of eight.
const MOMENTS: usize = 56;

/// From how many triangles on a patch is cheaper than the triangles: it takes 21 determinants and some sums.
pub(super) const WORTHWHILE: usize = 30;

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

    /// The coefficients of the sum of `det[a, b, c]`.
    pub(super) fn coefficients(&self, lattice: &[Moving]) -> [f64; 4] {
        let m = differences(self.corners.map(|corner| lattice[corner as usize].line()));
        let mut moments = self.moments.iter();
        let mut sum = [0.0; 4];
        for j in 1..8 {
            for k in j + 1..8 {
                let mut weighted = Line::default();
                for (m, &moment) in m[..j].iter().zip(moments.by_ref()) {
                    weighted = weighted.plus(m.times(moment));
                }
                super::sums::add(&mut sum, &determinant(weighted, m[j], m[k]));
            }
        }
        sum
    }
}

fn basis([x, y, z]: [f32; 3]) -> [f64; 8] {
    let [x, y, z] = [x, y, z].map(f64::from);
    [1.0, x, y, x * y, z, x * z, y * z, x * y * z]
}

/// The corners of a cell to the coefficients of its trilinear map: differences along x, y and z.
fn differences(mut m: [Line; 8]) -> [Line; 8] {
    for axis in [1, 2, 4] {
        for k in (0..8).filter(|k| k & axis != 0) {
            m[k] = m[k].minus(m[k ^ axis]);
        }
    }
    m
}
