//! The results of scenes have the bits that every machine gives.

use supple_tests::{BITS_TABLE, differences, hashes_of_scenes, root};

/// If a change of results is intended, `SUPPLE_WRITE=1 cargo run -p supple-tests --bin bits` writes the table anew.
#[test]
fn scenes_have_the_recorded_bits() {
    let differences = differences(&root(), &hashes_of_scenes(&root()));
    assert!(differences.is_empty(), "{BITS_TABLE}: {differences:#?}");
}
