//! Finds the cells that a surface encloses.

use std::ops::Range;

use super::grid_set::GridSet;
use crate::mesh::UnionFind;

/// Cells and faces that no path from outside passes.
pub(super) struct Walls<'a> {
    /// Cells that the surface passes through.
    pub(super) cells: &'a GridSet,
    /// For each axis, the cells with a wall on the face to the lower neighbor along the axis.
    pub(super) faces: [&'a GridSet; 3],
}

/// Returns the cells to which no path of steps through faces leads from outside the grid without passing a wall.
///
/// Connects the free intervals of neighboring rows. A row without a wall is connected to the outside along x, so only
/// rows with a wall are visited, and time and memory do not depend on the extent of the grid.
///
/// Returns the number of the enclosed cells as an error if it exceeds `max`.
pub(super) fn enclosed(walls: &Walls<'_>, max: u64) -> Result<GridSet, u64> {
    let free = FreeIntervals::new(walls);
    let sets = &mut free.connected(walls);
    let outside = sets.find(free.outside());
    let inner = || (0..free.rows.len()).flat_map(|row| free.inner(row).map(move |interval| (row, interval)));
    let mut enclosed = Vec::new();
    let mut count = 0;
    for (row, interval) in inner() {
        if sets.find(interval) != outside {
            let span = free.span(interval);
            count += span.len() as u64;
            enclosed.push((free.rows[row].key, span));
        }
    }
    if count > max {
        return Err(count);
    }
    let mut set = GridSet::default();
    for ((z, y), span) in enclosed {
        set.push([span.start, y, z], span.len() as u32);
    }
    Ok(set)
}

/// The intervals of cells without a wall, in each row with a wall in it.
///
/// The first and the last interval of a row are unbounded. They lead to the outside. The others are *inner* intervals.
struct FreeIntervals {
    /// Sorted by (z, y).
    rows: Vec<Row>,
    /// Range of x of each interval.
    spans: Vec<Range<i32>>,
}

/// A row with a wall in it.
struct Row {
    /// The (z, y) of the row.
    key: (i32, i32),
    /// Index of the first interval of the row.
    first: u32,
}

impl FreeIntervals {
    fn new(walls: &Walls<'_>) -> Self {
        let (cells, faces) = (walls.cells, walls.faces[0]);
        let mut free = Self { rows: Vec::new(), spans: Vec::new() };
        // The next row of each set.
        let (mut cell_row, mut face_row) = (0, 0);
        let key_of = |set: &GridSet, row| (row < set.row_count()).then(|| set.row_key(row));
        let mut stops: Vec<Range<i32>> = Vec::new();
        while let Some(key) = [key_of(cells, cell_row), key_of(faces, face_row)].into_iter().flatten().min() {
            stops.clear();
            if key_of(cells, cell_row) == Some(key) {
                stops.extend(cells.row_runs(cell_row).map(|run| cells.span(run)));
                cell_row += 1;
            }
            if key_of(faces, face_row) == Some(key) {
                // A wall on the face between x - 1 and x ends an interval but takes no cell.
                stops.extend(faces.row_runs(face_row).flat_map(|run| faces.span(run)).map(|x| x..x));
                stops.sort_unstable_by_key(|stop| stop.start);
                face_row += 1;
            }
            free.push_row(key, &stops);
        }
        free
    }

    /// Appends a row. `stops`: the walls in the row, sorted by their first x; at least one.
    fn push_row(&mut self, key: (i32, i32), stops: &[Range<i32>]) {
        self.rows.push(Row { key, first: self.spans.len() as u32 });
        let mut end = i32::MIN;
        for stop in stops {
            if stop.start > end {
                self.spans.push(end..stop.start);
            }
            end = end.max(stop.end);
        }
        self.spans.push(end..i32::MAX);
    }

    /// Returns the number that stands for the outside, among the numbers of the intervals.
    fn outside(&self) -> u32 {
        self.spans.len() as u32
    }

    /// Returns the range of x of an interval. The outside has all cells of its rows.
    fn span(&self, interval: u32) -> Range<i32> {
        self.spans.get(interval as usize).cloned().unwrap_or(i32::MIN..i32::MAX)
    }

    /// Returns the intervals of a row.
    fn of_row(&self, row: usize) -> Range<u32> {
        self.rows[row].first..self.rows.get(row + 1).map_or(self.outside(), |next| next.first)
    }

    /// Returns the inner intervals of a row.
    fn inner(&self, row: usize) -> Range<u32> {
        let all = self.of_row(row);
        all.start + 1..all.end - 1
    }

    /// Returns the sets of connected intervals.
    fn connected(&self, walls: &Walls<'_>) -> UnionFind {
        let mut sets = UnionFind::new(self.spans.len() + 1);
        for row in 0..self.rows.len() {
            let all = self.of_row(row);
            sets.unite(all.start, self.outside());
            sets.unite(all.end - 1, self.outside());
        }
        // For each neighbor of a row, the first row that does not come before it. Advances with the row.
        let mut found = [0; 4];
        for row in (0..self.rows.len()).filter(|&row| !self.inner(row).is_empty()) {
            let (z, y) = self.rows[row].key;
            // The faces between two rows are stored with the upper row.
            let neighbors = [
                ((z, y - 1), walls.faces[1], (z, y)),
                ((z, y + 1), walls.faces[1], (z, y + 1)),
                ((z - 1, y), walls.faces[2], (z, y)),
                ((z + 1, y), walls.faces[2], (z + 1, y)),
            ];
            for ((key, faces, upper), found) in neighbors.into_iter().zip(&mut found) {
                *found += self.rows[*found..].iter().take_while(|row| row.key < key).count();
                let is_row = self.rows.get(*found).is_some_and(|row| row.key == key);
                let others = if is_row { self.of_row(*found) } else { self.outside()..self.outside() + 1 };
                self.connect(self.inner(row), others, |x| faces.has_run(upper, x), &mut sets);
            }
        }
        sets
    }

    /// Connects the intervals of two neighboring rows.
    ///
    /// `has_wall`: returns whether there is a wall on all faces between the rows in a range of x.
    fn connect(
        &self,
        mut a: Range<u32>,
        mut b: Range<u32>,
        has_wall: impl Fn(Range<i32>) -> bool,
        sets: &mut UnionFind,
    ) {
        while !a.is_empty() && !b.is_empty() {
            let (left, right) = (self.span(a.start), self.span(b.start));
            let common = left.start.max(right.start)..left.end.min(right.end);
            if !common.is_empty() && !has_wall(common) {
                sets.unite(a.start, b.start);
            }
            if left.end < right.end {
                a.start += 1;
            } else {
                b.start += 1;
            }
        }
    }
}
