//! Pins, handles and contacts beside the naive sums: the core's own stages.

use nalgebra::{Point3, Vector3};
use supple::dynamics::{Constraint, ConstraintError, Constraints};
use supple::internals::{Colliders, Contacts, SampleCells};
use supple::state::{BodyFrame, BodyState, Interval};
use supple::{Body, Error, Lanes};
use supple_io::scene::{BodyData, Scene};

/// Slots in a block of [`Lanes`].
const SLOTS: usize = 8;

/// Pins, handles and contacts. They work on f32 with what was rounded away beside it: 48 bits of the positions.
pub(super) struct Stages {
    kinematics: Constraints,
    contacts: Option<(Contacts, Colliders)>,
    slots: Vec<u32>,
    frame: BodyFrame,
    positions: Lanes<3>,
    carry: Lanes<3>,
    velocities: Lanes<3>,
}

impl Stages {
    /// `None` if nothing holds the body and nothing can touch it.
    pub(super) fn new(body: &Body, data: &BodyData, scene: &Scene) -> Result<Option<Self>, Error> {
        let lattice = body.lattice();
        let vertices = |selection| -> Result<_, Error> { Ok(body.select(selection)?) };
        let held = |hold: Result<Constraint, ConstraintError>| -> Result<_, Error> { Ok(hold?) };
        let mut holds = Vec::new();
        for pin in &data.pins {
            holds.push(held(Constraint::new(vertices(&pin.selection)?, pin.window, None))?);
        }
        for handle in &data.handles {
            holds.push(held(Constraint::new(
                vertices(&handle.selection)?,
                handle.window,
                Some(&handle.keys),
            ))?);
        }
        let colliders = Colliders::new(&scene.colliders)?;
        if holds.is_empty() && colliders.is_empty() {
            return Ok(None);
        }
        let slots: Vec<u32> = (0..lattice.len() as u32).collect();
        let samples = || match body.mesh() {
            Some(mesh) => SampleCells::of_mesh(mesh, lattice, &slots),
            None => SampleCells::of_lattice(lattice, &slots),
        };
        let blocks = lattice.len().div_ceil(SLOTS);
        Ok(Some(Self {
            kinematics: Constraints::new(lattice.len(), holds),
            contacts: (!colliders.is_empty()).then(|| (Contacts::new(samples()), colliders)),
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

    pub(super) fn begin(
        &mut self,
        interval: Interval,
        positions: &[Vector3<f64>],
        velocities: &[Vector3<f64>],
    ) {
        self.write(positions, velocities);
        let Self { kinematics, slots, frame, positions, carry, velocities, .. } = self;
        let state = BodyState { positions, carry: Some(carry), velocities, frame: *frame };
        kinematics.begin(interval, &state, slots);
    }

    /// Whether a pin or a handle holds a vertex in the step that was begun last.
    pub(super) fn holds(&self, vertex: usize) -> bool {
        self.kinematics.held()[vertex]
    }

    /// Contacts note the velocities with which the surface comes.
    pub(super) fn came(&mut self, velocities: &[Vector3<f64>]) {
        let cell_size = self.frame.cell_size;
        let Some((contacts, _)) = &mut self.contacts else { return };
        for (slot, v) in (0..).zip(velocities) {
            self.velocities.set(slot, (v / cell_size).map(|v| v as f32).into());
        }
        contacts.begin(&self.velocities);
    }

    /// Contacts, pins and handles act; what they leave alone keeps its bits.
    pub(super) fn end(
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
