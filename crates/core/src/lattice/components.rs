//! Finds the connected components of a set of cells, and the bridges of cells that join them.
//!
//! A *part* is a connected component of the cells before joining. A *run* is a row of consecutive cells along
//! x; see [`GridSet`].

use super::nearest::{Bounds, RunTree};
use super::{FloatingPart, LatticeError, memory};
use crate::mesh::UnionFind;
use crate::voxel::GridSet;

/// The connected components of the link graph of a lattice.
///
/// Cells that share a face, an edge or a single corner share a lattice vertex, so they are in the same
/// component.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Components {
    /// Number of components, at least 1. Components are numbered in the order of their first vertex.
    pub count: usize,
    /// Component of each lattice vertex, shape `(n,)`.
    pub of_vertex: Vec<u32>,
}

/// The parts of a set of cells.
pub(super) struct RunLabels {
    /// Number of parts.
    pub(super) count: usize,
    /// Part of each run.
    pub(super) of_run: Vec<u32>,
}

/// A set of cells after joining, and the parts of the set before joining.
pub(super) struct Joined {
    /// The cells, including the cells of the bridges.
    pub(super) cells: GridSet,
    /// Number of cells that the bridges added.
    pub(super) bridge_cells: usize,
    /// The parts. Runs are runs of the cells before joining.
    pub(super) parts: RunLabels,
    /// Part with the most cells; the first one if several have equally many.
    pub(super) largest: u32,
    bridges: Vec<Bridge>,
}

/// Joins the parts of a set of cells by bridges if `join` is set.
///
/// Fails if the bridges need more than `limit` bytes.
pub(super) fn join(cells: GridSet, join: bool, cell_size: f64, limit: u64) -> Result<Joined, LatticeError> {
    let parts = label(&cells);
    let largest = largest(&cells, &parts);
    let bridges = if join { bridges(&cells, &parts, largest) } else { Vec::new() };
    if bridges.is_empty() {
        return Ok(Joined { cells, bridge_cells: 0, parts, largest, bridges });
    }
    // Each cell of a bridge shares a face with the cell before it, so it adds at most four vertices.
    let length = bridges.iter().fold(0u64, |sum, bridge| sum.saturating_add(bridge.len()));
    memory::check(memory::needed_bytes(length.saturating_mul(4)), limit, cell_size)?;
    let count = cells.len();
    let cells = cells.with(bridges.iter().flat_map(Bridge::cells).collect());
    let bridge_cells = cells.len() - count;
    Ok(Joined { cells, bridge_cells, parts, largest, bridges })
}

impl Joined {
    /// Lists all parts except the largest part, for the report. `before`: the cells before joining.
    pub(super) fn floating_parts(&self, before: &GridSet) -> Vec<FloatingPart> {
        let joined = !self.bridges.is_empty();
        let mut floating = vec![FloatingPart { joined, ..FloatingPart::default() }; self.parts.count];
        for (run, part) in self.parts.of_run.iter().enumerate() {
            floating[*part as usize].cells += before.span(run).len();
        }
        for bridge in &self.bridges {
            floating[bridge.part as usize].bridge_cells += bridge.len() as usize;
        }
        floating.remove(self.largest as usize);
        floating
    }
}

/// Finds the connected components of a set of cells. Cells that share a corner are connected.
pub(super) fn label(cells: &GridSet) -> RunLabels {
    let mut sets = UnionFind::new(cells.run_count());
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

/// Unites the runs of two neighboring rows that share at least a corner.
fn unite_rows(cells: &GridSet, a: usize, b: usize, sets: &mut UnionFind) {
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

/// A path of cells that joins a part to another part.
struct Bridge {
    /// The part that is joined, numbered as in [`RunLabels`].
    part: u32,
    /// The cell of this part at which the path starts.
    start: [i32; 3],
    /// The nearest cell of the other part, at which the path ends.
    end: [i32; 3],
}

impl Bridge {
    /// Returns the number of cells of the bridge, without the two cells that it joins.
    fn len(&self) -> u64 {
        let steps: u64 = (0..3).map(|a| u64::from(self.start[a].abs_diff(self.end[a]))).sum();
        steps.saturating_sub(1)
    }

    /// Iterates over the cells strictly between `start` and `end`: a shortest path of steps through faces.
    ///
    /// Each step is along the axis with the largest remaining distance, so the path stays near the straight
    /// line.
    fn cells(&self) -> impl Iterator<Item = [i32; 3]> {
        let mut cell = self.start;
        (0..self.len()).map(move |_| {
            let remaining = |a: &usize| (cell[*a].abs_diff(self.end[*a]), std::cmp::Reverse(*a));
            let axis = (0..3).max_by_key(remaining).unwrap_or(0);
            cell[axis] += self.end[axis].cmp(&cell[axis]) as i32;
            cell
        })
    }
}

/// Returns the part with the most cells; the first one if several have equally many.
fn largest(cells: &GridSet, labels: &RunLabels) -> u32 {
    let mut sizes = vec![0u64; labels.count];
    for run in 0..cells.run_count() {
        sizes[labels.of_run[run] as usize] += cells.span(run).len() as u64;
    }
    let largest = (0..labels.count).max_by_key(|&part| (sizes[part], std::cmp::Reverse(part)));
    largest.unwrap_or(0) as u32
}

/// Finds the bridges that join all parts (Borůvka 1926).
///
/// A *group* is a set of parts that are joined already. At first each part is a group. Each round joins every
/// group, except the group of the largest part, to the nearest other group. The rounds end when one group is
/// left.
fn bridges(cells: &GridSet, labels: &RunLabels, largest: u32) -> Vec<Bridge> {
    let mut bridges = Vec::new();
    if labels.count < 2 {
        return bridges;
    }
    let tree = RunTree::new(cells);
    let mut groups = UnionFind::new(labels.count);
    while bridges.len() + 1 < labels.count {
        let group_of_part: Vec<u32> = (0..labels.count as u32).map(|part| groups.find(part)).collect();
        let group = |run: u32| group_of_part[labels.of_run[run as usize] as usize];
        let excluded = group_of_part[largest as usize];
        for nearest in nearest_pairs(cells, &tree, labels.count, excluded, group).into_iter().flatten() {
            let [a, b] = nearest.runs;
            let [part, other] = [a, b].map(|run| labels.of_run[run as usize]);
            if groups.unite(part, other) {
                let (start, end) = closest_cells(cells, a, b);
                bridges.push(Bridge { part, start, end });
            }
        }
    }
    bridges
}

/// A run of one group, and the nearest run of all other groups.
#[derive(Clone, Copy)]
struct Nearest {
    /// Number of steps through faces from the one run to the other run.
    steps: i64,
    /// The run of the group, then the run of the other group.
    runs: [u32; 2],
}

/// Finds, for each group except `excluded`, the run that is nearest to any other group.
///
/// Entry p of the result belongs to the group whose lowest part is p. `group` returns the group of a run, as
/// the lowest part of the group. `parts` is the number of parts.
fn nearest_pairs(
    cells: &GridSet,
    tree: &RunTree,
    parts: usize,
    excluded: u32,
    group: impl Fn(u32) -> u32,
) -> Vec<Option<Nearest>> {
    let common = tree.common_labels(&group);
    let mut best: Vec<Option<Nearest>> = vec![None; parts];
    for (run, key) in cells.runs() {
        let own_group = group(run as u32);
        if own_group == excluded {
            continue;
        }
        let bounds = Bounds::of_run(cells, key, run);
        let found = tree.nearest(
            best[own_group as usize].map_or(i64::MAX, |nearest| nearest.steps),
            |other| bounds.steps(other),
            |node| common[node] == Some(own_group),
            |other| group(other) != own_group,
        );
        if let Some((steps, other)) = found {
            best[own_group as usize] = Some(Nearest { steps, runs: [run as u32, other] });
        }
    }
    best
}

/// Returns the nearest cells of two runs. Where the runs overlap in x, both cells have their lowest common x.
fn closest_cells(cells: &GridSet, a: u32, b: u32) -> ([i32; 3], [i32; 3]) {
    let [a, b] = [a, b].map(|run| Bounds::of_run(cells, cells.key_of_run(run as usize), run as usize));
    let x = [(&a, &b), (&b, &a)].map(|(run, other)| other.low[0].clamp(run.low[0], run.high[0]));
    let at = |bounds: &Bounds, x| [x, bounds.low[1], bounds.low[2]];
    (at(&a, x[0]), at(&b, x[1]))
}
