//! Lists the points of a study.
//!
//! The points are not all combinations of the varied parameters. Only the lattices are combined with all
//! methods of volume preservation; steps, half-width and sums are varied one at a time around the unchanged
//! scene.

use supple::HalfWidth;
use supple::reference::Regions;

use super::physical::Physical;
use super::setting::{Axis, Dynamics, Method, Setting, Sums};

/// The points of a study in the order in which they are run.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    pub(super) points: Vec<(Axis, Setting)>,
    /// Setting with the finest lattice, whose surface is the reference.
    pub(super) finest: Setting,
}

/// Values of the varied parameters, as factors relative to the scene; a refinement is the number of cells per
/// length. Of several values that give the same half-widths, only the first is used. Therefore the lists
/// begin with the values that give whole half-widths for every scene.
struct Axes {
    refinements: &'static [f64],
    substeps: &'static [f64],
    region_factors: &'static [f64],
    /// Half-widths in cells with which a material of a given Young's modulus is run.
    half_widths: &'static [f64],
    /// Refinements at which the sums are compared.
    sums: &'static [f64],
    /// Largest refinement at which all methods are used; finer lattices use only the method of the scene.
    max_refinement_of_all_methods: f64,
}

const FULL: Axes = Axes {
    refinements: &[1.0, 2.0, 3.0, 1.5, 0.5, 1.0 / 3.0],
    substeps: &[0.25, 0.5, 2.0, 4.0],
    region_factors: &[2.0, 1.5, 0.5],
    half_widths: &[0.5, 1.0, 2.0, 3.0],
    sums: &[0.5, 1.0],
    max_refinement_of_all_methods: 2.0,
};

const QUICK: Axes = Axes {
    refinements: &[1.0, 1.5, 0.5],
    substeps: &[0.5, 2.0],
    region_factors: &[1.5],
    half_widths: &[0.5, 1.0],
    sums: &[0.5],
    max_refinement_of_all_methods: 1.0,
};

impl Matrix {
    /// Creates the points around a scene that uses `method`. `methods` are the methods that its bodies
    /// support.
    pub(super) fn new(physical: &Physical, method: Method, methods: &[Method], quick: bool) -> Self {
        let axes = if quick { QUICK } else { FULL };
        let base = Dynamics {
            refinement: 1.0,
            region_factor: 1.0,
            half_width: None,
            substeps: physical.substeps,
            sums: Sums::Fast,
        };
        let widths = |refinement| physical.half_widths(Dynamics { refinement, ..base });
        let factor_widths = |region_factor| physical.half_widths(Dynamics { region_factor, ..base });
        let refinements = distinct(axes.refinements, widths);
        let region_factors = distinct(axes.region_factors, factor_widths);
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
            let all = refinement <= axes.max_refinement_of_all_methods;
            for &other in methods.iter().filter(|&&other| all || other == method) {
                let is_base = refinement == 1.0 && other == method;
                add(if is_base { Axis::Base } else { Axis::Resolution }, dynamics, other);
            }
        }
        for factor in axes.substeps {
            let substeps = (f64::from(base.substeps) * factor).round().max(1.0) as u32;
            add(Axis::Substeps, Dynamics { substeps, ..base }, method);
        }
        for region_factor in region_factors {
            if factor_widths(region_factor) != widths(1.0) {
                add(Axis::HalfWidth, Dynamics { region_factor, ..base }, method);
            }
        }
        for half_width in axes.half_widths.iter().map(|&cells| HalfWidth::from(cells)) {
            let Some(substeps) = physical.needed_substeps(half_width) else { continue };
            let dynamics = Dynamics { half_width: Some(half_width), substeps, ..base };
            if physical.half_widths(dynamics) != widths(1.0) {
                add(Axis::Regions, dynamics, method);
            }
        }
        for &refinement in axes.sums {
            let has_same_widths = |&&other: &&f64| widths(other) == widths(refinement);
            let Some(&refinement) = refinements.iter().find(has_same_widths) else { continue };
            for regions in [Regions::Staircase, Regions::BreadthFirst] {
                add(Axis::Sums, Dynamics { refinement, sums: Sums::Naive(regions), ..base }, method);
            }
        }
        let finest = refinements.iter().copied().fold(0.0, f64::max);
        let finest = Setting { dynamics: Dynamics { refinement: finest, ..base }, method };
        Self { points, finest }
    }
}

/// Returns the values in ascending order. Of several values that give the same half-widths, only the first is
/// kept.
fn distinct(values: &[f64], widths: impl Fn(f64) -> Vec<HalfWidth>) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::new();
    for &value in values {
        if !kept.iter().any(|&other| widths(other) == widths(value)) {
            kept.push(value);
        }
    }
    kept.sort_by(f64::total_cmp);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests as block;

    /// Returns the refinements and region factors of the points of a scene, ascending, and the names of the
    /// points.
    fn axes(half_widths: &[usize]) -> (Vec<f64>, Vec<f64>, Vec<String>) {
        let (_directory, physical) = block::physical(1, half_widths);
        let matrix = Matrix::new(&physical, Method::off(), &[Method::off()], false);
        let all = |value: fn(&Dynamics) -> f64| {
            let mut values: Vec<f64> =
                matrix.points.iter().map(|(_, setting)| value(&setting.dynamics)).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let names = matrix.points.iter().map(|(_, setting)| physical.name(setting)).collect();
        (all(|dynamics| dynamics.refinement), all(|dynamics| dynamics.region_factor), names)
    }

    #[test]
    fn lattices_are_distinct() {
        let (refinements, region_factors, names) = axes(&[1]);
        assert_eq!((refinements, region_factors), (vec![1.0, 2.0, 3.0], vec![1.0, 2.0]));
        assert_eq!(names[0], "off, 1.00 x the cells, 2 steps");
        let (refinements, region_factors, _) = axes(&[2]);
        assert_eq!((refinements, region_factors), (vec![0.5, 1.0, 1.5, 2.0, 3.0], vec![0.5, 1.0, 1.5, 2.0]));
        let (refinements, _, _) = axes(&[6]);
        assert_eq!(refinements, [1.0 / 3.0, 0.5, 1.0, 1.5, 2.0, 3.0]);
    }

    #[test]
    fn point_names_are_unique_and_contain_the_effective_refinement() {
        // Refinement 0.5 rounds a half-width of 3 cells to 2 cells, and a half-width of 1 cell to 1 cell.
        let (_, _, names) = axes(&[3]);
        assert!(names.contains(&"off, 0.67 x the cells, 2 steps".to_owned()), "{names:?}");
        for half_widths in [&[1, 3, 1][..], &[1, 2, 3, 4]] {
            let (_, _, names) = axes(half_widths);
            let mut different = names.clone();
            different.sort();
            different.dedup();
            assert_eq!(different.len(), names.len(), "{names:?}");
        }
        let (_, _, names) = axes(&[1, 3, 1]);
        assert!(names.contains(&"off, 1.00 and 0.67 x the cells, 2 steps".to_owned()), "{names:?}");
    }
}
