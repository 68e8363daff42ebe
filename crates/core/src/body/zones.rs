//! Stiffness that varies over a body: zones, and one factor per lattice vertex.

use super::soft_body::Body;
use crate::dynamics::{
    Elasticity, Inflation, Material, Selection, SelectionError, SelectionPose, Stiffness, StiffnessFactors,
    Zone,
};
use crate::error::Error;
use crate::range::{Range, RangeError, in_range};
use crate::state::ArrayError;

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
        let factors =
            factors.map(|factors| checked_factors(factors, self.shape.lattice.len())).transpose()?;
        check_stiffness(&self.settings.material, factors.as_ref())?;
        self.wake();
        self.settings.youngs_modulus = None;
        self.replace_stiffness_factors(factors);
        Ok(())
    }

    /// Returns the stiffness factors, one per lattice vertex, or `None` if the stiffness does not vary.
    pub fn stiffness_factors(&self) -> Option<&[f64]> {
        self.stiffness_factors.as_ref().map(StiffnessFactors::specified)
    }

    /// Replaces the factors by valid ones.
    pub(super) fn replace_stiffness_factors(&mut self, factors: Option<StiffnessFactors>) {
        self.stiffness_factors = factors;
        self.apply_stiffness_factors();
    }

    /// Limits the factors in force in steps of `dt` seconds, such that alpha times a factor is at most the greatest
    /// alpha.
    pub(super) fn limit_stiffness_factors(&mut self, dt: f64) {
        let (alpha, greatest) = (self.alpha(dt), self.greatest_alpha());
        if self.stiffness_factors.as_mut().is_some_and(|factors| factors.limit(alpha, greatest)) {
            self.apply_stiffness_factors();
        }
    }

    /// Passes the factors in force to the shape matching.
    fn apply_stiffness_factors(&mut self) {
        self.pass_stiffness_factors();
        self.forget_elastic_measures();
    }

    /// As [`apply_stiffness_factors`](Self::apply_stiffness_factors), for the same factors in a new shape matching.
    pub(super) fn pass_stiffness_factors(&mut self) {
        let in_force = self.stiffness_factors.as_ref().map(|factors| factors.in_force(1.0));
        self.pipeline.matching.set_factors(in_force.as_deref());
    }

    /// Returns the greatest stiffness factor in force.
    pub(super) fn greatest_factor(&self) -> f64 {
        self.stiffness_factors.as_ref().map_or(1.0, StiffnessFactors::greatest_in_force)
    }

    /// Returns the least and the greatest stiffness factor.
    pub(crate) fn factor_range(&self) -> (f64, f64) {
        self.stiffness_factors.as_ref().map_or((1.0, 1.0), StiffnessFactors::range)
    }

    /// Returns alpha of the stiffest region in steps of `dt` seconds.
    pub(super) fn alpha_of_stiffest(&self, dt: f64) -> f64 {
        self.alpha(dt) * self.stiffness_factors.as_ref().map_or(1.0, StiffnessFactors::greatest_in_force)
    }

    /// Multiplies the stiffness factors of a part of the body, and its [rest volume](Zone::inflate), from the next
    /// step on: see [`set_stiffness_factors`](Self::set_stiffness_factors). The body is at frame 0: see
    /// [`zone_at`](Self::zone_at).
    ///
    /// # Errors
    ///
    /// As for [`zone_at`](Self::zone_at).
    pub fn zone(&mut self, zone: &Zone) -> Result<(), Error> {
        self.zone_at(zone, SelectionPose::Start)
    }

    /// Multiplies the stiffness factors of a part of the body in a pose, and its rest volume, from the next step on.
    ///
    /// Shapes are in world space and are tested against the lattice vertices of the body. Unlike the shapes of a pin,
    /// they need not contain a mesh vertex.
    ///
    /// # Errors
    ///
    /// An empty or invalid selection, a factor, a product of factors or a ratio out of range, or a stiffness alpha
    /// per step whose product with the greatest factor exceeds 1. The body is then unchanged.
    pub fn zone_at(&mut self, zone: &Zone, pose: SelectionPose) -> Result<(), Error> {
        let factor = Range::STIFFNESS_FACTOR.check("factor", zone.factor)?;
        zone.inflate.iter().try_for_each(Inflation::validate)?;
        let shares = self.zone_shares(&zone.selection, pose)?;
        if factor != 1.0 || zone.inflate.is_none() {
            let mut factors =
                self.stiffness_factors().map_or_else(|| vec![1.0; self.shape.lattice.len()], <[f64]>::to_vec);
            for (value, &share) in factors.iter_mut().zip(&shares).filter(|(_, share)| **share > 0.0) {
                *value *= factor.powf(share);
            }
            let greatest = factors.iter().copied().fold(0.0, f64::max);
            in_range("product of the factors of zones", greatest, greatest <= 100.0, "at most 100")?;
            self.set_stiffness_factors(Some(&factors))?;
        }
        if let Some(ratio) = &zone.inflate {
            self.inflation.get_or_insert_default().add_zone(ratio.clone(), shares);
        }
        Ok(())
    }

    /// Returns the share of each lattice vertex in a zone: 1 inside, from where it decreases linearly to 0 over the
    /// length of a cell. A list of vertices has no such border.
    fn zone_shares(&self, selection: &Selection, pose: SelectionPose) -> Result<Vec<f64>, SelectionError> {
        selection.validate()?;
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

/// Checks the number and the range of the stiffness factors of `vertices` lattice vertices.
pub(super) fn checked_factors(factors: &[f64], vertices: usize) -> Result<StiffnessFactors, Error> {
    let (name, count) = ("stiffness_factors", factors.len());
    if count != vertices {
        return Err(ArrayError::Length { name, count, expected: vertices }.into());
    }
    Ok(StiffnessFactors::new(factors.to_vec())?)
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
