//! Defines a case: its expected behavior, its run, the measured figures and their bounds.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;
use supple::Error;

use crate::suite::{Runnable, Suite, caught};

/// Upper bound of a figure of a case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// The bounded figure.
    pub measure: Measure,
    /// The largest passing value.
    pub limit: f64,
}

type Run = Box<dyn Fn() -> Result<Figures, Error> + Send + Sync>;

/// One stiff or extreme case.
pub struct Case {
    /// Family of the case.
    pub family: &'static str,
    /// Name, unique in the family. It describes what is done to the body.
    pub name: String,
    /// Expected behavior.
    pub expected: &'static str,
    /// Bounds that the figures must satisfy. Every case has at least the bound that no number is NaN or
    /// infinite.
    pub bounds: Vec<Bound>,
    /// Run-time class. A quick case takes at most approximately a second and is part of every test run.
    pub suite: Suite,
    run: Run,
}

/// Result of a case in the report.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Family of the case.
    pub family: &'static str,
    /// Name of the case.
    pub case: String,
    /// Expected behavior.
    pub expected: &'static str,
    /// Whether all bounds are satisfied.
    pub passed: bool,
    /// All bounds of the case.
    pub bounds: Vec<Bound>,
    /// The violated bounds.
    pub broken: Vec<Bound>,
    /// Measured figures.
    pub figures: Figures,
    /// Error or panic that ended the case.
    pub error: Option<String>,
    /// Run time on one thread, in seconds.
    pub seconds: f64,
}

impl Case {
    /// Creates a quick case whose only bound is that no number is NaN or infinite.
    pub(super) fn new(
        name: impl Into<String>,
        expected: &'static str,
        run: impl Fn() -> Result<Figures, Error> + Send + Sync + 'static,
    ) -> Self {
        let bounds = vec![Bound { measure: Measure::NotNumbers, limit: 0.0 }];
        Self { family: "", name: name.into(), expected, bounds, suite: Suite::Quick, run: Box::new(run) }
    }

    /// Adds a bound.
    pub(super) fn bound(mut self, measure: Measure, limit: f64) -> Self {
        self.bounds.push(Bound { measure, limit });
        self
    }

    /// Adds bounds of the errors of linear and angular momentum at the level of single-precision rounding.
    pub(super) fn keeps_momenta(self) -> Self {
        self.bound(Measure::Linear, 1e-6).bound(Measure::Angular, 1e-6)
    }

    /// Sets the family.
    pub(super) fn of_family(self, family: &'static str) -> Self {
        Self { family, ..self }
    }

    /// Sets the run-time class.
    pub(super) fn suite(self, suite: Suite) -> Self {
        Self { suite, ..self }
    }
}

impl Runnable for Case {
    type Row = Row;

    fn family(&self) -> &str {
        self.family
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn suite(&self) -> Suite {
        self.suite
    }

    fn run(&self) -> Row {
        let start = Instant::now();
        let result = caught(|| (self.run)());
        let seconds = start.elapsed().as_secs_f64();
        let (figures, error) = match result {
            Ok(figures) => (figures, None),
            Err(error) => (Figures::default(), Some(error)),
        };
        let is_satisfied =
            |bound: &Bound| figures.get(bound.measure).is_some_and(|value| value <= bound.limit);
        let broken: Vec<Bound> =
            self.bounds.iter().copied().filter(|bound| error.is_none() && !is_satisfied(bound)).collect();
        Row {
            family: self.family,
            case: self.name.clone(),
            expected: self.expected,
            passed: broken.is_empty() && error.is_none(),
            bounds: self.bounds.clone(),
            broken,
            figures,
            error,
            seconds,
        }
    }
}

/// Figures of one case.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Number of steps.
    pub steps: u64,
    /// Measured values.
    pub values: BTreeMap<Measure, f64>,
    /// Step and energy (kinetic and elastic) at each evaluation; empty unless the energy is measured. The
    /// unit is the mass of a full cell times (cells per step)².
    pub energy: Vec<(u64, f64)>,
}

impl Figures {
    /// Returns a figure, if it was measured.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        self.values.get(&measure).copied()
    }

    /// Sets a figure.
    pub(super) fn set(&mut self, measure: Measure, value: f64) {
        self.values.insert(measure, value);
    }

    /// Sets a figure to the larger of its value and `value`; NaN counts as the largest number.
    pub(super) fn raise(&mut self, measure: Measure, value: f64) {
        let maximum = self.values.entry(measure).or_insert(value);
        *maximum = largest(*maximum, value);
    }

    /// Adds to a figure that is a count.
    pub(super) fn add(&mut self, measure: Measure, value: f64) {
        *self.values.entry(measure).or_insert(0.0) += value;
    }
}

/// Returns the larger number; NaN counts as the largest number.
pub(super) fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// A figure of a case. For all figures, smaller is better. Counts are sums over all evaluations; other
/// figures are maxima over all evaluations, unless their descriptions say "at the end".
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Count of NaN and infinite numbers in positions, velocities, rotations, the corrected lattice, the
    /// evaluated surface and volumes.
    NotNumbers,
    /// Maximum speed of a vertex, in cells per step.
    LargestSpeed,
    /// Maximum speed of a vertex at the end, in cells per step.
    FinalSpeed,
    /// Increase of the energy over the initial energy, divided by the sum of the initial energy and
    /// m v² for the mass of the bodies and v = 0.001 cells per step.
    EnergyGain,
    /// Energy at the end, divided by the same sum as [`Measure::EnergyGain`].
    EnergyLeft,
    /// Root mean square distance from the rest shape at the end, up to a rigid motion, in cells.
    Shape,
    /// Steps until the distance from the rest shape is a tenth of the initial distance, or below a thousandth
    /// of a cell.
    StepsToTenth,
    /// Root mean square distance of the vertices from their expected positions at the end, in cells.
    Place,
    /// Error of the linear momentum, relative to the sum of the magnitudes of the vertices' momenta.
    Linear,
    /// Error of the angular momentum about the center of mass, relative to the sum of the magnitudes of the
    /// vertices' angular momenta.
    Angular,
    /// Penetration depth of the boundary vertices in a collider at the end, in cells.
    Depth,
    /// Time of the last frame at whose end a body was awake, in seconds.
    Awake,
    /// Relative error of the period of a pendulum, from a physical pendulum of the same shape.
    Period,
    /// Relative loss of the amplitude of a pendulum.
    AmplitudeLoss,
    /// Relative error of the corrected volume at the end.
    Volume,
    /// Number of evaluations in which the volume correction reached its cap.
    Capped,
    /// Number of rotations for which Newton's method did not converge, so that the fallback, an eigenvalue
    /// problem in f64, computed them.
    Unsettled,
}

impl Measure {
    /// Returns a short label with the unit.
    pub fn label(self) -> &'static str {
        match self {
            Self::NotNumbers => "NaN",
            Self::LargestSpeed => "largest speed, cells/step",
            Self::FinalSpeed => "final speed, cells/step",
            Self::EnergyGain => "energy gained, relative",
            Self::EnergyLeft => "energy left, relative",
            Self::Shape => "shape, cells",
            Self::StepsToTenth => "steps to a tenth",
            Self::Place => "place, cells",
            Self::Linear => "momentum",
            Self::Angular => "angular momentum",
            Self::Depth => "depth, cells",
            Self::Awake => "awake, s",
            Self::Period => "period",
            Self::AmplitudeLoss => "amplitude lost",
            Self::Volume => "volume",
            Self::Capped => "capped evaluations",
            Self::Unsettled => "fallback rotations",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_returns_nan_if_either_is_nan() {
        for (a, b, expected) in [(1.0, 2.0, 2.0), (2.0, 1.0, 2.0), (1.0, f64::INFINITY, f64::INFINITY)] {
            assert_eq!(largest(a, b), expected);
        }
        for other in [-1.0, 0.0, 1.0, f64::INFINITY, f64::NAN] {
            assert!(largest(f64::NAN, other).is_nan(), "NaN, {other}");
            assert!(largest(other, f64::NAN).is_nan(), "{other}, NaN");
        }
    }
}
