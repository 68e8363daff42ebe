//! Sparse sets of rows. A row is an index into `SampleCells::vertices`.

/// Entry of `RowSet::indices` for a row that is not in the set.
const NONE: u32 = u32::MAX;

/// Sparse set of rows. The index of a row in the set is the number of rows that were added before it.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowSet {
    /// The rows in the set, by index.
    rows: Vec<u32>,
    /// Index in `rows` of every possible row, or `NONE`.
    indices: Vec<u32>,
}

impl RowSet {
    /// Creates an empty set. The possible rows are `0..rows`.
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: Vec::new(), indices: vec![NONE; rows] }
    }

    /// Empties the set and changes the possible rows to `0..rows`. Keeps the capacity of the buffers.
    pub(crate) fn resize(&mut self, rows: usize) {
        self.clear();
        self.indices.resize(rows, NONE);
    }

    /// Returns the memory of the set in bytes.
    pub(crate) fn bytes(&self) -> usize {
        buffer_bytes(&self.rows) + buffer_bytes(&self.indices)
    }

    /// Empties the set. Keeps the capacity of the buffers.
    pub(crate) fn clear(&mut self) {
        for row in self.rows.drain(..) {
            self.indices[row as usize] = NONE;
        }
    }

    /// Returns the index of a row in the set. Adds the row if it is not in the set.
    #[inline(always)]
    pub(crate) fn index_or_insert(&mut self, row: u32) -> u32 {
        let index = &mut self.indices[row as usize];
        if *index == NONE {
            *index = self.rows.len() as u32;
            self.rows.push(row);
        }
        *index
    }

    /// Returns the rows of the set in increasing order, with their indices.
    pub(super) fn increasing(&self) -> impl Iterator<Item = (u32, u32)> {
        (0..).zip(&self.indices).filter(|(_, index)| **index != NONE).map(|(row, index)| (row, *index))
    }

    /// Returns the rows of the set in the order of their indices.
    pub(crate) fn list(&self) -> &[u32] {
        &self.rows
    }
}

/// Returns the memory of a buffer in bytes, by its capacity.
pub(super) fn buffer_bytes<T>(buffer: &Vec<T>) -> usize {
    buffer.capacity() * size_of::<T>()
}
