//! Lists the cases, one file per family.

mod bending;
mod contact;
mod decay;
mod hanging;
mod modes;
mod moduli;
mod pressed;
mod released;
mod rest;
mod rolling;
mod speed;
mod units;

use super::case::Case;

/// Creates the cases of a family.
type Cases = fn() -> Vec<Case>;

const FAMILIES: [(&str, Cases); 12] = [
    ("hanging bar", hanging::cases),
    ("moduli", moduli::cases),
    ("free bar", modes::cases),
    ("cantilever", bending::cases),
    ("stretched and dropped", released::cases),
    ("decay", decay::cases),
    ("rest", rest::cases),
    ("ball", rolling::cases),
    ("units", units::cases),
    ("contact", contact::cases),
    ("pressed", pressed::cases),
    ("run time", speed::cases),
];

/// Returns all cases, grouped by family.
pub fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    for (family, cases) in FAMILIES {
        all.extend(cases().into_iter().map(|case| case.of_family(family)));
    }
    all
}
