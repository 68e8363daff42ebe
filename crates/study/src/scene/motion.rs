//! A point of the study in motion, by the core or by the naive sums.

use std::time::{Duration, Instant};

use nalgebra::Vector3;
use supple::{Body, Error, Simulation};
use supple_io::run::Prepared;
use supple_io::scene::Scene;

use super::naive::NaiveBody;
use super::setting::Sums;

/// A point in motion.
pub(super) struct Motion<'a> {
    /// What is looked at. Beside the naive sums it makes the same frames, so that it knows what is held and what is
    /// pushed, and is then put where these are.
    pub(super) simulation: Simulation,
    substeps: u64,
    /// One for each body; none where the core steps.
    naive: Vec<NaiveBody<'a>>,
}

impl<'a> Motion<'a> {
    /// A point in motion by the core, from time 0.
    pub(super) fn fast(prepared: Prepared) -> Self {
        let Prepared { simulation, substeps, .. } = prepared;
        Self { simulation, substeps: substeps.into(), naive: Vec::new() }
    }

    /// The same by the sums that are asked for. `model` is the point once more: the naive sums look their lattices up
    /// in it.
    ///
    /// # Errors
    ///
    /// Pins, handles or colliders that cannot be.
    pub(super) fn new(
        prepared: Prepared,
        model: &'a Prepared,
        scene: &Scene,
        sums: Sums,
    ) -> Result<Self, Error> {
        let mut motion = Self::fast(prepared);
        if let Sums::Naive(regions) = sums {
            let dt = motion.simulation.dt();
            for (body, data) in model.simulation.bodies().iter().zip(&scene.bodies) {
                motion.naive.push(NaiveBody::new(body, data, scene, dt, regions)?);
            }
        }
        Ok(motion)
    }

    /// Steps a frame; says how long the steps took.
    ///
    /// # Errors
    ///
    /// Positions that are no longer finite.
    pub(super) fn frame(&mut self) -> Result<Duration, Error> {
        let start = Instant::now();
        if self.naive.is_empty() {
            self.simulation.steps(self.substeps);
            return Ok(start.elapsed());
        }
        for body in &mut self.naive {
            (0..self.substeps).for_each(|_| body.step());
        }
        let elapsed = start.elapsed();
        self.simulation.steps(self.substeps);
        for (body, naive) in self.simulation.bodies_mut().iter_mut().zip(&self.naive) {
            let points: Vec<_> = naive.positions.iter().map(|&x| x.into()).collect();
            body.set_positions(&points)?;
            body.set_velocities(&naive.velocities)?;
        }
        Ok(elapsed)
    }

    /// Where the vertices of a body are.
    pub(super) fn positions(&self, body: usize) -> Vec<Vector3<f64>> {
        match self.naive.get(body) {
            Some(naive) => naive.positions.clone(),
            None => self.simulation.body(body).positions().iter().map(|p| p.coords).collect(),
        }
    }

    /// The goal positions that its sums give where it is now.
    pub(super) fn goals(&self, body: usize) -> Vec<Vector3<f64>> {
        match self.naive.get(body) {
            Some(naive) => naive.goals(),
            None => self.simulation.body(body).goals().iter().map(|p| p.coords).collect(),
        }
    }
}

/// Visits of a vertex by a region in one evaluation of the naive sums.
pub(super) fn visits(simulation: &Simulation) -> f64 {
    let of_body = |body: &Body| body.lattice().len() as f64 * (2.0 * body.half_width() as f64 + 1.0).powi(3);
    simulation.bodies().iter().map(of_body).sum()
}

/// Whether a frame, from 1 on, is one of so many moments, spread evenly over all frames, the last among them. Of fewer
/// frames than moments each is one.
pub(super) fn is_moment(frame: u32, frames: u32, moments: u32) -> bool {
    let before = |frame: u32| u64::from(frame) * u64::from(moments) / u64::from(frames);
    before(frame) != before(frame - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_spread_evenly() {
        let of = |frames, moments| -> Vec<u32> {
            (1..=frames).filter(|&frame| is_moment(frame, frames, moments)).collect()
        };
        assert_eq!(of(12, 4), [3, 6, 9, 12]);
        assert_eq!(of(10, 4), [3, 5, 8, 10]);
        assert_eq!(of(3, 12), [1, 2, 3]);
        assert!(is_moment(u32::MAX, u32::MAX, 12) && !is_moment(1, u32::MAX, 12));
    }
}
