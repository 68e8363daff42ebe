//! Computes the rotation that fits a matrix best, by a singular value decomposition.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Singular values below this fraction of the largest one are treated as zero.
const ROUNDING: f64 = 1e-15;

/// Maximum number of sweeps over the three pairs of columns. Five sweeps reach full precision. Further sweeps
/// are a margin.
const SWEEPS: usize = 30;

/// Computes the rotation R that maximizes tr(R^T A), where ^T is the transpose.
///
/// With the singular value decomposition A = U S V^T, R is U diag(1, 1, det(U V^T)) V^T.
///
/// The result is always a rotation. If det A is negative, the direction of the smallest singular value is
/// reversed (Umeyama 1991). If A has rank 1, several rotations maximize the trace, and the result is the one
/// with the smallest angle. If A is 0 or has an entry that is not finite, the result is the identity.
///
/// The decomposition uses one-sided Jacobi rotations (Hestenes 1958), which keep small singular values
/// precise. The decomposition of [`nalgebra`] for 3x3 matrices uses A^T A and loses half of the digits.
pub fn rotation(a: &Matrix3<f64>) -> Matrix3<f64> {
    let scale = a.amax();
    if !(scale > 0.0 && scale.is_finite()) {
        return Matrix3::identity();
    }
    // After the loop, the columns of B = (A / scale) V are orthogonal. They are the left singular vectors
    // times the singular values.
    let (mut b, mut v) = (a.map(|x| x / scale), Matrix3::identity());
    for _ in 0..SWEEPS {
        let rotated = [(0, 1), (0, 2), (1, 2)].map(|(p, q)| make_orthogonal(&mut b, &mut v, p, q));
        if rotated == [false; 3] {
            break;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&p, &q| b.column(q).norm().total_cmp(&b.column(p).norm()));
    let (s1, s2) = (b.column(order[0]).norm(), b.column(order[1]).norm());
    let u1 = b.column(order[0]) / s1;
    let v1: Vector3<f64> = v.column(order[0]).into();
    if s2 <= ROUNDING * s1 {
        return shortest_rotation(&v1, &u1);
    }
    let u2 = b.column(order[1]) / s2;
    let v2: Vector3<f64> = v.column(order[1]).into();
    // Two pairs of singular vectors determine the rotation. The third pair is their cross products, for any
    // sign of det A.
    u1 * v1.transpose() + u2 * v2.transpose() + u1.cross(&u2) * v1.cross(&v2).transpose()
}

/// Rotates the columns p and q of B and V so that these columns of B become orthogonal. Returns false if they
/// were orthogonal already.
fn make_orthogonal(b: &mut Matrix3<f64>, v: &mut Matrix3<f64>, p: usize, q: usize) -> bool {
    let (x, y): (Vector3<f64>, Vector3<f64>) = (b.column(p).into(), b.column(q).into());
    let (product, xx, yy) = (x.dot(&y), x.norm_squared(), y.norm_squared());
    if product == 0.0 || product.abs() <= f64::EPSILON * (xx * yy).sqrt() {
        return false;
    }
    let half_cot = (yy - xx) / (2.0 * product);
    let tan = half_cot.signum() / (half_cot.abs() + libm::hypot(half_cot, 1.0));
    let cos = 1.0 / libm::hypot(tan, 1.0);
    let sin = cos * tan;
    for m in [b, v] {
        let (x, y): (Vector3<f64>, Vector3<f64>) = (m.column(p).into(), m.column(q).into());
        m.set_column(p, &(x * cos - y * sin));
        m.set_column(q, &(x * sin + y * cos));
    }
    true
}

/// Returns the rotation with the smallest angle that maps one unit vector to another.
fn shortest_rotation(from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    let rotation = Rotation3::rotation_between(from, to).unwrap_or_else(|| {
        // Opposite vectors: a half turn about any orthogonal axis.
        let axis = Unit::new_normalize(from.cross(&Vector3::ith(from.iamin(), 1.0)));
        Rotation3::from_axis_angle(&axis, std::f64::consts::PI)
    });
    rotation.into_inner()
}
