//! Lists the cases, one file per family.

mod breaking;
mod colliders;
mod flight;
mod holds;
mod limits;
mod materials;
mod pendulums;
mod plastic;
mod scales;
mod shapes;
mod starts;
mod stiffness;
mod surfaces;

use super::case::Case;

/// Creates the cases of a family.
type Cases = fn() -> Vec<Case>;

const FAMILIES: [(&str, Cases); 13] = [
    ("stiffness and time steps", stiffness::cases),
    ("materials", materials::cases),
    ("plastic bodies", plastic::cases),
    ("bodies that break", breaking::cases),
    ("pendulums", pendulums::cases),
    ("start states", starts::cases),
    ("pins and handles", holds::cases),
    ("colliders", colliders::cases),
    ("surfaces", surfaces::cases),
    ("shapes", shapes::cases),
    ("scales and places", scales::cases),
    ("free flight", flight::cases),
    ("largest numbers", limits::cases),
];

/// Returns all cases, grouped by family.
pub fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    for (family, cases) in FAMILIES {
        all.extend(cases().into_iter().map(|case| case.of_family(family)));
    }
    all
}
