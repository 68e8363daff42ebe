//! Sparse sets of rows (indices into `SampleCells::vertices`), and the memory of buffers.

/// Marks a row that is not in the set, in `RowSet::numbers`.
const NONE: u32 = u32::MAX;

/// Sparse set of rows, numbered in the order in which they were added.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowSet {
    rows: Vec<u32>,
    /// Number of each row, or `NONE`.
    numbers: Vec<u32>,
}

impl RowSet {
    /// Creates an empty set of rows in `0..rows`.
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: Vec::new(), numbers: vec![NONE; rows] }
    }

    /// Clears and resizes; keeps the capacity.
    pub(crate) fn resize(&mut self, rows: usize) {
        self.clear();
        self.numbers.resize(rows, NONE);
    }

    /// Returns the memory of the buffers in bytes.
    pub(crate) fn bytes(&self) -> usize {
        buffer_bytes(&self.rows) + buffer_bytes(&self.numbers)
    }

    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        for row in self.rows.drain(..) {
            self.numbers[row as usize] = NONE;
        }
    }

    /// Returns the number of a row; adds the row if it is new.
    #[inline(always)]
    pub(crate) fn number(&mut self, row: u32) -> u32 {
        let number = &mut self.numbers[row as usize];
        if *number == NONE {
            *number = self.rows.len() as u32;
            self.rows.push(row);
        }
        *number
    }

    /// Returns the rows in the order of their numbers.
    pub(crate) fn list(&self) -> &[u32] {
        &self.rows
    }
}

/// Returns the memory of a buffer in bytes, by its capacity.
pub(super) fn buffer_bytes<T>(buffer: &Vec<T>) -> usize {
    buffer.capacity() * size_of::<T>()
}
