//! The results of scenes have the bits that every machine gives.

use supple_tests::{BITS_TABLE, hashes_of_scenes, recorded_hashes, root};

/// If a change of results is intended, `SUPPLE_WRITE=1 cargo run -p supple-tests --bin bits` writes the table anew.
#[test]
fn scenes_have_the_recorded_bits() {
    let (found, recorded) = (hashes_of_scenes(&root()), recorded_hashes(&root()));
    assert!(found.len() >= 12, "{} scenes", found.len());
    let names = |rows: &[(String, String)]| rows.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&found), names(&recorded), "the scenes of {BITS_TABLE}");
    let other: Vec<_> = found.iter().filter(|row| !recorded.contains(row)).collect();
    assert!(other.is_empty(), "{BITS_TABLE} has other bits of {other:?}");
}
