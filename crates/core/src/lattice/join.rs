//! Bridges of cells between parts that float apart.

use super::components::RunLabels;
use super::disjoint::DisjointSets;
use super::run_tree::{Bounds, RunTree};
use super::runs::Runs;

/// The cells that join one part to another.
pub(crate) struct Bridge {
    /// Part that asked for the bridge, numbered as its run labels.
    pub(crate) part: u32,
    from: [i32; 3],
    to: [i32; 3],
}

impl Bridge {
    /// Number of cells of the bridge, without the cells that it joins.
    pub(crate) fn len(&self) -> u64 {
        let steps: u64 = (0..3).map(|a| u64::from(self.from[a].abs_diff(self.to[a]))).sum();
        steps.saturating_sub(1)
    }

    /// The cells strictly between the two ends: a shortest path from face to face that keeps near the straight line, by stepping
    /// along the axis on which most is left.
    fn cells(&self) -> impl Iterator<Item = [i32; 3]> {
        let mut cell = self.from;
        (0..self.len()).map(move |_| {
            let left = |a: &usize| (cell[*a].abs_diff(self.to[*a]), std::cmp::Reverse(*a));
            let axis = (0..3).max_by_key(left).unwrap_or(0);
            cell[axis] += self.to[axis].cmp(&cell[axis]) as i32;
            cell
        })
    }
}

/// The largest part by cells; of equals, the first.
pub(crate) fn largest(cells: &Runs, labels: &RunLabels) -> u32 {
    let mut sizes = vec![0u64; labels.count];
    for run in 0..cells.run_count() {
        sizes[labels.of_run[run] as usize] += cells.span(run).len() as u64;
    }
    let largest = (0..labels.count).max_by_key(|&part| (sizes[part], std::cmp::Reverse(part)));
    largest.unwrap_or(0) as u32
}

/// The bridges that make one part of all: each part but the largest is joined to its nearest neighbour, then each group of parts
/// but that of the largest to its nearest, until all are one (Borůvka 1926).
pub(crate) fn bridges(cells: &Runs, labels: &RunLabels) -> Vec<Bridge> {
    let mut bridges = Vec::new();
    if labels.count < 2 {
        return bridges;
    }
    let largest = largest(cells, labels);
    let tree = RunTree::new(cells);
    let mut groups = DisjointSets::new(labels.count);
    while bridges.len() + 1 < labels.count {
        let group_of_part: Vec<u32> = (0..labels.count as u32).map(|part| groups.find(part)).collect();
        let group = |run: u32| group_of_part[labels.of_run[run as usize] as usize];
        let still = group_of_part[largest as usize];
        for nearest in nearest_pairs(cells, &tree, labels.count, still, group).into_iter().flatten() {
            let [a, b] = nearest.runs;
            let [part, other] = [a, b].map(|run| labels.of_run[run as usize]);
            if groups.unite(part, other) {
                let (from, to) = closest_cells(cells, a, b);
                bridges.push(Bridge { part, from, to });
            }
        }
    }
    bridges
}

/// A run of one group and the nearest run of another.
#[derive(Clone, Copy)]
struct Nearest {
    steps: i64,
    runs: [u32; 2],
}

/// For each group, by its lowest part, but `still`: the nearest run of any other group.
fn nearest_pairs(
    cells: &Runs,
    tree: &RunTree,
    parts: usize,
    still: u32,
    group: impl Fn(u32) -> u32,
) -> Vec<Option<Nearest>> {
    let shared = tree.shared_labels(&group);
    let mut best: Vec<Option<Nearest>> = vec![None; parts];
    for row in 0..cells.row_count() {
        let key = cells.row_key(row);
        for run in cells.row_runs(row).map(|run| run as u32) {
            let own = group(run);
            if own == still {
                continue;
            }
            let bounds = Bounds::of_run(cells, key, run as usize);
            let limit = best[own as usize].map_or(i64::MAX, |nearest| nearest.steps);
            let found = tree.nearest(
                limit,
                |other| bounds.steps(other),
                |node| shared[node] == Some(own),
                |other| group(other) != own,
            );
            if let Some((steps, other)) = found {
                best[own as usize] = Some(Nearest { steps, runs: [run, other] });
            }
        }
    }
    best
}

/// The nearest cells of two runs; where they overlap in x, at their lowest common x.
fn closest_cells(cells: &Runs, a: u32, b: u32) -> ([i32; 3], [i32; 3]) {
    let [a, b] =
        [a, b].map(|run| Bounds::of_run(cells, cells.row_key(cells.row_of_run(run as usize)), run as usize));
    let x = [(&a, &b), (&b, &a)].map(|(one, other)| other.low[0].clamp(one.low[0], one.high[0]));
    let at = |bounds: &Bounds, x| [x, bounds.low[1], bounds.low[2]];
    (at(&a, x[0]), at(&b, x[1]))
}

/// The cells with the bridges among them, and the number of cells that the bridges added.
pub(crate) fn with_bridges(cells: &Runs, bridges: &[Bridge]) -> (Runs, usize) {
    let mut positions = cells.positions();
    positions.extend(bridges.iter().flat_map(Bridge::cells));
    positions.sort_by_key(|&[x, y, z]| (z, y, x));
    let joined = Runs::from_sorted(&positions);
    let added = joined.len() - cells.len();
    (joined, added)
}
