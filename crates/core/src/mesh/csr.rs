//! Stores rows of different lengths in one array (compressed sparse rows, CSR).

/// Rows of items in one array. The items of row `r` are `items[starts[r]..starts[r + 1]]`. The
/// default stands for rows that are not built yet, and allocates nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Csr<T> {
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T> Csr<T> {
    /// Builds the rows from the index of the first item of each row, followed by the number of items, and
    /// from the items.
    ///
    /// # Panics
    ///
    /// If `starts` does not begin with 0, is not sorted, or does not end with the number of items.
    pub(crate) fn from_parts(starts: Vec<u32>, items: Vec<T>) -> Self {
        let in_order = starts.first() == Some(&0) && starts.is_sorted();
        assert!(
            in_order && starts.last().is_some_and(|&end| end as usize == items.len()),
            "`starts` must begin with 0, be sorted, and end with the number of items"
        );
        Self { starts, items }
    }

    /// Returns no rows, with room for some.
    pub(crate) fn with_capacity(rows: usize, items: usize) -> Self {
        let mut starts = Vec::with_capacity(rows + 1);
        starts.push(0);
        Self { starts, items: Vec::with_capacity(items) }
    }

    /// Appends a row. The rows begin as [`with_capacity`](Self::with_capacity): the default is not built yet.
    pub(crate) fn push(&mut self, row: impl IntoIterator<Item = T>) {
        debug_assert!(!self.starts.is_empty(), "rows that are not built yet");
        self.items.extend(row);
        self.starts.push(self.items.len() as u32);
    }

    /// Builds `rows` rows from `(row, item)` entries, by a counting sort. The items of a row keep their
    /// order.
    pub(crate) fn sorted(rows: usize, entries: impl Iterator<Item = (u32, T)> + Clone) -> Self
    where
        T: Copy + Default,
    {
        let mut starts = vec![0_u32; rows + 1];
        entries.clone().for_each(|(row, _)| starts[row as usize + 1] += 1);
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let mut items = vec![T::default(); starts[rows] as usize];
        entries.for_each(|(row, item)| {
            let at = &mut next[row as usize];
            items[*at as usize] = item;
            *at += 1;
        });
        Self { starts, items }
    }

    /// Returns the number of rows.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the items of a row.
    pub(crate) fn row(&self, row: usize) -> &[T] {
        &self.items[self.range(row)]
    }

    /// Returns the items of a row for writing.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [T] {
        let range = self.range(row);
        &mut self.items[range]
    }

    /// Iterates over all rows in order.
    pub(crate) fn rows(&self) -> impl ExactSizeIterator<Item = &[T]> + Clone {
        self.starts.windows(2).map(|ends| &self.items[ends[0] as usize..ends[1] as usize])
    }

    /// Returns the items of all rows, row by row.
    pub(super) fn items(&self) -> &[T] {
        &self.items
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.items)
    }

    /// Converts the rows into the list of all items, row by row.
    pub(crate) fn into_items(self) -> Vec<T> {
        self.items
    }

    /// Returns the row of an item, given its index in [`Csr::items`].
    pub(super) fn row_of(&self, item: usize) -> usize {
        self.starts.partition_point(|&start| start as usize <= item) - 1
    }

    /// Returns the range of the items of a row.
    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }
}
