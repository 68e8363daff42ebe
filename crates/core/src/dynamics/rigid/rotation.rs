//! The rotation of a body whose angular momentum is constant.

use nalgebra::{UnitQuaternion, Vector3};

/// Greatest angle of a part of a step, in radians. With it, the energy of a body that tumbles for a thousand turns
/// changes by less than 1e-4.
const GREATEST_ANGLE: f64 = 0.1;

/// Greatest number of parts of a step.
const MAX_PARTS: f64 = 64.0;

/// Returns the rotation after `dt` seconds. `angular_velocity` returns the angular velocity in world space of a rotation.
///
/// The angular momentum L is constant and the angular velocity is R I⁻¹ Rᵀ L, so that the gyroscopic torque needs no
/// term of its own and no rotation changes L. The method is that of Runge and Kutta of order 4 in the Lie algebra
/// (Munthe-Kaas 1998): R becomes exp(θ) R, with the rotation vector θ of dθ/dt = dexp⁻¹(θ) ω. A step is divided into
/// parts of at most [`GREATEST_ANGLE`].
pub(super) fn rotated(
    rotation: UnitQuaternion<f64>,
    dt: f64,
    angular_velocity: impl Fn(&UnitQuaternion<f64>) -> Vector3<f64>,
) -> UnitQuaternion<f64> {
    let angle = angular_velocity(&rotation).norm() * dt;
    if angle == 0.0 || !angle.is_finite() {
        return rotation;
    }
    let parts = (angle / GREATEST_ANGLE).ceil().clamp(1.0, MAX_PARTS);
    let h = dt / parts;
    (0..parts as usize).fold(rotation, |rotation, _| {
        let rate = |theta: Vector3<f64>| {
            let omega = angular_velocity(&(UnitQuaternion::from_scaled_axis(theta) * rotation));
            let bracket = theta.cross(&omega);
            omega - bracket / 2.0 + theta.cross(&bracket) / 12.0
        };
        let a = angular_velocity(&rotation);
        let b = rate(a * (h / 2.0));
        let c = rate(b * (h / 2.0));
        let d = rate(c * h);
        let turned = UnitQuaternion::from_scaled_axis((a + (b + c) * 2.0 + d) * (h / 6.0)) * rotation;
        UnitQuaternion::new_normalize(turned.into_inner())
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    #[test]
    fn rotation_about_a_principal_axis_is_exact() {
        let spin = Vector3::new(0.0, 0.0, 7.0);
        let rotation = rotated(UnitQuaternion::identity(), 0.3, |_| spin);
        let expected = UnitQuaternion::from_scaled_axis(spin * 0.3);
        assert!(rotation.angle_to(&expected) < 1e-14);
    }

    #[test]
    fn error_of_a_tumbling_rotation_falls_with_the_fourth_power_of_the_step() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0));
        let inverse = inertia.try_inverse().unwrap();
        let momentum = inertia * Vector3::new(0.3, 0.5, 0.2);
        let omega = |rotation: &UnitQuaternion<f64>| {
            rotation * (inverse * rotation.inverse_transform_vector(&momentum))
        };
        let after = |steps: usize| {
            let dt = 2.0 / steps as f64;
            (0..steps).fold(UnitQuaternion::identity(), |rotation, _| rotated(rotation, dt, omega))
        };
        let exact = after(2000);
        // No step is divided.
        let errors = [20, 40].map(|steps| after(steps).rotation_to(&exact).imag().norm());
        assert!(errors[0] < 1e-6 && errors[0] > 12.0 * errors[1], "{errors:?}");
    }
}
