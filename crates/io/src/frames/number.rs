//! Formats numbers as the shortest text that reads back exactly.

/// Appends the shortest decimal text that reads back as the same finite `f32`: `0.1`, `-3`, `1.5e-7`, `-0`.
#[inline]
pub(super) fn append(text: &mut Vec<u8>, number: f32) {
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format_finite(number).as_bytes();
    if number.abs() < 1e9 {
        text.extend_from_slice(digits.strip_suffix(b".0").unwrap_or(digits));
    } else {
        // `zmij` writes numbers from 1e9 as `1e+30` or `1000000000.0`.
        let digits = digits.strip_suffix(b".0").unwrap_or(digits);
        text.extend(digits.iter().filter(|&&digit| digit != b'+'));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    fn text(number: f32) -> String {
        let mut text = Vec::new();
        super::append(&mut text, number);
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn known_numbers_have_the_shortest_text() {
        for (number, expected) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (1.0, "1"),
            (-3.5, "-3.5"),
            (0.1, "0.1"),
            (100.0, "100"),
            (1e30, "1e30"),
        ] {
            assert_eq!(text(number), expected);
        }
        assert_eq!(text(16_777_216.0), "16777216");
    }

    proptest! {
        #[test]
        fn every_finite_number_reads_back_from_the_shortest_text(bits: u32) {
            let number = f32::from_bits(bits);
            prop_assume!(number.is_finite());
            let written = text(number);
            prop_assert_eq!(written.parse::<f32>().unwrap().to_bits(), bits);
            // The text has as many digits as the shortest text of the standard library.
            let digits = |text: &str| {
                let mantissa = text.split('e').next().unwrap().replace(['.', '-'], "");
                mantissa.trim_matches('0').len()
            };
            prop_assert_eq!(digits(&written), digits(&number.to_string()));
        }
    }
}
