//! Flood fill of the cells outside a surface.

use std::collections::VecDeque;

use super::bitmap::Bitmap;

/// Cells and faces that the flood fill does not pass.
pub(super) struct Walls<'a> {
    /// Cells that the surface passes through.
    pub(super) cells: &'a Bitmap,
    /// For each axis, the cells with a wall on the face to the lower neighbor along the axis. `None` if there
    /// is no such wall.
    pub(super) faces: [Option<&'a Bitmap>; 3],
}

/// Returns the cells, margin included, that are connected to the margin through faces without passing a wall.
///
/// Works on rows of bits along x, with a queue of rows. A row is filled along x in two passes, one for each
/// direction. The bits of the row then spread to the four neighboring rows. A neighboring row that gets new
/// bits is added to the queue.
pub(super) fn outside(walls: &Walls<'_>) -> Bitmap {
    // Cells that the flood fill has reached.
    let mut reached = Bitmap::new(walls.cells.size());
    let rows = reached.row_count();
    let plane = reached.rows_per_plane();
    let mut queue = VecDeque::from([0]);
    let mut queued = vec![false; rows];
    reached.row_mut(0).fill(usize::MAX);
    while let Some(row) = queue.pop_front() {
        queued[row] = false;
        fill_row(reached.row_mut(row), walls.cells.row(row), walls.faces[0].map(|faces| faces.row(row)));
        let y = row % plane;
        // The face between two rows is stored with the upper row.
        let neighbors = [
            (y > 0).then(|| (row - 1, row, 1)),
            (y + 1 < plane).then(|| (row + 1, row + 1, 1)),
            (row >= plane).then(|| (row - plane, row, 2)),
            (row + plane < rows).then(|| (row + plane, row + plane, 2)),
        ];
        for (next, upper, axis) in neighbors.into_iter().flatten() {
            let faces = walls.faces[axis].map(|faces| faces.row(upper));
            if spread_to(&mut reached, row, next, walls.cells.row(next), faces) && !queued[next] {
                queued[next] = true;
                queue.push_back(next);
            }
        }
    }
    reached
}

/// Spreads the reached bits along a row up to the next walls, in both directions.
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

/// Spreads the bits of a word through adjacent bits of `open`, in one direction. The shift doubles in each
/// step.
///
/// `shifted(bits, n)`: returns `bits`, shifted by n bits in this direction.
fn spread(mut bits: usize, mut open: usize, shifted: impl Fn(usize, u32) -> usize) -> usize {
    for step in (0..usize::BITS.ilog2()).map(|k| 1 << k) {
        bits |= open & shifted(bits, step);
        open &= shifted(open, step);
    }
    bits
}

/// Spreads the reached bits of row `from` to the neighboring row `to`. Returns whether row `to` has new bits.
///
/// `walls`: cells of row `to` that are walls. `faces`: cells with a wall on the face between the two rows.
fn spread_to(reached: &mut Bitmap, from: usize, to: usize, walls: &[usize], faces: Option<&[usize]>) -> bool {
    let mut changed = false;
    for (word, wall) in walls.iter().enumerate() {
        let open = !wall & !faces.map_or(0, |faces| faces[word]);
        let new = reached.row(from)[word] & open & !reached.row(to)[word];
        if new != 0 {
            reached.row_mut(to)[word] |= new;
            changed = true;
        }
    }
    changed
}
