//! Rows that are numbered as they come.

/// No number.
const NONE: u32 = u32::MAX;

/// Some of all rows, in the order in which they were first named.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbered {
    rows: Vec<u32>,
    /// For each row, where it stands among them.
    numbers: Vec<u32>,
}

impl Numbered {
    /// None yet, of so many.
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: Vec::new(), numbers: vec![NONE; rows] }
    }

    /// None, of so many; keeps its room.
    pub(super) fn resize(&mut self, rows: usize) {
        self.clear();
        self.numbers.resize(rows, NONE);
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.rows) + size_of_val(&*self.numbers)
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        for row in self.rows.drain(..) {
            self.numbers[row as usize] = NONE;
        }
    }

    /// The number of a row: the next one if it was not named before.
    #[inline(always)]
    pub(super) fn number(&mut self, row: u32) -> u32 {
        let number = &mut self.numbers[row as usize];
        if *number == NONE {
            *number = self.rows.len() as u32;
            self.rows.push(row);
        }
        *number
    }

    /// The rows, by number.
    pub(super) fn list(&self) -> &[u32] {
        &self.rows
    }
}
