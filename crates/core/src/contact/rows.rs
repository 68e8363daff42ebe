//! Sets of rows of the samples' vertices, and the memory of buffers.

/// Marks a row that is not in the set.
const NONE: u32 = u32::MAX;

/// A sparse set: some of all rows, numbered in the order in which they were added.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowSet {
    rows: Vec<u32>,
    /// The number of each row.
    numbers: Vec<u32>,
}

impl RowSet {
    /// An empty set; rows are less than `rows`.
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: Vec::new(), numbers: vec![NONE; rows] }
    }

    /// Clears and resizes; keeps the capacity.
    pub(crate) fn resize(&mut self, rows: usize) {
        self.clear();
        self.numbers.resize(rows, NONE);
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        held(&self.rows) + held(&self.numbers)
    }

    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        for row in self.rows.drain(..) {
            self.numbers[row as usize] = NONE;
        }
    }

    /// The number of a row; adds it if it is new.
    #[inline(always)]
    pub(crate) fn number(&mut self, row: u32) -> u32 {
        let number = &mut self.numbers[row as usize];
        if *number == NONE {
            *number = self.rows.len() as u32;
            self.rows.push(row);
        }
        *number
    }

    /// The rows, by number.
    pub(crate) fn list(&self) -> &[u32] {
        &self.rows
    }
}

/// Memory in bytes of a buffer that keeps its capacity.
pub(super) fn held<T>(buffer: &Vec<T>) -> usize {
    buffer.capacity() * size_of::<T>()
}
