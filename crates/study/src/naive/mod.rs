//! A body stepped by the naive method: positions and velocities in f64, explicit sums over each region.
//!
//! Pins, handles and contacts are the core's own stages, and act on both alike.

mod stages;

use nalgebra::Vector3;
use supple::reference::{Mass, Momenta, Naive, RegionMotion, Regions};
use supple::state::Interval;
use supple::{Body, Error};
use supple_io::scene::{BodyData, Scene};

use stages::Stages;

/// A body stepped by the naive method.
pub(crate) struct NaiveBody<'a> {
    naive: Naive<'a>,
    /// The component of the lattice that each vertex belongs to.
    components: &'a supple::Components,
    /// Those of the step before: damping takes the rotations from them, as the core does.
    motions: Vec<RegionMotion>,
    /// In scene units.
    pub(crate) positions: Vec<Vector3<f64>>,
    /// In scene units per second.
    pub(crate) velocities: Vec<Vector3<f64>>,
    /// alpha/dt, in 1/s.
    pull: f64,
    damping: f64,
    gravity: Vector3<f64>,
    dt: f64,
    steps: u64,
    stages: Option<Stages>,
}

impl<'a> NaiveBody<'a> {
    /// A body as it is now, at time 0, in a scene whose steps take `dt` seconds.
    ///
    /// # Errors
    ///
    /// Colliders, pins or handles that cannot be; the core would have refused the same.
    pub(crate) fn new(
        body: &'a Body,
        data: &BodyData,
        scene: &Scene,
        dt: f64,
        regions: Regions,
    ) -> Result<Self, Error> {
        let naive = Naive::new(body.lattice(), body.half_width(), regions).listed();
        let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
        let material = body.material();
        Ok(Self {
            motions: naive.motions(&positions),
            components: body.lattice().components(),
            naive,
            positions,
            velocities: body.velocities(),
            pull: material.alpha(dt) / dt,
            damping: material.damping_share(dt),
            gravity: scene.simulation.gravity.into(),
            dt,
            steps: 0,
            stages: Stages::new(body, data, scene)?,
        })
    }

    /// The goal positions that its sums give where it is now.
    pub(crate) fn goals(&self) -> Vec<Vector3<f64>> {
        self.naive.goals(&self.naive.motions(&self.positions))
    }

    /// One step, stage for stage as the core's.
    pub(crate) fn step(&mut self) {
        let interval = Interval::of_step(self.steps, self.dt);
        if let Some(stages) = &mut self.stages {
            stages.begin(interval, &self.positions, &self.velocities);
        }
        let books = self.momenta();
        if self.damping > 0.0 {
            self.velocities = self.naive.damped_velocities(&self.motions, &self.velocities, self.damping);
        }
        if let Some(stages) = &mut self.stages {
            stages.came(&self.velocities);
        }
        self.motions = self.naive.motions(&self.positions);
        let goals = self.naive.goals(&self.motions);
        for ((x, v), goal) in self.positions.iter().zip(&mut self.velocities).zip(&goals) {
            *v += (goal - x) * self.pull + self.gravity * self.dt;
        }
        self.keep(&books);
        for (x, v) in self.positions.iter_mut().zip(&self.velocities) {
            *x += v * self.dt;
        }
        if let Some(stages) = &mut self.stages {
            stages.end(interval, self.gravity, &mut self.positions, &mut self.velocities);
        }
        self.steps += 1;
    }

    /// The vertices of a component of the lattice.
    fn masses(&self, component: usize) -> impl Iterator<Item = Mass> + Clone {
        let of_vertex = self.components.of_vertex.iter().enumerate();
        of_vertex.filter(move |(_, of)| **of as usize == component).map(|(v, _)| Mass {
            mass: self.naive.weights().masses[v],
            position: self.positions[v],
            velocity: self.velocities[v],
        })
    }

    /// The momenta of each component of which nothing is held.
    fn momenta(&self) -> Vec<Option<Momenta>> {
        let mut held = vec![false; self.components.count];
        for (vertex, &component) in self.components.of_vertex.iter().enumerate() {
            held[component as usize] |= self.stages.as_ref().is_some_and(|stages| stages.holds(vertex));
        }
        (0..)
            .zip(held)
            .map(|(component, held)| (!held).then(|| Momenta::of(self.masses(component))))
            .collect()
    }

    /// Gives the momenta back that a step before contacts must not change but by gravity. Without the core's books of them,
    /// the damping of a deformed body, whose lever arms are those of the rest shape, would slow its spin.
    fn keep(&mut self, books: &[Option<Momenta>]) {
        for (component, book) in books.iter().enumerate() {
            let Some(book) = book else { continue };
            let aim = Momenta { linear: book.linear + self.gravity * (self.dt * book.mass), ..*book };
            let now = Momenta::of(self.masses(component));
            let (velocity, spin) = now.missing(&aim, self.masses(component));
            for (vertex, v) in self.velocities.iter_mut().enumerate() {
                if self.components.of_vertex[vertex] as usize == component {
                    *v += velocity + spin.cross(&(self.positions[vertex] - now.centre));
                }
            }
        }
    }
}
