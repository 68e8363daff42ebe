//! A case: what it shows, what bounds it, and how it is run.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use supple::Error;

use super::{Figures, Measure};

/// How long a case takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A second or less: part of every test run.
    Quick,
    /// Longer.
    Long,
}

/// The largest value of a figure that a case may have.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
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
    /// What it passes by; never NaN is asked of all.
    pub bounds: Vec<Bound>,
    /// How long it takes.
    pub effort: Effort,
    run: Run,
}

/// What came out of a case.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Outcome {
    /// What was measured.
    pub figures: Figures,
    /// The bounds that do not hold.
    pub broken: Vec<Bound>,
    /// Why it could not be run to its end.
    pub error: Option<String>,
}

impl Outcome {
    /// Whether all bounds hold.
    pub fn passed(&self) -> bool {
        self.broken.is_empty() && self.error.is_none()
    }
}

impl Case {
    pub(crate) fn new(
        family: &'static str,
        name: impl Into<String>,
        shows: &'static str,
        run: impl Fn() -> Result<Figures, Error> + Send + Sync + 'static,
    ) -> Self {
        let bounds = vec![Bound { measure: Measure::NotNumbers, limit: 0.0 }];
        Self { family, name: name.into(), shows, bounds, effort: Effort::Quick, run: Box::new(run) }
    }

    pub(crate) fn bound(mut self, measure: Measure, limit: f64) -> Self {
        self.bounds.push(Bound { measure, limit });
        self
    }

    pub(crate) fn long(mut self) -> Self {
        self.effort = Effort::Long;
        self
    }

    /// Runs the case on the calling thread. A panic is an error of the case, so that the others are still run.
    pub fn run(&self) -> Outcome {
        // Nothing that was halfway changed is seen again: a case makes its bodies anew.
        let ran = catch_unwind(AssertUnwindSafe(|| (self.run)().map_err(|error| error.to_string())));
        match ran.unwrap_or_else(|panic| Err(format!("panicked: {}", said(&*panic)))) {
            Ok(figures) => {
                let holds =
                    |bound: &&Bound| figures.get(bound.measure).is_some_and(|value| value <= bound.limit);
                let broken = self.bounds.iter().filter(|bound| !holds(bound)).copied().collect();
                Outcome { figures, broken, error: None }
            }
            Err(error) => Outcome { figures: Figures::default(), broken: Vec::new(), error: Some(error) },
        }
    }
}

/// The message of a panic.
fn said(panic: &(dyn Any + Send)) -> &str {
    let literal = panic.downcast_ref::<&str>().copied();
    literal.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}
