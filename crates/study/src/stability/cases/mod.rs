//! The cases, a file for each family.

mod colliders;
mod flight;
mod holds;
mod limits;
mod scales;
mod shapes;
mod starts;
mod stiffness;
mod surfaces;

use super::Case;

/// All cases, family by family.
pub fn cases() -> Vec<Case> {
    let families = [
        stiffness::cases,
        starts::cases,
        holds::cases,
        colliders::cases,
        surfaces::cases,
        shapes::cases,
        scales::cases,
        flight::cases,
        limits::cases,
    ];
    families.into_iter().flat_map(|family| family()).collect()
}
