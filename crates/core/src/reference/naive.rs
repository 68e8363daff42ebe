//! The naive method on one lattice, whose regions and weights are found once.

use std::borrow::Cow;

use nalgebra::{Matrix3, Vector3};

use super::{Regions, Weights, region, rotation, weights};
use crate::lattice::Lattice;

/// The naive method on one lattice, with what repeated evaluations share.
#[derive(Clone, Debug)]
pub struct Naive<'a> {
    lattice: &'a Lattice,
    half_width: usize,
    regions: Regions,
    weights: Weights,
    /// The members of each region; none if they are looked up each time.
    listed: Option<Vec<Vec<u32>>>,
}

/// The rigid motion from rest that fits a region best (Müller et al. 2005).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionMotion {
    /// Sum of the weights of the region's vertices, in masses of a full cell.
    pub mass: f64,
    /// Weighted mean of the rest positions, relative to the lattice's origin.
    pub rest_centroid: Vector3<f64>,
    /// Weighted mean of the positions.
    pub centroid: Vector3<f64>,
    /// The rotation from rest.
    pub rotation: Matrix3<f64>,
}

impl RegionMotion {
    /// A rest position, relative to the lattice's origin, from the region's center and turned.
    fn arm(&self, rest: Vector3<f64>) -> Vector3<f64> {
        self.rotation * (rest - self.rest_centroid)
    }

    /// Where the motion puts a rest position.
    fn goal(&self, rest: Vector3<f64>) -> Vector3<f64> {
        self.centroid + self.arm(rest)
    }
}

impl<'a> Naive<'a> {
    /// The method with regions of half-width `half_width` in cells, which are looked up each time.
    pub fn new(lattice: &'a Lattice, half_width: usize, regions: Regions) -> Self {
        let weights = weights(lattice, half_width, regions);
        Self { lattice, half_width, regions, weights, listed: None }
    }

    /// The same with its regions listed: up to `4 (2 w + 1)^3` bytes for each lattice vertex.
    pub fn listed(self) -> Self {
        let listed = self.vertices().map(|vertex| self.members(vertex).into_owned()).collect();
        Self { listed: Some(listed), ..self }
    }

    /// The masses, and in how many regions each vertex is.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    fn vertices(&self) -> std::ops::Range<u32> {
        0..self.lattice.len() as u32
    }

    /// The vertices of the region of `vertex`, sorted.
    fn members(&self, vertex: u32) -> Cow<'_, [u32]> {
        match &self.listed {
            Some(listed) => Cow::Borrowed(&listed[vertex as usize]),
            None => Cow::Owned(region(self.lattice, vertex, self.half_width, self.regions)),
        }
    }

    /// Rest position of a vertex relative to the lattice's origin.
    fn rest(&self, vertex: u32) -> Vector3<f64> {
        Vector3::from(self.lattice.indices()[vertex as usize].map(f64::from)) * self.lattice.cell_size()
    }

    /// The motion of the region of each vertex: its rest shape matched to the positions.
    ///
    /// # Panics
    ///
    /// If the number of positions is not the number of lattice vertices.
    pub fn motions(&self, positions: &[Vector3<f64>]) -> Vec<RegionMotion> {
        assert_eq!(positions.len(), self.lattice.len(), "one position per lattice vertex");
        self.vertices().map(|vertex| self.motion(&self.members(vertex), positions)).collect()
    }

    fn motion(&self, members: &[u32], positions: &[Vector3<f64>]) -> RegionMotion {
        let mass: f64 = members.iter().map(|&i| self.weights.of(i)).sum();
        let mean = |value: &dyn Fn(u32) -> Vector3<f64>| -> Vector3<f64> {
            members.iter().map(|&i| value(i) * self.weights.of(i)).sum::<Vector3<f64>>() / mass
        };
        let rest_centroid = mean(&|i| self.rest(i));
        let centroid = mean(&|i| positions[i as usize]);
        let moments: Matrix3<f64> = members
            .iter()
            .map(|&i| {
                (positions[i as usize] - centroid)
                    * (self.rest(i) - rest_centroid).transpose()
                    * self.weights.of(i)
            })
            .sum();
        RegionMotion { mass, rest_centroid, centroid, rotation: rotation(&moments) }
    }

    /// The goal positions: for each vertex the mean, over the regions that hold it, of where their motions put it.
    ///
    /// # Panics
    ///
    /// If the number of motions is not the number of lattice vertices.
    pub fn goals(&self, motions: &[RegionMotion]) -> Vec<Vector3<f64>> {
        self.means(motions, |&motion, _| move |rest| motion.goal(rest))
    }

    /// Velocities drawn towards the mean rigid velocity of the regions: [`damped_velocities`](super::damped_velocities)
    /// with motions that are known.
    ///
    /// # Panics
    ///
    /// If the number of motions or velocities is not the number of lattice vertices.
    pub fn damped_velocities(
        &self,
        motions: &[RegionMotion],
        velocities: &[Vector3<f64>],
        damping: f64,
    ) -> Vec<Vector3<f64>> {
        assert_eq!(velocities.len(), self.lattice.len(), "one velocity per lattice vertex");
        let means = self.means(motions, |&motion, members| {
            let (mut momentum, mut angular) = (Vector3::zeros(), Vector3::zeros());
            let mut inertia = Matrix3::zeros();
            for &i in members {
                let (m, d, v) = (self.weights.of(i), motion.arm(self.rest(i)), velocities[i as usize]);
                momentum += v * m;
                angular += d.cross(&v) * m;
                inertia += (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * m;
            }
            // Only a region of one vertex has no inertia, and no spin either.
            let spin = inertia.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * angular);
            move |rest| momentum / motion.mass + spin.cross(&motion.arm(rest))
        });
        velocities.iter().zip(&means).map(|(v, mean)| v + (mean - v) * damping).collect()
    }

    /// For each vertex the mean, over the regions that hold it, of a value that a region gives to rest positions.
    fn means<V: Fn(Vector3<f64>) -> Vector3<f64>>(
        &self,
        motions: &[RegionMotion],
        value: impl Fn(&RegionMotion, &[u32]) -> V,
    ) -> Vec<Vector3<f64>> {
        assert_eq!(motions.len(), self.lattice.len(), "one motion per lattice vertex");
        let mut means = vec![Vector3::zeros(); motions.len()];
        for (vertex, motion) in self.vertices().zip(motions) {
            let members = self.members(vertex);
            let value = value(motion, &members);
            for &i in members.iter() {
                means[i as usize] += value(self.rest(i)) / self.weights.counts[i as usize] as f64;
            }
        }
        means
    }

    /// Half the sum, over all regions, of the weighted squared distances of their vertices from where the motions put
    /// them: its gradient is `m_i (x_i - g_i)`. Times `alpha / dt^2`, and the mass of a full cell, it is the elastic
    /// energy of the body.
    ///
    /// # Panics
    ///
    /// If the number of motions or positions is not the number of lattice vertices.
    pub fn mismatch(&self, motions: &[RegionMotion], positions: &[Vector3<f64>]) -> f64 {
        assert_eq!(motions.len(), self.lattice.len(), "one motion per lattice vertex");
        assert_eq!(positions.len(), self.lattice.len(), "one position per lattice vertex");
        let of_region = |(vertex, motion): (u32, &RegionMotion)| -> f64 {
            let members = self.members(vertex);
            let distance = |i: u32| positions[i as usize] - motion.goal(self.rest(i));
            members.iter().map(|&i| self.weights.of(i) * distance(i).norm_squared()).sum()
        };
        self.vertices().zip(motions).map(of_region).sum::<f64>() / 2.0
    }

    /// The energy of a body that is drawn to its goals by `alpha` in each step: in masses of a full cell times squared
    /// units of the positions, per step squared.
    ///
    /// A step is one of the leapfrog method, which does not keep kinetic and elastic energy themselves. Of a harmonic
    /// motion it keeps the elastic energy at the positions and the kinetic one of the velocities before and after the
    /// pull there, multiplied: what that sum gains is of the method. `velocities`: those before the pull, per step.
    ///
    /// # Panics
    ///
    /// If the number of positions or velocities is not the number of lattice vertices.
    pub fn energy(&self, positions: &[Vector3<f64>], velocities: &[Vector3<f64>], alpha: f64) -> f64 {
        assert_eq!(velocities.len(), self.lattice.len(), "one velocity per lattice vertex");
        let motions = self.motions(positions);
        let goals = self.goals(&motions);
        let vertices = goals.iter().zip(positions).zip(velocities).zip(&self.weights.masses);
        let kinetic = vertices.map(|(((goal, x), v), m)| 0.5 * m * v.dot(&(v + (goal - x) * alpha)));
        kinetic.sum::<f64>() + alpha * self.mismatch(&motions, positions)
    }
}
