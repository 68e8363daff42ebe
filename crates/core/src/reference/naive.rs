//! Implements the reference method on one lattice, with regions and weights computed once.

use std::borrow::Cow;

use nalgebra::{Matrix3, Vector3};

use super::region_motion::{RegionMotion, volume_term};
use super::{Regions, Weights, flowed, region, rotation, weights};
use crate::body::Body;
use crate::dynamics::Plasticity;
use crate::lattice::Lattice;
use crate::matching::HalfWidth;

/// The reference method on one lattice, with the data that repeated evaluations need.
#[derive(Clone, Debug)]
pub struct Naive<'a> {
    pub(super) lattice: &'a Lattice,
    half_width: HalfWidth,
    regions: Regions,
    pub(super) weights: Weights,
    /// The filled share of each cell. `None` if all are 1.
    shares: Option<Vec<f64>>,
    /// The stiffness factor of the region around each vertex. `None` if all are 1.
    factors: Option<Vec<f64>>,
    /// Poisson's ratio.
    poisson_ratio: f64,
    /// The ratio of the rest volume around each vertex. `None` if all are 1.
    ratios: Option<Vec<f64>>,
    /// The plastic shape of each region. `None` if all are the identity.
    shapes: Option<Vec<Matrix3<f64>>>,
    /// The vertices of each region. `None` if they are found again at each use.
    listed: Option<Vec<Vec<u32>>>,
}

impl<'a> Naive<'a> {
    /// Prepares the method for regions of half-width `half_width`: one around each vertex, or each cell if it is 1/2.
    ///
    /// The regions are found again at each use, unless [`Naive::listed`] stores them. The masses are as in a bare
    /// lattice, unless [`Naive::with_masses`] sets them.
    pub fn new(lattice: &'a Lattice, half_width: impl Into<HalfWidth>, regions: Regions) -> Self {
        let half_width = half_width.into();
        let weights = weights(lattice, half_width, regions);
        let poisson_ratio = 0.0;
        Self {
            lattice,
            half_width,
            regions,
            weights,
            shares: None,
            factors: None,
            poisson_ratio,
            ratios: None,
            shapes: None,
            listed: None,
        }
    }

    /// Uses other masses than those of a bare lattice: `masses` has the mass of each vertex in masses of a full cell,
    /// for example [`Body::fit_masses`](crate::Body::fit_masses).
    ///
    /// # Panics
    ///
    /// If the number of masses is not the number of lattice vertices.
    #[must_use]
    pub fn with_masses(mut self, masses: Vec<f64>) -> Self {
        self.set_masses(masses);
        self
    }

    /// Uses the masses in the fits, the stiffness factors, Poisson's ratio and the rest volumes of a body.
    ///
    /// # Panics
    ///
    /// If the body has another number of lattice vertices.
    #[must_use]
    pub fn with_material_of(self, body: &Body) -> Self {
        let mut naive =
            self.with_masses(body.fit_masses()).with_poisson_ratio(body.material().poisson_ratio());
        naive.shares = Some(body.cell_shares());
        naive.ratios = Some(body.rest_volume_ratios());
        match body.region_factors() {
            Some(factors) => naive.with_factors(factors.to_vec()),
            None => naive,
        }
    }

    /// Changes the masses: see [`Naive::with_masses`].
    ///
    /// # Panics
    ///
    /// If the number of masses is not the number of lattice vertices.
    pub fn set_masses(&mut self, masses: Vec<f64>) {
        assert_eq!(masses.len(), self.lattice.len(), "`masses` must match the lattice vertices");
        self.weights.masses = masses;
    }

    /// Uses stiffness factors: `factors` has the factor of the region around each vertex, as
    /// [`Body::stiffness_factors`](crate::Body::stiffness_factors).
    ///
    /// # Panics
    ///
    /// If the number of factors is not the number of lattice vertices.
    #[must_use]
    pub fn with_factors(self, factors: Vec<f64>) -> Self {
        assert_eq!(factors.len(), self.lattice.len(), "`factors` must match the lattice vertices");
        Self { factors: Some(factors), ..self }
    }

    /// Uses Poisson's ratio, in [0, 0.5).
    #[must_use]
    pub fn with_poisson_ratio(self, poisson_ratio: f64) -> Self {
        Self { poisson_ratio, ..self }
    }

    /// Uses rest volumes: `ratios` has the ratio of the rest volume around each vertex, as
    /// [`Body::rest_volume_ratios`](crate::Body::rest_volume_ratios).
    ///
    /// # Panics
    ///
    /// If the number of ratios is not the number of lattice vertices.
    #[must_use]
    pub fn with_rest_volumes(self, ratios: Vec<f64>) -> Self {
        assert_eq!(ratios.len(), self.lattice.len(), "`ratios` must match the lattice vertices");
        Self { ratios: Some(ratios), ..self }
    }

    /// Uses plastic shapes: `shapes` has the plastic shape of each region, a symmetric matrix of determinant 1, as
    /// [`Body::plastic_shapes`](crate::Body::plastic_shapes).
    ///
    /// # Panics
    ///
    /// If the number of shapes is not the number of regions.
    #[must_use]
    pub fn with_shapes(mut self, shapes: Vec<Matrix3<f64>>) -> Self {
        self.set_shapes(shapes);
        self
    }

    /// Changes the plastic shapes: see [`Naive::with_shapes`].
    ///
    /// # Panics
    ///
    /// If the number of shapes is not the number of regions.
    pub fn set_shapes(&mut self, shapes: Vec<Matrix3<f64>>) {
        assert_eq!(shapes.len(), self.region_count(), "`shapes` must match the regions");
        self.shapes = Some(shapes);
    }

    /// Returns the plastic shapes after a step of `dt` seconds in which the regions have the given motions.
    pub fn flowed(&self, motions: &[RegionMotion], plasticity: &Plasticity, dt: f64) -> Vec<Matrix3<f64>> {
        let flowed =
            |motion: &RegionMotion| flowed([motion.rotation, motion.gradient, motion.shape], plasticity, dt);
        motions.iter().map(flowed).collect()
    }

    /// Returns the number of regions: of the vertices, or of the cells.
    pub(super) fn region_count(&self) -> usize {
        if self.half_width.is_cell() { self.lattice.cells().len() } else { self.lattice.len() }
    }

    pub(super) fn regions(&self) -> std::ops::Range<u32> {
        0..self.region_count() as u32
    }

    /// Returns the stiffness factor of a region.
    pub(super) fn factor(&self, region: u32) -> f64 {
        self.at_region(self.factors.as_deref(), region)
    }

    /// Returns the cube root of the ratio of the rest volume of a region.
    fn stretch(&self, region: u32) -> f64 {
        libm::cbrt(self.at_region(self.ratios.as_deref(), region))
    }

    /// Returns a number of a region: the number of its center vertex, or the mean over the corners of a cell; 1
    /// without numbers.
    fn at_region(&self, numbers: Option<&[f64]>, region: u32) -> f64 {
        let Some(numbers) = numbers else { return 1.0 };
        match self.half_width.is_cell() {
            true => self.members(region).iter().map(|&corner| numbers[corner as usize]).sum::<f64>() / 8.0,
            false => numbers[region as usize],
        }
    }

    /// Returns the factor with which a region counts in means, beside its stiffness: an eighth of the filled share of a
    /// cell.
    pub(super) fn share(&self, region: u32) -> f64 {
        match (self.half_width.is_cell(), &self.shares) {
            (true, Some(shares)) => shares[region as usize] / 8.0,
            (true, None) => 0.125,
            (false, _) => 1.0,
        }
    }

    /// Returns the weight of a vertex in its regions: m_i / n_i, or 1 in cells.
    pub(super) fn weight(&self, vertex: u32) -> f64 {
        if self.half_width.is_cell() { 1.0 } else { self.weights.of(vertex) }
    }

    /// Returns the stiffness factor of each vertex, by which alpha is multiplied: the mean factor of the regions that
    /// contain the vertex.
    pub fn vertex_factors(&self) -> Vec<f64> {
        if self.factors.is_none() {
            return vec![1.0; self.lattice.len()];
        }
        let mut sums = vec![0.0; self.lattice.len()];
        for region in self.regions() {
            for &i in self.members(region).iter() {
                let i = i as usize;
                let whole = match self.half_width.is_cell() {
                    true => self.weights.masses[i],
                    false => self.weights.counts[i] as f64,
                };
                sums[i] += self.factor(region) * self.share(region) / whole;
            }
        }
        sums
    }

    /// Stores the regions. This takes up to `4 (2 w + 1)^3` bytes per lattice vertex for the half-width w.
    pub fn listed(self) -> Self {
        let listed = self.regions().map(|region| self.members(region).into_owned()).collect();
        Self { listed: Some(listed), ..self }
    }

    /// Returns the mass of each vertex and the number of regions that contain it.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Returns the vertices of a region. The vertices of a region around a vertex are sorted.
    pub(super) fn members(&self, number: u32) -> Cow<'_, [u32]> {
        match &self.listed {
            Some(listed) => Cow::Borrowed(&listed[number as usize]),
            None if self.half_width.is_cell() => Cow::Owned(self.lattice.cell_corners(number).to_vec()),
            None => Cow::Owned(region(self.lattice, number, self.half_width, self.regions)),
        }
    }

    /// Returns the rest position of a vertex, relative to the lattice's origin.
    pub(super) fn rest(&self, vertex: u32) -> Vector3<f64> {
        Vector3::from(self.lattice.indices()[vertex as usize].map(f64::from)) * self.lattice.cell_size()
    }

    /// Computes the motion of each region: matches the region's rest shape to the positions.
    ///
    /// # Panics
    ///
    /// If the number of positions is not the number of lattice vertices.
    pub fn motions(&self, positions: &[Vector3<f64>]) -> Vec<RegionMotion> {
        assert_eq!(positions.len(), self.lattice.len(), "`positions` must match the lattice vertices");
        let shape = |region: u32| {
            self.shapes.as_ref().map_or_else(Matrix3::identity, |shapes| shapes[region as usize])
        };
        let motion =
            |region| self.motion(&self.members(region), (shape(region), self.stretch(region)), positions);
        self.regions().map(motion).collect()
    }

    /// Computes the motion of the region with the vertices `members`, a plastic shape and the stretch at rest.
    fn motion(
        &self,
        members: &[u32],
        (shape, stretch): (Matrix3<f64>, f64),
        positions: &[Vector3<f64>],
    ) -> RegionMotion {
        let mass: f64 = members.iter().map(|&i| self.weight(i)).sum();
        let mean = |value: &dyn Fn(u32) -> Vector3<f64>| -> Vector3<f64> {
            members.iter().map(|&i| value(i) * self.weight(i)).sum::<Vector3<f64>>() / mass
        };
        let rest_centroid = mean(&|i| self.rest(i));
        let centroid = mean(&|i| positions[i as usize]);
        let (mut moments, mut covariance) = (Matrix3::zeros(), Matrix3::zeros());
        for &i in members {
            let y = self.rest(i) - rest_centroid;
            moments += (positions[i as usize] - centroid) * y.transpose() * self.weight(i);
            covariance += y * y.transpose() * self.weight(i);
        }
        // The covariance is singular only for a region of one vertex, which has no gradient.
        let inverse = covariance.try_inverse().unwrap_or_else(Matrix3::zeros);
        let gradient = moments * inverse / stretch;
        let (volume_motion, volume_energy) = volume_term(&gradient, &(inverse * mass), self.poisson_ratio);
        RegionMotion {
            volume_motion,
            volume_energy,
            mass,
            rest_centroid,
            centroid,
            rotation: rotation(&(moments * shape)),
            gradient,
            shape,
            stretch,
        }
    }

    /// Computes the goal position of each vertex: the mean of the positions to which the motions of all
    /// regions that contain the vertex move its rest position, weighted by the stiffness factors of the regions.
    ///
    /// # Panics
    ///
    /// If the number of motions is not the number of regions.
    pub fn goals(&self, motions: &[RegionMotion]) -> Vec<Vector3<f64>> {
        let factor = |region| self.factor(region) * self.share(region);
        self.means(motions, factor, |&motion, _| move |rest| motion.goal(rest))
    }

    /// Damps velocities as [`damped_velocities`](super::damped_velocities) does, with given motions.
    ///
    /// # Panics
    ///
    /// If the number of motions is not the number of regions, or that of velocities not the number of lattice vertices.
    pub fn damped_velocities(
        &self,
        motions: &[RegionMotion],
        velocities: &[Vector3<f64>],
        damping: f64,
    ) -> Vec<Vector3<f64>> {
        assert_eq!(velocities.len(), self.lattice.len(), "`velocities` must match the lattice vertices");
        let means = self.means(
            motions,
            |region| self.share(region),
            |&motion, members| {
                let (mut momentum, mut angular) = (Vector3::zeros(), Vector3::zeros());
                let mut inertia = Matrix3::zeros();
                for &i in members {
                    let (m, d, v) = (self.weight(i), motion.arm(self.rest(i)), velocities[i as usize]);
                    momentum += v * m;
                    angular += d.cross(&v) * m;
                    inertia += (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * m;
                }
                // The inertia is singular only for a region of one vertex, which has no angular velocity.
                let spin = inertia.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * angular);
                move |rest| momentum / motion.mass + spin.cross(&motion.arm(rest))
            },
        );
        velocities.iter().zip(&means).map(|(v, mean)| v + (mean - v) * damping).collect()
    }

    /// Computes, for each vertex, the mean of a value over the regions that contain it, weighted by the `factor` of
    /// each.
    ///
    /// `value`: returns, for the motion and the vertices of a region, the value as a function of the rest
    /// position.
    fn means<V: Fn(Vector3<f64>) -> Vector3<f64>>(
        &self,
        motions: &[RegionMotion],
        factor: impl Fn(u32) -> f64,
        value: impl Fn(&RegionMotion, &[u32]) -> V,
    ) -> Vec<Vector3<f64>> {
        assert_eq!(motions.len(), self.region_count(), "`motions` must match the regions");
        let mut means = vec![(Vector3::zeros(), 0.0); self.lattice.len()];
        for (region, motion) in self.regions().zip(motions) {
            let members = self.members(region);
            let value = value(motion, &members);
            let factor = factor(region);
            for &i in members.iter() {
                let (sum, weight) = &mut means[i as usize];
                *sum += value(self.rest(i)) * factor;
                *weight += factor;
            }
        }
        means.into_iter().map(|(sum, weight)| sum / weight).collect()
    }
}
