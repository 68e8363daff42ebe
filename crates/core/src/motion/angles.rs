//! Computes rotation matrices from Euler angles in degrees, bit-identical on every machine, Euler angles from matrices,
//! and unit vectors.
//!
//! Sine and cosine are own code, because the standard library's have other bits on other platforms. Those of the crate
//! libm have the same bits everywhere, but need the exact reduction of degrees as well, are not faster (26 ns in
//! place of 25 ns), and differ in the last place for 5 % of the angles, which would change the frames of existing
//! scenes.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Coefficients of x³, x⁵, ... x¹⁷ in the Taylor series of the sine.
const SIN: [f64; 8] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];

/// Coefficients of x², x⁴, ... x¹⁶ in the Taylor series of the cosine.
const COS: [f64; 8] = [
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// Computes the sine and the cosine of an angle in degrees. The error is approximately 1 ulp, and zero at
/// multiples of 90 degrees.
///
/// Uses only correctly rounded operations, so that the results are bit-identical on every machine. The math
/// library of a platform does not guarantee this. An angle of many full turns has the same accuracy. The
/// results are NaN for an angle that is not finite.
pub(crate) fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    // Both the remainder by 360 and the difference from a multiple of 90 are exact.
    let within_turn = degrees % 360.0;
    let quarters = (within_turn / 90.0).round();
    let x = (within_turn - 90.0 * quarters) * (std::f64::consts::PI / 180.0);
    let (s, c) = (x + x * series(&SIN, x * x), 1.0 + series(&COS, x * x));
    match (quarters as i32).rem_euclid(4) {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Computes the sum of `coefficients[k] * x_squared^(k+1)`.
fn series(coefficients: &[f64; 8], x_squared: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * x_squared)
}

/// Computes the rotation matrix of Euler angles in degrees about the *fixed* axes x, then y, then z:
/// `Rz * Ry * Rx`.
///
/// If all angles are multiples of 90 degrees, each entry is exactly 0, 1 or -1. Zero angles give the
/// identity.
pub fn euler_degrees(angles: [f64; 3]) -> Matrix3<f64> {
    let [(sx, cx), (sy, cy), (sz, cz)] = angles.map(sin_cos_degrees);
    Matrix3::new(cz, -sz, 0.0, sz, cz, 0.0, 0.0, 0.0, 1.0)
        * Matrix3::new(cy, 0.0, sy, 0.0, 1.0, 0.0, -sy, 0.0, cy)
        * Matrix3::new(1.0, 0.0, 0.0, 0.0, cx, -sx, 0.0, sx, cx)
}

/// Computes Euler angles in degrees about the *fixed* axes x, then y, then z of a rotation matrix: the inverse of
/// [`euler_degrees`]. Of all angles of the rotation it returns those nearest to `near`, so that the angles of rotations
/// one after another do not jump. The error is approximately 1e-13 degrees, also where the y axis turns by 90 degrees.
pub fn euler_degrees_near(rotation: &Matrix3<f64>, near: [f64; 3]) -> [f64; 3] {
    let r = rotation;
    let cos_y = libm::hypot(r.m11, r.m21);
    // With y = 90 degrees, only the difference of x and z is determined. Rounding errors leave a cosine of about 1e-16.
    let z = if cos_y < 1e-12 { near[2].to_radians() } else { libm::atan2(r.m21, r.m11) };
    let (sz, cz) = libm::sincos(z);
    // The rotation about x is what is left when the one about z is undone (Day 2012, "Extracting Euler angles from a
    // rotation matrix"). It is accurate for every y.
    let x = libm::atan2(sz * r.m13 - cz * r.m23, cz * r.m22 - sz * r.m12);
    let y = libm::atan2(-r.m31, cos_y);
    let first = [x, y, z].map(f64::to_degrees);
    // The other rotations about x and z by half a turn more have the same matrix.
    let second = [first[0] + 180.0, 180.0 - first[1], first[2] + 180.0];
    let nearest = |angles: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|c| angles[c] + 360.0 * ((near[c] - angles[c]) / 360.0).round())
    };
    let distance = |angles: &[f64; 3]| (0..3).map(|c| (angles[c] - near[c]).abs()).sum::<f64>();
    let [first, second] = [nearest(first), nearest(second)];
    if distance(&second) < distance(&first) { second } else { first }
}

/// Computes the rotation matrix of a quaternion x, y, z, w of any length but zero; `None` for another one. Of the matrix,
/// [`euler_degrees_near`] computes the angles that keyframes and shapes take.
pub fn quaternion_rotation(quaternion: [f64; 4]) -> Option<Matrix3<f64>> {
    let greatest = quaternion.iter().fold(0.0_f64, |greatest, x| greatest.max(x.abs()));
    if !(greatest > 0.0 && quaternion.iter().all(|x| x.is_finite())) {
        return None;
    }
    // The squares of numbers of at most 1 do not overflow.
    let [x, y, z, w] = quaternion.map(|x| x / greatest);
    Some(UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner())
}

/// Returns the unit vector along `v`, or `None` if `v` is zero or not finite.
pub(crate) fn direction(v: [f64; 3]) -> Option<Vector3<f64>> {
    let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    // The vector is scaled before it is normalized, so that the squares of components such as 1e-200 or 1e200
    // neither underflow nor overflow.
    Some((Vector3::from(v) / largest).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn sine_and_cosine_agree_with_the_math_library() {
        for i in -72_000..72_000 {
            let degrees = f64::from(i) * 0.01 + 0.003;
            let (s, c) = sin_cos_degrees(degrees);
            let (s0, c0) = libm::sincos((degrees % 360.0).to_radians());
            assert!((s - s0).abs() < 1e-15 && (c - c0).abs() < 1e-15, "{degrees}");
        }
    }

    #[test]
    fn sine_and_cosine_are_exact_at_multiples_of_90_degrees() {
        for (degrees, expected) in [
            (0.0, (0.0, 1.0)),
            (90.0, (1.0, 0.0)),
            (180.0, (0.0, -1.0)),
            (270.0, (-1.0, 0.0)),
            (720.0, (0.0, 1.0)),
            (-90.0, (-1.0, 0.0)),
            (90.0 * 1e9 + 90.0, (1.0, 0.0)),
        ] {
            assert_eq!(sin_cos_degrees(degrees), expected, "{degrees}");
        }
        assert!(sin_cos_degrees(f64::INFINITY).0.is_nan());
    }

    #[test]
    fn euler_angles_of_a_matrix_give_the_matrix_and_are_the_nearest() {
        let steps = [-180.0, -135.0, -90.0, -89.999_999, -30.0, 0.0, 45.0, 90.0, 90.000_001, 179.0];
        for x in steps {
            for y in steps {
                for z in steps {
                    let rotation = euler_degrees([x, y, z]);
                    for near in [[0.0; 3], [x, y, z], [720.0 + x, y - 360.0, z + 5.0], [300.0, -200.0, 100.0]]
                    {
                        let angles = euler_degrees_near(&rotation, near);
                        assert!((euler_degrees(angles) - rotation).norm() < 1e-14, "{x} {y} {z} {near:?}");
                        // No two sets of angles are farther apart than half a turn about each axis.
                        assert!((0..3).all(|c| (angles[c] - near[c]).abs() <= 180.0 + 1e-9));
                    }
                    let same = euler_degrees_near(&rotation, [x + 720.0, y, z - 360.0]);
                    if y.abs() != 90.0 {
                        let error = [same[0] - x - 720.0, same[1] - y, same[2] - z + 360.0];
                        // Near y = 90 degrees the angles x and z amplify rounding errors by 1/cos(y).
                        let limit = 1e-12 / sin_cos_degrees(y).1.abs();
                        assert!(error.iter().all(|e| e.abs() < limit), "{x} {y} {z} {same:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn quaternions_of_any_length_are_rotations_about_their_axis() {
        let half = 35.0_f64.to_radians();
        let angles = [0.0, 0.0, 70.0];
        for scale in [1.0, -3.0, 1e-300, 1e300] {
            let quaternion = [0.0, 0.0, libm::sin(half), libm::cos(half)].map(|x| x * scale);
            let rotation = quaternion_rotation(quaternion).unwrap();
            assert!((rotation - euler_degrees(angles)).norm() < 1e-15, "{scale}: {rotation}");
        }
        assert_eq!(quaternion_rotation([0.0; 4]), None);
        assert_eq!(quaternion_rotation([0.0, f64::INFINITY, 0.0, 1.0]), None);
        assert_eq!(quaternion_rotation([0.0, f64::NAN, 0.0, 1.0]), None);
    }

    #[test]
    fn euler_angles_are_about_fixed_axes_in_the_order_x_y_z() {
        let [x, y, z] = [20.0, -35.0, 70.0];
        let about = |axis: Vector3<f64>, a: f64| Rotation3::new(axis * a.to_radians()).into_inner();
        let expected = about(Vector3::z(), z) * about(Vector3::y(), y) * about(Vector3::x(), x);
        assert!((euler_degrees([x, y, z]) - expected).norm() < 1e-15);
        // 90 degrees about x leave the x axis unchanged; 90 degrees about z then map it to y.
        assert_eq!(euler_degrees([90.0, 0.0, 90.0]) * Vector3::x(), Vector3::y());
    }
}
