//! Selects the pairs of bodies that may touch.

/// Pairs of bodies that can touch.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactFilter {
    /// Whether different bodies touch each other.
    pub between: bool,
    /// The bodies that touch themselves, in increasing order.
    pub with_itself: Vec<u32>,
    /// Pairs of bodies that do not touch, the lesser index first, in increasing order.
    pub ignored: Vec<(u32, u32)>,
    /// What each body is, for bodies that touch soft bodies alone. Empty if there is none.
    pub kinds: Vec<ContactKind>,
}

/// Whether a body is rigid, and what it touches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactKind {
    pub is_rigid: bool,
    /// Whether it touches soft bodies alone.
    pub soft_only: bool,
}

impl ContactFilter {
    /// Returns whether a body touches another one, or itself.
    pub(super) fn may_touch(&self, body: u32, other: u32) -> bool {
        match body == other {
            true => self.with_itself.binary_search(&body).is_ok(),
            false => {
                self.between
                    && self.ignored.binary_search(&(body.min(other), body.max(other))).is_err()
                    && self.kinds_touch(body, other)
            }
        }
    }

    fn kinds_touch(&self, body: u32, other: u32) -> bool {
        let kind = |index: u32| self.kinds.get(index as usize);
        let (Some(a), Some(b)) = (kind(body), kind(other)) else { return true };
        !(a.soft_only && b.is_rigid || b.soft_only && a.is_rigid)
    }
}
