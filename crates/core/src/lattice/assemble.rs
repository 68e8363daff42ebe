//! Assembles a lattice from a set of cells: numbers the corners of the cells and finds their links.
//!
//! A *row* has the cells or corners with a common (z, y). A *run* has consecutive cells along x in a row; see
//! [`GridSet`].

use nalgebra::Point3;

use super::components::{Components, label};
use super::{Lattice, LatticeError, LatticeReport, memory};
use crate::voxel::GridSet;

/// Assembles the lattice of a set of cells, which must not be empty.
///
/// Fails if the lattice and a simulation of it need more than `limit` bytes.
pub(super) fn lattice(
    cells: GridSet,
    cell_size: f64,
    origin: Point3<f64>,
    report: LatticeReport,
    limit: u64,
) -> Result<Lattice, LatticeError> {
    let count = count_vertices(&cells);
    memory::check(memory::needed_bytes(count as u64), limit, cell_size)?;
    let labels = label(&cells);
    let mut vertex_set = GridSet::default();
    let mut indices = Vec::with_capacity(count);
    let mut links = Vec::with_capacity(count);
    let mut occupied_cells = Vec::with_capacity(count);
    let mut of_vertex = Vec::with_capacity(count);
    visit(&cells, |corner| {
        vertex_set.push(corner.index, 1);
        indices.push(corner.index);
        links.push(corner.links);
        occupied_cells.push(corner.cells);
        of_vertex.push(labels.of_run[corner.cell_run]);
    });
    let components = Components { count: labels.count, of_vertex };
    let positions = cells.positions();
    Ok(Lattice {
        cell_size,
        origin,
        indices,
        vertex_set,
        links,
        occupied_cells,
        cells: positions,
        cell_set: cells,
        components,
        report,
        broken: None,
    })
}

/// A lattice vertex that [`visit`] emits.
struct Corner {
    /// Grid index.
    index: [i32; 3],
    /// Links as in [`Lattice::links`]: bits for the neighbors at -x, +x, -y, +y, -z, +z.
    links: u8,
    /// Number of occupied cells that have this corner, 1 to 8.
    cells: u8,
    /// Run of any of the occupied cells that have this corner.
    cell_run: usize,
}

/// Calls `emit` for the corners of all cells in the order of (z, y, x).
///
/// A row of corners along x lies between four rows of cells. These rows of cells are numbered as quadrants.
/// Bit q of a mask in [`visit_row`] belongs to quadrant q:
///
/// ```text
///   z ^   2 | 3
///     |  ---+---      seen along x; the row of corners is at the cross
///     |   0 | 1
///     +------> y
/// ```
fn visit(cells: &GridSet, mut emit: impl FnMut(Corner)) {
    // `next[j]` is the next row of cells that is used as quadrant j of a row of corners.
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

/// Calls `emit` for one row of corners between up to four rows of cells.
fn visit_row(cells: &GridSet, (z, y): (i32, i32), rows: [Option<usize>; 4], emit: &mut impl FnMut(Corner)) {
    // Mask of the two quadrants at lower y, and mask of the two quadrants at lower z.
    const LOW_Y: u8 = 0b0101;
    const LOW_Z: u8 = 0b0011;
    let mut runs = rows.map(|row| row.map_or(0..0, |row| cells.row_runs(row)));
    // In each quadrant, the run that contains x; if there is none, the next run.
    let mut spans: [_; 4] = std::array::from_fn(|j| runs[j].next().map(|run| (run, cells.span(run))));
    // Mask of the quadrants that are occupied at x - 1.
    let mut before = 0;
    let mut cell_run = 0;
    let mut x = i32::MIN;
    loop {
        // Mask of the quadrants that are occupied at x.
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
        let either: u8 = before | here;
        if either == 0 {
            if start == i32::MAX {
                return;
            }
            x = start;
            continue;
        }
        let links = u8::from(before != 0)
            | u8::from(here != 0) << 1
            | u8::from(either & LOW_Y != 0) << 2
            | u8::from(either & !LOW_Y != 0) << 3
            | u8::from(either & LOW_Z != 0) << 4
            | u8::from(either & !LOW_Z != 0) << 5;
        let cells = (before.count_ones() + u8::count_ones(here)) as u8;
        emit(Corner { index: [x, y, z], links, cells, cell_run });
        before = here;
        x += 1;
    }
}

/// Counts the lattice vertices of a set of cells.
pub(super) fn count_vertices(cells: &GridSet) -> usize {
    let mut count = 0;
    visit(cells, |_| count += 1);
    count
}
