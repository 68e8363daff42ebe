//! Parses the corners of `f` statements: `v`, `v/vt`, `v//vn` or `v/vt/vn`.

/// The indices of a corner as written in the file. Positive indices count from 1. Negative indices count
/// back, and -1 is the last element above the line. 0 is invalid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub(super) vertex: i64,
    pub(super) texture: Option<i64>,
    pub(super) normal: Option<i64>,
}

/// Parses a corner. Returns `None` if the text does not have one of the four forms. Indices beyond `i64`
/// saturate.
///
/// An empty texture or normal index (`1/`, `1//`) counts as absent.
#[inline]
pub(super) fn parse(text: &[u8]) -> Option<Corner> {
    let (vertex, rest) = integer(text)?;
    let (texture, rest) = optional(rest)?;
    let (normal, rest) = optional(rest)?;
    rest.is_empty().then_some(Corner { vertex: vertex?, texture, normal })
}

/// Parses a `/` followed by an optional integer, or empty text. Returns the integer and the text after it.
fn optional(text: &[u8]) -> Option<(Option<i64>, &[u8])> {
    match text {
        [] => Some((None, text)),
        [b'/', rest @ ..] => integer(rest),
        _ => None,
    }
}

/// Parses an optional integer that ends at a `/` or at the end of the text. Returns the integer and the text
/// after it, or `None` if there are other characters.
fn integer(text: &[u8]) -> Option<(Option<i64>, &[u8])> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let mut value = 0_i64;
    let mut length = 0;
    for &byte in digits.iter().take_while(|byte| byte.is_ascii_digit()) {
        value = value.saturating_mul(10).saturating_add(i64::from(byte - b'0'));
        length += 1;
    }
    match (length, digits.get(length)) {
        (0, None | Some(b'/')) if digits.len() == text.len() => Some((None, digits)),
        (1.., None | Some(b'/')) => Some((Some(if negative { -value } else { value }), &digits[length..])),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_four_corner_forms_parse() {
        let corner = |vertex, texture, normal| Some(Corner { vertex, texture, normal });
        assert_eq!(parse(b"7"), corner(7, None, None));
        assert_eq!(parse(b"-7/+2"), corner(-7, Some(2), None));
        assert_eq!(parse(b"7//-3"), corner(7, None, Some(-3)));
        assert_eq!(parse(b"7/8/9"), corner(7, Some(8), Some(9)));
        assert_eq!(parse(b"7/"), corner(7, None, None));
        assert_eq!(parse(b"7//"), corner(7, None, None));
        assert_eq!(parse(b"99999999999999999999"), corner(i64::MAX, None, None));
        for bad in ["", "/", "/1", "-", "-/1", "1/-", "1.5", "1/2/3/4", "a", "1a", "1/2/3/", "--1", "\u{661}"]
        {
            assert_eq!(parse(bad.as_bytes()), None, "{bad}");
        }
    }
}
