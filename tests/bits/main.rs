//! Compares the results of scenes with the hashes in `hashes.txt`, which are the same on every machine:
//! `bits [ROOT]`, where `ROOT` is the top directory of the project. It has no other dependencies than the tested crates,
//! so that it can be built for any processor: see scripts/bits. `SUPPLE_WRITE=1` writes the hashes anew. It
//! does nothing at a SIMD level that the processor does not have.

#![allow(clippy::print_stdout, reason = "a table for the reader")]

use std::path::Path;
use std::process::ExitCode;

use supple_tests::{BITS_TABLE, hashes_of_scenes, recorded_hashes};

fn main() -> ExitCode {
    if supple::check_simd_request().is_err() {
        return ExitCode::SUCCESS;
    }
    let root = std::env::args_os().nth(1).unwrap_or_else(|| ".".into());
    let root = Path::new(&root);
    let found = hashes_of_scenes(root);
    if std::env::var_os("SUPPLE_WRITE").is_some() {
        let lines: String = found.iter().map(|(scene, hash)| format!("{scene} {hash}\n")).collect();
        std::fs::write(root.join(BITS_TABLE), lines).expect("the table can be written");
        return ExitCode::SUCCESS;
    }
    let recorded = recorded_hashes(root);
    for row in found.iter().filter(|row| !recorded.contains(row)) {
        println!("{}: other bits ({}) than in {BITS_TABLE}", row.0, row.1);
    }
    let same = found == recorded;
    let outcome = if same { "the same bits" } else { "DIFFERENT" };
    println!("{} {}: {} scenes, {outcome}", std::env::consts::ARCH, supple::simd_level(), found.len());
    if same { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
