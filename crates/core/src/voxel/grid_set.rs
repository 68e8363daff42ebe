//! A set of grid positions as runs along x: small, sorted, and searched in two binary searches.

use std::ops::Range;

use super::grid::FARTHEST_MOVE;

/// How far outside a cell, in cells, a point may lie and still count as in it: more than a surface was moved into grid planes.
const SLACK: f64 = 2.0 * FARTHEST_MOVE;

/// A set of grid positions, numbered in the order of (z, y, x), x fastest.
///
/// Kept as the runs of consecutive x in each row (z, y) that holds a position. A run takes 8 bytes and a row 12, so that solid
/// shapes need about one byte a position, and cells that lie far apart cost nothing for the space between them.
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
    first_run: u32,
}

/// Consecutive positions from `x` on; they end where the numbers of the next run begin.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    x: i32,
    first: u32,
}

impl GridSet {
    /// The set of the given positions, which must be sorted by (z, y, x) and may repeat.
    pub(crate) fn from_sorted(positions: &[[i32; 3]]) -> Self {
        let mut set = Self::default();
        for (i, position) in positions.iter().enumerate() {
            if i == 0 || positions[i - 1] != *position {
                set.push(*position, 1);
            }
        }
        set
    }

    /// Adds `count` positions from `[x, y, z]` on along x; they must lie behind all that are there.
    pub(crate) fn push(&mut self, [x, y, z]: [i32; 3], count: u32) {
        let same_row = self.rows.last().is_some_and(|row| (row.z, row.y) == (z, y));
        if !same_row {
            self.rows.push(Row { z, y, first_run: self.runs.len() as u32 });
        }
        let adjoins = same_row && self.span(self.runs.len() - 1).end == x;
        if !adjoins {
            self.runs.push(Run { x, first: self.len });
        }
        self.len += count;
    }

    /// Number of positions.
    pub(crate) fn len(&self) -> usize {
        self.len as usize
    }

    /// Number of rows that hold a position.
    pub(crate) fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Number of runs.
    pub(crate) fn run_count(&self) -> usize {
        self.runs.len()
    }

    /// (z, y) of a row.
    pub(crate) fn row_key(&self, row: usize) -> (i32, i32) {
        (self.rows[row].z, self.rows[row].y)
    }

    /// The runs of a row.
    pub(crate) fn row_runs(&self, row: usize) -> Range<usize> {
        let end = self.rows.get(row + 1).map_or(self.runs.len(), |next| next.first_run as usize);
        self.rows[row].first_run as usize..end
    }

    /// All runs in order, each with its (z, y).
    pub(crate) fn runs(&self) -> impl Iterator<Item = (usize, (i32, i32))> {
        (0..self.row_count()).flat_map(move |row| self.row_runs(row).map(move |run| (run, self.row_key(row))))
    }

    /// The x of a run's positions.
    pub(crate) fn span(&self, run: usize) -> Range<i32> {
        let end = self.runs.get(run + 1).map_or(self.len, |next| next.first);
        let Run { x, first } = self.runs[run];
        x..x + (end - first) as i32
    }

    /// The number of a run's first position.
    pub(crate) fn first(&self, run: usize) -> u32 {
        self.runs[run].first
    }

    /// (z, y) of the row that holds a run.
    pub(crate) fn key_of_run(&self, run: usize) -> (i32, i32) {
        self.row_key(self.rows.partition_point(|row| row.first_run as usize <= run) - 1)
    }

    /// The row with the given (z, y).
    pub(crate) fn find_row(&self, key: (i32, i32)) -> Option<usize> {
        self.rows.binary_search_by_key(&key, |row| (row.z, row.y)).ok()
    }

    /// The number of a position, if the set holds it.
    pub(crate) fn find(&self, [x, y, z]: [i32; 3]) -> Option<u32> {
        let runs = self.row_runs(self.find_row((z, y))?);
        let before = self.runs[runs.clone()].partition_point(|run| run.x <= x);
        let run = runs.start + before.checked_sub(1)?;
        self.span(run).contains(&x).then(|| self.runs[run].first + (x - self.runs[run].x) as u32)
    }

    /// The run that holds a position of the set, given the position's number.
    pub(crate) fn run_of(&self, number: u32) -> usize {
        self.runs.partition_point(|run| run.first <= number) - 1
    }

    /// The cell of the set that holds a point, given in cells. A point between several cells goes to the one that begins there, or
    /// else to the first that the set holds.
    pub(crate) fn locate(&self, point: [f64; 3]) -> Option<u32> {
        let middle = point.map(|x| x.floor());
        // On each axis the cell of the point, and the one beyond the face near which it lies.
        let beside: [f64; 3] = std::array::from_fn(|a| match point[a] - middle[a] {
            depth if depth <= SLACK => middle[a] - 1.0,
            depth if depth >= 1.0 - SLACK => middle[a] + 1.0,
            _ => middle[a],
        });
        let mut last = None;
        for k in 0..8 {
            let cell = std::array::from_fn(|a| if k >> a & 1 == 0 { middle[a] } else { beside[a] });
            if last != Some(cell) {
                // Saturates: no cell has such an index.
                if let Some(cell) = self.find(cell.map(|x| x as i32)) {
                    return Some(cell);
                }
            }
            last = Some(cell);
        }
        None
    }

    /// All positions in order.
    pub(crate) fn positions(&self) -> Vec<[i32; 3]> {
        let mut positions = Vec::with_capacity(self.len());
        for (run, (z, y)) in self.runs() {
            positions.extend(self.span(run).map(|x| [x, y, z]));
        }
        positions
    }

    /// Bytes that the set takes.
    pub(crate) fn bytes(&self) -> usize {
        self.rows.len() * size_of::<Row>() + self.runs.len() * size_of::<Run>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_found_by_their_number_and_others_are_not() {
        let positions = [[-2, 0, 0], [-1, 0, 0], [3, 0, 0], [0, 5, 0], [0, -7, 1], [1, -7, 1], [9, -7, 1]];
        let set = GridSet::from_sorted(&positions);
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
}
