//! One bit for each cell of a grid, with a margin of one cell all round.

use super::runs::Runs;

/// Bits in a word.
const WORD: usize = u64::BITS as usize;

/// Rows of bits along x for a grid and a margin of one cell all round it.
///
/// Bit x + 1 of row (z + 1, y + 1) is cell `[x, y, z]`.
#[derive(Clone, Debug)]
pub(crate) struct Bitmap {
    /// Cells along each axis without the margin.
    size: [usize; 3],
    row_words: usize,
    words: Vec<u64>,
}

impl Bitmap {
    pub(crate) fn new(size: [usize; 3]) -> Self {
        let row_words = (size[0] + 2).div_ceil(WORD);
        Self { size, row_words, words: vec![0; row_words * (size[1] + 2) * (size[2] + 2)] }
    }

    /// Bytes of a bitmap of so many cells along each axis, infinite where it overflows.
    pub(crate) fn bytes(size: [f64; 3]) -> f64 {
        ((size[0] + 2.0) / WORD as f64).ceil() * 8.0 * Self::row_count_of(size)
    }

    /// Number of rows of a bitmap of so many cells along each axis.
    pub(crate) fn row_count_of(size: [f64; 3]) -> f64 {
        (size[1] + 2.0) * (size[2] + 2.0)
    }

    /// Cells along each axis without the margin.
    pub(crate) fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Number of rows, those of the margin included.
    pub(crate) fn row_count(&self) -> usize {
        (self.size[1] + 2) * (self.size[2] + 2)
    }

    /// Number of rows from z to z + 1.
    pub(crate) fn rows_per_plane(&self) -> usize {
        self.size[1] + 2
    }

    /// The words of a row.
    pub(crate) fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.row_words..][..self.row_words]
    }

    /// The words of a row, to write to.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.words[row * self.row_words..][..self.row_words]
    }

    /// Word and bit of a cell; coordinates go from -1 to the size.
    fn address(&self, cell: [i32; 3]) -> (usize, u64) {
        let [x, y, z] = cell.map(|i| (i + 1) as usize);
        let row = z * self.rows_per_plane() + y;
        (row * self.row_words + x / WORD, 1 << (x % WORD))
    }

    pub(crate) fn get(&self, cell: [i32; 3]) -> bool {
        let (word, bit) = self.address(cell);
        self.words[word] & bit != 0
    }

    pub(crate) fn set(&mut self, cell: [i32; 3]) {
        let (word, bit) = self.address(cell);
        self.words[word] |= bit;
    }

    /// Sets the bits that are set in another bitmap of the same size.
    pub(crate) fn insert(&mut self, other: &Self) {
        self.words.iter_mut().zip(&other.words).for_each(|(word, other)| *word |= other);
    }

    /// Clears the bits that are set in another bitmap of the same size.
    pub(crate) fn remove(&mut self, other: &Self) {
        self.words.iter_mut().zip(&other.words).for_each(|(word, other)| *word &= !other);
    }

    /// Whether a cell belongs to the grid and not to the margin.
    pub(crate) fn within(&self, cell: [i32; 3]) -> bool {
        (0..3).all(|a| (0..self.size[a] as i32).contains(&cell[a]))
    }

    /// Number of bits that are set.
    pub(crate) fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The cells whose bits are set, in order, margin included.
    pub(crate) fn cells(&self) -> impl Iterator<Item = [i32; 3]> {
        (0..self.row_count()).flat_map(move |row| {
            let (z, y) = (row / self.rows_per_plane(), row % self.rows_per_plane());
            self.row(row).iter().enumerate().flat_map(move |(word, &bits)| {
                let first = word * WORD;
                set_bits(bits).map(move |bit| [(first + bit) as i32 - 1, y as i32 - 1, z as i32 - 1])
            })
        })
    }

    /// The cells of the grid whose bits are *not* set, as runs.
    pub(crate) fn unset(&self) -> Runs {
        let mut runs = Runs::default();
        let [nx, ny, nz] = self.size;
        for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
            let row = self.row((z + 1) * self.rows_per_plane() + y + 1);
            let mut x = 1;
            loop {
                x = next(row, x, nx + 1, false);
                if x > nx {
                    break;
                }
                let end = next(row, x, nx + 1, true);
                runs.push([x as i32 - 1, y as i32, z as i32], (end - x) as u32);
                x = end;
            }
        }
        runs
    }
}

/// The numbers of the bits that are set in a word.
fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (bit < WORD).then_some(bit)
    })
}

/// The first bit from `from` on that has the given value, or `end` if there is none before.
fn next(row: &[u64], from: usize, end: usize, value: bool) -> usize {
    let flip = if value { 0 } else { u64::MAX };
    let mut mask = u64::MAX << (from % WORD);
    for (word, bits) in row.iter().enumerate().skip(from / WORD) {
        let found = (bits ^ flip) & mask;
        if found != 0 {
            return (word * WORD + found.trailing_zeros() as usize).min(end);
        }
        mask = u64::MAX;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_runs_of_a_bitmap_are_those_that_were_set() {
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
        assert!(unset.find([61, 1, 0]).is_some() && unset.find([65, 1, 0]).is_some());
        assert!(bitmap.within([129, 2, 1]) && !bitmap.within([130, 2, 1]) && !bitmap.within([0, -1, 0]));
    }
}
