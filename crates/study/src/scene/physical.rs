//! Converts the materials of a scene to physical units, which do not depend on the lattice and the steps.

use supple::{
    Body, Damping, Elasticity, HalfWidth, Material, Preservation, RegionDamping, RegionSize, Resolution,
    VolumeMeasure, VolumeOptions,
};
use supple_io::counted;
use supple_io::run::{Prepared, RunError, prepare};
use supple_io::scene::{Scene, Substeps};

use super::grid::Grid;
use super::setting::{Dynamics, Method, Setting, Sums};

/// Relative margin of rounding errors in comparisons of stiffnesses.
const ROUNDING: f64 = 1e-9;

/// A scene whose materials are given in lengths and seconds. Its bodies have no elastic damping and do not sleep.
#[derive(Clone, Debug)]
pub(super) struct Physical {
    scene: Scene,
    /// Regions, lattice and stiffness of each body in the original scene.
    grids: Vec<Grid>,
    /// Steps per frame in the original scene.
    pub(super) substeps: u32,
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
        scene.simulation.sleep = false;
        for data in &mut scene.bodies {
            data.material = physical(data.material, dt);
        }
        let grids = (0..scene.bodies.len()).map(|body| Grid::of(simulation.body(body), dt)).collect();
        Ok(Self { scene, grids, substeps })
    }

    /// Returns the regions, lattice and stiffness of each body at a point, before refinement.
    fn grids(&self, dynamics: Dynamics) -> impl Iterator<Item = Grid> {
        self.grids.iter().map(move |grid| grid.with_half_width(dynamics.half_width))
    }

    /// Returns the half-widths of all bodies at a point, in cells.
    pub(super) fn half_widths(&self, dynamics: Dynamics) -> Vec<HalfWidth> {
        let Dynamics { refinement, region_factor, .. } = dynamics;
        let width = |grid: Grid| grid.nearest(grid.refined(refinement).cells() * region_factor);
        self.grids(dynamics).map(width).collect()
    }

    /// Returns the least number of steps per frame in which no body is softer than specified with regions of a
    /// half-width; `None` if the stiffness of a body is that of its regions.
    pub(super) fn needed_substeps(&self, half_width: HalfWidth) -> Option<u32> {
        let dt = 1.0 / (self.scene.simulation.fps * f64::from(self.substeps));
        let alphas = self
            .grids
            .iter()
            .map(|grid| grid.has_modulus().then(|| grid.with_half_width(Some(half_width)).alpha(1.0, dt)));
        let greatest = alphas.collect::<Option<Vec<f64>>>()?.into_iter().fold(0.0, f64::max);
        // alpha grows with the square of the step.
        let needed = f64::from(self.substeps) * greatest.sqrt() * (1.0 - ROUNDING);
        Some(needed.ceil().max(1.0) as u32)
    }

    /// Returns the name of a point, which is unique in a study. It contains the effective refinement: one
    /// number if it is the same for all bodies, otherwise one number for each distinct half-width of the
    /// original scene.
    pub(super) fn name(&self, setting: &Setting) -> String {
        let Dynamics { refinement, region_factor, half_width, substeps, sums } = setting.dynamics;
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
        if let Some(half_width) = half_width {
            name += &format!(", half-width {half_width}");
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
        let widths = self.half_widths(dynamics);
        self.grids(dynamics).zip(widths).fold((0.0, 0.0), |(vertices, visits), (grid, width)| {
            let of_body = grid.vertices as f64 * grid.effective_refinement(dynamics.refinement).powi(3);
            (vertices + of_body, visits + of_body * (2.0 * width.cells() + 1.0).powi(3))
        })
    }

    /// Returns whether steps of `dt` seconds are too long for the stiffness of a body, so that the body is softer than
    /// specified: alpha would exceed 1.
    pub(super) fn softened(&self, dynamics: Dynamics, dt: f64) -> bool {
        self.grids(dynamics).any(|grid| grid.alpha(dynamics.refinement, dt) > 1.0 + ROUNDING)
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
        let dt = 1.0 / (scene.simulation.fps * f64::from(dynamics.substeps));
        let widths = self.half_widths(dynamics);
        for ((data, grid), width) in scene.bodies.iter_mut().zip(self.grids(dynamics)).zip(widths) {
            if grid.refined(dynamics.refinement) != grid.half_width {
                // The radius is a whole number of cells on every lattice, so rounding does not change the
                // material.
                data.resolution = Resolution::CellSize(grid.refined_cell_size(dynamics.refinement));
            }
            let stiffness = grid.stiffness(dynamics.refinement, dt);
            // That of a named material would be lost with it.
            data.material.poisson_ratio = Some(data.material.poisson_ratio());
            data.material.elasticity = Elasticity::Regions { size: RegionSize::Cells(width), stiffness };
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
        free.scene.simulation.gravity = [0.0; 3].into();
        free.scene.colliders.clear();
        for data in &mut free.scene.bodies {
            data.pins.clear();
            data.handles.clear();
            data.material.region_damping = RegionDamping::PerStep(0.0);
        }
        free.prepare(&Setting { dynamics, method: Method::off() })
    }
}

/// Converts the damping of a material to units that do not depend on the step, and removes its elastic damping. The
/// elasticity is unchanged.
fn physical(material: Material, dt: f64) -> Material {
    let region_damping = match material.region_damping {
        // Complete damping in one step has no finite rate, so it stays per step.
        RegionDamping::PerStep(fraction) if fraction < 1.0 => RegionDamping::Rate(-(-fraction).ln_1p() / dt),
        region_damping => region_damping,
    };
    Material { damping: Some(Damping::Ratio(0.0)), region_damping, ..material }
}

#[cfg(test)]
mod tests {
    use supple::ElasticLaw;

    use super::*;
    use crate::elasticity::alpha;
    use crate::scene::setting::Sums;
    use crate::scene::tests as block;

    #[test]
    fn conversion_preserves_the_material_at_the_original_step() {
        for fraction in [0.0, 0.5, 1e-9, 1.0] {
            let before = Material { region_damping: RegionDamping::PerStep(fraction), ..Material::default() };
            let after = physical(before, 0.01);
            let error = (after.region_damping_fraction(0.01) - fraction).abs();
            assert!(error <= 1e-12 * fraction, "{fraction}");
            assert!(after.validate().is_ok());
            assert_eq!((after.elasticity, after.damping()), (before.elasticity, Damping::Ratio(0.0)));
        }
    }

    #[test]
    fn every_point_has_the_youngs_modulus_of_the_scene_unless_it_is_softened() {
        for elasticity in ["", "material = \"jelly\"", "youngs_modulus = 3e7"] {
            let (_directory, physical) = block::physical_with("", 4, &[elasticity]);
            let base = prepare(physical.scene()).unwrap().simulation;
            let specified = base
                .body(0)
                .softened()
                .map_or_else(|| base.body(0).youngs_modulus().unwrap(), |softened| softened.specified);
            let half_width = base.body(0).half_width();
            let mut softened_points = 0;
            for (refinement, region_factor, factor) in
                [(1.0, 1.0, 1), (1.0, 1.0, 3), (1.5, 1.0, 1), (1.5, 1.0, 4), (0.5, 1.0, 2), (1.0, 2.0, 2)]
            {
                let dynamics = Dynamics {
                    refinement,
                    region_factor,
                    half_width: None,
                    substeps: factor * physical.substeps,
                    sums: Sums::Fast,
                };
                let simulation =
                    physical.prepare(&Setting { dynamics, method: Method::off() }).unwrap().simulation;
                let (body, dt) = (simulation.body(0), simulation.dt());
                let softened = physical.softened(dynamics, dt);
                softened_points += u32::from(softened);
                if region_factor == 1.0 {
                    let modulus = body.youngs_modulus().unwrap() / specified;
                    match softened {
                        true => {
                            let greatest = ElasticLaw::greatest_alpha_of(body.material().poisson_ratio());
                            let is_greatest = (alpha(&body, dt) / greatest - 1.0).abs() < 1e-9;
                            assert!(modulus < 1.0 - 1e-9 && is_greatest, "{modulus}");
                        }
                        false => assert!((modulus - 1.0).abs() < 1e-9, "{elasticity}: {modulus}"),
                    }
                } else {
                    let same = Dynamics { region_factor: 1.0, ..dynamics };
                    let same = physical.prepare(&Setting { dynamics: same, method: Method::off() }).unwrap();
                    assert_eq!(alpha(&body, dt), alpha(&same.simulation.body(0), dt));
                    assert!(body.half_width() > half_width);
                }
            }
            assert!(softened_points < 3, "{elasticity}: {softened_points}");
        }
    }

    #[test]
    fn regions_of_any_half_width_have_the_youngs_modulus_of_the_scene_in_the_steps_that_it_needs() {
        let (_directory, physical) = block::physical_with("", 4, &["youngs_modulus = 3e7"]);
        let mut steps = Vec::new();
        for cells in [0.5, 1.0, 2.0, 3.0] {
            let half_width = HalfWidth::from(cells);
            let substeps = physical.needed_substeps(half_width).unwrap();
            let dynamics = Dynamics { half_width: Some(half_width), substeps, ..block::FAST };
            let simulation =
                physical.prepare(&Setting { dynamics, method: Method::off() }).unwrap().simulation;
            let body = simulation.body(0);
            assert_eq!(body.half_width(), half_width);
            assert!((body.youngs_modulus().unwrap() / 3e7 - 1.0).abs() < 1e-9, "{cells}");
            assert!(
                physical.softened(Dynamics { substeps: substeps - 1, ..dynamics }, simulation.dt() * 1.5)
            );
            steps.push(substeps);
        }
        assert!(steps.is_sorted_by(|a, b| a > b), "{steps:?}");
        let (_directory, of_regions) = block::physical(4, &[2]);
        assert_eq!(of_regions.needed_substeps(HalfWidth::CELL), None);
    }

    #[test]
    fn too_few_steps_soften_a_point() {
        let (_directory, physical) = block::physical_with("", 4, &["youngs_modulus = 3e7"]);
        let dynamics = |substeps| Dynamics { substeps, ..block::FAST };
        let dt = |substeps: u32| 1.0 / (30.0 * f64::from(substeps));
        assert!(!physical.softened(dynamics(physical.substeps), dt(physical.substeps)));
        assert!(physical.softened(dynamics(1), dt(1)), "{}", physical.substeps);
    }
}
