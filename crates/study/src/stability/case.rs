//! A case: what it shows, how it is run, what is measured of it and what bounds that.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use serde::Serialize;
use supple::Error;

/// How long a case takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    /// A second or less: part of every test run.
    Quick,
    /// Longer.
    Long,
}

/// The largest value of a figure that a case may have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Of what.
    pub measure: Measure,
    /// The largest value that passes.
    pub limit: f64,
}

type Run = Box<dyn Fn() -> Result<Figures, Error> + Send + Sync>;

/// One stiff or extreme case.
pub struct Case {
    /// Which cases it belongs to.
    pub family: &'static str,
    /// What is done, unique.
    pub name: String,
    /// What is expected, and why, in plain words.
    pub shows: &'static str,
    /// What it passes by; every case is bound to be without NaN.
    pub bounds: Vec<Bound>,
    /// How long it takes.
    pub suite: Suite,
    run: Run,
}

/// A case that was run, as the report has it.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Which cases it belongs to.
    pub family: &'static str,
    /// What was done.
    pub case: String,
    /// What was expected.
    pub expected: &'static str,
    /// Whether all bounds hold.
    pub passed: bool,
    /// What it was held to.
    pub bounds: Vec<Bound>,
    /// The bounds that do not hold.
    pub broken: Vec<Bound>,
    /// What was measured.
    pub figures: Figures,
    /// Why it could not be run to its end.
    pub error: Option<String>,
    /// How long it took on one thread, in seconds.
    pub seconds: f64,
}

impl Case {
    pub(super) fn new(
        name: impl Into<String>,
        shows: &'static str,
        run: impl Fn() -> Result<Figures, Error> + Send + Sync + 'static,
    ) -> Self {
        let bounds = vec![Bound { measure: Measure::NotNumbers, limit: 0.0 }];
        Self { family: "", name: name.into(), shows, bounds, suite: Suite::Quick, run: Box::new(run) }
    }

    pub(super) fn bound(mut self, measure: Measure, limit: f64) -> Self {
        self.bounds.push(Bound { measure, limit });
        self
    }

    /// Bounds both momenta by the rounding of single precision.
    pub(super) fn keeps_momenta(self) -> Self {
        self.bound(Measure::Linear, 1e-6).bound(Measure::Angular, 1e-6)
    }

    pub(super) fn of_family(self, family: &'static str) -> Self {
        Self { family, ..self }
    }

    pub(super) fn suite(self, suite: Suite) -> Self {
        Self { suite, ..self }
    }

    /// Runs the case on the calling thread. A panic is an error of the case, so that the others are still run.
    pub fn run(&self) -> Row {
        let start = Instant::now();
        // A case builds its bodies anew: no state that a panic left half changed is used again.
        let ran = catch_unwind(AssertUnwindSafe(|| (self.run)().map_err(|error| error.to_string())));
        let ran = ran.unwrap_or_else(|panic| Err(format!("panicked: {}", message(&*panic))));
        let seconds = start.elapsed().as_secs_f64();
        let (figures, error) = match ran {
            Ok(figures) => (figures, None),
            Err(error) => (Figures::default(), Some(error)),
        };
        let holds = |bound: &Bound| figures.get(bound.measure).is_some_and(|value| value <= bound.limit);
        let broken: Vec<Bound> =
            self.bounds.iter().copied().filter(|bound| error.is_none() && !holds(bound)).collect();
        Row {
            family: self.family,
            case: self.name.clone(),
            expected: self.shows,
            passed: broken.is_empty() && error.is_none(),
            bounds: self.bounds.clone(),
            broken,
            figures,
            error,
            seconds,
        }
    }
}

/// The message of a panic.
fn message(panic: &(dyn Any + Send)) -> &str {
    let literal = panic.downcast_ref::<&str>().copied();
    literal.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

/// The figures of one case.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Steps that were made.
    pub steps: u64,
    /// What was measured.
    pub values: BTreeMap<Measure, f64>,
    /// Step and energy at each look, of a case whose energy is known: kinetic, of deformation and of gravity, in masses
    /// of a full cell times (cells per step)².
    pub energy: Vec<(u64, f64)>,
}

impl Figures {
    /// One figure.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        self.values.get(&measure).copied()
    }

    pub(super) fn set(&mut self, measure: Measure, value: f64) {
        self.values.insert(measure, value);
    }

    /// Keeps the larger one; NaN is larger than any.
    pub(super) fn raise(&mut self, measure: Measure, value: f64) {
        let kept = self.values.entry(measure).or_insert(value);
        *kept = largest(*kept, value);
    }

    pub(super) fn add(&mut self, measure: Measure, value: f64) {
        *self.values.entry(measure).or_insert(0.0) += value;
    }
}

/// The larger one; NaN is larger than any.
pub(super) fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// A figure of a case. All are the smaller the better; where a case looks several times it is the largest that counts,
/// unless it says "at the end".
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Numbers that are NaN or infinite: of positions, velocities, rotations, the corrected lattice, volumes.
    NotNumbers,
    /// The largest speed of a vertex, in cells a step.
    LargestSpeed,
    /// The largest speed of a vertex at the end, in cells a step.
    FinalSpeed,
    /// What the energy rose to above that of the start, as a share of it and of that of motion by a thousandth of a cell a
    /// step.
    EnergyGain,
    /// The energy at the end, as a share of that of the start.
    EnergyLeft,
    /// Root mean square distance from the rest shape at the end, up to a rigid motion, in cells.
    Shape,
    /// Steps until the distance from the rest shape was a tenth of that at the start, or below a thousandth of a cell.
    StepsToTenth,
    /// Distance of the vertices from where they are expected at the end, root mean square, in cells.
    Place,
    /// Error of the linear momentum, as a share of the sum of the magnitudes of what makes it up.
    Linear,
    /// Error of the angular momentum about the center of mass, as a share of the sum of the magnitudes.
    Angular,
    /// How deep the surface lies in a collider at the end, in cells.
    Depth,
    /// Error of the volume after its correction at the end, as a share of the volume at rest.
    Volume,
    /// Looks at which no correction within its cap kept the volume.
    Capped,
    /// Rotations that Newton's method left to the robust path.
    Unsettled,
}

impl Measure {
    /// In a few words, with the unit.
    pub fn label(self) -> &'static str {
        match self {
            Self::NotNumbers => "NaN",
            Self::LargestSpeed => "largest speed, cells/step",
            Self::FinalSpeed => "final speed, cells/step",
            Self::EnergyGain => "energy gained, share",
            Self::EnergyLeft => "energy left, share",
            Self::Shape => "shape, cells",
            Self::StepsToTenth => "steps to a tenth",
            Self::Place => "place, cells",
            Self::Linear => "momentum",
            Self::Angular => "angular momentum",
            Self::Depth => "depth, cells",
            Self::Volume => "volume",
            Self::Capped => "capped looks",
            Self::Unsettled => "robust rotations",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_larger_one_is_nan_whichever_is_nan() {
        for (a, b, expected) in [(1.0, 2.0, 2.0), (2.0, 1.0, 2.0), (1.0, f64::INFINITY, f64::INFINITY)] {
            assert_eq!(largest(a, b), expected);
        }
        for other in [-1.0, 0.0, 1.0, f64::INFINITY, f64::NAN] {
            assert!(largest(f64::NAN, other).is_nan(), "NaN, {other}");
            assert!(largest(other, f64::NAN).is_nan(), "{other}, NaN");
        }
    }
}
