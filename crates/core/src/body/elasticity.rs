//! The material in force: Young's modulus and the half-width of the regions, which are fixed when a body joins a
//! simulation.

use super::parts::Pipeline;
use super::proportions::Proportions;
use super::soft_body::Body;
use crate::contact::Colliders;
use crate::dynamics::{
    Accuracy, Damping, DampingRates, ElasticLaw, Elasticity, Material, MomentumTracker, RegionDamper,
    RegionSize, Stiffness, StiffnessFactors, half_width_of, lowest_eigenvalue,
};
use crate::lattice::Lattice;
use crate::matching::{HalfWidth, Matching, bulk_of};
use crate::parallel::Executor;

/// Half-width of the regions of a body with a Young's modulus outside a simulation, in cells.
pub(super) const DEFAULT_HALF_WIDTH: HalfWidth = HalfWidth::whole(2);

/// Greatest length R of the regions of a body with a Young's modulus, as a fraction of its size, if that is more than the
/// length of the half-width 2. Wider ones show: the sides of a block that is stretched by half are then wavy.
const SIZE_FRACTION: f64 = 0.15;

/// As [`SIZE_FRACTION`], of the least width: a solid part of this thickness t bends by 0.6 R²/t², 5 %, less than it should.
/// Walls, which may be three times as thin, and bodies of less than 4.7 cells, which have w = 1, bend less.
const WIDTH_FRACTION: f64 = 0.3;

/// Time that a step takes for a lattice vertex, in seconds, by which [`Accuracy::Balanced`] chooses: a step of
/// regions of one cell takes 10 to 15 ns on a core of 2020, and contacts as much again. It is a fixed number, so that
/// a body has the same regions on every machine.
const TIME_PER_VERTEX: f64 = 2e-8;

/// A body that is softer than its material, because its steps are too long.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Softened {
    /// The key of the quantity, as in a scene: `youngs_modulus` for a preset or a Young's modulus, or `frequency`.
    pub key: &'static str,
    /// Specified value: Young's modulus in scene units of force per area, or a frequency in Hz.
    pub specified: f64,
    /// Value in force.
    pub in_force: f64,
    /// The stiffness factor of the part that the values are of: the greatest of the body, and 1 without zones.
    pub factor: f64,
    /// Number of steps per second that reach the specified value.
    pub needed_rate: f64,
}

impl Body {
    /// Prepares the body for a simulation with these colliders, this greatest gravity and this step length.
    pub(crate) fn join(&mut self, colliders: &Colliders, gravity: f64, dt: f64) {
        self.update_contact_stage(colliders);
        self.search_escapes();
        self.fix_elasticity(gravity, dt);
    }

    /// Fixes Young's modulus and the half-width of the regions, for a simulation with this gravity, in scene units
    /// per second squared, and this step length. Later changes of gravity or the step length change neither. With
    /// the elasticity of regions, it has no effect.
    pub(crate) fn fix_elasticity(&mut self, gravity: f64, dt: f64) {
        self.settings.youngs_modulus = self.modulus_to_reach(gravity);
        if let Some(half_width) = self.half_width_to_fix(gravity, dt) {
            self.set_half_width(half_width);
        }
        self.limit_stiffness_factors(dt);
    }

    /// Returns the half-width of the regions that [`fix_elasticity`](Self::fix_elasticity) sets; `None` with the
    /// elasticity of regions.
    pub(super) fn half_width_to_fix(&self, gravity: f64, dt: f64) -> Option<HalfWidth> {
        let modulus = self.modulus_to_reach(gravity)?;
        let greatest = modulus * self.factor_range().1;
        let least = self.greatest_law(dt).least_half_width(greatest, self.shape.extent);
        let chosen = self.chosen_half_width(modulus);
        let is_reached = |half_width| 1.0 / dt >= (1.0 - 1e-9) * self.step_rate(half_width, greatest);
        Some(match self.settings.material.accuracy {
            Accuracy::Fast => least,
            _ if is_reached(chosen) && chosen < least => chosen,
            _ => least,
        })
    }

    /// Returns the half-width of the regions that the [accuracy](Accuracy) asks for with Young's modulus `modulus`,
    /// if the steps are short enough: see [`step_rate`](Self::step_rate).
    pub(crate) fn chosen_half_width(&self, modulus: f64) -> HalfWidth {
        let Proportions { size, least_width, .. } = self.shape.proportions;
        // w (w + 1) <= (R/h)².
        let within = |length: f64| {
            let cells = length / self.shape.lattice.cell_size();
            half_width_of(cells * cells).floor()
        };
        let widest = within(SIZE_FRACTION * size).max(2.0).min(within(WIDTH_FRACTION * least_width)).max(1.0);
        let greatest = self.factor_range().1 * modulus;
        let share = |half_width: HalfWidth| {
            self.step_rate(half_width, greatest) * self.shape.lattice.len() as f64 * TIME_PER_VERTEX
        };
        match self.settings.material.accuracy {
            Accuracy::Fast => widest.into(),
            Accuracy::Exact => HalfWidth::CELL,
            Accuracy::Balanced => {
                // Wide regions smooth the strains by which a body breaks and flows.
                let follows_strains = self.is_armed() || self.settings.material.plastic.is_some();
                let widest = if follows_strains { 1.0 } else { widest };
                let mut half_widths =
                    std::iter::once(HalfWidth::CELL).chain((1..=widest as usize).map(HalfWidth::from));
                half_widths.find(|&half_width| share(half_width) <= Accuracy::BUDGET).unwrap_or(widest.into())
            }
        }
    }

    /// Calls [`fix_elasticity`](Self::fix_elasticity) if the elasticity was changed after the body joined.
    pub(super) fn complete_elasticity(&mut self, gravity: f64, dt: f64) {
        let is_regions = matches!(self.settings.material.elasticity, Elasticity::Regions { .. });
        if self.settings.youngs_modulus.is_none() && !is_regions {
            self.fix_elasticity(gravity, dt);
        } else {
            self.limit_stiffness_factors(dt);
        }
    }

    /// Returns the elastic law for steps of `dt` seconds by which the regions and the steps are chosen: that of the greatest
    /// Poisson's ratio.
    fn greatest_law(&self, dt: f64) -> ElasticLaw {
        ElasticLaw { poisson_ratio: self.greatest_poisson_ratio(), ..self.elastic_law(dt) }
    }

    /// Returns the elastic law for steps of `dt` seconds.
    fn elastic_law(&self, dt: f64) -> ElasticLaw {
        let (density, poisson_ratio) =
            (self.settings.material.density, self.settings.material.poisson_ratio());
        ElasticLaw { density, cell_size: self.shape.lattice.cell_size(), dt, poisson_ratio }
    }

    /// Returns alpha, the fraction of the distance to the goal position that a vertex covers in a step of `dt`
    /// seconds if its stiffness factor is 1.
    pub(crate) fn alpha(&self, dt: f64) -> f64 {
        match (self.settings.material.elasticity, self.settings.youngs_modulus) {
            (Elasticity::Regions { stiffness, .. }, _) => stiffness.alpha(dt).min(self.greatest_alpha()),
            (_, Some(modulus)) => {
                // Times the greatest factor it is at most the greatest one.
                let limit = self.greatest_alpha() / self.factor_range().1.min(1.0);
                let in_force = modulus * self.settings.modulus_share;
                self.elastic_law(dt).alpha(self.half_width(), in_force).min(limit)
            }
            (_, None) => self.greatest_alpha(),
        }
    }

    /// Returns whether and how the body is softer than its material in steps of `dt` seconds.
    pub(super) fn softened(&self, dt: f64) -> Option<Softened> {
        // Rounding errors do not count.
        const MARGIN: f64 = 1.0 + 1e-9;
        let (_, factor) = self.factor_range();
        let softened = match self.frequency() {
            // Without factors and Poisson's ratio, alpha is 1 at six steps per period.
            Some(frequency) => {
                let needed_rate = frequency * self.steps_per_period();
                let in_force = frequency / (needed_rate * dt);
                Softened { key: "frequency", specified: frequency, in_force, factor, needed_rate }
            }
            None => {
                let specified = factor * self.settings.youngs_modulus?;
                let needed_rate = self.step_rate(self.half_width(), specified);
                let greatest = self.elastic_law(dt).modulus(self.half_width(), self.greatest_alpha());
                let in_force = specified.min(greatest);
                Softened { key: "youngs_modulus", specified, in_force, factor, needed_rate }
            }
        };
        (softened.specified > MARGIN * softened.in_force).then_some(softened)
    }

    /// Returns the greatest alpha with which steps are stable: see [`ElasticLaw::greatest_alpha`].
    pub(super) fn greatest_alpha(&self) -> f64 {
        ElasticLaw::greatest_alpha_of(self.settings.material.poisson_ratio())
    }

    /// Returns the steps per period of a frequency at which alpha times the greatest stiffness factor is the greatest
    /// one.
    pub(crate) fn steps_per_period(&self) -> f64 {
        Stiffness::steps_per_period(self.greatest_alpha() / self.factor_range().1.max(1.0))
    }

    /// Returns the steps per second at which alpha is the greatest one for Young's modulus `modulus`, in scene units
    /// of force per area, with regions of half-width `half_width`.
    pub fn step_rate(&self, half_width: HalfWidth, modulus: f64) -> f64 {
        1.0 / self.greatest_law(1.0).longest_step(half_width, modulus)
    }

    /// Returns Young's modulus in force in steps of `dt` seconds, in scene units of force per area. It is less than
    /// the modulus of the material if that one is out of reach of steps of this length: alpha is at most 1.
    pub(super) fn modulus_in_force(&self, dt: f64) -> f64 {
        self.elastic_law(dt).modulus(self.half_width(), self.alpha(dt))
    }

    /// Returns Young's modulus that the body has in a simulation with this gravity, or `None` with the elasticity of
    /// regions.
    pub(crate) fn modulus_to_reach(&self, gravity: f64) -> Option<f64> {
        let Material { elasticity, density, .. } = self.settings.material;
        match elasticity {
            Elasticity::Preset(preset) => {
                let Proportions { size, slenderness, .. } = self.shape.proportions;
                Some(preset.youngs_modulus(density, size, slenderness, gravity))
            }
            Elasticity::YoungsModulus(modulus) => Some(modulus),
            Elasticity::Regions { .. } => None,
        }
    }

    /// Returns the frequency of the stiffness in Hz, if it is set as one.
    pub(crate) fn frequency(&self) -> Option<f64> {
        match self.settings.material.elasticity {
            Elasticity::Regions { stiffness: Stiffness::Frequency(frequency), .. } => Some(frequency),
            _ => None,
        }
    }

    /// Returns the least width of the body in scene units: that of a box with the least principal second moment of its
    /// volume, but at most 6 V/A with the volume V and the area A of its mesh, or of the cells of a bare lattice. It is the
    /// shortest side of a block, three times the thickness of thin walls, 0.77 of the diameter of a ball with a mesh, and 0
    /// for a body without volume. Fracture does not change it.
    pub fn least_width(&self) -> f64 {
        self.shape.proportions.least_width
    }

    /// Returns the size L of the body in scene units, the cube root of its volume: see [`Proportions`].
    pub(crate) fn size(&self) -> f64 {
        self.shape.proportions.size
    }

    /// Returns Young's modulus of the material, or `None` with the elasticity of regions, or if the body has a
    /// preset and is not in a simulation.
    pub(super) fn material_modulus(&self) -> Option<f64> {
        match self.settings.material.elasticity {
            Elasticity::YoungsModulus(modulus) => Some(modulus),
            _ => self.settings.youngs_modulus,
        }
    }

    /// Changes the half-width of the regions, and rebuilds them. Positions, velocities, momenta and plastic shapes
    /// are unchanged.
    pub(super) fn set_half_width(&mut self, half_width: HalfWidth) {
        if half_width == self.half_width() {
            return;
        }
        self.carry_shapes(half_width);
        self.pipeline.matching.set_half_width(&self.shape.lattice, &self.shape.masses, half_width);
        self.state.fitted = false;
        self.forget_elastic_measures();
        self.rebuild_stages();
    }

    /// Removes the data that were computed from the regions and their factors.
    pub(super) fn forget_elastic_measures(&mut self) {
        (self.pipeline.energy, self.state.energy_limit) = (None, None);
        self.pipeline.lowest_eigenvalue.take();
    }

    /// Returns the angular frequency of the lowest elastic mode of the free body in rad/s, in steps of `dt` seconds.
    /// The first call computes the mode. A broken body keeps the mode of the whole body, because parts that hang by
    /// an edge, as a crack can leave them, swing freely.
    pub(super) fn lowest_angular_frequency(&self, dt: f64, executor: &Executor) -> f64 {
        let Self { pipeline: Pipeline { matching, .. }, stiffness_factors, .. } = self;
        let greatest = stiffness_factors.as_ref().map_or(1.0, StiffnessFactors::greatest_in_force);
        let eigenvalue = *self.pipeline.lowest_eigenvalue.get_or_init(|| {
            let (lattice, masses) = self.whole();
            // Without the larger masses of constrained vertices.
            let mut matching = Matching::new(&lattice, masses, matching.regions.half_width());
            // With keyframes, those of the greatest values, whichever are in force.
            let factors = stiffness_factors.as_ref().map(|factors| match &self.keyed {
                None => factors.parts_of(greatest),
                Some(_) => factors.parts_of(factors.range().1),
            });
            let bulk = bulk_of(self.greatest_poisson_ratio()) as f32;
            matching.set_factors(factors.as_ref().map(|factors| &factors[..lattice.len()]));
            matching.set_covariances(bulk != 0.0);
            matching.set_bulk(bulk);
            let damper = RegionDamper::new(&matching).with_bulk(&matching);
            let mut tracker =
                MomentumTracker::new(&lattice, masses, &matching.layout, matching.cascade.tasks());
            lowest_eigenvalue(&lattice, &matching, &damper, &mut tracker, executor)
        });
        (eigenvalue * greatest * self.alpha(dt)).sqrt() / dt
    }

    /// Returns the rates at which damping lets the amplitudes of elastic modes decay, in steps of `dt` seconds.
    pub(super) fn damping_rates(&self, dt: f64, executor: &Executor) -> DampingRates {
        let rate = match self.settings.material.damping() {
            Damping::Rate(rate) => rate,
            Damping::Ratio(0.0) => 0.0,
            Damping::Ratio(ratio) => ratio * self.lowest_angular_frequency(dt, executor),
        };
        // At the greatest angular frequency of a mode, √alpha/dt, no mode oscillates. A higher rate would keep the
        // elastic forces from carrying the body, or its softest part.
        let most = (self.alpha(dt) * self.factor_range().0).min(1.0).sqrt() / dt;
        DampingRates { rate, most, dt }
    }
}

/// Returns the half-width of the regions of a body outside a simulation, in cells: at most the extent of the lattice.
pub(super) fn initial_half_width(material: &Material, lattice: &Lattice, extent: usize) -> HalfWidth {
    let cells = match material.elasticity {
        Elasticity::Regions { size: RegionSize::Cells(cells), .. } => cells,
        Elasticity::Regions { size: RegionSize::Radius(radius), .. } => {
            (radius / lattice.cell_size()).round().max(1.0).into()
        }
        _ => DEFAULT_HALF_WIDTH,
    };
    if cells.is_cell() { cells } else { HalfWidth::whole(cells.links().min(extent.max(1))) }
}
