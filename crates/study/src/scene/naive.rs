//! Steps a body by the naive method: positions and velocities in f64, explicit sums over each region.
//!
//! Pins, handles and contacts use the code of the library.

use nalgebra::{Point3, Vector3};
use supple::internals::{
    BodyFrame, BodyState, Colliders, Constraint, Constraints, Contacts, Interval, Lanes, SampleCells,
    constraint_factors,
};
use supple::reference::{Mass, Momenta, Naive, RegionMotion, Regions};
use supple::{Body, Collider, Error, Executor, SkinKind};

use crate::elasticity::{alpha, relative_masses};

/// A body stepped by the naive method.
pub(super) struct NaiveBody<'a> {
    naive: Naive<'a>,
    /// Masses of the vertices in masses of a full cell. Constrained vertices have other masses in the fits.
    masses: Vec<f64>,
    body: &'a Body,
    /// Connected components of the lattice.
    components: &'a supple::Components,
    /// Region motions of the previous step. Region damping uses their rotations, as in the library.
    motions: Vec<RegionMotion>,
    /// Positions, in scene units.
    pub(super) positions: Vec<Vector3<f64>>,
    /// Velocities, in scene units per second.
    pub(super) velocities: Vec<Vector3<f64>>,
    /// alpha/dt, in 1/s.
    stiffness_rate: f64,
    damping: f64,
    gravity: Vector3<f64>,
    dt: f64,
    steps: u64,
    stages: Option<Stages>,
}

impl<'a> NaiveBody<'a> {
    /// Creates a naive body from the state of a body at time 0, for steps of `dt` seconds.
    ///
    /// # Errors
    ///
    /// Returns an error if a collider, pin or handle is invalid, as the library does.
    pub(super) fn new(
        body: &'a Body,
        (gravity, colliders): ([f64; 3], &[Collider]),
        dt: f64,
        regions: Regions,
    ) -> Result<Self, Error> {
        let masses = relative_masses(body);
        let naive = Naive::new(body.lattice(), body.half_width(), regions)
            .with_material_of(body)
            .with_masses(masses.clone())
            .listed();
        let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
        let material = body.material();
        Ok(Self {
            motions: naive.motions(&positions),
            components: body.lattice().components(),
            naive,
            masses,
            body,
            positions,
            velocities: body.velocities(),
            stiffness_rate: alpha(body, dt) / dt,
            damping: material.region_damping_fraction(dt),
            gravity: gravity.into(),
            dt,
            steps: 0,
            stages: Stages::new(body, colliders)?,
        })
    }

    /// Returns the goal positions at the current positions.
    pub(super) fn goals(&self) -> Vec<Vector3<f64>> {
        self.naive.goals(&self.naive.motions(&self.positions))
    }

    /// Makes one step. Its stages run in the same order as in the library.
    pub(super) fn step(&mut self) {
        let interval = Interval::of_step(self.steps, self.dt);
        if let Some(stages) = &mut self.stages
            && stages.begin(interval, &self.positions, &self.velocities)
        {
            self.update_fit_masses();
        }
        let before = self.momenta();
        if self.damping > 0.0 {
            self.velocities = self.naive.damped_velocities(&self.motions, &self.velocities, self.damping);
        }
        if let Some(stages) = &mut self.stages {
            stages.begin_contacts(&self.velocities);
        }
        self.motions = self.naive.motions(&self.positions);
        let goals = self.naive.goals(&self.motions);
        self.flow();
        for ((x, v), goal) in self.positions.iter().zip(&mut self.velocities).zip(&goals) {
            *v += (goal - x) * self.stiffness_rate + self.gravity * self.dt;
        }
        self.restore_momenta(&before);
        for (x, v) in self.positions.iter_mut().zip(&self.velocities) {
            *x += v * self.dt;
        }
        if let Some(stages) = &mut self.stages {
            stages.end(interval, self.gravity, &mut self.positions, &mut self.velocities);
        }
        self.steps += 1;
    }

    /// Lets the plastic shapes flow.
    fn flow(&mut self) {
        let Some(plastic) = &self.body.material().plastic else { return };
        let shapes = self.naive.flowed(&self.motions, plastic, self.dt);
        // Region damping uses the new shapes with the rotations of this step.
        for (motion, &shape) in self.motions.iter_mut().zip(&shapes) {
            motion.shape = shape;
        }
        self.naive.set_shapes(shapes);
    }

    /// Gives the constrained vertices more mass in the fits, as the library does. Region damping uses the masses of
    /// this step with the rotations of the previous step.
    fn update_fit_masses(&mut self) {
        let Some(stages) = &self.stages else { return };
        let factors = constraint_factors(self.body, stages.constraints.constrained());
        // The library rounds to f32.
        let masses = self.masses.iter().zip(factors);
        self.naive
            .set_masses(masses.map(|(mass, factor)| f64::from((mass * f64::from(factor)) as f32)).collect());
        let motions = self.naive.motions(&self.positions);
        for (motion, new) in self.motions.iter_mut().zip(motions) {
            *motion = RegionMotion { rotation: motion.rotation, ..new };
        }
    }

    /// Returns the vertices of a connected component of the lattice as point masses.
    fn point_masses(&self, component: usize) -> impl Iterator<Item = Mass> + Clone {
        let vertices = self.components.of_vertex.iter().enumerate();
        vertices.filter(move |(_, other)| **other as usize == component).map(|(v, _)| Mass {
            mass: self.masses[v],
            position: self.positions[v],
            velocity: self.velocities[v],
        })
    }

    /// Returns the momenta of each connected component; `None` for components with constrained vertices.
    fn momenta(&self) -> Vec<Option<Momenta>> {
        let mut is_constrained = vec![false; self.components.count];
        for (vertex, &component) in self.components.of_vertex.iter().enumerate() {
            is_constrained[component as usize] |=
                self.stages.as_ref().is_some_and(|stages| stages.is_constrained(vertex));
        }
        (0..)
            .zip(is_constrained)
            .map(|(component, constrained)| (!constrained).then(|| Momenta::of(self.point_masses(component))))
            .collect()
    }

    /// Restores the momenta, as the momentum tracker of the library does: before contacts, only gravity may
    /// change them. Without this correction damping would slow the spin of a deformed body, because it uses
    /// the lever arms of the rest shape.
    fn restore_momenta(&mut self, before: &[Option<Momenta>]) {
        for (component, before) in before.iter().enumerate() {
            let Some(before) = before else { continue };
            let target =
                Momenta { linear: before.linear + self.gravity * (self.dt * before.mass), ..*before };
            let now = Momenta::of(self.point_masses(component));
            let (velocity, spin) = now.missing(&target, self.point_masses(component));
            for (vertex, v) in self.velocities.iter_mut().enumerate() {
                if self.components.of_vertex[vertex] as usize == component {
                    *v += velocity + spin.cross(&(self.positions[vertex] - now.center));
                }
            }
        }
    }
}

/// Number of vertices in a SIMD block of [`Lanes`].
const SLOTS: usize = 8;

/// Pins, handles and contacts, computed by the library.
struct Stages {
    constraints: Constraints,
    contacts: Option<(Contacts, Colliders)>,
    /// Slot (index in the storage order of `state`) of each vertex: here the index of the vertex itself.
    slots: Vec<u32>,
    state: SingleState,
}

/// The state of the body in the format of the library: f32. Each position has a compensation, a second f32
/// with its rounding error, which gives positions of 48 bits.
struct SingleState {
    frame: BodyFrame,
    positions: Lanes<3>,
    compensation: Lanes<3>,
    velocities: Lanes<3>,
}

impl SingleState {
    fn new(body: &Body) -> Self {
        let (lattice, points) = (body.lattice(), body.positions());
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        let origin: Point3<f64> = (sum / points.len() as f64).into();
        let zeros = || Lanes::zeros(lattice.len().div_ceil(SLOTS));
        Self {
            frame: BodyFrame { origin, cell_size: lattice.cell_size() },
            positions: zeros(),
            compensation: zeros(),
            velocities: zeros(),
        }
    }

    fn body_state(&mut self) -> BodyState<'_> {
        let Self { frame, positions, compensation, velocities } = self;
        BodyState { positions, compensation: Some(compensation), velocities, frame: *frame }
    }

    /// Sets positions and velocities, and returns a view of the state.
    fn set(&mut self, positions: &[Vector3<f64>], velocities: &[Vector3<f64>]) -> BodyState<'_> {
        let frame = self.frame;
        let mut state = self.body_state();
        for (slot, (&x, v)) in (0..).zip(positions.iter().zip(velocities)) {
            state.set_position(slot, frame.to_local(&x.into()));
            state.set_velocity(slot, v / frame.cell_size);
        }
        state
    }
}

impl Stages {
    /// Creates constraints and contacts. Returns `None` if there are neither constraints nor colliders.
    fn new(body: &Body, colliders: &[Collider]) -> Result<Option<Self>, Error> {
        let lattice = body.lattice();
        let constraints: Vec<Constraint> = body.constraints().cloned().collect();
        let colliders = Colliders::new(colliders)?;
        if constraints.is_empty() && colliders.is_empty() {
            return Ok(None);
        }
        let slots: Vec<u32> = (0..lattice.len() as u32).collect();
        let masses: Vec<f32> = relative_masses(body).iter().map(|&mass| mass as f32).collect();
        let samples = || match body.mesh() {
            Some(mesh) => {
                let samples = SampleCells::of_mesh(mesh, lattice, &slots, &masses);
                match body.skin() {
                    SkinKind::Smooth => samples.smoothed(lattice, &slots, &masses),
                    _ => samples,
                }
            }
            None => SampleCells::of_lattice(lattice, &slots, &masses),
        };
        Ok(Some(Self {
            constraints: Constraints::new(lattice.len(), constraints),
            contacts: (!colliders.is_empty()).then(|| (Contacts::new(samples()), colliders)),
            state: SingleState::new(body),
            slots,
        }))
    }

    /// Begins the constraints of a step. Returns whether a constraint began or ended.
    fn begin(&mut self, interval: Interval, positions: &[Vector3<f64>], velocities: &[Vector3<f64>]) -> bool {
        let state = (&self.state.set(positions, velocities), &self.slots[..]);
        self.constraints.begin(interval, state, &Executor::sequential())
    }

    /// Returns whether a vertex is constrained in the current step.
    fn is_constrained(&self, vertex: usize) -> bool {
        self.constraints.constrained()[vertex]
    }

    /// Stores the velocities before the step for the contacts.
    fn begin_contacts(&mut self, velocities: &[Vector3<f64>]) {
        let Some((contacts, _)) = &mut self.contacts else { return };
        for (slot, v) in (0..).zip(velocities) {
            self.state.velocities.set(slot, (v / self.state.frame.cell_size).map(|v| v as f32).into());
        }
        contacts.begin(&self.state.velocities);
    }

    /// Applies contacts, pins and handles. Only vertices that are in contact or constrained are copied back
    /// from f32; the other vertices keep their f64 values.
    fn end(
        &mut self,
        interval: Interval,
        gravity: Vector3<f64>,
        positions: &mut [Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) {
        let Self { constraints, contacts, slots, state } = self;
        let (frame, mut state) = (state.frame, state.set(positions, velocities));
        let mut changed: Vec<u32> = Vec::new();
        if let Some((contacts, colliders)) = contacts {
            contacts.resolve(&mut state, colliders, interval, gravity.into());
            changed.extend(contacts.touched());
        }
        constraints.apply(interval, &mut state, slots);
        let constrained = (0..).zip(constraints.constrained()).filter(|(_, constrained)| **constrained);
        changed.extend(constrained.map(|(vertex, _)| vertex));
        for vertex in changed {
            positions[vertex as usize] = frame.to_world(state.position(vertex)).coords;
            velocities[vertex as usize] = state.velocity(vertex) * frame.cell_size;
        }
    }
}
