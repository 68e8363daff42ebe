//! Connected parts of the link graph.

use super::disjoint::DisjointSets;
use super::runs::Runs;

/// The connected parts of the link graph of a lattice.
///
/// Cells that share a face, an edge or a single corner share a lattice vertex, so they are in the same component.
#[derive(Clone, Debug, PartialEq)]
pub struct Components {
    /// Number of components, at least 1. They are numbered in the order of their first vertex.
    pub count: usize,
    /// Component of each lattice vertex, shape `(n,)`.
    pub of_vertex: Vec<u32>,
}

/// The component of each run of cells.
pub(crate) struct RunLabels {
    pub(crate) count: usize,
    pub(crate) of_run: Vec<u32>,
}

/// Finds the components of a set of cells; cells that share a corner belong together.
pub(crate) fn label(cells: &Runs) -> RunLabels {
    let mut sets = DisjointSets::new(cells.run_count());
    for row in 0..cells.row_count() {
        let (z, y) = cells.row_key(row);
        for key in [(z - 1, y - 1), (z - 1, y), (z - 1, y + 1), (z, y - 1)] {
            if let Some(other) = cells.find_row(key) {
                unite_rows(cells, row, other, &mut sets);
            }
        }
    }
    let (count, of_run) = sets.labels();
    RunLabels { count, of_run }
}

/// Unites the runs of two neighbouring rows that touch, corners included.
fn unite_rows(cells: &Runs, a: usize, b: usize, sets: &mut DisjointSets) {
    let (mut a, mut b) = (cells.row_runs(a), cells.row_runs(b));
    while !a.is_empty() && !b.is_empty() {
        let (left, right) = (cells.span(a.start), cells.span(b.start));
        if left.start <= right.end && right.start <= left.end {
            sets.unite(a.start as u32, b.start as u32);
        }
        if left.end < right.end {
            a.start += 1;
        } else {
            b.start += 1;
        }
    }
}
