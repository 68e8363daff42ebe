//! The motion of a region, with its volume term.

use nalgebra::{Matrix3, Vector3};

/// The best-fit rigid motion of a region from its rest pose (Müller et al. 2005).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionMotion {
    /// Sum of the weights m_i / n_i of the region's vertices, in masses of a full cell.
    pub mass: f64,
    /// Weighted mean of the rest positions, relative to the lattice's origin.
    pub rest_centroid: Vector3<f64>,
    /// Weighted mean of the positions.
    pub centroid: Vector3<f64>,
    /// Rotation from the rest pose.
    pub rotation: Matrix3<f64>,
    /// Deformation gradient: the matrix F for which F y is closest to the position relative to `centroid`, where y is
    /// the rest position relative to `rest_centroid` times `stretch`.
    pub gradient: Matrix3<f64>,
    /// Plastic shape S: the region is fitted with S y in place of y.
    pub shape: Matrix3<f64>,
    /// k Y of the volume term: the region moves S y to (R S - k Y) y. Zero with Poisson's ratio 0.
    pub volume_motion: Matrix3<f64>,
    /// k W/t: the potential of the volume term divided by the mass of the region and by alpha/dt².
    pub volume_energy: f64,
    /// The cube root of the ratio by which the rest volume of the region is inflated.
    pub stretch: f64,
}

impl RegionMotion {
    /// Returns the rotated lever arm of a rest position. `rest`: relative to the lattice's origin.
    pub(super) fn arm(&self, rest: Vector3<f64>) -> Vector3<f64> {
        self.rotation * self.shape * (rest - self.rest_centroid) * self.stretch
    }

    /// Returns the position to which the motion moves a rest position. `rest`: relative to the lattice's
    /// origin.
    pub(super) fn goal(&self, rest: Vector3<f64>) -> Vector3<f64> {
        self.centroid + self.arm(rest) - self.volume_motion * (rest - self.rest_centroid) * self.stretch
    }

    /// Returns the position to which the rigid motion, without the volume term, moves a rest position.
    pub(super) fn rigid_goal(&self, rest: Vector3<f64>) -> Vector3<f64> {
        self.centroid + self.arm(rest)
    }
}

/// Returns k Y and k W/t of the volume term of a region, from its deformation gradient F and its inverse rest
/// covariance C⁻¹. With t = tr C⁻¹/3, D = C⁻¹/t, the cofactors K of F, d = det F - 1 and q = K : K D, the potential
/// is W = d²/(2 (q + 4 d²)), and Y D⁻¹ its gradient with respect to F.
pub(super) fn volume_term(
    f: &Matrix3<f64>,
    inverse: &Matrix3<f64>,
    poisson_ratio: f64,
) -> (Matrix3<f64>, f64) {
    let (k, t) = (3.0 * poisson_ratio / (1.0 - 2.0 * poisson_ratio), inverse.trace() / 3.0);
    if k == 0.0 || t == 0.0 {
        return (Matrix3::zeros(), 0.0);
    }
    let metric = inverse / t;
    let cofactors = crossed(f, f) / 2.0;
    let d = f.determinant() - 1.0;
    let stretched = cofactors * metric;
    let q = cofactors.dot(&stretched);
    let size = q + 4.0 * d * d;
    let slope = (cofactors * q - crossed(&stretched, f) * d) * (d / (size * size));
    (slope * metric * k, k * d * d / (2.0 * size) / t)
}

/// Returns the product of two matrices that is twice the cofactor matrix if they are the same.
fn crossed(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    let entry = |i: usize, j: usize| {
        let [(i1, j1), (i2, j2)] = [((i + 1) % 3, (j + 1) % 3), ((i + 2) % 3, (j + 2) % 3)];
        let first = a[(i1, j1)] * b[(i2, j2)] + b[(i1, j1)] * a[(i2, j2)];
        first - a[(i1, j2)] * b[(i2, j1)] - b[(i1, j2)] * a[(i2, j1)]
    };
    Matrix3::from_fn(entry)
}
