//! A bitmap with one bit for each cell of a grid and of a margin of one cell around it.

use fixedbitset::FixedBitSet;

use super::grid_set::GridSet;

/// Number of bits in a word.
const WORD: usize = usize::BITS as usize;

/// Rows of bits along x, for a grid and a margin of one cell around it. Each row begins at a word boundary.
///
/// Bit x + 1 of row (z + 1, y + 1) is cell `[x, y, z]`.
#[derive(Clone, Debug)]
pub(super) struct Bitmap {
    /// Number of cells along each axis, without the margin.
    size: [usize; 3],
    /// Number of words of a row.
    row_words: usize,
    bits: FixedBitSet,
}

impl Bitmap {
    /// Creates a bitmap without set bits, for a grid with `size` cells along each axis.
    pub(super) fn new(size: [usize; 3]) -> Self {
        let row_words = (size[0] + 2).div_ceil(WORD);
        let bits = FixedBitSet::with_capacity(row_words * WORD * (size[1] + 2) * (size[2] + 2));
        Self { size, row_words, bits }
    }

    /// Returns the bytes of a bitmap with `size` cells along each axis, or infinity if the number overflows.
    pub(super) fn bytes(size: [f64; 3]) -> f64 {
        ((size[0] + 2.0) / 64.0).ceil() * 8.0 * Self::row_count_of(size)
    }

    /// Returns the number of rows of a bitmap with `size` cells along each axis, margin included.
    pub(super) fn row_count_of(size: [f64; 3]) -> f64 {
        (size[1] + 2.0) * (size[2] + 2.0)
    }

    /// Returns the number of cells along each axis, without the margin.
    pub(super) fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Returns the number of rows, margin included.
    pub(super) fn row_count(&self) -> usize {
        (self.size[1] + 2) * (self.size[2] + 2)
    }

    /// Returns the number of rows with the same z, margin included.
    pub(super) fn rows_per_plane(&self) -> usize {
        self.size[1] + 2
    }

    /// Returns the words of a row.
    pub(super) fn row(&self, row: usize) -> &[usize] {
        &self.bits.as_slice()[row * self.row_words..][..self.row_words]
    }

    /// Returns the words of a row for writing.
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [usize] {
        &mut self.bits.as_mut_slice()[row * self.row_words..][..self.row_words]
    }

    /// Returns the index of a cell's bit. Coordinates are from -1 to the size, both included.
    fn bit(&self, cell: [i32; 3]) -> usize {
        let [x, y, z] = cell.map(|i| (i + 1) as usize);
        (z * self.rows_per_plane() + y) * self.row_words * WORD + x
    }

    pub(super) fn get(&self, cell: [i32; 3]) -> bool {
        self.bits[self.bit(cell)]
    }

    pub(super) fn set(&mut self, cell: [i32; 3]) {
        self.bits.insert(self.bit(cell));
    }

    /// Returns whether the bits of all cells of the range `low..high` are set.
    pub(super) fn has_all(&self, low: [i32; 3], high: [i32; 3]) -> bool {
        let mut rows = (low[2]..high[2]).flat_map(|z| (low[1]..high[1]).map(move |y| (z, y)));
        rows.all(|(z, y)| {
            let row = self.row((z + 1) as usize * self.rows_per_plane() + (y + 1) as usize);
            let end = (high[0] + 1) as usize;
            next_bit(row, (low[0] + 1) as usize, end, false) == end
        })
    }

    /// Sets all bits that are set in another bitmap of the same size.
    pub(super) fn insert(&mut self, other: &Self) {
        self.bits.union_with(&other.bits);
    }

    /// Clears all bits that are set in another bitmap of the same size.
    pub(super) fn remove(&mut self, other: &Self) {
        self.bits.difference_with(&other.bits);
    }

    /// Returns whether a cell is in the grid and not in the margin.
    pub(super) fn in_grid(&self, cell: [i32; 3]) -> bool {
        (0..3).all(|a| (0..self.size[a] as i32).contains(&cell[a]))
    }

    /// Returns the number of bits that are set.
    pub(super) fn count(&self) -> usize {
        self.bits.count_ones(..)
    }

    /// Iterates over the cells whose bits are set, in order, margin included.
    pub(super) fn cells(&self) -> impl Iterator<Item = [i32; 3]> {
        self.bits.ones().map(|bit| {
            let (row, x) = (bit / (self.row_words * WORD), bit % (self.row_words * WORD));
            let (z, y) = (row / self.rows_per_plane(), row % self.rows_per_plane());
            [x, y, z].map(|i| i as i32 - 1)
        })
    }

    /// Returns the set of the cells of the grid whose bits are *not* set.
    pub(super) fn unset(&self) -> GridSet {
        let mut set = GridSet::default();
        let [nx, ny, nz] = self.size;
        for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
            let row = self.row((z + 1) * self.rows_per_plane() + y + 1);
            let mut end = 1;
            loop {
                let x = next_bit(row, end, nx + 1, false);
                if x > nx {
                    break;
                }
                end = next_bit(row, x, nx + 1, true);
                set.push([x as i32 - 1, y as i32, z as i32], (end - x) as u32);
            }
        }
        set
    }
}

/// Returns the first bit in `start..end` that has the given value, or `end` if there is no such bit.
fn next_bit(row: &[usize], start: usize, end: usize, value: bool) -> usize {
    let flip = if value { 0 } else { usize::MAX };
    let mut mask = usize::MAX << (start % WORD);
    for (word, bits) in row.iter().enumerate().skip(start / WORD) {
        let found = (bits ^ flip) & mask;
        if found != 0 {
            return (word * WORD + found.trailing_zeros() as usize).min(end);
        }
        mask = usize::MAX;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_unset_are_complementary() {
        let size = [130, 3, 2];
        let mut bitmap = Bitmap::new(size);
        let set = [[-1, -1, -1], [0, 0, 0], [62, 1, 0], [63, 1, 0], [64, 1, 0], [129, 2, 1], [130, 3, 2]];
        for cell in set {
            bitmap.set(cell);
        }
        assert!(bitmap.cells().eq(set));
        assert_eq!(bitmap.count(), set.len());
        let unset = bitmap.unset();
        assert_eq!(unset.len(), 130 * 6 - 5);
        for cell in set {
            assert!(bitmap.get(cell) && unset.find(cell).is_none());
        }
        assert!(bitmap.has_all([62, 1, 0], [65, 2, 1]) && bitmap.has_all([129, 2, 1], [130, 3, 2]));
        assert!(!bitmap.has_all([61, 1, 0], [65, 2, 1]) && !bitmap.has_all([62, 1, 0], [66, 2, 1]));
        assert!(!bitmap.has_all([62, 1, 0], [65, 3, 1]) && !bitmap.has_all([62, 1, 0], [65, 2, 2]));
        assert!(bitmap.has_all([5, 1, 0], [5, 2, 1]), "an empty range");
        assert!(unset.find([61, 1, 0]).is_some() && unset.find([65, 1, 0]).is_some());
        assert!(bitmap.in_grid([129, 2, 1]) && !bitmap.in_grid([130, 2, 1]) && !bitmap.in_grid([0, -1, 0]));
    }
}
