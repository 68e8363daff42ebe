//! A body stepped by the naive method: positions and velocities in f64, explicit sums over each region.
//!
//! Pins, handles and contacts are the core's own stages, and act on both alike.

use nalgebra::{Point3, Vector3};
use supple::dynamics::{
    BodyFrame, BodyState, Colliders, Contacts, Hold, Interval, Kinematics, KinematicsError, SampleCells,
};
use supple::reference::{Naive, RegionMotion, Regions};
use supple::scene::{BodyData, Scene};
use supple::{Body, Error, Lanes};

/// Slots in a block of [`Lanes`].
const SLOTS: usize = 8;

/// A body stepped by the naive method.
pub(crate) struct NaiveBody<'a> {
    naive: Naive<'a>,
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
        let Self { naive, positions, velocities, stages, .. } = self;
        if let Some(stages) = stages {
            stages.begin(interval, positions, velocities);
        }
        if self.damping > 0.0 {
            *velocities = naive.damped_velocities(&self.motions, velocities, self.damping);
        }
        if let Some(stages) = stages {
            stages.came(velocities);
        }
        self.motions = naive.motions(positions);
        let goals = naive.goals(&self.motions);
        for ((x, v), goal) in positions.iter_mut().zip(velocities.iter_mut()).zip(&goals) {
            *v += (goal - *x) * self.pull + self.gravity * self.dt;
            *x += *v * self.dt;
        }
        if let Some(stages) = stages {
            stages.end(interval, self.gravity, positions, velocities);
        }
        self.steps += 1;
    }
}

/// Pins, handles and contacts. They work on f32 with what was rounded away beside it: 48 bits of the positions.
struct Stages {
    kinematics: Kinematics,
    contacts: Option<(Contacts, Colliders)>,
    slots: Vec<u32>,
    frame: BodyFrame,
    positions: Lanes<3>,
    carry: Lanes<3>,
    velocities: Lanes<3>,
}

impl Stages {
    /// `None` if nothing holds the body and nothing can touch it.
    fn new(body: &Body, data: &BodyData, scene: &Scene) -> Result<Option<Self>, Error> {
        let lattice = body.lattice();
        let vertices = |selection| -> Result<_, Error> { Ok(body.select(selection)?) };
        let held = |hold: Result<Hold, KinematicsError>| -> Result<_, Error> { Ok(hold?) };
        let mut holds = Vec::new();
        for pin in &data.pins {
            holds.push(held(Hold::new(vertices(&pin.selection)?, pin.window, None))?);
        }
        for handle in &data.handles {
            holds.push(held(Hold::new(vertices(&handle.selection)?, handle.window, Some(&handle.keys)))?);
        }
        let colliders = Colliders::new(&scene.colliders)?;
        if holds.is_empty() && colliders.is_none() {
            return Ok(None);
        }
        let slots: Vec<u32> = (0..lattice.len() as u32).collect();
        let samples = || match body.mesh() {
            Some(mesh) => SampleCells::of_mesh(mesh, lattice, &slots),
            None => SampleCells::of_lattice(lattice, &slots),
        };
        let blocks = lattice.len().div_ceil(SLOTS);
        Ok(Some(Self {
            kinematics: Kinematics::new(lattice.len(), holds),
            contacts: colliders.map(|colliders| (Contacts::new(samples()), colliders)),
            frame: BodyFrame { origin: middle(&body.positions()), cell_size: lattice.cell_size() },
            positions: Lanes::zeros(blocks),
            carry: Lanes::zeros(blocks),
            velocities: Lanes::zeros(blocks),
            slots,
        }))
    }

    /// The state as the stages see it.
    fn shared(&mut self) -> BodyState<'_> {
        BodyState {
            positions: &mut self.positions,
            carry: Some(&mut self.carry),
            velocities: &mut self.velocities,
            frame: self.frame,
        }
    }

    fn write(&mut self, positions: &[Vector3<f64>], velocities: &[Vector3<f64>]) {
        let (frame, mut state) = (self.frame, self.shared());
        for (slot, (&x, v)) in (0..).zip(positions.iter().zip(velocities)) {
            state.set_position(slot, frame.to_local(&x.into()));
            state.set_velocity(slot, v / frame.cell_size);
        }
    }

    fn begin(&mut self, interval: Interval, positions: &[Vector3<f64>], velocities: &[Vector3<f64>]) {
        self.write(positions, velocities);
        let Self { kinematics, slots, frame, positions, carry, velocities, .. } = self;
        let state = BodyState { positions, carry: Some(carry), velocities, frame: *frame };
        kinematics.begin(interval, &state, slots);
    }

    /// Contacts note the velocities with which the surface comes.
    fn came(&mut self, velocities: &[Vector3<f64>]) {
        let cell_size = self.frame.cell_size;
        let Some((contacts, _)) = &mut self.contacts else { return };
        for (slot, v) in (0..).zip(velocities) {
            self.velocities.set(slot, (v / cell_size).map(|v| v as f32).into());
        }
        contacts.begin(&self.velocities);
    }

    /// Contacts, pins and handles act; what they leave alone keeps its bits.
    fn end(
        &mut self,
        interval: Interval,
        gravity: Vector3<f64>,
        positions: &mut [Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) {
        self.write(positions, velocities);
        let mut changed: Vec<u32> = Vec::new();
        let Self { kinematics, contacts, slots, frame, .. } = self;
        let mut state = BodyState {
            positions: &mut self.positions,
            carry: Some(&mut self.carry),
            velocities: &mut self.velocities,
            frame: *frame,
        };
        if let Some((contacts, colliders)) = contacts {
            contacts.resolve(&mut state, colliders, interval, gravity.into());
            changed.extend(contacts.touched());
        }
        kinematics.apply(interval, &mut state, slots);
        changed.extend((0..).zip(kinematics.held()).filter(|(_, held)| **held).map(|(vertex, _)| vertex));
        for vertex in changed {
            positions[vertex as usize] = frame.to_world(state.position(vertex)).coords;
            velocities[vertex as usize] = state.velocity(vertex) * frame.cell_size;
        }
    }
}

fn middle(points: &[Point3<f64>]) -> Point3<f64> {
    let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
    (sum / points.len() as f64).into()
}
