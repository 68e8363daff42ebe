//! Soft goals of pins and handles: springs in place of prescribed positions.

use std::f64::consts::{FRAC_PI_3, TAU};

use crate::motion::{Curve, CurveKey};
use crate::range::{Range, RangeError};
use crate::state::Interval;

/// How strongly a pin or a handle pulls its vertices to their targets, in place of prescribing their positions.
///
/// Each vertex is on a damped spring to its target: a = -ω² (x - t) - 2 ζ ω (v - t'), with the frequency
/// ω/(2 pi) = `frequency` sqrt(w/(1 - w)) for the weight w. So a weight of 1/2 gives `frequency`, and a greater one a
/// higher frequency; with the weight 1 the positions are prescribed. The frequency is the same at any step length, on any
/// lattice and for any mass, up to a sixth of the step rate, beyond which a vertex is at its target after each step. Under
/// gravity g a vertex hangs g/ω² below its target.
///
/// The springs pull the vertices of the part alone. A part that is thinner than the regions of the body is bent against
/// them: one layer of vertices does not hold a body like a clamp.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Goal {
    /// The weight w, in (0, 1]: a number or keyframes; default 1.
    pub weight: Curve,
    /// The frequency in Hz, above 0, that a weight of 1/2 gives; default 5.
    pub frequency: f64,
    /// The damping ratio ζ of the springs, in [0, 1]; default 0.2.
    pub damping_ratio: f64,
}

impl Default for Goal {
    fn default() -> Self {
        Self { weight: 1.0.into(), frequency: 5.0, damping_ratio: 0.2 }
    }
}

impl From<f64> for Goal {
    fn from(weight: f64) -> Self {
        Self { weight: weight.into(), ..Self::default() }
    }
}

impl Goal {
    /// Checks the numbers.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn validate(&self) -> Result<(), RangeError> {
        for CurveKey { value, .. } in self.weight.keys() {
            Range::POSITIVE_FRACTION.check("weight", *value)?;
        }
        Range::FREQUENCY.check("goal_frequency", self.frequency)?;
        Range::FRACTION.check("goal_damping", self.damping_ratio)?;
        Ok(())
    }

    /// Returns whether positions are prescribed at a time.
    pub(super) fn is_hard(&self, time: f64) -> bool {
        self.weight.value(time) >= 1.0
    }

    /// Returns whether the weight changes in a step.
    pub(super) fn changes_in(&self, step: Interval) -> bool {
        self.weight.value(step.start) != self.weight.value(step.end)
    }

    /// Returns the greatest frequency in Hz of the springs at a vertex with a factor of the weight; 0 if positions are
    /// always prescribed.
    pub(super) fn greatest_frequency(&self, factor: f64) -> f64 {
        let soft = self.weight.keys().iter().map(|key| key.value * factor).filter(|weight| *weight < 1.0);
        soft.map(|weight| self.frequency_of(weight)).fold(0.0, f64::max)
    }

    /// Returns the factors of the distance x - t and of the velocity v - t' in the acceleration in a step of `dt` seconds
    /// that begins at `time`, at a vertex with the factor `factor` of the weight.
    ///
    /// See [`spring_shares`].
    pub(super) fn factors(&self, time: f64, dt: f64, factor: f64) -> [f64; 2] {
        let omega = TAU * self.frequency_of((self.weight.value(time) * factor).min(1.0));
        let [stiffness, damping] = spring_shares(omega * dt, 2.0 * self.damping_ratio * omega * dt);
        [stiffness / (dt * dt), damping / dt]
    }

    fn frequency_of(&self, weight: f64) -> f64 {
        self.frequency * (weight / (1.0 - weight)).sqrt()
    }
}

/// Returns the shares s and c of a damped spring in a step: of its displacement d, which it takes away by a change of the
/// velocity of -s d/dt, and of the velocity u, which it changes by -c u. `phase`: ω dt, with the angular frequency ω.
/// `decay`: 2 ζ ω dt, with the damping ratio ζ.
///
/// A step changes u by the acceleration, and then d by dt u. The oscillation of this scheme has exactly the frequency ω if
/// s = 2 (1 - cos(ω dt)). At ω dt = pi/3 it is 1: d vanishes in the step. The scheme is stable with a share c of u, and an
/// elasticity of the body that adds up to 2 to s, if s + 2 < 2 (2 - c): c is at most 1 - s/2.
pub(crate) fn spring_shares(phase: f64, decay: f64) -> [f64; 2] {
    let share = 2.0 * (1.0 - libm::cos(phase.min(FRAC_PI_3)));
    [share, (-libm::expm1(-decay)).min(1.0 - share / 2.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scheme_has_the_frequency_of_the_weight_at_any_step_length() {
        let goal = Goal { weight: 0.3.into(), frequency: 2.0, damping_ratio: 0.0 };
        let frequency = 2.0 * (0.3_f64 / 0.7).sqrt();
        for dt in [1e-3, 1e-2, 0.1] {
            let [stiffness, damping] = goal.factors(0.0, dt, 1.0);
            let (mut x, mut v, mut phase, steps) = (1.0_f64, 0.0_f64, 0.0_f64, (20.0 / dt) as usize);
            let mut before = 0.0;
            for _ in 0..steps {
                v -= dt * (stiffness * x + damping * v);
                x += dt * v;
                // The scheme moves on an ellipse, on which the mean rate of the angle is ω.
                let angle = libm::atan2(-v, x * TAU * frequency);
                phase += (angle - before).rem_euclid(TAU);
                before = angle;
            }
            let found = phase / TAU / (steps as f64 * dt);
            assert!((found / frequency - 1.0).abs() < 0.02, "{dt}: {found} {frequency}");
        }
    }

    #[test]
    fn springs_beyond_the_steps_are_at_their_targets_after_each_step() {
        for weight in [0.999, 1.0] {
            let [stiffness, damping] = Goal::from(weight).factors(0.0, 1.0 / 30.0, 1.0);
            let dt = 1.0 / 30.0;
            let (x, v) = (1.0, 3.0);
            let after = v - dt * (stiffness * x + damping * v);
            assert!((x + dt * after).abs() < dt * v * (1.0 - damping * dt) + 1e-12);
            assert!(stiffness * dt * dt <= 1.0 + 1e-12 && damping * dt <= 1.0);
        }
    }

    #[test]
    fn numbers_out_of_range_are_errors() {
        for wrong in [0.0, 1.01, -0.5] {
            assert!(Goal::from(wrong).validate().is_err());
        }
        assert!(Goal { frequency: 0.0, ..Goal::default() }.validate().is_err());
        assert!(Goal { damping_ratio: 1.5, ..Goal::default() }.validate().is_err());
        assert!(Goal::from(0.7).validate().is_ok());
    }
}
