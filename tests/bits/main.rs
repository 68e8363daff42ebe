//! Compares the results of scenes with the hashes in `hashes.txt`, which are the same on every machine:
//! `bits [ROOT]`, where `ROOT` is the top directory of the project. It has no other dependencies than the tested crates,
//! so that it can be built for any processor: see scripts/bits. `SUPPLE_WRITE=1` writes the hashes anew. It
//! does nothing at a SIMD level that the processor does not have.

#![allow(clippy::print_stdout, reason = "a table for the reader")]

use std::path::Path;
use std::process::ExitCode;

use supple_tests::{BITS_TABLE, differences, hashes_of_scenes};

fn main() -> ExitCode {
    if let Err(error) = supple::check_simd_request() {
        println!("left out: {error}");
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
    let differences = differences(root, &found);
    differences.iter().for_each(|row| println!("{row}"));
    let outcome = if differences.is_empty() { "the recorded bits" } else { "OTHER BITS" };
    println!("{} {}: {} scenes, {outcome}", std::env::consts::ARCH, supple::simd_level(), found.len());
    if differences.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
