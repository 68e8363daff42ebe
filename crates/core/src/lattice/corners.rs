//! Lattice vertices: the corners of the occupied cells, with their links.

use super::runs::Runs;

/// One lattice vertex, as it is met in the order of (z, y, x).
pub(crate) struct Corner {
    /// Grid index.
    pub(crate) index: [i32; 3],
    /// Bit n is set iff the vertex is linked to its neighbour n: -x, +x, -y, +y, -z, +z.
    pub(crate) links: u8,
    /// Occupied cells that have this corner, 1 to 8.
    pub(crate) cells: u8,
    /// The run of one of these cells.
    pub(crate) cell_run: usize,
}

/// Visits the corners of all cells in the order of (z, y, x).
///
/// The four rows of cells around a row of corners, as bits of a mask:
///
/// ```text
///   z ^   2 | 3
///     |  ---+---      the corners lie on the cross, seen along x
///     |   0 | 1
///     +------> y
/// ```
pub(crate) fn visit(cells: &Runs, mut emit: impl FnMut(Corner)) {
    // Row `next[j]` of cells is the next to lie in quadrant j of a row of corners.
    let mut next = [0; 4];
    let offset = |quadrant: usize| (i32::from(quadrant < 2), i32::from(quadrant.is_multiple_of(2)));
    loop {
        let keys: [Option<(i32, i32)>; 4] = std::array::from_fn(|j| {
            let (dz, dy) = offset(j);
            (next[j] < cells.row_count()).then(|| {
                let (z, y) = cells.row_key(next[j]);
                (z + dz, y + dy)
            })
        });
        let Some(key) = keys.iter().flatten().min().copied() else { return };
        let mut rows = [None; 4];
        for j in 0..4 {
            if keys[j] == Some(key) {
                rows[j] = Some(next[j]);
                next[j] += 1;
            }
        }
        visit_row(cells, key, rows, &mut emit);
    }
}

/// Visits one row of corners between up to four rows of cells.
fn visit_row(cells: &Runs, (z, y): (i32, i32), rows: [Option<usize>; 4], emit: &mut impl FnMut(Corner)) {
    const LOW_Y: u8 = 0b0101;
    const LOW_Z: u8 = 0b0011;
    let mut runs = rows.map(|row| row.map_or(0..0, |row| cells.row_runs(row)));
    // The run under way in each quadrant, or the one to come.
    let mut spans: [_; 4] = std::array::from_fn(|j| runs[j].next().map(|run| (run, cells.span(run))));
    let mut before = 0;
    let mut cell_run = 0;
    let mut x = i32::MIN;
    loop {
        let mut here = 0;
        let mut start = i32::MAX;
        for j in 0..4 {
            if spans[j].as_ref().is_some_and(|(_, span)| span.end <= x) {
                spans[j] = runs[j].next().map(|run| (run, cells.span(run)));
            }
            if let Some((run, span)) = &spans[j] {
                if span.start <= x {
                    here |= 1 << j;
                    cell_run = *run;
                }
                start = start.min(span.start);
            }
        }
        let around: u8 = before | here;
        if around == 0 {
            if start == i32::MAX {
                return;
            }
            x = start;
            continue;
        }
        let links = u8::from(before != 0)
            | u8::from(here != 0) << 1
            | u8::from(around & LOW_Y != 0) << 2
            | u8::from(around & !LOW_Y != 0) << 3
            | u8::from(around & LOW_Z != 0) << 4
            | u8::from(around & !LOW_Z != 0) << 5;
        let cells = (before.count_ones() + u8::count_ones(here)) as u8;
        emit(Corner { index: [x, y, z], links, cells, cell_run });
        before = here;
        x += 1;
    }
}

/// Number of lattice vertices of a set of cells.
pub(crate) fn count(cells: &Runs) -> usize {
    let mut count = 0;
    visit(cells, |_| count += 1);
    count
}
