//! Defines a case: what is measured, the law or the target of each quantity, and the results.

use std::error::Error;
use std::fmt;
use std::time::Instant;

use serde::Serialize;

use crate::suite::{Runnable, Suite, caught};

/// The range that a quantity should be in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Least value.
    pub low: Option<f64>,
    /// Greatest value.
    pub high: Option<f64>,
}

impl Target {
    /// A target with a least and a greatest value.
    pub(super) fn within(low: f64, high: f64) -> Self {
        Self { low: Some(low), high: Some(high) }
    }

    /// A target with a greatest value.
    pub(super) fn at_most(high: f64) -> Self {
        Self { low: None, high: Some(high) }
    }

    /// A target with a least value.
    pub(super) fn at_least(low: f64) -> Self {
        Self { low: Some(low), high: None }
    }

    /// Returns whether a value is in the range; NaN is not.
    pub fn contains(&self, value: f64) -> bool {
        !value.is_nan()
            && self.low.is_none_or(|low| value >= low)
            && self.high.is_none_or(|high| value <= high)
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.low, self.high) {
            (Some(low), Some(high)) => write!(f, "{low} to {high}"),
            (Some(low), None) => write!(f, ">= {low}"),
            (None, Some(high)) => write!(f, "<= {high}"),
            (None, None) => write!(f, "-"),
        }
    }
}

/// A quantity that a case measures.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Name with the unit.
    pub name: &'static str,
    /// The range of the ratio of the value to its law, or of the value itself if there is no law.
    pub target: Target,
    /// Reason why the target is missed, if that is known.
    pub known_miss: Option<String>,
}

impl Quantity {
    /// Creates a quantity.
    pub(super) fn new(name: &'static str, target: Target) -> Self {
        Self { name, target, known_miss: None }
    }

    /// Marks the target as missed, for the given reason.
    pub(super) fn misses(self, reason: impl Into<String>) -> Self {
        Self { known_miss: Some(reason.into()), ..self }
    }
}

/// A measured value and the value that the law gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    pub(super) value: f64,
    pub(super) law: Option<f64>,
}

impl Measured {
    /// Creates a measured value with its law.
    pub(super) fn by_law(value: f64, law: f64) -> Self {
        Self { value, law: Some(law) }
    }
}

impl From<f64> for Measured {
    fn from(value: f64) -> Self {
        Self { value, law: None }
    }
}

/// Result of a run: one measured value per quantity.
pub(super) type Outcome = Result<Vec<Measured>, Box<dyn Error>>;

type Run = Box<dyn Fn() -> Outcome + Send + Sync>;

/// A body, what is done to it, and what is measured.
pub struct Case {
    /// Family of the case.
    pub family: &'static str,
    /// Name, unique in the family.
    pub name: String,
    /// The measured quantities.
    pub quantities: Vec<Quantity>,
    /// Run-time class. The quick cases take less than two minutes together.
    pub suite: Suite,
    /// Whether the case measures run times, so that it runs alone.
    pub timed: bool,
    run: Run,
}

impl Case {
    /// Creates a quick case.
    pub(super) fn new(
        name: impl Into<String>,
        quantities: impl IntoIterator<Item = Quantity>,
        run: impl Fn() -> Outcome + Send + Sync + 'static,
    ) -> Self {
        let quantities = quantities.into_iter().collect();
        Self {
            family: "",
            name: name.into(),
            quantities,
            suite: Suite::Quick,
            timed: false,
            run: Box::new(run),
        }
    }

    /// Moves the case to the long cases if its body has more than 50,000 lattice vertices.
    pub(super) fn of_vertices(self, vertices: usize) -> Self {
        Self { suite: if vertices > 50_000 { Suite::Long } else { Suite::Quick }, ..self }
    }

    /// Marks the case as one that measures run times.
    pub(super) fn timed(self) -> Self {
        Self { timed: true, ..self }
    }

    /// Sets the family.
    pub(super) fn of_family(self, family: &'static str) -> Self {
        Self { family, ..self }
    }
}

/// Result of a quantity in the report.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Family of the case.
    pub family: &'static str,
    /// Name of the case.
    pub case: String,
    /// Name of the quantity, with the unit.
    pub quantity: &'static str,
    /// Measured value; `None` if the case failed.
    pub value: Option<f64>,
    /// Value that the law gives, if there is a law.
    pub law: Option<f64>,
    /// Value divided by the law.
    pub ratio: Option<f64>,
    /// Range of the ratio, or of the value if there is no law.
    pub target: Target,
    /// Whether the target is met.
    pub met: bool,
    /// Reason why the target is missed, if that is known.
    pub known_miss: Option<String>,
    /// Error or panic that ended the case.
    pub error: Option<String>,
    /// Run time of the case in seconds.
    pub seconds: f64,
}

impl Runnable for Case {
    type Row = Vec<Row>;

    fn family(&self) -> &str {
        self.family
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn suite(&self) -> Suite {
        self.suite
    }

    fn is_timed(&self) -> bool {
        self.timed
    }

    fn run(&self) -> Vec<Row> {
        let start = Instant::now();
        let result = caught(|| (self.run)());
        let seconds = start.elapsed().as_secs_f64();
        let row = |(index, quantity): (usize, &Quantity)| {
            let measured = result.as_ref().ok().and_then(|measured| measured.get(index).copied());
            let law = measured.and_then(|measured| measured.law);
            let value = measured.map(|measured| measured.value);
            let ratio = value.zip(law).map(|(value, law)| value / law);
            Row {
                family: self.family,
                case: self.name.clone(),
                quantity: quantity.name,
                value,
                law,
                ratio,
                target: quantity.target,
                met: ratio.or(value).is_some_and(|value| quantity.target.contains(value)),
                known_miss: quantity.known_miss.clone(),
                error: result.as_ref().err().cloned(),
                seconds,
            }
        };
        self.quantities.iter().enumerate().map(row).collect()
    }
}
