//! Rigid bodies: their step, and their contacts.
//!
//! A rigid body has the lattice of a soft body, which gives the geometry of its contacts and displays its mesh. One stage
//! takes the place of damping, shape matching and integration: it advances the pose (`dynamics::rigid`) and writes the
//! lattice vertices. Forces, contacts, pins and handles change the pose and the momenta.

use nalgebra::{Point3, Vector3};

use super::context::StepContext;
use super::parts::{Pipeline, Shape};
use super::soft_body::Body;
use crate::contact::{Contacts, RigidMover};
use crate::dynamics::{
    Constraint, Constraints, HeldVertex, RigidBody, RigidError, RigidMass, rolling_resistance,
};
use crate::parallel::Executor;
use crate::simd::vector::wide;
use crate::state::{BodyFrame, BodyState, Interval, RigidMobility, RigidPose, State, Twist};

impl Body {
    /// Returns whether the body is rigid.
    pub fn is_rigid(&self) -> bool {
        self.rigid.is_some()
    }

    /// Returns an error if the body is rigid.
    pub(super) fn check_deforms(&self, change: &'static str) -> Result<(), RigidError> {
        if self.is_rigid() { Err(RigidError::Change { change }) } else { Ok(()) }
    }

    /// Makes a new body rigid, with the velocity and the spin of its placement.
    pub(super) fn make_rigid(&mut self, mass: RigidMass, velocity: Vector3<f64>, spin: Vector3<f64>) {
        let Shape { lattice, masses, model_to_world, .. } = &self.shape;
        let layout = &self.pipeline.matching.layout;
        let (rigid, mut pose) =
            RigidBody::new(mass, (lattice, layout), masses, (&self.state, model_to_world.rotation));
        let motion = Twist { linear: velocity / lattice.cell_size(), angular: spin };
        rigid.set_motion(&mut pose, motion);
        self.state.set_origin_velocity(layout.slots(), Vector3::zeros());
        self.state.rigid = Some(pose);
        self.rigid = Some(Box::new(rigid));
        self.write_pose();
    }

    /// Returns the parts that contacts and pushes move, and the contacts with colliders; `None` if the body is not rigid.
    pub(super) fn moved_in_contact(&mut self) -> Option<(MovedBody<'_>, Option<&mut Contacts>)> {
        let Self { pipeline: Pipeline { matching, .. }, contact, rigid, state, .. } = self;
        let rigid = rigid.as_deref_mut()?;
        let moved = MovedBody { rigid, state, occupied: matching.layout.occupied() };
        Some((moved, contact.contacts.as_mut()))
    }

    fn moved(&mut self) -> Option<MovedBody<'_>> {
        self.moved_in_contact().map(|(moved, _)| moved)
    }

    /// Writes the lattice vertices of a rigid body, whose pose was set.
    pub(super) fn write_pose(&mut self) {
        self.change_pose(|_, _| {});
    }

    /// Changes the pose of a rigid body, and writes its lattice vertices.
    pub(super) fn change_pose(&mut self, change: impl FnOnce(&mut RigidBody, &mut RigidPose)) {
        if let Some(mut moved) = self.moved() {
            moved.change(change);
        }
    }

    /// Reads the targets of the vertices that pins and handles hold in a step.
    pub(super) fn read_held(&mut self, step: Interval) {
        let Self { pipeline: Pipeline { matching, .. }, constraints, rigid: Some(rigid), state, .. } = self
        else {
            return;
        };
        let places = (state.frame.body_frame(), matching.layout.slots());
        let mut held = std::mem::take(&mut rigid.held);
        held.clear();
        if let Some(constraints) = constraints {
            held.extend(held_vertices((constraints, constraints.list()), rigid, places, step));
        }
        rigid.held = held;
    }

    /// Advances the pose by a step.
    pub(super) fn move_rigidly(&mut self, context: &StepContext) {
        let Interval { dt, .. } = context.interval;
        self.read_held(context.interval);
        let velocity_change = context.gravity * (dt / self.shape.lattice.cell_size());
        self.change_pose(|rigid, pose| rigid.advance(pose, velocity_change, dt));
    }

    /// Moves the held vertices of a rigid body to their targets.
    pub(super) fn hold_rigidly(&mut self) {
        if self.rigid.as_ref().is_some_and(|rigid| !rigid.held.is_empty()) {
            self.change_pose(|rigid, pose| rigid.fit_to(pose, &rigid.held));
        }
    }

    /// Applies the pulls of soft goals in a step of `dt` seconds: their sum and their torque.
    pub(super) fn pull_rigidly(&mut self, dt: f64) {
        let (Some(constraints), Some(pose), Some(rigid)) =
            (&self.constraints, &self.state.rigid, self.rigid.as_deref())
        else {
            return;
        };
        let (_, mass_factor) = rigid.lattice_center(pose);
        let (slots, unit) = (self.pipeline.matching.layout.slots(), dt / self.shape.lattice.cell_size());
        let mut impulse = Twist::default();
        for (vertex, acceleration) in constraints.pulls() {
            let part = acceleration * (unit * mass_factor * f64::from(self.shape.masses[vertex as usize]));
            let arm = self.state.local(slots[vertex as usize]) - pose.center();
            impulse.linear += part;
            impulse.angular += arm.cross(&part);
        }
        self.constraints.iter_mut().for_each(Constraints::clear_pulls);
        self.apply_impulse_rigidly(impulse, dt);
    }

    /// Applies an impulse of a step of `dt` seconds.
    fn apply_impulse_rigidly(&mut self, impulse: Twist, dt: f64) {
        if impulse != Twist::default() {
            self.change_pose(|rigid, pose| rigid.apply_impulse(pose, impulse, dt));
        }
    }

    /// Applies the external forces of the step: their sum and their torque.
    pub(super) fn apply_forces_rigidly(&mut self, context: &StepContext) {
        let cell_mass = self.cell_mass();
        let dt = context.interval.dt;
        let Self {
            shape: Shape { lattice, masses, .. },
            pipeline: Pipeline { matching, .. },
            forces: Some(forces),
            rigid: Some(rigid),
            state,
            ..
        } = self
        else {
            return;
        };
        let Some(pose) = state.rigid else { return };
        let mass = |vertex: u32| cell_mass * f64::from(masses[vertex as usize]);
        let (lattice_center, mass_factor) = rigid.lattice_center(&pose);
        let slots = matching.layout.slots();
        let arm = |vertex: u32| state.local(slots[vertex as usize]) - pose.center();
        let is_awake = state.rest.time() == 0.0;
        let sum =
            forces.take_sum((context.is_frame_start, is_awake), (arm, lattice_center), (mass, mass_factor));
        let is_empty = forces.is_empty();
        let unit = dt / (cell_mass * lattice.cell_size());
        if is_empty {
            self.forces = None;
        }
        self.apply_impulse_rigidly(Twist { linear: sum.linear * unit, angular: sum.angular * unit }, dt);
    }

    /// Moves the origin of the body if it is far away.
    pub(super) fn rebase_rigidly(&mut self) {
        let weights = &self.pipeline.matching.regions.weights;
        let slots = self.pipeline.matching.layout.slots();
        if let Some(pose) = self.state.rigid
            && self.state.needs_rebase(slots[0], weights)
        {
            self.state.rebase(slots, pose.center());
        }
    }

    /// Stores the pose before a step, from which a body inside colliders leaves them.
    pub(super) fn begin_rigid_contacts(&mut self) {
        if let (Some(rigid), Some(pose)) = (&mut self.rigid, self.state.rigid) {
            rigid.before = pose;
        }
    }

    /// Passes the mobility to the contacts with colliders.
    pub(super) fn pass_mobility(&mut self) {
        if let (Some(rigid), Some(contacts)) = (&self.rigid, &mut self.contact.contacts) {
            contacts.set_rigid(rigid.mobility());
        }
    }

    /// Moves the body out of colliders in which it began, by the translation of the first component.
    pub(super) fn move_out_rigidly(&mut self) {
        let Some(escape) = self.state.escapes.list().first() else { return };
        let translation = Vector3::from(escape.translation);
        self.change_pose(|rigid, pose| {
            *pose = rigid.before;
            pose.set_center(pose.center() + translation);
        });
        self.state.escapes.advance();
    }

    /// Applies the contacts with colliders of a rigid body that touches no other body.
    pub(super) fn finish_alone_rigidly(&mut self, context: &StepContext) {
        if let Some((mut moved, Some(contacts))) = self.moved_in_contact() {
            contacts.finish_alone(&mut moved, context.colliders, context.interval);
        }
    }

    /// Applies the rolling resistance of the supports.
    pub(super) fn resist_rolling(&mut self, context: &StepContext) {
        let own = self.rolling_resistance();
        let Some(before) = self.spin() else { return };
        let Some(mut moved) = self.moved() else { return };
        let mut spin = before;
        for support in moved.state.supports.list() {
            let coefficient = context.colliders.rolling_resistance(support.collider).unwrap_or(own);
            spin += rolling_resistance(support, coefficient, moved.rigid.mobility(), spin);
        }
        if spin != before {
            moved.change(|rigid, pose| rigid.set_spin(pose, spin));
        }
    }

    /// Fits the pose of a rigid body to positions that were set. The motion is unchanged.
    pub(super) fn fit_pose(&mut self) {
        let Some(vertices) = self.vertex_motions() else { return };
        self.change_pose(|rigid, pose| {
            let spin = rigid.angular_velocity(pose);
            rigid.fit_to(pose, &vertices);
            rigid.set_spin(pose, spin);
        });
    }

    /// Fits the motion of a rigid body to velocities that were set.
    pub(super) fn fit_motion(&mut self) {
        let vertices = self.vertex_motions();
        self.state.set_origin_velocity(self.pipeline.matching.layout.slots(), Vector3::zeros());
        if let Some(vertices) = vertices {
            self.change_pose(|rigid, pose| rigid.fit_motion(pose, &vertices));
        }
    }

    /// Returns the positions and velocities of all vertices of a rigid body; `None` of a soft one.
    fn vertex_motions(&self) -> Option<Vec<HeldVertex>> {
        let (rigid, state) = (self.rigid.as_ref()?, &self.state);
        Some(self.by_vertex(|slot| HeldVertex {
            offset: rigid.offset(slot),
            target: state.local(slot),
            velocity: wide(state.velocities.get(slot)) + state.frame.velocity(),
        }))
    }

    /// Returns the force and the torque about `center` of a pin or handle of a rigid body in the next step of `dt`
    /// seconds, shared by all pins and handles in proportion to the numbers of vertices that they hold.
    pub(super) fn reaction_of(
        &self,
        constraint: &Constraint,
        gravity: Vector3<f64>,
        (step, executor): (Interval, &Executor),
        center: Point3<f64>,
    ) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let (rigid, pose, constraints) =
            (self.rigid.as_deref()?, self.state.rigid?, self.constraints.as_ref()?);
        let (frame, slots) = (self.frame(), self.pipeline.matching.layout.slots());
        let mut holding = rigid.clone();
        holding.held.clear();
        let mut own = 0;
        for other in constraints.list() {
            let in_step = other.in_step(step, executor);
            let some = (constraints, std::slice::from_ref(&*in_step));
            let before = holding.held.len();
            holding.held.extend(held_vertices(some, rigid, (frame, slots), step));
            if other.index() == constraint.index() {
                own = holding.held.len() - before;
            }
        }
        let Twist { linear, angular } =
            holding.reaction(&pose, gravity * (step.dt / frame.cell_size), step.dt);
        let unit = self.impulse_unit() / step.dt * own as f64 / holding.held.len().max(1) as f64;
        let force = linear * unit;
        let arm = frame.to_world(pose.center()) - center;
        Some((force, angular * (unit * frame.cell_size) + arm.cross(&force)))
    }
}

/// Returns the vertices of a rigid body that some of its pins and handles hold in a step. `frame`, `slots`: of the body.
fn held_vertices<'a>(
    (constraints, some): (&'a Constraints, &'a [Constraint]),
    rigid: &'a RigidBody,
    (frame, slots): (BodyFrame, &'a [u32]),
    step: Interval,
) -> impl Iterator<Item = HeldVertex> + 'a {
    let targets = some.iter().flat_map(move |constraint| {
        constraint.targets(step).filter(move |&(vertex, ..)| constraints.is_moved_by(constraint, vertex))
    });
    targets.map(move |(vertex, target, change)| HeldVertex {
        offset: rigid.offset(slots[vertex as usize]),
        target: frame.to_local(&target),
        velocity: change / (step.dt * frame.cell_size),
    })
}

/// The parts of a rigid body that contacts move.
pub(super) struct MovedBody<'a> {
    rigid: &'a mut RigidBody,
    state: &'a mut State,
    occupied: &'a [u8],
}

impl MovedBody<'_> {
    /// Changes the pose, and writes the lattice vertices.
    pub(super) fn change(&mut self, change: impl FnOnce(&mut RigidBody, &mut RigidPose)) {
        if let Some(pose) = &mut self.state.rigid {
            change(self.rigid, pose);
        }
        self.rigid.write(self.state, self.occupied);
    }
}

impl RigidMover for MovedBody<'_> {
    fn body_state(&mut self) -> BodyState<'_> {
        self.state.body_state()
    }

    fn mobility(&self) -> RigidMobility {
        *self.rigid.mobility()
    }

    fn apply_impulse(&mut self, impulse: Twist, dt: f64) {
        self.change(|rigid, pose| rigid.apply_impulse(pose, impulse, dt));
    }

    fn displace(&mut self, displacement: Twist) {
        self.change(|rigid, pose| rigid.displace(pose, displacement));
    }
}
