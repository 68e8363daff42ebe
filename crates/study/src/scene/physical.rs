//! A scene in physical terms, so that lattice and steps can change and the material stays.

use supple::{
    Body, Material, Preservation, RegionDamping, RegionSize, Resolution, Stiffness, VolumeMeasure,
    VolumeOptions,
};
use supple_io::run::{Prepared, RunError, prepare};
use supple_io::scene::{Scene, Substeps};

use super::setting::{Dynamics, Method, Setting, Sums};

/// A scene whose materials are given by lengths and seconds.
#[derive(Clone, Debug)]
pub(super) struct Physical {
    scene: Scene,
    /// Half-width and cell size of each body as the scene has them.
    grids: Vec<Grid>,
    /// Steps a frame as the scene has them.
    pub(super) substeps: u32,
}

/// The regions and the lattice of a body.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// In cells.
    half_width: usize,
    cell_size: f64,
    vertices: usize,
}

impl Grid {
    fn of(body: &Body) -> Self {
        let lattice = body.lattice();
        Self { half_width: body.half_width(), cell_size: lattice.cell_size(), vertices: lattice.len() }
    }

    /// The half-width of the same radius on a lattice with `refinement` times the cells per length.
    fn refined(self, refinement: f64) -> usize {
        ((self.half_width as f64 * refinement).round() as usize).max(1)
    }

    /// What a refinement comes to.
    fn finer(self, refinement: f64) -> f64 {
        self.refined(refinement) as f64 / self.half_width as f64
    }
}

impl Physical {
    /// Builds a scene once, to learn what its resolution and steps come to.
    ///
    /// # Errors
    ///
    /// A scene that cannot be built.
    pub(super) fn new(mut scene: Scene) -> Result<Self, RunError> {
        let Prepared { simulation, substeps, .. } = prepare(&scene)?;
        let dt = simulation.dt();
        for data in &mut scene.bodies {
            data.material = physical(data.material, dt);
        }
        Ok(Self { scene, grids: simulation.bodies().iter().map(Grid::of).collect(), substeps })
    }

    /// The half-widths of all bodies at a refinement, in cells.
    pub(super) fn half_widths(&self, refinement: f64, region_factor: f64) -> Vec<usize> {
        let width = |grid: &Grid| (grid.refined(refinement) as f64 * region_factor).round() as usize;
        self.grids.iter().map(|grid| width(grid).max(1)).collect()
    }

    /// The name of a point, one of a kind in a study: with the refinement that its half-widths come to. Bodies of which these
    /// differ are named one after another, those of one half-width once.
    pub(super) fn name(&self, setting: &Setting) -> String {
        let Dynamics { refinement, region_factor, substeps, sums } = setting.dynamics;
        let mut grids: Vec<Grid> = Vec::new();
        for grid in &self.grids {
            if !grids.iter().any(|other| other.half_width == grid.half_width) {
                grids.push(*grid);
            }
        }
        let finer = |grid: &Grid| format!("{:.2}", grid.finer(refinement));
        let mut cells: Vec<String> = grids.iter().map(finer).collect();
        if cells.iter().all(|other| *other == cells[0]) {
            cells.truncate(1);
        }
        let (method, cells) = (setting.method.name(), cells.join(" and "));
        let mut name = format!("{method}, {cells} x the cells, {substeps} steps");
        if region_factor != 1.0 {
            name += &format!(", {region_factor} x the radius");
        }
        if sums != Sums::Fast {
            name += &format!(", {}", sums.name());
        }
        name
    }

    /// How the scene itself keeps the volume of its first body; by the cells, where not all bodies can do the same.
    pub(super) fn method(&self, body: &Body, usable: &[Method]) -> Method {
        let VolumeOptions { measure, scope, .. } = self.scene.bodies[0].volume;
        let measure = match measure {
            Preservation::Off => return Method::off(),
            // What `auto` has become.
            Preservation::Auto => Preservation::By(body.alone().volume_report().measure),
            measure => measure,
        };
        let method = Method { measure, scope };
        let cells = Method { measure: Preservation::By(VolumeMeasure::Cells), scope };
        if usable.contains(&method) { method } else { cells }
    }

    /// The scene as it is described, in physical terms.
    pub(super) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// About how many lattice vertices a motion has, and how many visits of these by regions the naive sums take.
    pub(super) fn estimate(&self, dynamics: Dynamics) -> (f64, f64) {
        let widths = self.half_widths(dynamics.refinement, dynamics.region_factor);
        self.grids.iter().zip(widths).fold((0.0, 0.0), |(vertices, visits), (grid, width)| {
            let own = grid.vertices as f64 * grid.finer(dynamics.refinement).powi(3);
            (vertices + own, visits + own * (2.0 * width as f64 + 1.0).powi(3))
        })
    }

    /// Whether steps of `dt` seconds are longer than a sixth of a body's period, so that it is softer than asked.
    pub(super) fn softened(&self, dt: f64) -> bool {
        let too_fast = |stiffness| match stiffness {
            Stiffness::Frequency(frequency) => frequency * dt > (1.0 + 1e-9) / 6.0,
            Stiffness::PerStep(_) => false,
        };
        self.scene.bodies.iter().any(|body| too_fast(body.material.stiffness))
    }

    /// Builds a point.
    ///
    /// # Errors
    ///
    /// A lattice that does not fit in memory, a handle that takes nothing on this lattice.
    pub(super) fn prepare(&self, setting: &Setting) -> Result<Prepared, RunError> {
        let Setting { dynamics, method } = *setting;
        let mut scene = self.scene.clone();
        scene.simulation.substeps = Substeps::Fixed(dynamics.substeps);
        let widths = self.half_widths(dynamics.refinement, dynamics.region_factor);
        for ((data, grid), width) in scene.bodies.iter_mut().zip(&self.grids).zip(widths) {
            let refined = grid.refined(dynamics.refinement);
            if refined != grid.half_width {
                // The radius is a whole number of cells on every lattice, so that rounding changes no material.
                let cell_size = grid.cell_size * grid.half_width as f64 / refined as f64;
                data.resolution = Resolution::CellSize(cell_size);
            }
            data.material.region_size = RegionSize::Cells(width);
            data.volume = VolumeOptions { measure: method.measure, scope: method.scope, ..data.volume };
        }
        prepare(&scene)
    }

    /// The same bodies in free flight: held by nothing, among nothing, without gravity, undamped.
    ///
    /// # Errors
    ///
    /// As [`Physical::prepare`].
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

/// The same material in terms that do not change with the step.
fn physical(material: Material, dt: f64) -> Material {
    let stiffness = match material.stiffness {
        // alpha = 4 sin²(pi f dt).
        Stiffness::PerStep(alpha) => {
            Stiffness::Frequency((alpha.sqrt() / 2.0).asin() / (std::f64::consts::PI * dt))
        }
        frequency @ Stiffness::Frequency(_) => frequency,
    };
    let region_damping = match material.region_damping {
        // All at once is no rate.
        RegionDamping::PerStep(share) if share < 1.0 => RegionDamping::Rate(-(-share).ln_1p() / dt),
        region_damping => region_damping,
    };
    Material { stiffness, region_damping, ..material }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_the_step_of_the_scene_the_material_is_the_same() {
        for (alpha, share) in [(1.0, 0.0), (0.25, 0.5), (1e-6, 1e-9), (0.9, 1.0)] {
            let before = Material {
                stiffness: Stiffness::PerStep(alpha),
                region_damping: RegionDamping::PerStep(share),
                ..Material::default()
            };
            let after = physical(before, 0.01);
            assert!((after.alpha(0.01) / alpha - 1.0).abs() < 1e-12, "{alpha}: {}", after.alpha(0.01));
            assert!((after.region_damping_share(0.01) - share).abs() <= 1e-12 * share, "{share}");
            assert!(after.validate().is_ok());
        }
        let half = physical(Material::default(), 0.01).alpha(0.005);
        // 4 sin²(pi / 12) = 2 - sqrt(3).
        assert!((half - (2.0 - 3.0_f64.sqrt())).abs() < 1e-12, "{half}");
    }
}
