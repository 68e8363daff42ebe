//! Arrays that do not fit a body.

/// An array with the wrong length or an invalid value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArrayError {
    /// A wrong number of entries.
    #[error("{name} has {count} entries; the body has {expected} lattice vertices")]
    Length {
        /// Name of the array.
        name: &'static str,
        /// Number of entries.
        count: usize,
        /// Number of lattice vertices of the body.
        expected: usize,
    },
    /// A number that is not finite.
    #[error("{name}[{index}] = {value:?} is not finite")]
    NotFinite {
        /// Name of the array.
        name: &'static str,
        /// Index of the entry.
        index: usize,
        /// Value of the entry.
        value: [f64; 3],
    },
    /// A coordinate beyond 10^15 cells, or a velocity component beyond 10^15 cells/s.
    #[error("{name}[{index}] = {value:?} is too large: the limit is {limit:.3e}, 10^15 cells")]
    TooFar {
        /// Name of the array.
        name: &'static str,
        /// Index of the entry.
        index: usize,
        /// Value of the entry.
        value: [f64; 3],
        /// Greatest valid magnitude of a component, in the units of `value`.
        limit: f64,
    },
}
