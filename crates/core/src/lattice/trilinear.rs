//! Trilinear interpolation in a cell, continued linearly outside.
//!
//! The update of the mesh is `skin::mesh_update`. It uses [`polynomial`], and [`CellMap`] only for vertices outside
//! their cell.

use std::ops::{Mul, Sub};

use nalgebra::Vector3;

/// Returns the trilinear weights of the eight corners at local coordinates.
///
/// The weights continue linearly outside `[0, 1]^3`.
pub(crate) fn weights(local: [f32; 3]) -> [f32; 8] {
    let [inside, outside] = split(local);
    let one = |k: usize, a: usize| if k >> a & 1 == 0 { 1.0 - inside[a] } else { inside[a] };
    std::array::from_fn(|k| {
        let mut weight = one(k, 0) * one(k, 1) * one(k, 2);
        for (a, excess) in outside.iter().enumerate() {
            let slope = if k >> a & 1 == 0 { -1.0 } else { 1.0 };
            weight += excess * slope * one(k, (a + 1) % 3) * one(k, (a + 2) % 3);
        }
        weight
    })
}

/// Splits local coordinates into the nearest point of the cell and the remaining offset.
fn split(local: [f32; 3]) -> [[f32; 3]; 2] {
    let inside = local.map(|x| x.clamp(0.0, 1.0));
    [inside, std::array::from_fn(|a| local[a] - inside[a])]
}

/// Returns the trilinear interpolant of the corner values as the coefficients of 1, x, y, xy, z, xz, yz, xyz.
///
/// For a cell with many points this is half the work of [`weights`].
#[inline(always)]
pub(crate) fn polynomial<T: Copy + Sub<Output = T>>(mut terms: [T; 8]) -> [T; 8] {
    // Differences along x, then y, then z: each corner with the bit set, minus the corner without it.
    for bit in [1, 2, 4] {
        for k in 0..8 {
            if k & bit != 0 {
                terms[k] = terms[k] - terms[k - bit];
            }
        }
    }
    terms
}

/// Returns the monomials 1, x, y, xy, z, xz, yz, xyz of local coordinates.
#[inline(always)]
pub(crate) fn monomials<T: Copy + Mul<Output = T>>(one: T, local: [T; 3]) -> [T; 8] {
    let mut monomials = [one; 8];
    for a in 0..3 {
        let bit = 1 << a;
        for k in 0..bit {
            monomials[k + bit] = monomials[k] * local[a];
        }
    }
    monomials
}

/// Converts sums of [`monomials`] over points into sums of corner weights: transpose of [`polynomial`].
#[inline(always)]
pub(crate) fn corner_sums(mut sums: [f64; 8]) -> [f64; 8] {
    for bit in [1, 2, 4] {
        for k in 0..8 {
            if k & bit != 0 {
                sums[k - bit] -= sums[k];
            }
        }
    }
    sums
}

/// The trilinear map of one deformed cell, as a polynomial about corner 0.
///
/// Its coefficients are small differences, which keeps the rounding error small.
pub(crate) struct CellMap {
    /// The coefficients of 1, x, y, xy, z, xz, yz, xyz.
    terms: [Vector3<f32>; 8],
}

impl CellMap {
    /// Builds the map of a cell from the positions of its corners.
    pub(crate) fn new(corners: [[f32; 3]; 8]) -> Self {
        Self { terms: polynomial(corners.map(Vector3::from)) }
    }

    /// Returns the position of local coordinates.
    #[inline]
    pub(crate) fn at(&self, local: [f32; 3]) -> [f32; 3] {
        let [origin, x, y, xy, z, xz, yz, xyz] = &self.terms;
        let [[u, v, w], outside] = split(local);
        let (uv, uw, vw) = (u * v, u * w, v * w);
        let uvw = uv * w;
        let mut offset: [f32; 3] = std::array::from_fn(|a| {
            let linear = u * x[a] + v * y[a] + w * z[a];
            linear + (uv * xy[a] + uw * xz[a] + vw * yz[a] + uvw * xyz[a])
        });
        if outside != [0.0; 3] {
            let slope: [f32; 3] = std::array::from_fn(|a| {
                outside[0] * (x[a] + v * xy[a] + w * xz[a] + vw * xyz[a])
                    + outside[1] * (y[a] + u * xy[a] + w * yz[a] + uw * xyz[a])
                    + outside[2] * (z[a] + u * xz[a] + v * yz[a] + uv * xyz[a])
            });
            offset = std::array::from_fn(|a| offset[a] + slope[a]);
        }
        std::array::from_fn(|a| origin[a] + offset[a])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cell_map_equals_weighted_mean_of_corners() {
        let corners: [[f32; 3]; 8] = std::array::from_fn(|k| {
            std::array::from_fn(|a| ((7 * k + 3 * a) % 5) as f32 + (k >> a & 1) as f32)
        });
        let map = CellMap::new(corners);
        for local in [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.75], [1.5, 0.5, -2.0], [-1.0, 3.0, 2.0]] {
            let weights = weights(local);
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            let at = map.at(local);
            for (a, at) in at.iter().enumerate() {
                let mean: f32 = (0..8).map(|k| weights[k] * corners[k][a]).sum();
                assert!((mean - at).abs() < 1e-4, "{local:?}: {mean} {at}");
            }
        }
        for (k, expected) in corners.iter().enumerate() {
            let corner = std::array::from_fn(|a| (k >> a & 1) as f32);
            assert_eq!(map.at(corner), *expected);
        }
    }

    #[test]
    fn points_outside_the_cell_follow_affine_motions() {
        let corners: [[f32; 3]; 8] = std::array::from_fn(|k| {
            let [x, y, z] = std::array::from_fn(|a| (k >> a & 1) as f32);
            [2.0 * x + y, y - z, 3.0 + z]
        });
        assert_eq!(CellMap::new(corners).at([100.0, -50.0, 8.0]), [150.0, -58.0, 11.0]);
    }
}
