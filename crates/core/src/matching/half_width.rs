//! The half-width of the regions.

use std::fmt;

use crate::range::Range;

/// Half-width w of the regions in cells: 1/2, or a whole number of at least 1.
///
/// A region has 2 w + 1 vertices along each axis. With w = 1/2 each region is a cell with its 8 corners; otherwise it
/// has the vertices up to w links from its center vertex along each axis (Rivers & James 2007). Regions of one cell
/// have Young's modulus and Poisson's ratio as asked at every thickness, and need the shortest steps.
///
/// Any number can be converted; [`Material::validate`](crate::Material::validate) refuses those that are no half-width.
///
/// ```
/// use supple::HalfWidth;
///
/// assert_eq!(HalfWidth::from(2), 2);
/// assert_eq!(HalfWidth::CELL.cells(), 0.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct HalfWidth(f64);

impl HalfWidth {
    /// The half-width 1/2: each region is a cell.
    pub const CELL: Self = Self(0.5);

    /// Returns the half-width of whole cells.
    pub(crate) const fn whole(cells: usize) -> Self {
        Self(cells as f64)
    }

    /// Returns the number of cells.
    pub fn cells(self) -> f64 {
        self.0
    }

    /// Returns the number of cells if it is whole.
    pub fn whole_cells(self) -> Option<usize> {
        (self.0.fract() == 0.0).then_some(self.0 as usize)
    }

    /// Returns whether each region is a cell.
    pub fn is_cell(self) -> bool {
        self == Self::CELL
    }

    /// Returns whether this is a half-width: 1/2, or a whole number of at least 1.
    pub fn is_valid(self) -> bool {
        Range::HALF_WIDTH.contains(self.0)
    }

    /// Returns the greatest number of links between the place where the sums of a region are stored and a vertex of the
    /// region, along an axis: see [`cascade`](super::cascade).
    pub(crate) fn links(self) -> usize {
        self.0.ceil() as usize
    }

    /// Returns the radius √(w (w + 1)) of the regions in cells: the length R over which they resist, over the cell size.
    pub fn radius(self) -> f64 {
        (self.0 * (self.0 + 1.0)).sqrt()
    }

    /// Returns the second moment w (w + 1)/3 of a window, in squared cells.
    pub(crate) fn moment(self) -> f64 {
        self.0 * (self.0 + 1.0) / 3.0
    }
}

/// A number; in text a whole one has no point.
#[cfg(feature = "serde")]
impl serde::Serialize for HalfWidth {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.whole_cells().filter(|_| serializer.is_human_readable()) {
            Some(cells) => serializer.serialize_u64(cells as u64),
            None => serializer.serialize_f64(self.0),
        }
    }
}

impl From<usize> for HalfWidth {
    fn from(cells: usize) -> Self {
        Self::whole(cells)
    }
}

impl From<f64> for HalfWidth {
    fn from(cells: f64) -> Self {
        Self(cells)
    }
}

impl PartialEq<usize> for HalfWidth {
    fn eq(&self, cells: &usize) -> bool {
        self.0 == *cells as f64
    }
}

impl fmt::Display for HalfWidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
