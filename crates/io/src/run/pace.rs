//! Time scale: how long a frame takes in simulated time, and in how many steps.
//!
//! With the time scale s, `fps` frames per second and n steps per frame of a scene without it, frame k ends after the
//! simulated time T(k) = ∫ s dt up to k / fps. Its m steps have the length (T(k) - T(k - 1)) / m with the least m, at
//! least 1, for which they are no longer than 1 / (fps n). So slow motion has steps of the same length or shorter, and a
//! time scale of 1 changes nothing.

use supple::{Curve, Error, Simulation, Substeps};

use super::error::RunError;

/// Intervals in which the integral over a curve between two keyframes is computed, which is exact: a curve has at most
/// the degree 3 there, and Simpson's rule is exact up to this degree.
const SIMPSON: [(f64, f64); 3] = [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)];

/// The time scale of a run.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// The time scale; `None` if it is 1 at all times.
    scale: Option<Curve>,
    fps: f64,
    /// Steps per frame at a time scale of 1.
    substeps: u32,
}

impl Pace {
    pub(super) fn new(scale: &Curve, fps: f64, substeps: u32) -> Self {
        let scale = Some(scale.clone()).filter(|scale| scale.constant() != Some(1.0));
        Self { scale, fps, substeps }
    }

    /// Checks that all steps are long enough.
    pub(super) fn check(&self) -> Result<(), RunError> {
        let values = self.scale.iter().flat_map(Curve::keys).map(|key| key.value);
        let least = values.fold(1.0, f64::min);
        // Frames have one step if they are short.
        let shortest = least.min(0.5 / f64::from(self.substeps)) / self.fps;
        let shortest = if self.scale.is_some() { shortest } else { f64::INFINITY };
        match shortest >= 1e-11 {
            true => Ok(()),
            false => Err(RunError::Option {
                option: "simulation.time_scale",
                value: format!("{least} at fps = {}", self.fps),
                range: "greater, so that steps are at least 1e-11 s long",
            }),
        }
    }

    /// Sets the steps of a simulation to those of frame `frame`, counted from 0, which begins with the next step. Returns
    /// their number.
    ///
    /// # Errors
    ///
    /// A step length out of range.
    pub(super) fn begin_frame(&self, simulation: &mut Simulation, frame: u32) -> Result<u64, Error> {
        let Some(scale) = &self.scale else { return Ok(u64::from(self.substeps)) };
        // The length of all frames is the same to the last bit at a constant time scale, so that bodies sleep.
        let duration = match scale.constant() {
            Some(value) => value / self.fps,
            None => integral(scale, (f64::from(frame) - 1.0) / self.fps, f64::from(frame) / self.fps),
        };
        let longest = 1.0 / (self.fps * f64::from(self.substeps));
        // The factor keeps a rounding error from adding a step.
        let steps = (duration / longest * (1.0 - 1e-9)).ceil().max(1.0);
        if simulation.substeps() != steps as u64 {
            simulation.set_substeps(Substeps::Fixed(steps as u32))?;
        }
        let dt = duration / steps;
        if simulation.dt() != dt {
            simulation.set_dt(dt)?;
        }
        Ok(steps as u64)
    }
}

/// Returns the integral over a curve from `start` to `end`.
fn integral(curve: &Curve, start: f64, end: f64) -> f64 {
    if let Some(value) = curve.constant() {
        return value * (end - start);
    }
    let inner = curve.keys().iter().map(|key| key.time).filter(|&time| start < time && time < end);
    let times: Vec<f64> = std::iter::once(start).chain(inner).chain([end]).collect();
    let part = |times: &[f64]| {
        let length = times[1] - times[0];
        let sum: f64 = SIMPSON.iter().map(|(at, weight)| weight * curve.value(times[0] + at * length)).sum();
        length * sum / 6.0
    };
    times.windows(2).map(part).sum()
}

#[cfg(test)]
mod tests {
    use supple::{CurveKey, Interpolation};

    use super::*;

    #[test]
    fn integrals_are_exact_for_all_interpolations() {
        let keys = [(1.0, 2.0), (3.0, 4.0)].map(|(time, value)| CurveKey { time, value });
        for interpolation in [Interpolation::Linear, Interpolation::Smooth, Interpolation::Cubic] {
            let curve = Curve::new(keys.to_vec()).unwrap().interpolated(interpolation);
            // The mean of each interpolation between two keyframes is the mean of their values.
            assert!((integral(&curve, 0.0, 4.0) - (2.0 + 6.0 + 4.0)).abs() < 1e-12);
            assert!((integral(&curve, 1.0, 3.0) - 6.0).abs() < 1e-12);
        }
        assert_eq!(integral(&0.5.into(), 1.0, 2.0), 0.5);
    }
}
