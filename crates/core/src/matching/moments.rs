//! Rest moments of the regions, their inverse inertia and covariances, and the misfit of a deformed lattice.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::covariances::InverseCovariances;
use super::line_windows::LineWindows;
use super::regions::{Regions, field_of};
use crate::lattice::Layout;
use crate::simd::lanes::Lanes;

impl Regions {
    /// Computes the sum, over all regions and the vertices of each region, of s m/n |y|², where y is the rest
    /// offset of the vertex from the rest centroid of the region, in cells, and s the factor of the region.
    pub(crate) fn rest_moment(&self, layout: &Layout) -> f64 {
        let [xx, yy, zz, ..] = self.second_moments(layout);
        let moments = self.slots(layout).map(|&slot| {
            let [inverse_mass, x, y, z] = self.constants.get(slot).map(f64::from);
            let i = slot as usize;
            self.factor(slot) * (xx[i] + yy[i] + zz[i] - (x * x + y * y + z * z) / inverse_mass)
        });
        moments.sum()
    }

    /// Computes the sum, over all regions and the vertices of each region, of s m/n |R y + c - x|², in f64. x is the
    /// position of a vertex, y its rest offset from the rest centroid of the region, c the center of mass of the
    /// region, R its rotation, all in cells, and s the factor of the region.
    ///
    /// `position` returns x of a slot, and `rotation` the quaternion (x, y, z, w) of R of the region around a slot. An
    /// error of the quaternion has an effect of second order if it is the fitted one, so f32 is enough. `strains` are
    /// S - 1 of the plastic shapes S of the regions; S y then takes the place of y, and σ y in an inflated region.
    /// With a volume term, 2 M σ² k W/t of each region is added, times s.
    pub(crate) fn misfit(
        &self,
        layout: &Layout,
        position: impl Fn(u32) -> Vector3<f64>,
        rotation: impl Fn(u32) -> [f32; 4],
        strains: Option<&Lanes<6>>,
    ) -> f64 {
        let m_over_n = self.region_weights(layout);
        let weighted = |value: &dyn Fn(Vector3<f64>) -> f64| {
            let mut field = vec![0.0; m_over_n.len()];
            for &slot in layout.slots() {
                field[slot as usize] = m_over_n[slot as usize] * value(position(slot));
            }
            field
        };
        let windows = LineWindows::new(layout, self.half_width());
        let [mass, rest @ ..] = windows.first_moments(&m_over_n);
        let second = windows.second_moments(&m_over_n);
        let [yy0, yy1, yy2, ..] = &second;
        let [x, y, z] = [0, 1, 2].map(|c| windows.first_moments(&weighted(&|x| x[c])));
        let xx = windows.sums(&weighted(&|x| x.norm_squared()));
        let misfit_of = |&slot: &u32| {
            let i = slot as usize;
            let moment = |k: usize| Vector3::new(x[k][i], y[k][i], z[k][i]);
            let (sum, d) = (moment(0), Vector3::new(rest[0][i], rest[1][i], rest[2][i]) / mass[i]);
            let rest_moment = yy0[i] + yy1[i] + yy2[i] - mass[i] * d.norm_squared();
            let central = xx[i] - sum.norm_squared() / mass[i];
            let [qx, qy, qz, qw] = rotation(slot).map(f64::from);
            let r = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz)).to_rotation_matrix();
            // Σ m/n (x - c) · R y, the trace of Rᵀ Σ m/n (x - c) yᵀ.
            let product: f64 = (0..3).map(|k| r.matrix().column(k).dot(&(moment(k + 1) - sum * d[k]))).sum();
            let c = || self::covariance(second.each_ref().map(|moment| moment[i] / mass[i]), d);
            let a = || Matrix3::from_fn(|row, k| (moment(k + 1) - sum * d[k])[row] / mass[i]);
            let sigma = self.inflation.as_ref().map_or(1.0, |sigma| f64::from(sigma.get(slot)[0]));
            let change = strains.map_or(0.0, |strains| {
                let t = symmetric(strains.get(slot));
                let of_shape = (c() * (t * 2.0 + t * t)).trace() * (sigma * sigma);
                of_shape - 2.0 * sigma * (r.matrix().transpose() * a() * t).trace()
            });
            let volume = match self.bulk {
                0.0 => 0.0,
                bulk => 2.0 * f64::from(bulk) * volume_energy(a() / sigma, c()) * (sigma * sigma),
            };
            let misfit = central + rest_moment * (sigma * sigma) - 2.0 * sigma * product;
            self.factor(slot) * (misfit + mass[i] * (change + volume))
        };
        self.slots(layout).map(misfit_of).sum()
    }

    /// Computes the second moments of each region, by slot of its center vertex: Σ m/n times xx, yy, zz, xy,
    /// xz and yz, where (x, y, z) is the rest offset of a vertex from the center vertex.
    fn second_moments(&self, layout: &Layout) -> [Vec<f64>; 6] {
        LineWindows::new(layout, self.half_width()).second_moments(&self.region_weights(layout))
    }

    /// Returns the region weight m/n of the vertex in each slot, or 1 in cells. The product is rounded to f32, as in
    /// the window sums of a step.
    pub(super) fn region_weights(&self, layout: &Layout) -> Vec<f64> {
        let is_cell = self.half_width().is_cell();
        field_of(layout, |slot| {
            let [m, inverse_count] = self.weights.get(slot);
            if is_cell { 1.0 } else { f64::from(m * inverse_count) }
        })
    }

    /// Computes, for each region, the inverse of M⁻¹ Σ m/n ((y·y) I - y yᵀ): the rest inertia divided by the
    /// mass. y is the rest offset of a vertex from the rest centroid, in cells, and I is the identity. The
    /// entries of a matrix are in the order xx, yy, zz, xy, xz, yz.
    pub(crate) fn inverse_inertia(&self, layout: &Layout) -> Lanes<6> {
        self.inverses(layout, |covariance| Matrix3::identity() * covariance.trace() - covariance)
    }

    /// Computes [`Regions::inverse_covariances`]. Numbers at the level of rounding errors become zero, so that most
    /// blocks with the same covariances have the same bits.
    pub(super) fn inverse_covariances(&self, layout: &Layout) -> InverseCovariances {
        let mut covariances = self.inverses(layout, |covariance| covariance);
        for &slot in layout.slots() {
            let covariance = covariances.get(slot);
            let noise = (covariance[0] + covariance[1] + covariance[2]) * f32::EPSILON;
            covariances.set(slot, covariance.map(|number| if number.abs() > noise { number } else { 0.0 }));
        }
        InverseCovariances::new(&covariances)
    }

    /// Computes, for each region, the inverse of a matrix that depends on its rest covariance; zero if it has none.
    /// In a whole body every region contains the corners of a cell, so that its covariance and its inertia have an
    /// inverse. At the front of a crack, where links are left out, a region can be planar, and its covariance has
    /// none.
    fn inverses(&self, layout: &Layout, matrix: impl Fn(Matrix3<f64>) -> Matrix3<f64>) -> Lanes<6> {
        let second = self.second_moments(layout);
        let mut lanes = Lanes::zeros(layout.blocks());
        for &slot in self.slots(layout) {
            let [inverse_mass, x, y, z] = self.constants.get(slot).map(f64::from);
            let moments = second.each_ref().map(|moment| moment[slot as usize] * inverse_mass);
            let covariance = covariance(moments, Vector3::new(x, y, z));
            let inverse = matrix(covariance).try_inverse().unwrap_or_else(Matrix3::zeros);
            lanes.set(slot, SYMMETRIC.map(|at| inverse[at] as f32));
        }
        lanes
    }
}

/// Returns W/t of the [volume term](super::bulk) of a region, from A and the rest covariance C; 0 if C has no inverse.
fn volume_energy(a: Matrix3<f64>, c: Matrix3<f64>) -> f64 {
    let Some(inverse) = c.try_inverse() else { return 0.0 };
    let (f, t) = (a * inverse, inverse.trace() / 3.0);
    let column = |k: usize| f.column((k + 1) % 3).cross(&f.column((k + 2) % 3));
    let cofactors = Matrix3::from_columns(&[column(0), column(1), column(2)]);
    let (d, q) = (f.determinant() - 1.0, cofactors.dot(&(cofactors * inverse)) / t);
    d * d / (2.0 * (q + 4.0 * d * d)) / t
}

/// The order of the entries of a symmetric matrix: xx, yy, zz, xy, xz, yz.
const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Computes the covariance of a region. The arguments are the second moments about the center vertex, divided by the
/// mass, and the rest centroid `d` relative to the center vertex.
fn covariance([xx, yy, zz, xy, xz, yz]: [f64; 6], d: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - d * d.transpose()
}

/// Returns the symmetric matrix with the entries xx, yy, zz, xy, xz, yz.
pub(crate) fn symmetric([xx, yy, zz, xy, xz, yz]: [f32; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).map(f64::from)
}
