//! Codes the integers and bytes of the structure of a crate file.
//!
//! ```text
//! integers  ->  differences  ->  common difference, codes of two bits, the other differences  ->  bytes
//! bytes     ->  chunks of LZ4
//! ```
//!
//! The chunks contain literals only, which is valid LZ4: the structure has a few kilobytes, whatever the number of
//! frames.

/// The difference that needs no bytes: consecutive indices have it.
const COMMON: i32 = 1;

/// Largest number of literals whose length is in the first byte of an LZ4 sequence.
const SHORT: usize = 15;

/// Codes 32-bit integers as differences from their predecessors. The first one differs from 0.
pub(super) fn code_integers(integers: impl ExactSizeIterator<Item = u32>) -> Vec<u8> {
    let mut codes = vec![0_u8; integers.len().div_ceil(4)];
    let mut differences = Vec::new();
    let mut previous = 0_i32;
    for (index, integer) in integers.enumerate() {
        let difference = (integer as i32).wrapping_sub(previous);
        previous = integer as i32;
        let code = if difference == COMMON {
            0
        } else if let Ok(byte) = i8::try_from(difference) {
            differences.extend(byte.to_le_bytes());
            1
        } else if let Ok(word) = i16::try_from(difference) {
            differences.extend(word.to_le_bytes());
            2
        } else {
            differences.extend(difference.to_le_bytes());
            3
        };
        codes[index / 4] |= code << (2 * (index % 4));
    }
    [&COMMON.to_le_bytes()[..], &codes, &differences].concat()
}

/// Stores bytes as one LZ4 chunk of literals. A chunk is preceded by the number of further chunks, 0.
pub(super) fn lz4(bytes: &[u8]) -> Vec<u8> {
    let mut chunk = vec![0, (bytes.len().min(SHORT) as u8) << 4];
    if let Some(mut more) = bytes.len().checked_sub(SHORT) {
        while more >= 255 {
            chunk.push(255);
            more -= 255;
        }
        chunk.push(more as u8);
    }
    chunk.extend_from_slice(bytes);
    chunk
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Decodes integers, by the description of the code.
    fn decode(bytes: &[u8], count: usize) -> Vec<u32> {
        let common = i32::from_le_bytes(bytes[..4].try_into().unwrap());
        let (codes, mut rest) = bytes[4..].split_at(count.div_ceil(4));
        let mut previous = 0_i32;
        let mut take = |length: usize| {
            let (taken, after) = rest.split_at(length);
            rest = after;
            let sign = if taken[length - 1] >= 128 { 255 } else { 0 };
            i32::from_le_bytes(std::array::from_fn(|byte| *taken.get(byte).unwrap_or(&sign)))
        };
        let mut integers = Vec::new();
        for index in 0..count {
            let difference = match codes[index / 4] >> (2 * (index % 4)) & 3 {
                0 => common,
                code => take(1 << (code - 1)),
            };
            previous = previous.wrapping_add(difference);
            integers.push(previous as u32);
        }
        assert!(rest.is_empty());
        integers
    }

    proptest! {
        #[test]
        fn integers_are_decoded_from_their_code(
            integers: Vec<u32>,
            small in proptest::collection::vec(0_u32..400, 0..40),
        ) {
            for integers in [integers, small] {
                let code = code_integers(integers.iter().copied());
                prop_assert_eq!(decode(&code, integers.len()), integers);
            }
        }

        #[test]
        fn chunks_have_the_length_of_their_literals(length in 0_usize..2000) {
            let bytes: Vec<u8> = (0..length).map(|byte| byte as u8).collect();
            let chunk = lz4(&bytes);
            prop_assert_eq!(chunk[0], 0);
            prop_assert_eq!(chunk[1] & 15, 0, "no match follows");
            let mut found = usize::from(chunk[1] >> 4);
            let mut at = 2;
            if found == SHORT {
                loop {
                    found += usize::from(chunk[at]);
                    at += 1;
                    if chunk[at - 1] < 255 {
                        break;
                    }
                }
            }
            prop_assert_eq!(found, length);
            prop_assert_eq!(&chunk[at..], &bytes[..]);
        }
    }
}
