//! A point of the study in motion, by the core or by the naive sums.

use std::time::{Duration, Instant};

use nalgebra::Vector3;
use supple::{Error, Simulation};
use supple_io::run::Prepared;
use supple_io::scene::Scene;

use crate::naive::NaiveBody;
use crate::setting::Sums;

/// A point in motion.
pub(crate) struct Motion<'a> {
    /// What is looked at. Beside the naive sums it makes the same frames, so that it knows what is held and what is
    /// pushed, and is then put where these are.
    pub(crate) simulation: Simulation,
    substeps: u64,
    /// One for each body; none where the core steps.
    naive: Vec<NaiveBody<'a>>,
}

impl<'a> Motion<'a> {
    /// A point in motion by the core, from time 0.
    pub(crate) fn fast(prepared: Prepared) -> Self {
        let Prepared { simulation, substeps, .. } = prepared;
        Self { simulation, substeps: substeps.into(), naive: Vec::new() }
    }

    /// The same by the sums that are asked for. `model` is the point once more: the naive sums look their lattices up
    /// in it.
    ///
    /// # Errors
    ///
    /// Pins, handles or colliders that cannot be.
    pub(crate) fn new(
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
    pub(crate) fn frame(&mut self) -> Result<Duration, Error> {
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
    pub(crate) fn positions(&self, body: usize) -> Vec<Vector3<f64>> {
        match self.naive.get(body) {
            Some(naive) => naive.positions.clone(),
            None => self.simulation.body(body).positions().iter().map(|p| p.coords).collect(),
        }
    }

    /// The goal positions that its sums give where it is now.
    pub(crate) fn goals(&self, body: usize) -> Vec<Vector3<f64>> {
        match self.naive.get(body) {
            Some(naive) => naive.goals(),
            None => self.simulation.body(body).goals().iter().map(|p| p.coords).collect(),
        }
    }
}
