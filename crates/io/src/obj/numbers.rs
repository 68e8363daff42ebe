//! Parses the numbers of `v` and `vn` statements, and keeps their byte ranges.

use std::ops::Range;

use super::error::ObjProblem;
use super::lines::{Words, decode};

/// Byte ranges of the three numbers of a `v` or `vn` statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Numbers {
    start: usize,
    /// End of the first number, start and end of the second, start and end of the third; relative to `start`.
    ends: [u32; 5],
}

impl Numbers {
    /// Returns the byte range from the start of the first number to the end of the third.
    #[inline]
    pub(crate) fn span(&self) -> Range<usize> {
        self.start..self.start + self.ends[4] as usize
    }

    /// Returns the byte ranges of the three numbers.
    #[inline]
    pub(crate) fn ranges(&self) -> [Range<usize>; 3] {
        let [a, b, c, d, e] = self.ends.map(|end| self.start + end as usize);
        [self.start..a, b..c, d..e]
    }
}

/// Parses the first three numbers of a statement; returns their byte ranges and values.
pub(super) fn three_numbers(
    statement: &'static str,
    raw: &[u8],
    mut words: Words<'_>,
) -> Result<(Numbers, [f64; 3]), ObjProblem> {
    let mut ranges: [Range<usize>; 3] = [0..0, 0..0, 0..0];
    for (found, range) in ranges.iter_mut().enumerate() {
        *range = words.next().ok_or(ObjProblem::TooFewNumbers { statement, needed: 3, found })?;
    }
    let mut values = [0.0; 3];
    for (value, range) in values.iter_mut().zip(&ranges) {
        *value = number(statement, &raw[range.clone()])?;
    }
    let [x, y, z] = ranges;
    let start = x.start;
    // Fails only if the three numbers and the blanks between them are longer than 4 GiB.
    let ends = [x.end, y.start, y.end, z.start, z.end].map(|end| u32::try_from(end - start));
    let [Ok(a), Ok(b), Ok(c), Ok(d), Ok(e)] = ends else { return Err(ObjProblem::TooLarge) };
    Ok((Numbers { start, ends: [a, b, c, d, e] }, values))
}

/// Parses a number. Text that is not a finite number counts as 0, as in programs that skip it.
pub(super) fn finite_or_zero(bytes: &[u8]) -> f32 {
    let number = std::str::from_utf8(bytes).ok().and_then(|text| text.parse::<f32>().ok());
    number.filter(|number| number.is_finite()).unwrap_or(0.0)
}

/// Parses a number in the range of `f32`.
#[inline]
fn number(statement: &'static str, bytes: &[u8]) -> Result<f64, ObjProblem> {
    match std::str::from_utf8(bytes).ok().and_then(|text| text.parse::<f64>().ok()) {
        Some(number) if (number as f32).is_finite() => Ok(number),
        Some(_) => Err(ObjProblem::NotFinite { statement, text: decode(bytes).into_owned() }),
        None => Err(ObjProblem::NotANumber { statement, text: decode(bytes).into_owned() }),
    }
}
