//! Keeps the regions and the stiffness of a body on lattices and with steps other than those of the scene.

use supple::{BodyRef, ElasticLaw, Elasticity, HalfWidth, Material, Stiffness};

/// The regions, the lattice and the stiffness of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) half_width: HalfWidth,
    cell_size: f64,
    /// Number of lattice vertices.
    pub(super) vertices: usize,
    stiffness: PhysicalStiffness,
}

/// The stiffness of a body, which does not depend on the step.
#[derive(Clone, Copy, Debug)]
enum PhysicalStiffness {
    /// Frequency in Hz at which a vertex oscillates about a fixed goal position: of a body with regions.
    Frequency(f64),
    /// Young's modulus, in scene units of force per area, and density: of a body with a preset or Young's modulus.
    Modulus { modulus: f64, density: f64, poisson_ratio: f64 },
}

impl Grid {
    /// Reads a body of the original scene, with steps of `dt` seconds.
    pub(super) fn of(body: BodyRef<'_>, dt: f64) -> Self {
        let lattice = body.lattice();
        let Material { elasticity, density, .. } = *body.material();
        let poisson_ratio = body.material().poisson_ratio();
        let stiffness = match elasticity {
            Elasticity::Regions { stiffness, .. } => PhysicalStiffness::Frequency(frequency(stiffness, dt)),
            // If the steps of the scene are too long for the material, the specified modulus counts.
            _ => {
                let modulus = body
                    .softened()
                    .map(|softened| softened.specified / softened.factor)
                    .or(body.youngs_modulus());
                PhysicalStiffness::Modulus { modulus: modulus.unwrap_or_default(), density, poisson_ratio }
            }
        };
        Self {
            half_width: body.half_width(),
            cell_size: lattice.cell_size(),
            vertices: lattice.len(),
            stiffness,
        }
    }

    /// Returns the grid with regions of another half-width, for the same material.
    pub(super) fn with_half_width(self, half_width: Option<HalfWidth>) -> Self {
        Self { half_width: half_width.unwrap_or(self.half_width), ..self }
    }

    /// Returns whether the material has a Young's modulus, whatever the regions.
    pub(super) fn has_modulus(self) -> bool {
        matches!(self.stiffness, PhysicalStiffness::Modulus { .. })
    }

    /// Returns the half-width that gives the same radius of the regions on a lattice with `refinement` times
    /// as many cells per length.
    pub(super) fn refined(self, refinement: f64) -> HalfWidth {
        self.nearest(self.half_width.cells() * refinement)
    }

    /// Returns the half-width nearest to a number of cells: at least 1, or 0.5 for a body whose regions are cells.
    pub(super) fn nearest(self, cells: f64) -> HalfWidth {
        if self.half_width.is_cell() && cells < 0.75 {
            HalfWidth::CELL
        } else {
            cells.round().max(1.0).into()
        }
    }

    /// Returns the refinement closest to `refinement` for which the radius of the regions is a whole number
    /// of cells.
    pub(super) fn effective_refinement(self, refinement: f64) -> f64 {
        self.refined(refinement).cells() / self.half_width.cells()
    }

    /// Returns the edge of a cell of the lattice with [`effective_refinement`](Self::effective_refinement).
    pub(super) fn refined_cell_size(self, refinement: f64) -> f64 {
        self.cell_size * self.half_width.cells() / self.refined(refinement).cells()
    }

    /// Returns alpha in steps of `dt` seconds on a lattice with `refinement` times as many cells per length, as a fraction
    /// of the greatest one of the material. It exceeds 1 if the steps are too long for the material. For regions with
    /// another radius it is the same: they are another material.
    pub(super) fn alpha(self, refinement: f64, dt: f64) -> f64 {
        match self.stiffness {
            // alpha = 2 (1 - cos(2 pi f dt)) is 1 at a sixth of the step rate.
            PhysicalStiffness::Frequency(frequency) if 6.0 * frequency * dt > 1.0 => 6.0 * frequency * dt,
            PhysicalStiffness::Frequency(frequency) => Stiffness::Frequency(frequency).alpha(dt),
            PhysicalStiffness::Modulus { modulus, density, poisson_ratio } => {
                let law =
                    ElasticLaw { density, cell_size: self.refined_cell_size(refinement), dt, poisson_ratio };
                law.alpha(self.refined(refinement), modulus) / law.greatest_alpha()
            }
        }
    }

    /// Returns the stiffness of a body in steps of `dt` seconds.
    pub(super) fn stiffness(self, refinement: f64, dt: f64) -> Stiffness {
        match self.stiffness {
            PhysicalStiffness::Frequency(frequency) => Stiffness::Frequency(frequency),
            PhysicalStiffness::Modulus { poisson_ratio, .. } => {
                let greatest = ElasticLaw::greatest_alpha_of(poisson_ratio);
                Stiffness::PerStep(self.alpha(refinement, dt).min(1.0) * greatest)
            }
        }
    }
}

/// Converts a stiffness to a frequency in Hz.
fn frequency(stiffness: Stiffness, dt: f64) -> f64 {
    match stiffness {
        // A frequency f in Hz gives alpha = 4 sin²(pi f dt).
        Stiffness::PerStep(alpha) => (alpha.sqrt() / 2.0).asin() / (std::f64::consts::PI * dt),
        Stiffness::Frequency(frequency) => frequency,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversion_preserves_the_stiffness_at_the_original_step() {
        for before in [1.0, 0.25, 1e-6, 0.9] {
            let after = Stiffness::Frequency(frequency(Stiffness::PerStep(before), 0.01)).alpha(0.01);
            assert!((after / before - 1.0).abs() < 1e-12, "{before}: {after}");
        }
        let half = Stiffness::Frequency(frequency(Stiffness::PerStep(1.0), 0.01)).alpha(0.005);
        // 4 sin²(pi / 12) = 2 - sqrt(3).
        assert!((half - (2.0 - 3.0_f64.sqrt())).abs() < 1e-12, "{half}");
    }
}
