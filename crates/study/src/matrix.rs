//! The points of a study.
//!
//! Not the full product, most of which nobody would look at: every method on every lattice, and around the scene as it
//! is, one at a time, the steps, the half-width and the sums.

use supple::reference::Regions;

use crate::physical::Physical;
use crate::setting::{Axis, Dynamics, Method, Setting, Sums};

/// The points of a study, in the order in which they are run.
#[derive(Clone, Debug)]
pub(crate) struct Matrix {
    pub(crate) points: Vec<(Axis, Setting)>,
    /// The finest lattice, whose surface the others are compared with.
    pub(crate) finest: Setting,
}

/// Which values the axes take.
struct Axes {
    refinements: &'static [f64],
    substeps: &'static [f64],
    reaches: &'static [f64],
    /// The refinements at which the sums are compared.
    sums: &'static [f64],
    /// The greatest refinement at which methods other than the scene's are run.
    all_methods: f64,
}

const FULL: Axes = Axes {
    refinements: &[1.0 / 3.0, 0.5, 1.0, 1.5, 2.0, 3.0],
    substeps: &[0.25, 0.5, 2.0, 4.0],
    reaches: &[0.5, 1.5, 2.0],
    sums: &[0.5, 1.0],
    all_methods: 2.0,
};

const QUICK: Axes = Axes {
    refinements: &[0.5, 1.0, 1.5],
    substeps: &[0.5, 2.0],
    reaches: &[1.5],
    sums: &[0.5],
    all_methods: 1.0,
};

impl Matrix {
    /// The points around a scene that keeps its volume by `method`, one of `methods`, those that its bodies can have.
    pub(crate) fn new(physical: &Physical, method: Method, methods: &[Method], quick: bool) -> Self {
        let axes = if quick { QUICK } else { FULL };
        let base = Dynamics { refinement: 1.0, reach: 1.0, substeps: physical.substeps, sums: Sums::Fast };
        let widths = |refinement| physical.half_widths(refinement, 1.0);
        // Refinements that come to the same half-widths are one.
        let mut refinements: Vec<f64> = Vec::new();
        for &refinement in axes.refinements {
            if !refinements.iter().any(|&other| widths(other) == widths(refinement)) {
                refinements.push(refinement);
            }
        }
        let mut points: Vec<(Axis, Setting)> = Vec::new();
        let mut add = |axis, dynamics, method| {
            let setting = Setting { dynamics, method };
            if !points.iter().any(|(_, other)| *other == setting) {
                points.push((axis, setting));
            }
        };
        add(Axis::Base, base, method);
        for &refinement in &refinements {
            let dynamics = Dynamics { refinement, ..base };
            let coarse = refinement <= axes.all_methods;
            for &one in methods.iter().filter(|&&one| coarse || one == method) {
                add(
                    if refinement == 1.0 && one == method { Axis::Base } else { Axis::Resolution },
                    dynamics,
                    one,
                );
            }
        }
        for factor in axes.substeps {
            let substeps = (f64::from(base.substeps) * factor).round().max(1.0) as u32;
            add(Axis::Substeps, Dynamics { substeps, ..base }, method);
        }
        for &reach in axes.reaches {
            if physical.half_widths(1.0, reach) != widths(1.0) {
                add(Axis::HalfWidth, Dynamics { reach, ..base }, method);
            }
        }
        for &refinement in axes.sums {
            let same = |&&other: &&f64| widths(other) == widths(refinement);
            let Some(&refinement) = refinements.iter().find(same) else { continue };
            for regions in [Regions::Staircase, Regions::BreadthFirst] {
                add(Axis::Sums, Dynamics { refinement, sums: Sums::Naive(regions), ..base }, method);
            }
        }
        let finest = refinements.iter().copied().fold(0.0, f64::max);
        let finest = Setting { dynamics: Dynamics { refinement: finest, ..base }, method };
        Self { points, finest }
    }
}
