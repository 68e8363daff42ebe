//! Stiffness that varies over a body: zones, and one factor per lattice vertex.

use super::parts::{Settings, Shape};
use super::soft_body::Body;
use crate::dynamics::{
    Elasticity, Inflation, Material, PartFactors, Quantity, Selection, SelectionError, SelectionPose,
    Stiffness, StiffnessFactors, Zone,
};
use crate::error::Error;
use crate::range::{Range, RangeError, in_range};
use crate::state::ArrayError;

/// Least product of the factors of overlapping zones, other than the stiffness.
const LEAST_FACTOR: f64 = 1e-6;

impl Body {
    /// Sets the stiffness factors, from the next step on: Young's modulus around each lattice vertex is the modulus
    /// of the material times the factor of the vertex. `None` removes all factors, also of zones.
    ///
    /// A factor belongs to the region around its vertex, so the momenta are conserved. Parts that are smaller than the
    /// regions, 2 w + 1 vertices wide with the half-width w, are mixed with their surroundings. In a simulation, the
    /// regions are fixed again as if the body joined the simulation at the next step, for the greatest factor.
    ///
    /// * `factors`: one per lattice vertex, in (0, 100]. Factors below 1e-6 act as 1e-6.
    ///
    /// # Errors
    ///
    /// A wrong number of factors, a factor out of range, or a stiffness alpha per step whose product with the greatest
    /// factor exceeds 1. The factors are then unchanged.
    pub fn set_stiffness_factors(&mut self, factors: Option<&[f64]>) -> Result<(), Error> {
        self.check_deforms("a stiffness factor")?;
        factors.map(|factors| checked_factors(factors, self.shape.lattice.len())).transpose()?;
        let parts = self.settings.parts.clone();
        let factors = self.varied(&parts, factors.map(<[f64]>::to_vec))?;
        check_stiffness(&self.settings.material, factors.as_ref())?;
        self.change_factors(parts, factors);
        Ok(())
    }

    /// Returns the stiffness factors, one per lattice vertex, or `None` if the stiffness does not vary.
    pub fn stiffness_factors(&self) -> Option<&[f64]> {
        self.stiffness_factors.as_ref().map(StiffnessFactors::specified)
    }

    /// Returns the factors of alpha of the regions, one per lattice vertex: those of the stiffness divided by those of
    /// the density; `None` if they do not vary.
    pub(crate) fn region_factors(&self) -> Option<&[f64]> {
        self.stiffness_factors.as_ref().map(StiffnessFactors::relative)
    }

    /// Returns the stiffness factors for the factors `stiffness` of Young's modulus, one per lattice vertex, and those of
    /// the density.
    ///
    /// # Errors
    ///
    /// A factor out of range.
    pub(super) fn varied(
        &self,
        parts: &PartFactors,
        stiffness: Option<Vec<f64>>,
    ) -> Result<Option<StiffnessFactors>, RangeError> {
        let lattice = &self.shape.lattice;
        let density =
            parts.on(lattice, Quantity::Density).map(|factor| (0..lattice.len() as u32).map(factor));
        // With another density alone, the regions have factors too.
        let varies = stiffness.is_some() || density.is_some();
        let specified = varies.then(|| stiffness.unwrap_or_else(|| vec![1.0; lattice.len()]));
        specified.map(|specified| StiffnessFactors::new(specified, density)).transpose()
    }

    /// Replaces the factors by valid ones.
    pub(super) fn replace_factors(&mut self, parts: PartFactors, factors: Option<StiffnessFactors>) {
        self.stiffness_factors = factors;
        let before = std::mem::replace(&mut self.settings.parts, parts);
        let has_changed = |quantity| before.of(quantity) != self.settings.parts.of(quantity);
        let [masses, friction, yields, damping] =
            [Quantity::Density, Quantity::Friction, Quantity::YieldStrain, Quantity::Damping]
                .map(has_changed);
        if masses {
            self.update_masses();
        }
        if friction {
            self.pass_friction_factors();
        }
        if damping {
            self.update_elastic_damping();
        }
        if yields {
            self.pass_yield_factors();
        }
        self.apply_stiffness_factors();
    }

    /// Replaces the factors by valid ones, from the next step on. The regions are fixed again.
    fn change_factors(&mut self, parts: PartFactors, factors: Option<StiffnessFactors>) {
        self.wake();
        self.settings.youngs_modulus = None;
        self.replace_factors(parts, factors);
    }

    /// Limits the factors in force in steps of `dt` seconds, such that alpha times a factor is at most the greatest
    /// alpha. If they change, what was measured with others is forgotten.
    pub(super) fn limit_stiffness_factors(&mut self, dt: f64) {
        if self.limit_factors_in_force(dt) {
            self.forget_elastic_measures();
        }
    }

    /// Limits the factors in force as [`limit_stiffness_factors`](Self::limit_stiffness_factors), but keeps what was
    /// measured with others. Returns whether they change.
    pub(super) fn limit_factors_in_force(&mut self, dt: f64) -> bool {
        let (alpha, greatest) = (self.alpha(dt), self.greatest_alpha());
        let changes = self.stiffness_factors.as_mut().is_some_and(|factors| factors.limit(alpha, greatest));
        if changes {
            self.pass_stiffness_factors();
        }
        changes
    }

    /// Passes the factors in force to the shape matching.
    fn apply_stiffness_factors(&mut self) {
        self.pass_stiffness_factors();
        self.forget_elastic_measures();
    }

    /// As [`apply_stiffness_factors`](Self::apply_stiffness_factors), for the same factors in a new shape matching.
    pub(super) fn pass_stiffness_factors(&mut self) {
        let in_force = self.stiffness_factors.as_ref().map(|factors| factors.in_force());
        self.pipeline.matching.set_factors(in_force.as_deref());
    }

    /// Passes the factors of the yield strain to the shape matching.
    pub(super) fn pass_yield_factors(&mut self) {
        let Self { shape: Shape { lattice, .. }, settings: Settings { parts, .. }, pipeline, .. } = self;
        pipeline.matching.set_yield_factors(parts.on(lattice, Quantity::YieldStrain));
    }

    /// Passes the factors of the friction to the contacts with colliders.
    fn pass_friction_factors(&mut self) {
        let Self { shape: Shape { lattice, .. }, settings: Settings { parts, .. }, contact, .. } = self;
        if let Some(contacts) = &mut contact.contacts {
            contacts.set_friction_factors(parts.on(lattice, Quantity::Friction));
        }
    }

    /// Returns the least and the greatest stiffness factor.
    pub(crate) fn factor_range(&self) -> (f64, f64) {
        self.stiffness_factors.as_ref().map_or((1.0, 1.0), StiffnessFactors::range)
    }

    /// Returns alpha of the stiffest region in steps of `dt` seconds.
    pub(super) fn alpha_of_stiffest(&self, dt: f64) -> f64 {
        self.alpha(dt) * self.stiffness_factors.as_ref().map_or(1.0, StiffnessFactors::greatest_in_force)
    }

    /// Multiplies the stiffness factors of a part of the body, and the other quantities of a [zone](Zone), from the next
    /// step on: see [`set_stiffness_factors`](Self::set_stiffness_factors). The body is at frame 0: see
    /// [`zone_at`](Self::zone_at).
    ///
    /// # Errors
    ///
    /// As for [`zone_at`](Self::zone_at).
    pub fn zone(&mut self, zone: &Zone) -> Result<(), Error> {
        self.zone_at(zone, SelectionPose::Start)
    }

    /// Multiplies the stiffness factors of a part of the body in a pose, and the other quantities of a zone, from the
    /// next step on. The initial spin of a body that has not moved is about its new center of mass. A map of zeros
    /// changes nothing.
    ///
    /// Shapes are in world space and are tested against the lattice vertices of the body. Unlike the shapes of a pin,
    /// they need not contain a mesh vertex.
    ///
    /// # Errors
    ///
    /// An empty or invalid selection, a factor, a product of factors or a ratio out of range, or a stiffness alpha
    /// per step whose product with the greatest factor exceeds 1. The body is then unchanged.
    pub fn zone_at(&mut self, zone: &Zone, pose: SelectionPose) -> Result<(), Error> {
        let (factor, others) = (zone.factor, zone.part_factors());
        for (name, factor) in others.into_iter().chain([("factor", factor)]) {
            Range::STIFFNESS_FACTOR.check(name, factor)?;
        }
        zone.inflate.iter().try_for_each(Inflation::validate)?;
        if zone.strength != 1.0 && self.fracture().is_none() {
            return Err(Error::NoFracture);
        }
        if zone.yield_strain != 1.0 && self.settings.material.plastic.is_none() {
            return Err(Error::NotPlastic);
        }
        let shares = self.zone_shares(&zone.selection, pose)?;
        let has_others = others.iter().any(|(_, factor)| *factor != 1.0);
        let of_stiffness = factor != 1.0 || (zone.inflate.is_none() && !has_others);
        if of_stiffness || has_others {
            self.check_deforms("a stiffness factor")?;
            let mut parts = self.settings.parts.clone();
            let of_whole = self.shares_of_whole(&shares);
            for (quantity, (_, factor)) in Quantity::ALL.into_iter().zip(others) {
                let factors = at_least(multiplied(parts.of(quantity), factor, &of_whole)?)?;
                parts.set(quantity, factors);
            }
            let stiffness = match multiplied(self.stiffness_factors(), factor, &shares)? {
                None if of_stiffness => Some(vec![1.0; shares.len()]),
                stiffness => stiffness,
            };
            let factors = self.varied(&parts, stiffness)?;
            check_stiffness(&self.settings.material, factors.as_ref())?;
            let has_not_moved = zone.density != 1.0 && self.has_initial_motion();
            self.change_factors(parts, factors);
            if has_not_moved {
                let Self { shape: Shape { masses, placement, .. }, pipeline, state, .. } = self;
                state.set_initial_velocities(masses, &pipeline.matching.layout, placement);
            }
        }
        if let Some(ratio) = &zone.inflate {
            self.inflation.get_or_insert_default().add_zone(ratio.clone(), shares);
        }
        Ok(())
    }

    /// Returns whether the body has not moved, and spins as it is placed.
    fn has_initial_motion(&self) -> bool {
        let Self { shape: Shape { masses, placement, .. }, pipeline, state, .. } = self;
        if placement.spin == [0.0; 3] || !self.is_at_start() {
            return false;
        }
        let mut initial = state.clone();
        initial.set_initial_velocities(masses, &pipeline.matching.layout, placement);
        initial == *state
    }

    /// Returns the share of each vertex of the lattice before the body broke: the greatest of its copies.
    fn shares_of_whole(&self, shares: &[f64]) -> Vec<f64> {
        let mut whole = vec![0.0; self.whole().1.len()];
        for (vertex, &share) in (0..).zip(shares) {
            let greatest: &mut f64 = &mut whole[self.shape.lattice.source(vertex) as usize];
            *greatest = greatest.max(share);
        }
        whole
    }

    /// Returns the share of each lattice vertex in a zone: the weights of a map, or 1 inside, from where it decreases
    /// linearly to 0 over the length of a cell. A list of vertices has no such border.
    fn zone_shares(&self, selection: &Selection, pose: SelectionPose) -> Result<Vec<f64>, SelectionError> {
        selection.validate()?;
        if let Some(weights) = self.weights(selection)? {
            return Ok(weights);
        }
        let pose = self.pose_of(pose);
        let points = self.lattice_at(pose);
        let mut shares = vec![0.0; self.shape.lattice.len()];
        if selection.is_shape() {
            for (point, share) in points.iter().zip(&mut shares) {
                *share = (1.0 - selection.distance(point) / self.shape.lattice.cell_size()).max(0.0);
            }
        }
        if shares.iter().all(|&share| share == 0.0) {
            // An empty shape is an error, with the distance to the nearest vertex.
            let selected = match selection {
                Selection::MeshVertices(_) | Selection::Group(_) => self.select(selection),
                _ => selection.lattice_vertices(points, shares.len(), |vertex| [vertex]),
            };
            for vertex in selected.map_err(|error| error.at(pose))? {
                shares[vertex as usize] = 1.0;
            }
        }
        Ok(shares)
    }
}

/// Returns factors times a factor in a zone with a share of each vertex. `None`: all are 1.
fn multiplied(factors: Option<&[f64]>, factor: f64, shares: &[f64]) -> Result<Option<Vec<f64>>, RangeError> {
    if factor == 1.0 {
        return Ok(factors.map(<[f64]>::to_vec));
    }
    let mut products = factors.map_or_else(|| vec![1.0; shares.len()], <[f64]>::to_vec);
    for (value, &share) in products.iter_mut().zip(shares).filter(|(_, share)| **share > 0.0) {
        *value *= libm::pow(factor, share);
    }
    let greatest = products.iter().copied().fold(0.0, f64::max);
    in_range("product of the factors of zones", greatest, greatest <= 100.0, "at most 100")?;
    Ok(Some(products))
}

/// Checks that no product of factors is so small that masses or limits vanish.
fn at_least(factors: Option<Vec<f64>>) -> Result<Option<Vec<f64>>, RangeError> {
    let least = factors.iter().flatten().copied().fold(1.0, f64::min);
    in_range("product of the factors of zones", least, least >= LEAST_FACTOR, "at least 1e-6")?;
    Ok(factors)
}

/// Checks the number and the range of the stiffness factors of `vertices` lattice vertices.
pub(super) fn checked_factors(factors: &[f64], vertices: usize) -> Result<StiffnessFactors, Error> {
    let (name, count) = ("stiffness_factors", factors.len());
    if count != vertices {
        return Err(ArrayError::Length { name, count, expected: vertices }.into());
    }
    Ok(StiffnessFactors::new(factors.to_vec(), None::<std::iter::Empty<f64>>)?)
}

/// Checks that alpha per step, where it is given as such, times the greatest stiffness factor is at most 1.
pub(super) fn check_stiffness(
    material: &Material,
    factors: Option<&StiffnessFactors>,
) -> Result<(), RangeError> {
    let (Elasticity::Regions { stiffness: Stiffness::PerStep(alpha), .. }, Some(factors)) =
        (material.elasticity, factors)
    else {
        return Ok(());
    };
    let product = alpha * factors.range().1;
    in_range(
        "stiffness x the greatest stiffness factor",
        product,
        product <= 1.0,
        "at most 1; lower stiffness",
    )
    .map(drop)
}
