//! A tree of boxes over the runs of a set of cells (BVH), for the nearest cell.

use crate::voxel::GridSet;

/// Runs in a leaf; more make the tree smaller and each leaf slower.
const LEAF: usize = 8;

/// A bounding box tree over the runs of a set of cells.
pub(super) struct RunTree {
    /// The runs in the order of the leaves, each with its box in cells, ends included.
    items: Vec<(u32, Bounds)>,
    /// Preorder: the first child of an inner node follows it.
    nodes: Vec<Node>,
}

struct Node {
    bounds: Bounds,
    /// Second child of an inner node; 0 in a leaf.
    second: u32,
    first_item: u32,
    end_item: u32,
}

/// A box of cells: lowest and highest index on each axis.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) low: [i32; 3],
    pub(super) high: [i32; 3],
}

impl Bounds {
    /// The cells of a run.
    pub(super) fn of_run(cells: &GridSet, key: (i32, i32), run: usize) -> Self {
        let (z, y) = key;
        let span = cells.span(run);
        Self { low: [span.start, y, z], high: [span.end - 1, y, z] }
    }

    /// Steps from cell to cell through faces between the nearest cells of two boxes.
    pub(super) fn steps(&self, other: &Self) -> i64 {
        let gap = |a| {
            (i64::from(self.low[a]) - i64::from(other.high[a]))
                .max(i64::from(other.low[a]) - i64::from(self.high[a]))
        };
        (0..3).map(|a| gap(a).max(0)).sum()
    }

    /// Square of the distance to a point, in cells; a cell reaches from its index to its index + 1.
    pub(super) fn distance_squared(&self, point: [f64; 3]) -> f64 {
        let outside = |a: usize| {
            (f64::from(self.low[a]) - point[a]).max(point[a] - (f64::from(self.high[a]) + 1.0)).max(0.0)
        };
        (0..3).map(|a| outside(a).powi(2)).sum()
    }

    fn united(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|a| self.low[a].min(other.low[a])),
            high: std::array::from_fn(|a| self.high[a].max(other.high[a])),
        }
    }
}

impl RunTree {
    /// The tree of a set that is not empty.
    pub(super) fn new(cells: &GridSet) -> Self {
        let items: Vec<_> =
            cells.runs().map(|(run, key)| (run as u32, Bounds::of_run(cells, key, run))).collect();
        let mut tree = Self { nodes: Vec::with_capacity(2 * items.len().div_ceil(LEAF)), items };
        tree.build(0, tree.items.len());
        tree
    }

    fn build(&mut self, first: usize, end: usize) {
        let items = &mut self.items[first..end];
        let bounds = items.iter().map(|(_, bounds)| *bounds).reduce(|a, b| a.united(&b));
        let Some(bounds) = bounds else { return };
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, second: 0, first_item: first as u32, end_item: end as u32 });
        if items.len() <= LEAF {
            return;
        }
        let extent = |a: &usize| i64::from(bounds.high[*a]) - i64::from(bounds.low[*a]);
        let axis = (0..3).max_by_key(extent).unwrap_or(0);
        let middle = items.len() / 2;
        // The run's number makes the order, and with it every later choice, unique.
        items.select_nth_unstable_by_key(middle, |(run, b)| {
            (i64::from(b.low[axis]) + i64::from(b.high[axis]), *run)
        });
        self.build(first, first + middle);
        self.nodes[node].second = self.nodes.len() as u32;
        self.build(first + middle, end);
    }

    /// The run of least cost among those that `accept` takes and that cost less than `limit`.
    ///
    /// `cost` of a box must not exceed the cost of what lies in it. Nodes whose runs are known to be refused are skipped by `skip`.
    pub(super) fn nearest<C: PartialOrd + Copy>(
        &self,
        limit: C,
        cost: impl Fn(&Bounds) -> C,
        skip: impl Fn(usize) -> bool,
        accept: impl Fn(u32) -> bool,
    ) -> Option<(C, u32)> {
        let mut best = (limit, None);
        let mut stack = vec![(cost(&self.nodes.first()?.bounds), 0)];
        while let Some((node_cost, index)) = stack.pop() {
            let beaten = |cost: C| !matches!(cost.partial_cmp(&best.0), Some(std::cmp::Ordering::Less));
            if beaten(node_cost) || skip(index) {
                continue;
            }
            let node = &self.nodes[index];
            if node.second == 0 {
                for (run, bounds) in &self.items[node.first_item as usize..node.end_item as usize] {
                    let cost = cost(bounds);
                    if cost < best.0 && accept(*run) {
                        best = (cost, Some(*run));
                    }
                }
                continue;
            }
            let children =
                [index + 1, node.second as usize].map(|child| (cost(&self.nodes[child].bounds), child));
            // The nearer child is looked at first.
            let swap = children[1].0 < children[0].0;
            stack.push(children[usize::from(!swap)]);
            stack.push(children[usize::from(swap)]);
        }
        best.1.map(|run| (best.0, run))
    }

    /// The cell nearest to a point, given in cells; `cells` is the set of the tree.
    pub(super) fn nearest_cell(&self, cells: &GridSet, point: [f64; 3]) -> u32 {
        let found = self.nearest(f64::INFINITY, |bounds| bounds.distance_squared(point), |_| false, |_| true);
        let Some((_, run)) = found else { return 0 };
        let span = cells.span(run as usize);
        let x = (point[0].floor() as i32).clamp(span.start, span.end - 1);
        cells.first(run as usize) + (x - span.start) as u32
    }

    /// The label that all runs below each node share, if they do.
    pub(super) fn shared_labels(&self, mut label: impl FnMut(u32) -> u32) -> Vec<Option<u32>> {
        let mut shared = vec![None; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().rev() {
            shared[index] = if node.second == 0 {
                let mut items = self.items[node.first_item as usize..node.end_item as usize].iter();
                let first = items.next().map(|(run, _)| label(*run));
                first.filter(|first| items.all(|(run, _)| label(*run) == *first))
            } else {
                shared[index + 1].filter(|a| shared[node.second as usize] == Some(*a))
            };
        }
        shared
    }
}
