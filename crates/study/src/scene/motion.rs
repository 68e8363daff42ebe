//! Steps the motion of a point of the study, computed by the library or by naive sums.

use std::time::{Duration, Instant};

use nalgebra::Vector3;
use supple::{Body, Error, Simulation};
use supple_io::run::Prepared;
use supple_io::scene::Scene;

use super::naive::NaiveBody;
use super::setting::Sums;

/// The motion of a point.
pub(super) struct Motion<'a> {
    /// The simulation whose bodies are evaluated. With naive sums, it makes the steps of each frame as well,
    /// to update its constraints and contacts, and then receives the positions and velocities of the naive
    /// bodies.
    pub(super) simulation: Simulation,
    substeps: u64,
    /// One naive body for each body of the simulation; empty if the library computes the motion.
    naive: Vec<NaiveBody<'a>>,
}

impl<'a> Motion<'a> {
    /// Starts a motion that the library computes.
    pub(super) fn fast(prepared: Prepared) -> Self {
        let Prepared { simulation, substeps, .. } = prepared;
        Self { simulation, substeps: substeps.into(), naive: Vec::new() }
    }

    /// Starts a motion that `sums` computes. `model` is the same point, prepared a second time; the naive
    /// bodies borrow its lattices.
    ///
    /// # Errors
    ///
    /// Returns an error if a pin, handle or collider is invalid.
    pub(super) fn new(
        prepared: Prepared,
        model: &'a Prepared,
        scene: &Scene,
        sums: Sums,
    ) -> Result<Self, Error> {
        let mut motion = Self::fast(prepared);
        if let Sums::Naive(regions) = sums {
            let (dt, simulation) = (motion.simulation.dt(), &model.simulation);
            let colliders = (0..simulation.collider_count()).map(|index| simulation.collider(index));
            let colliders: Vec<_> = colliders.map(|collider| collider.description().clone()).collect();
            for body in simulation.bodies() {
                motion.naive.push(NaiveBody::new(
                    body,
                    (scene.simulation.gravity.value(0.0), &colliders),
                    dt,
                    regions,
                )?);
            }
        }
        Ok(motion)
    }

    /// Makes the steps of one frame and returns their run time.
    ///
    /// # Errors
    ///
    /// Returns an error if a position is not finite.
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

    /// Returns the positions of the lattice vertices of a body.
    pub(super) fn positions(&self, body: usize) -> Vec<Vector3<f64>> {
        match self.naive.get(body) {
            Some(naive) => naive.positions.clone(),
            None => self.simulation.body(body).positions().iter().map(|p| p.coords).collect(),
        }
    }

    /// Returns the masses of the vertices of a body in the fits of its regions, in masses of a full cell.
    pub(super) fn fit_masses(&self, body: usize) -> Vec<f64> {
        self.simulation.body(body).fit_masses()
    }

    /// Returns the goal positions at the current positions.
    pub(super) fn goals(&self, body: usize) -> Vec<Vector3<f64>> {
        match self.naive.get(body) {
            Some(naive) => naive.goals(),
            None => self.simulation.body(body).goals().iter().map(|p| p.coords).collect(),
        }
    }
}

/// Returns an upper bound of the number of visits in one evaluation of the naive sums. A visit is a pair of a
/// region and a vertex in it.
pub(super) fn visits(simulation: &Simulation) -> f64 {
    let of_body = |body: &Body| body.lattice().len() as f64 * (2.0 * body.half_width().cells() + 1.0).powi(3);
    simulation.bodies().iter().map(of_body).sum()
}

/// Returns whether a frame (counted from 1) is one of `count` sampled frames, which are evenly distributed
/// over all frames and include the last. If there are fewer frames than samples, every frame is sampled.
pub(super) fn is_sampled(frame: u32, frames: u32, count: u32) -> bool {
    let samples_until = |frame: u32| u64::from(frame) * u64::from(count) / u64::from(frames);
    samples_until(frame) != samples_until(frame - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sampled_frames_are_evenly_distributed() {
        let sampled = |frames, count| -> Vec<u32> {
            (1..=frames).filter(|&frame| is_sampled(frame, frames, count)).collect()
        };
        assert_eq!(sampled(12, 4), [3, 6, 9, 12]);
        assert_eq!(sampled(10, 4), [3, 5, 8, 10]);
        assert_eq!(sampled(3, 12), [1, 2, 3]);
        assert!(is_sampled(u32::MAX, u32::MAX, 12) && !is_sampled(1, u32::MAX, 12));
    }
}
