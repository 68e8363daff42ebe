//! Trilinear interpolation in a cell, continued linearly outside the cell.
//!
//! The *local coordinates* of a point are its coordinates relative to corner 0 of its cell, in cells. They
//! are in `[0, 1]^3` for a point in the cell. Bit a of the number of a corner is the local coordinate of the
//! corner along axis a.
//!
//! `skin::mesh_update`, which interpolates the mesh vertices, uses [`polynomial`]. Only for vertices outside
//! their cells does it use [`CellMap`].

use std::ops::{Mul, Sub};

use nalgebra::Vector3;

/// Returns the trilinear weights of the eight corners at local coordinates.
///
/// The weights continue linearly outside `[0, 1]^3`.
pub(crate) fn weights(local: [f32; 3]) -> [f32; 8] {
    let [inside, outside] = split(local);
    // Linear weight of corner k along axis a.
    let linear = |k: usize, a: usize| if k >> a & 1 == 0 { 1.0 - inside[a] } else { inside[a] };
    std::array::from_fn(|k| {
        let mut weight = linear(k, 0) * linear(k, 1) * linear(k, 2);
        for (a, excess) in outside.iter().enumerate() {
            let slope = if k >> a & 1 == 0 { -1.0 } else { 1.0 };
            weight += excess * slope * linear(k, (a + 1) % 3) * linear(k, (a + 2) % 3);
        }
        weight
    })
}

/// Splits local coordinates into the nearest point of the cell and the offset from this point.
pub(super) fn split(local: [f32; 3]) -> [[f32; 3]; 2] {
    let inside = local.map(|x| x.clamp(0.0, 1.0));
    [inside, std::array::from_fn(|a| local[a] - inside[a])]
}

/// Returns the coefficients of 1, x, y, xy, z, xz, yz, xyz of the trilinear interpolant of values at the
/// corners.
///
/// `terms`: the values at the corners. For a cell with many points, the evaluation of this polynomial takes
/// half the work of [`weights`].
#[inline(always)]
pub(crate) fn polynomial<T: Copy + Sub<Output = T>>(mut terms: [T; 8]) -> [T; 8] {
    // Differences along x, then y, then z: the entry with the bit set, minus the entry without the bit.
    for bit in [1, 2, 4] {
        for k in 0..8 {
            if k & bit != 0 {
                terms[k] = terms[k] - terms[k - bit];
            }
        }
    }
    terms
}

/// Returns the monomials 1, x, y, xy, z, xz, yz, xyz of local coordinates. `one`: the number 1.
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

/// Converts the sums of [`monomials`] over points to the sums of the trilinear weights of each corner.
///
/// This is the transpose of [`polynomial`].
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

/// The trilinear map from the local coordinates of one deformed cell to positions, as a polynomial about
/// corner 0.
///
/// All coefficients but the first are differences between corners and therefore small, which keeps the
/// rounding error small.
pub(crate) struct CellMap {
    /// The coefficients of 1, x, y, xy, z, xz, yz, xyz.
    terms: [Vector3<f32>; 8],
}

impl CellMap {
    /// Builds the map of a cell from the positions of its corners.
    pub(super) fn new(corners: [[f32; 3]; 8]) -> Self {
        Self { terms: polynomial(corners.map(Vector3::from)) }
    }

    /// Returns the position at local coordinates.
    #[inline]
    pub(super) fn at(&self, local: [f32; 3]) -> [f32; 3] {
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
            let position = map.at(local);
            for (a, component) in position.iter().enumerate() {
                let mean: f32 = (0..8).map(|k| weights[k] * corners[k][a]).sum();
                assert!((mean - component).abs() < 1e-4, "{local:?}: {mean} {component}");
            }
        }
        for (k, expected) in corners.iter().enumerate() {
            let corner = std::array::from_fn(|a| (k >> a & 1) as f32);
            assert_eq!(map.at(corner), *expected);
        }
    }

    #[test]
    fn cell_map_is_exact_for_affine_motions_outside_the_cell() {
        let corners: [[f32; 3]; 8] = std::array::from_fn(|k| {
            let [x, y, z] = std::array::from_fn(|a| (k >> a & 1) as f32);
            [2.0 * x + y, y - z, 3.0 + z]
        });
        assert_eq!(CellMap::new(corners).at([100.0, -50.0, 8.0]), [150.0, -58.0, 11.0]);
    }
}
