//! A sorted set of grid positions (of cells or lattice vertices), stored as runs along x. A look-up takes two
//! binary searches.

use std::ops::Range;

use super::grid::MAX_SNAP;

/// Distance from a cell, in cells, up to which a point outside counts as inside. It is greater than the
/// largest distance by which a coordinate is snapped to a grid plane.
const SLACK: f64 = 2.0 * MAX_SNAP;

/// A set of grid positions. Their *numbers* count from 0 in the order of (z, y, x), x fastest.
///
/// A *row* consists of the positions with the same (z, y), and a *run* of positions with consecutive x in a
/// row. A run takes 8 bytes and a row that is not empty 12 bytes. Solid shapes need approximately one byte
/// per position, and the empty space between cells takes no memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GridSet {
    rows: Vec<Row>,
    runs: Vec<Run>,
    len: u32,
}

/// One row of positions along x.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    z: i32,
    y: i32,
    /// Index of the first run of the row.
    first_run: u32,
}

/// Positions with consecutive x, starting at `x`. The number of positions is the difference between `first`
/// of the next run and `first` of this run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    x: i32,
    /// Number of the run's first position.
    first: u32,
}

impl GridSet {
    /// Builds the set of the given positions, in any order; they may repeat.
    pub(crate) fn new(mut positions: Vec<[i32; 3]>) -> Self {
        positions.sort_unstable_by_key(|&[x, y, z]| (z, y, x));
        positions.dedup();
        let mut set = Self::default();
        positions.into_iter().for_each(|position| set.push(position, 1));
        set
    }

    /// Returns the set with further positions, in any order.
    pub(crate) fn with(self, positions: Vec<[i32; 3]>) -> Self {
        if positions.is_empty() { self } else { self.union(&Self::new(positions)) }
    }

    /// Appends `count` positions along x, starting at `[x, y, z]`. They must come after all positions of the
    /// set in the order of (z, y, x).
    pub(crate) fn push(&mut self, [x, y, z]: [i32; 3], count: u32) {
        let end = self.end_of_row((z, y));
        if end.is_none() {
            self.rows.push(Row { z, y, first_run: self.runs.len() as u32 });
        }
        if end != Some(x) {
            self.runs.push(Run { x, first: self.len });
        }
        self.len += count;
    }

    /// Returns the x after the last position if the last position is in the given row (z, y).
    fn end_of_row(&self, key: (i32, i32)) -> Option<i32> {
        self.rows.last().filter(|row| (row.z, row.y) == key)?;
        Some(self.span(self.runs.len() - 1).end)
    }

    /// Returns the positions that are in this set or in another one.
    pub(super) fn union(&self, other: &Self) -> Self {
        let mut union = Self::default();
        let mut spans = [self, other].map(|set| set.runs().map(|(run, key)| (key, set.span(run))).peekable());
        loop {
            // The set whose next run comes first.
            let starts = spans.each_mut().map(|spans| spans.peek().map(|(key, span)| (*key, span.start)));
            let first = match starts {
                [None, None] => return union,
                [Some(a), Some(b)] => usize::from(b < a),
                [a, _] => usize::from(a.is_none()),
            };
            let Some((key, span)) = spans[first].next() else { return union };
            // The part of the run that the union does not contain yet.
            let start = union.end_of_row(key).map_or(span.start, |end| span.start.max(end));
            if start < span.end {
                union.push([start, key.1, key.0], (span.end - start) as u32);
            }
        }
    }

    /// Returns the number of positions.
    pub(crate) fn len(&self) -> usize {
        self.len as usize
    }

    /// Returns the number of rows that are not empty.
    pub(crate) fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Returns the number of runs.
    pub(crate) fn run_count(&self) -> usize {
        self.runs.len()
    }

    /// Returns the (z, y) of a row.
    pub(crate) fn row_key(&self, row: usize) -> (i32, i32) {
        (self.rows[row].z, self.rows[row].y)
    }

    /// Returns the range of the runs of a row.
    pub(crate) fn row_runs(&self, row: usize) -> Range<usize> {
        let end = self.rows.get(row + 1).map_or(self.runs.len(), |next| next.first_run as usize);
        self.rows[row].first_run as usize..end
    }

    /// Iterates over all runs in order, each with its (z, y).
    pub(crate) fn runs(&self) -> impl Iterator<Item = (usize, (i32, i32))> {
        (0..self.row_count()).flat_map(move |row| self.row_runs(row).map(move |run| (run, self.row_key(row))))
    }

    /// Returns the range of x of a run.
    pub(crate) fn span(&self, run: usize) -> Range<i32> {
        let end = self.runs.get(run + 1).map_or(self.len, |next| next.first);
        let Run { x, first } = self.runs[run];
        x..x + (end - first) as i32
    }

    /// Returns the number of a run's first position.
    pub(crate) fn first(&self, run: usize) -> u32 {
        self.runs[run].first
    }

    /// Returns the (z, y) of the row of a run.
    pub(crate) fn key_of_run(&self, run: usize) -> (i32, i32) {
        self.row_key(self.rows.partition_point(|row| row.first_run as usize <= run) - 1)
    }

    /// Returns the row with the given (z, y), if there is one.
    pub(crate) fn find_row(&self, key: (i32, i32)) -> Option<usize> {
        self.rows.binary_search_by_key(&key, |row| (row.z, row.y)).ok()
    }

    /// Returns the number of a position, if it is in the set.
    pub(crate) fn find(&self, [x, y, z]: [i32; 3]) -> Option<u32> {
        let run = self.run_before((z, y), x)?;
        self.span(run).contains(&x).then(|| self.runs[run].first + (x - self.runs[run].x) as u32)
    }

    /// Returns whether a run of the row (z, y) contains all positions of a range of x, which must not be empty.
    pub(super) fn has_run(&self, row: (i32, i32), x: Range<i32>) -> bool {
        self.run_before(row, x.start).is_some_and(|run| x.end <= self.span(run).end)
    }

    /// Returns the last run of the row (z, y) that begins at `x` or before it.
    fn run_before(&self, row: (i32, i32), x: i32) -> Option<usize> {
        let runs = self.row_runs(self.find_row(row)?);
        let before = self.runs[runs.clone()].partition_point(|run| run.x <= x);
        Some(runs.start + before.checked_sub(1)?)
    }

    /// Returns the first position of the row (z, y) with an x of at least `x`: its number and its x.
    pub(crate) fn find_from(&self, row: (i32, i32), x: i32) -> Option<(u32, i32)> {
        if let Some(number) = self.find([x, row.1, row.0]) {
            return Some((number, x));
        }
        let runs = &self.runs[self.row_runs(self.find_row(row)?)];
        runs.get(runs.partition_point(|run| run.x <= x)).map(|run| (run.first, run.x))
    }

    /// Returns the run of a position, given the position's number.
    pub(crate) fn run_of(&self, number: u32) -> usize {
        self.runs.partition_point(|run| run.first <= number) - 1
    }

    /// Returns the number of the cell of the set that contains a point, if there is one.
    ///
    /// `point`: coordinates in cells. A point at the boundary of cells belongs to the cell `floor(point)` if
    /// this cell is in the set, and otherwise to the first neighbor that is in the set.
    pub(crate) fn locate(&self, point: [f64; 3]) -> Option<u32> {
        let middle = point.map(|x| x.floor());
        // On each axis, the index of the neighbor if the point is near the face to this neighbor, and the
        // index of the point's cell otherwise.
        let beside: [f64; 3] = std::array::from_fn(|a| match point[a] - middle[a] {
            local if local <= SLACK => middle[a] - 1.0,
            local if local >= 1.0 - SLACK => middle[a] + 1.0,
            _ => middle[a],
        });
        let mut last = None;
        for k in 0..8 {
            let cell = std::array::from_fn(|a| if k >> a & 1 == 0 { middle[a] } else { beside[a] });
            if last != Some(cell) {
                // The conversion saturates, and no cell has the saturated index.
                if let Some(cell) = self.find(cell.map(|x| x as i32)) {
                    return Some(cell);
                }
            }
            last = Some(cell);
        }
        None
    }

    /// Returns all positions in order.
    pub(crate) fn positions(&self) -> Vec<[i32; 3]> {
        let mut positions = Vec::with_capacity(self.len());
        for (run, (z, y)) in self.runs() {
            positions.extend(self.span(run).map(|x| [x, y, z]));
        }
        positions
    }

    /// Returns the memory of the set, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.rows.len() * size_of::<Row>() + self.runs.len() * size_of::<Run>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::Random;

    #[test]
    fn find_returns_the_number_of_each_position_of_the_set() {
        let positions = [[-2, 0, 0], [-1, 0, 0], [3, 0, 0], [0, 5, 0], [0, -7, 1], [1, -7, 1], [9, -7, 1]];
        let set = GridSet::new(positions.to_vec());
        assert_eq!(set.positions(), positions);
        assert_eq!((set.len(), set.row_count(), set.run_count()), (7, 3, 5));
        for (number, position) in positions.iter().enumerate() {
            assert_eq!(set.find(*position), Some(number as u32));
            assert!(
                set.row_runs(0)
                    .chain(set.row_runs(1))
                    .chain(set.row_runs(2))
                    .any(|r| r == set.run_of(number as u32))
            );
        }
        for absent in [[0, 0, 0], [4, 0, 0], [-3, 0, 0], [0, 5, 1], [2, -7, 1], [0, 6, 0]] {
            assert_eq!(set.find(absent), None);
        }
        assert_eq!(GridSet::default().find([0, 0, 0]), None);
    }

    #[test]
    fn union_and_runs_agree_with_single_positions() {
        let mut random = Random(7);
        let mut below = |n: usize| random.below(n) as i32;
        for count in [0, 1, 5, 20, 60] {
            let mut all = Vec::new();
            let [a, b] = [count, 30].map(|count| {
                let positions: Vec<_> = (0..count).map(|_| [below(12), below(3), below(2)]).collect();
                all.extend(&positions);
                GridSet::new(positions)
            });
            let union = a.union(&b);
            assert_eq!(union, GridSet::new(all));
            assert_eq!(union, b.union(&a));
            for (y, z, start) in
                (0..3).flat_map(|y| (0..2).flat_map(move |z| (0..12).map(move |x| (y, z, x))))
            {
                for end in start + 1..14 {
                    let expected = (start..end).all(|x| union.find([x, y, z]).is_some());
                    assert_eq!(union.has_run((z, y), start..end), expected);
                }
            }
        }
    }
}
