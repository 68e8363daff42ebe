//! The cells that can be reached from outside: a flood fill.

use std::collections::VecDeque;

use super::bitmap::Bitmap;

/// What stands in the way of the flood.
pub(super) struct Walls<'a> {
    /// Cells that the surface passes through.
    pub(super) cells: &'a Bitmap,
    /// For each axis: a bit is set where the surface lies between the cell and its lower neighbour along the axis.
    pub(super) faces: [Option<&'a Bitmap>; 3],
}

/// Marks the cells, margin included, to which a way leads from the margin, through faces, past cells and faces of the surface.
///
/// Works on rows of bits along x: a row is filled along x in two passes, then spills into its four neighbours; a row into which
/// something spilled waits for its turn.
pub(super) fn outside(walls: &Walls<'_>) -> Bitmap {
    let mut reached = Bitmap::new(walls.cells.size());
    let rows = reached.row_count();
    let plane = reached.rows_per_plane();
    let mut waiting = VecDeque::from([0]);
    let mut waits = vec![false; rows];
    reached.row_mut(0).fill(usize::MAX);
    while let Some(row) = waiting.pop_front() {
        waits[row] = false;
        fill_row(reached.row_mut(row), walls.cells.row(row), walls.faces[0].map(|faces| faces.row(row)));
        let y = row % plane;
        // The face between two rows is kept with the upper of them.
        let neighbours = [
            (y > 0).then(|| (row - 1, row, 1)),
            (y + 1 < plane).then(|| (row + 1, row + 1, 1)),
            (row >= plane).then(|| (row - plane, row, 2)),
            (row + plane < rows).then(|| (row + plane, row + plane, 2)),
        ];
        for (next, upper, axis) in neighbours.into_iter().flatten() {
            let faces = walls.faces[axis].map(|faces| faces.row(upper));
            if spill(&mut reached, row, next, walls.cells.row(next), faces) && !waits[next] {
                waits[next] = true;
                waiting.push_back(next);
            }
        }
    }
    reached
}

/// Spreads what is reached along a row, past no wall.
fn fill_row(reached: &mut [usize], walls: &[usize], faces: Option<&[usize]>) {
    const LAST: u32 = usize::BITS - 1;
    let face = |word: usize| faces.map_or(0, |faces| faces.get(word).copied().unwrap_or(0));
    let mut carry = 0;
    for word in 0..reached.len() {
        let open = !walls[word] & !face(word);
        reached[word] = spread(reached[word] | (carry & open), open, |bits, by| bits << by);
        carry = reached[word] >> LAST;
    }
    carry = 0;
    for word in (0..reached.len()).rev() {
        let open = !walls[word] & !(face(word) >> 1 | face(word + 1) << LAST);
        reached[word] = spread(reached[word] | (carry & open), open, |bits, by| bits >> by);
        carry = reached[word] << LAST;
    }
}

/// Spreads the bits of a word one way through those that are open.
fn spread(mut bits: usize, mut open: usize, shifted: impl Fn(usize, u32) -> usize) -> usize {
    for step in (0..usize::BITS.ilog2()).map(|k| 1 << k) {
        bits |= open & shifted(bits, step);
        open &= shifted(open, step);
    }
    bits
}

/// Spreads what is reached from a row to its neighbour; whether there was anything new.
fn spill(reached: &mut Bitmap, from: usize, to: usize, walls: &[usize], faces: Option<&[usize]>) -> bool {
    let mut spilled = false;
    for (word, wall) in walls.iter().enumerate() {
        let open = !wall & !faces.map_or(0, |faces| faces[word]);
        let new = reached.row(from)[word] & open & !reached.row(to)[word];
        if new != 0 {
            reached.row_mut(to)[word] |= new;
            spilled = true;
        }
    }
    spilled
}
