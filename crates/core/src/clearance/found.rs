//! The list of limits that are found.

use crate::sparse_set::SparseSet;
use crate::volume::{Limit, Limits};

/// The limits of all obstacles, and a table of those of the present one.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) limits: Limits,
    /// Keys of the limits of the present obstacle.
    keys: SparseSet,
    /// Index in `limits` of the first limit of the present obstacle.
    first: usize,
}

impl Found {
    /// Begins an obstacle, whose limits have keys below `keys`.
    pub(super) fn begin(&mut self, keys: usize) {
        self.keys.resize(keys);
        self.first = self.limits.list().len();
    }

    /// Adds a limit, which has its key in common with those that it replaces: of these, the one with the least clearance
    /// counts. Of several with the same clearance, the direction of the sum of their normals counts.
    pub(super) fn add(&mut self, key: u32, limit: Limit) {
        let index = self.first + self.keys.index_or_insert(key) as usize;
        let limits = self.limits.list_mut();
        match limits.get_mut(index) {
            None => limits.push(limit),
            Some(found) if limit.clearance < found.clearance => *found = limit,
            Some(found) if limit.clearance == found.clearance => found.normal += limit.normal,
            Some(_) => {}
        }
    }

    /// Ends the obstacle. Returns whether it has limits.
    pub(super) fn end(&mut self) -> bool {
        let limits = &mut self.limits.list_mut()[self.first..];
        for limit in &mut *limits {
            limit.normal = limit.normal.try_normalize(0.0).unwrap_or(limit.normal);
            limit.clearance = limit.clearance.max(0.0);
        }
        !limits.is_empty()
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.limits.bytes() + self.keys.bytes()
    }
}
