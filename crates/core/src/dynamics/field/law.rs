//! The kinds of fields, and their accelerations.

use nalgebra::{Point3, Vector3};

use super::wind::{Air, Wind};
use crate::motion::direction;
use crate::range::{Range, RangeError, in_range};
use crate::state::Interval;

/// The acceleration of a field. Accelerations and rates are multiplied by the strength of the field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FieldLaw {
    /// The same acceleration everywhere, in length/s^2, besides the gravity of the simulation.
    Gravity([f64; 3]),
    /// Air that moves.
    Wind(Wind),
    /// A rate in 1/s, at least 0, at which velocities decay: v becomes v exp(-rate t).
    Drag(f64),
    /// Air that turns about an axis.
    Vortex(Vortex),
    /// An attraction by a point.
    Attract(Attraction),
}

/// Air that turns about an axis like a rigid body within a radius, and slower outside, like the inverse of the distance
/// (Rankine 1858). It accelerates bodies like a [`Wind`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Vortex {
    /// A point of the axis; default the origin.
    pub center: [f64; 3],
    /// Direction of the axis, not zero; default y. The air turns counter-clockwise seen from its tip.
    pub axis: [f64; 3],
    /// Angular velocity within the radius, in rad/s; default 1.
    pub spin: f64,
    /// Radius, above 0; default 1.
    pub radius: f64,
    /// Rate in 1/s, at least 0, at which a body takes the velocity of the air; default 1.
    pub drag: f64,
}

impl Default for Vortex {
    fn default() -> Self {
        Self { center: [0.0; 3], axis: [0.0, 1.0, 0.0], spin: 1.0, radius: 1.0, drag: 1.0 }
    }
}

/// An acceleration towards a point: `acceleration` (radius/r)^`power` at the distance r, and within the radius linear in
/// r, so that it is 0 at the point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Attraction {
    /// The point; default the origin.
    pub center: [f64; 3],
    /// The acceleration at the radius, in length/s^2; negative ones repel; default 1.
    pub acceleration: f64,
    /// The radius, above 0; default 1.
    pub radius: f64,
    /// How fast the acceleration decreases beyond the radius, at least 0; default 2, as of masses and charges; 0: not at
    /// all.
    pub power: f64,
}

impl Default for Attraction {
    fn default() -> Self {
        Self { center: [0.0; 3], acceleration: 1.0, radius: 1.0, power: 2.0 }
    }
}

/// The strength of a field and its air in a step.
#[derive(Debug)]
pub(super) struct Moment {
    pub(super) strength: f64,
    dt: f64,
    /// Present for a wind.
    air: Option<Air>,
}

impl Moment {
    pub(super) fn new(law: &FieldLaw, strength: f64, step: Interval) -> Self {
        let air = match law {
            FieldLaw::Wind(wind) => Some(Air::new(wind, step.start)),
            _ => None,
        };
        Self { strength, dt: step.dt, air }
    }

    /// Returns the mean acceleration in the step by air with the velocity `air`, of which a body takes the velocity at a
    /// rate. The change of v is exact: (u - v) (1 - exp(-rate h)), at any rate and step length h.
    fn drag(&self, rate: f64, air: Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
        (air - velocity) * (-libm::expm1(-rate * self.strength * self.dt) / self.dt)
    }
}

impl FieldLaw {
    /// Returns whether the acceleration of a body at rest does not change over time.
    pub(super) fn is_steady(&self) -> bool {
        match self {
            Self::Wind(Wind { gust, turbulence, .. }) => *gust == 0.0 && *turbulence == 0.0,
            _ => true,
        }
    }

    /// Checks the numbers.
    pub(super) fn validate(&self) -> Result<(), RangeError> {
        let acceleration = |name, value: f64| in_range(name, value, value.abs() <= 1e12, "at most 1e12");
        let finite = |name, values: [f64; 3]| {
            values.into_iter().try_for_each(|value| acceleration(name, value).map(drop))
        };
        match *self {
            Self::Gravity(gravity) => {
                for component in gravity {
                    acceleration("gravity", component)?;
                }
            }
            Self::Wind(Wind { velocity, drag, gust, turbulence, .. }) => {
                finite("velocity", velocity)?;
                Range::RATE.check("drag", drag)?;
                Range::FRACTION.check("gust", gust)?;
                in_range(
                    "turbulence",
                    turbulence,
                    (0.0..=1e3).contains(&turbulence),
                    "at least 0 and at most 1000",
                )?;
            }
            Self::Drag(rate) => drop(Range::RATE.check("drag", rate)?),
            Self::Vortex(Vortex { center, axis, spin, radius, drag }) => {
                finite("center", center)?;
                finite("axis", axis)?;
                in_range("axis", axis[0], direction(axis).is_some(), "a vector that is not zero")?;
                acceleration("spin", spin)?;
                Range::LENGTH.check("radius", radius)?;
                Range::RATE.check("drag", drag)?;
            }
            Self::Attract(Attraction { center, acceleration: at_radius, radius, power }) => {
                finite("center", center)?;
                acceleration("acceleration", at_radius)?;
                Range::LENGTH.check("radius", radius)?;
                Range::NOT_NEGATIVE.check("power", power)?;
            }
        }
        Ok(())
    }

    /// Returns the mean acceleration in a step of a point with a velocity.
    pub(super) fn acceleration(
        &self,
        moment: &Moment,
        point: &Point3<f64>,
        velocity: &Vector3<f64>,
    ) -> Vector3<f64> {
        match self {
            Self::Gravity(gravity) => Vector3::from(*gravity) * moment.strength,
            Self::Wind(wind) => {
                let air = moment.air.as_ref().map_or_else(Vector3::zeros, |air| air.velocity(point));
                moment.drag(wind.drag, air, velocity)
            }
            Self::Drag(rate) => moment.drag(*rate, Vector3::zeros(), velocity),
            Self::Vortex(vortex) => moment.drag(vortex.drag, vortex.air(point), velocity),
            Self::Attract(attraction) => attraction.at(point) * moment.strength,
        }
    }
}

impl Vortex {
    /// Returns the velocity of the air.
    fn air(&self, point: &Point3<f64>) -> Vector3<f64> {
        let axis = direction(self.axis).unwrap_or_else(Vector3::y);
        let turned = (axis * self.spin).cross(&(point - Point3::from(self.center)));
        // The squared distance from the axis.
        let squared = (point - Point3::from(self.center)).cross(&axis).norm_squared();
        turned * (self.radius * self.radius / squared.max(self.radius * self.radius))
    }
}

impl Attraction {
    /// Returns the acceleration.
    fn at(&self, point: &Point3<f64>) -> Vector3<f64> {
        let to_center = Point3::from(self.center) - point;
        let distance = to_center.norm();
        if distance <= self.radius {
            return to_center * (self.acceleration / self.radius);
        }
        to_center * (self.acceleration / distance * libm::pow(self.radius / distance, self.power))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drag_is_exact_at_any_step_length() {
        for dt in [1e-3, 0.1, 100.0] {
            let velocity = Vector3::new(2.0, 0.0, 0.0);
            let law = FieldLaw::Drag(3.0);
            let moment = Moment::new(&law, 1.0, Interval { start: 0.0, end: dt, dt });
            let change = law.acceleration(&moment, &Point3::origin(), &velocity) * dt;
            assert!((velocity + change - velocity * libm::exp(-3.0 * dt)).norm() < 1e-12);
        }
    }

    #[test]
    fn a_vortex_turns_like_a_rigid_body_inside_and_decays_outside() {
        let vortex = Vortex { spin: 2.0, radius: 1.5, ..Vortex::default() };
        let speed = |x: f64| vortex.air(&Point3::new(x, 7.0, 0.0));
        assert_eq!(speed(1.0), Vector3::new(0.0, 0.0, -2.0));
        assert!((speed(1.5).norm() - 3.0).abs() < 1e-12 && (speed(3.0).norm() - 1.5).abs() < 1e-12);
        assert_eq!(speed(0.0), Vector3::zeros());
    }

    #[test]
    fn an_attraction_is_zero_at_its_point_and_continuous_at_its_radius() {
        let attraction = Attraction { acceleration: 4.0, radius: 2.0, ..Attraction::default() };
        let at = |x: f64| attraction.at(&Point3::new(x, 0.0, 0.0)).x;
        assert_eq!([at(0.0), at(1.0), at(2.0), at(4.0)], [0.0, -2.0, -4.0, -1.0]);
    }

    #[test]
    fn numbers_out_of_range_are_errors() {
        let wrong = [
            FieldLaw::Gravity([f64::NAN, 0.0, 0.0]),
            FieldLaw::Drag(-1.0),
            FieldLaw::Wind(Wind { gust: 1.5, ..Wind::default() }),
            FieldLaw::Vortex(Vortex { axis: [0.0; 3], ..Vortex::default() }),
            FieldLaw::Attract(Attraction { radius: 0.0, ..Attraction::default() }),
        ];
        assert!(wrong.iter().all(|law| law.validate().is_err()));
    }
}
