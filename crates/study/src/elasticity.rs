//! Computes the stiffness per step and the masses of a body as the steps use them.

use supple::{Body, ElasticLaw, Elasticity};

/// Returns the elastic law of a body for steps of `dt` seconds.
pub(crate) fn elastic_law(body: &Body, dt: f64) -> ElasticLaw {
    let (material, cell_size) = (body.material(), body.lattice().cell_size());
    ElasticLaw { density: material.density, cell_size, dt, poisson_ratio: material.poisson_ratio() }
}

/// Returns alpha, the fraction of the distance to the goal position that a vertex covers in a step of `dt` seconds, of
/// a body in a simulation.
pub(crate) fn alpha(body: &Body, dt: f64) -> f64 {
    let law = elastic_law(body, dt);
    let alpha = match (body.material().elasticity, body.alone().youngs_modulus()) {
        (Elasticity::Regions { stiffness, .. }, _) => stiffness.alpha(dt),
        (_, Some(modulus)) => law.alpha(body.half_width(), modulus),
        (_, None) => 1.0,
    };
    alpha.min(law.greatest_alpha())
}

/// Returns the masses of the vertices of a body in masses of a full cell.
pub(crate) fn relative_masses(body: &Body) -> Vec<f64> {
    let full_cell = body.material().density * body.lattice().cell_size().powi(3);
    body.masses().iter().map(|mass| mass / full_cell).collect()
}
