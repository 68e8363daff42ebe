//! Converts the materials of a scene to physical units, which do not depend on the lattice and the steps.

use supple::{
    Body, Material, Preservation, RegionDamping, RegionSize, Resolution, Stiffness, VolumeMeasure,
    VolumeOptions,
};
use supple_io::counted;
use supple_io::run::{Prepared, RunError, prepare};
use supple_io::scene::{Scene, Substeps};

use super::setting::{Dynamics, Method, Setting, Sums};

/// A scene whose materials are given in lengths and seconds.
#[derive(Clone, Debug)]
pub(super) struct Physical {
    scene: Scene,
    /// Regions and lattice of each body in the original scene.
    grids: Vec<Grid>,
    /// Steps per frame in the original scene.
    pub(super) substeps: u32,
}

/// The regions and the lattice of a body.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// Half-width in cells.
    half_width: usize,
    cell_size: f64,
    /// Number of lattice vertices.
    vertices: usize,
}

impl Grid {
    fn of(body: &Body) -> Self {
        let lattice = body.lattice();
        Self { half_width: body.half_width(), cell_size: lattice.cell_size(), vertices: lattice.len() }
    }

    /// Returns the half-width that gives the same radius of the regions on a lattice with `refinement` times
    /// as many cells per length.
    fn refined(self, refinement: f64) -> usize {
        ((self.half_width as f64 * refinement).round() as usize).max(1)
    }

    /// Returns the refinement closest to `refinement` for which the radius of the regions is a whole number
    /// of cells.
    fn effective_refinement(self, refinement: f64) -> f64 {
        self.refined(refinement) as f64 / self.half_width as f64
    }
}

impl Physical {
    /// Builds a scene to determine its cell sizes and steps, and converts its materials.
    ///
    /// # Errors
    ///
    /// Returns an error if the scene cannot be built.
    pub(super) fn new(mut scene: Scene) -> Result<Self, RunError> {
        let Prepared { simulation, substeps, .. } = prepare(&scene)?;
        let dt = simulation.dt();
        for data in &mut scene.bodies {
            data.material = physical(data.material, dt);
        }
        Ok(Self { scene, grids: simulation.bodies().iter().map(Grid::of).collect(), substeps })
    }

    /// Returns the half-widths of all bodies, in cells.
    pub(super) fn half_widths(&self, refinement: f64, region_factor: f64) -> Vec<usize> {
        let width = |grid: &Grid| (grid.refined(refinement) as f64 * region_factor).round() as usize;
        self.grids.iter().map(|grid| width(grid).max(1)).collect()
    }

    /// Returns the name of a point, which is unique in a study. It contains the effective refinement: one
    /// number if it is the same for all bodies, otherwise one number for each distinct half-width of the
    /// original scene.
    pub(super) fn name(&self, setting: &Setting) -> String {
        let Dynamics { refinement, region_factor, substeps, sums } = setting.dynamics;
        let mut grids: Vec<Grid> = Vec::new();
        for grid in &self.grids {
            if !grids.iter().any(|other| other.half_width == grid.half_width) {
                grids.push(*grid);
            }
        }
        let effective_refinement = |grid: &Grid| format!("{:.2}", grid.effective_refinement(refinement));
        let mut cells: Vec<String> = grids.iter().map(effective_refinement).collect();
        if cells.iter().all(|other| *other == cells[0]) {
            cells.truncate(1);
        }
        let (method, cells) = (setting.method.name(), cells.join(" and "));
        let mut name = format!("{method}, {cells} x the cells, {}", counted(substeps as usize, "step"));
        if region_factor != 1.0 {
            name += &format!(", {region_factor} x the radius");
        }
        if sums != Sums::Fast {
            name += &format!(", {}", sums.name());
        }
        name
    }

    /// Returns the method of volume preservation of the first body of the scene. If not all bodies support
    /// its measure, the measure is replaced by `cells`.
    pub(super) fn method(&self, body: &Body, usable: &[Method]) -> Method {
        let VolumeOptions { measure, scope, .. } = self.scene.bodies[0].volume;
        let measure = match measure {
            Preservation::Off => return Method::off(),
            // The measure that `auto` resolves to.
            Preservation::Auto => Preservation::By(body.alone().volume_report().measure),
            measure => measure,
        };
        let method = Method { measure, scope };
        let cells = Method { measure: Preservation::By(VolumeMeasure::Cells), scope };
        if usable.contains(&method) { method } else { cells }
    }

    /// Returns the scene with physical materials.
    pub(super) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Estimates the number of lattice vertices, and the number of visits (pairs of a region and a vertex in
    /// it) in one evaluation of the naive sums.
    pub(super) fn estimate(&self, dynamics: Dynamics) -> (f64, f64) {
        let widths = self.half_widths(dynamics.refinement, dynamics.region_factor);
        self.grids.iter().zip(widths).fold((0.0, 0.0), |(vertices, visits), (grid, width)| {
            let of_body = grid.vertices as f64 * grid.effective_refinement(dynamics.refinement).powi(3);
            (vertices + of_body, visits + of_body * (2.0 * width as f64 + 1.0).powi(3))
        })
    }

    /// Returns whether steps of `dt` seconds are longer than a sixth of the period of a body, so that the
    /// body is softer than specified.
    pub(super) fn softened(&self, dt: f64) -> bool {
        let too_fast = |stiffness| match stiffness {
            Stiffness::Frequency(frequency) => frequency > (1.0 + 1e-9) * (1.0 / (6.0 * dt)),
            Stiffness::PerStep(_) => false,
        };
        self.scene.bodies.iter().any(|body| matches!(body.material.elasticity, supple::Elasticity::Regions { stiffness, .. } if too_fast(stiffness)))
    }

    /// Builds a point of the study.
    ///
    /// # Errors
    ///
    /// Returns an error if the lattice does not fit in memory, or if a selection is empty on this lattice.
    pub(super) fn prepare(&self, setting: &Setting) -> Result<Prepared, RunError> {
        let Setting { dynamics, method } = *setting;
        let mut scene = self.scene.clone();
        scene.simulation.substeps = Substeps::Fixed(dynamics.substeps);
        let widths = self.half_widths(dynamics.refinement, dynamics.region_factor);
        for ((data, grid), width) in scene.bodies.iter_mut().zip(&self.grids).zip(widths) {
            let refined = grid.refined(dynamics.refinement);
            if refined != grid.half_width {
                // The radius is a whole number of cells on every lattice, so rounding does not change the
                // material.
                let cell_size = grid.cell_size * grid.half_width as f64 / refined as f64;
                data.resolution = Resolution::CellSize(cell_size);
            }
            data.material.elasticity = data.material.elasticity.with_region_size(RegionSize::Cells(width));
            data.volume = VolumeOptions { measure: method.measure, scope: method.scope, ..data.volume };
        }
        prepare(&scene)
    }

    /// Builds the bodies of a point for free flight: without constraints, colliders, gravity and damping.
    ///
    /// # Errors
    ///
    /// See [`Physical::prepare`].
    pub(super) fn prepare_free(&self, dynamics: Dynamics) -> Result<Prepared, RunError> {
        let mut free = self.clone();
        free.scene.simulation.gravity = [0.0; 3];
        free.scene.colliders.clear();
        for data in &mut free.scene.bodies {
            data.pins.clear();
            data.handles.clear();
            data.material.region_damping = RegionDamping::PerStep(0.0);
        }
        free.prepare(&Setting { dynamics, method: Method::off() })
    }
}

/// Converts a material to units that do not depend on the step.
fn physical(material: Material, dt: f64) -> Material {
    let supple::Elasticity::Regions { size, stiffness } = material.elasticity else { return material };
    let stiffness = match stiffness {
        // A frequency f in Hz gives alpha = 4 sin²(pi f dt).
        Stiffness::PerStep(alpha) => {
            Stiffness::Frequency((alpha.sqrt() / 2.0).asin() / (std::f64::consts::PI * dt))
        }
        frequency @ Stiffness::Frequency(_) => frequency,
    };
    let region_damping = match material.region_damping {
        // Complete damping in one step has no finite rate, so it stays per step.
        RegionDamping::PerStep(fraction) if fraction < 1.0 => RegionDamping::Rate(-(-fraction).ln_1p() / dt),
        region_damping => region_damping,
    };
    Material { elasticity: supple::Elasticity::Regions { size, stiffness }, region_damping, ..material }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversion_preserves_the_material_at_the_original_step() {
        for (alpha, fraction) in [(1.0, 0.0), (0.25, 0.5), (1e-6, 1e-9), (0.9, 1.0)] {
            let before = Material {
                stiffness: Stiffness::PerStep(alpha),
                region_damping: RegionDamping::PerStep(fraction),
                ..Material::default()
            };
            let after = physical(before, 0.01);
            assert!((after.alpha(0.01) / alpha - 1.0).abs() < 1e-12, "{alpha}: {}", after.alpha(0.01));
            let error = (after.region_damping_fraction(0.01) - fraction).abs();
            assert!(error <= 1e-12 * fraction, "{fraction}");
            assert!(after.validate().is_ok());
        }
        let half = physical(Material::default(), 0.01).alpha(0.005);
        // 4 sin²(pi / 12) = 2 - sqrt(3).
        assert!((half - (2.0 - 3.0_f64.sqrt())).abs() < 1e-12, "{half}");
    }
}
