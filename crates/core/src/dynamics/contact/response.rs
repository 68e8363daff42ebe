//! What contacts do to the lattice vertices under them: impulses with friction, then push-out.

use nalgebra::{Point3, Vector3};

use crate::dynamics::BodyState;
use crate::dynamics::colliders::PosedCollider;

/// Passes over the contacts for velocities, and at most so many for positions.
const VELOCITY_PASSES: usize = 6;
const POSITION_PASSES: usize = 10;

/// Depth in cells that is left as it is.
const DEPTH_LEFT: f64 = 1e-4;

/// The passes for velocities end when the square of the greatest impulse has fallen by this factor.
const CHANGE_LEFT: f64 = 1e-6;

/// Marks a row of the samples' vertices without contact.
const NONE: u32 = u32::MAX;

/// One sample at one collider.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// Where its vertices stand among the touched ones.
    pub(super) touched: [u32; 8],
    /// Trilinear weights of the vertices.
    pub(super) weights: [f64; 8],
    /// Outward normal of the collider.
    pub(super) normal: Vector3<f64>,
    /// Velocity of the collider's surface, cells per second.
    pub(super) surface: Vector3<f64>,
    /// Normal velocity to leave with, cells per second.
    pub(super) bounce: f64,
    /// Depth in cells that this step leaves to the next.
    pub(super) left: f64,
    /// Impulses so far, per unit of mass: along the normal, and across it.
    pub(super) normal_impulse: f64,
    pub(super) friction_impulse: Vector3<f64>,
}

/// Sums of one pass at a vertex: weighted changes along the normals and across them, and the weights.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    along: Vector3<f64>,
    across: Vector3<f64>,
    weight: f64,
}

/// What a vertex got in this step.
#[derive(Clone, Copy, Debug, Default)]
struct Changes {
    /// Velocity along the normals, and across them.
    along: Vector3<f64>,
    across: Vector3<f64>,
    /// Push-out.
    out: Vector3<f64>,
}

/// The contacts of one collider.
#[derive(Clone, Copy, Debug)]
struct Group {
    collider: PosedCollider,
    first: usize,
    end: usize,
}

/// The contacts of a step and the vertices that they touch.
///
/// Colliders take turns within a pass, each seeing what the one before did (Gauss-Seidel); the contacts of one
/// collider act together (Jacobi), so that a symmetric body stays symmetric.
#[derive(Clone, Debug)]
pub(super) struct Response {
    contacts: Vec<Contact>,
    groups: Vec<Group>,
    /// Rows of the touched vertices among the samples' vertices; the next four follow it.
    rows: Vec<u32>,
    positions: Vec<Vector3<f64>>,
    velocities: Vec<Vector3<f64>>,
    changes: Vec<Changes>,
    sums: Vec<Sums>,
    /// For each row of the samples' vertices, where it stands in `rows`.
    index: Vec<u32>,
}

impl Response {
    pub(super) fn new(rows: usize) -> Self {
        Self {
            contacts: Vec::new(),
            groups: Vec::new(),
            rows: Vec::new(),
            positions: Vec::new(),
            velocities: Vec::new(),
            changes: Vec::new(),
            sums: Vec::new(),
            index: vec![NONE; rows],
        }
    }

    pub(super) fn clear(&mut self) {
        for row in self.rows.drain(..) {
            self.index[row as usize] = NONE;
        }
        self.contacts.clear();
        self.groups.clear();
    }

    pub(super) fn open_group(&mut self, collider: &PosedCollider) {
        let first = self.contacts.len();
        self.groups.push(Group { collider: *collider, first, end: first });
    }

    /// Adds a contact whose vertices are in these rows; a vertex without weight is left alone.
    pub(super) fn add(&mut self, rows: [u32; 8], mut contact: Contact) {
        for ((touched, row), weight) in contact.touched.iter_mut().zip(rows).zip(contact.weights) {
            let place = &mut self.index[row as usize];
            if *place == NONE && weight != 0.0 {
                *place = self.rows.len() as u32;
                self.rows.push(row);
            }
            // Without weight any vertex will do: it is multiplied by zero.
            *touched = if *place == NONE { 0 } else { *place };
        }
        self.contacts.push(contact);
    }

    pub(super) fn close_group(&mut self) {
        let end = self.contacts.len();
        if let Some(group) = self.groups.last_mut() {
            group.end = end;
            if group.first == end {
                self.groups.pop();
            }
        }
    }

    /// Rows of the samples' vertices that the contacts of the last step touch.
    pub(super) fn rows(&self) -> impl Iterator<Item = u32> + '_ {
        self.rows.iter().copied()
    }

    /// Solves the contacts, writes positions and velocities, adds what contacts did along the normals to
    /// `pushes`.
    pub(super) fn solve(
        &mut self,
        state: &mut BodyState<'_>,
        slots: &[u32],
        pushes: &mut [[f32; 3]],
        dt: f64,
    ) {
        if self.contacts.is_empty() {
            return;
        }
        let slot_of = |row: &u32| slots[*row as usize];
        self.positions.clear();
        self.positions.extend(self.rows.iter().map(|row| state.position(slot_of(row))));
        self.velocities.clear();
        self.velocities.extend(self.rows.iter().map(|row| state.velocity(slot_of(row))));
        self.changes.clear();
        self.changes.resize(self.rows.len(), Changes::default());
        self.sums.clear();
        self.sums.resize(self.rows.len(), Sums::default());

        let mut first = 0.0;
        for pass in 0..VELOCITY_PASSES {
            let change = (0..self.groups.len()).fold(0.0, |most: f64, g| most.max(self.exchange_impulses(g)));
            if pass == 0 {
                first = change;
            }
            if change <= CHANGE_LEFT * first {
                break;
            }
        }
        // The position was integrated with the velocity before friction. What friction took must be taken
        // from it as well, or a body that it holds would creep down a slope by g dt^2 a step.
        for (position, changes) in self.positions.iter_mut().zip(&self.changes) {
            *position += changes.across * dt;
        }
        for _ in 0..POSITION_PASSES {
            let deepest = (0..self.groups.len()).fold(0.0, |most: f64, g| most.max(self.push_out(g)));
            if deepest <= DEPTH_LEFT {
                break;
            }
        }
        for (k, row) in self.rows.iter().enumerate() {
            let slot = slot_of(row);
            state.set_position(slot, self.positions[k]);
            state.set_velocity(slot, self.velocities[k]);
            let Changes { along, out, .. } = self.changes[k];
            for (sum, push) in pushes[*row as usize].iter_mut().zip(&(out + along * dt)) {
                *sum += *push as f32;
            }
        }
    }

    /// One pass of impulses over the contacts of a collider; the square of the greatest one.
    ///
    /// Impulses are summed and the sums clamped, so that a later pass may take back what an earlier one gave
    /// too much: the normal one stays >= 0, the tangential one within `friction` times the normal one.
    fn exchange_impulses(&mut self, group: usize) -> f64 {
        let Group { collider, first, end } = self.groups[group];
        let mut greatest = 0.0_f64;
        for contact in &mut self.contacts[first..end] {
            let velocity = contact.blend(&self.velocities) - contact.surface;
            let along = velocity.dot(&contact.normal);
            let normal = (contact.normal_impulse + contact.bounce - along).max(0.0);
            let wished = contact.friction_impulse - (velocity - contact.normal * along);
            let (limit, length) = (collider.friction * normal, wished.norm());
            let friction = if length > limit { wished * (limit / length) } else { wished };
            let along = contact.normal * (normal - contact.normal_impulse);
            let across = friction - contact.friction_impulse;
            contact.normal_impulse = normal;
            contact.friction_impulse = friction;
            contact.spread(&mut self.sums, 1.0, along, across);
            greatest = greatest.max((along + across).norm_squared());
        }
        for ((velocity, changes), sums) in
            self.velocities.iter_mut().zip(&mut self.changes).zip(&mut self.sums)
        {
            let (along, across) = sums.take_means();
            *velocity += along + across;
            changes.along += along;
            changes.across += across;
        }
        greatest
    }

    /// One pass of push-out over the contacts of a collider; the greatest depth that it found.
    ///
    /// Samples count by their depth: the deepest, which the others would hold back, comes out soonest. (On a
    /// resting bust ten passes of plain means left 0.1 cell, these leave less than 0.001.)
    fn push_out(&mut self, group: usize) -> f64 {
        let Group { collider, first, end } = self.groups[group];
        let mut deepest = 0.0_f64;
        for contact in &self.contacts[first..end] {
            let place = Point3::from(contact.blend(&self.positions));
            let here = collider.shape.signed_distance(&place);
            let push = -here.distance - contact.left;
            if push > 0.0 {
                deepest = deepest.max(push);
                contact.spread(&mut self.sums, push, here.normal * push, Vector3::zeros());
            }
        }
        for ((position, changes), sums) in
            self.positions.iter_mut().zip(&mut self.changes).zip(&mut self.sums)
        {
            let (out, _) = sums.take_means();
            *position += out;
            changes.out += out;
        }
        deepest
    }
}

impl Contact {
    /// The weighted sum of something of the vertices.
    fn blend(&self, values: &[Vector3<f64>]) -> Vector3<f64> {
        let terms = self.weights.iter().zip(self.touched);
        terms.fold(Vector3::zeros(), |sum, (&w, k)| sum + values[k as usize] * w)
    }

    /// Adds a change of the sample to the sums of its vertices, where it counts by `importance`.
    fn spread(&self, sums: &mut [Sums], importance: f64, along: Vector3<f64>, across: Vector3<f64>) {
        let square: f64 = self.weights.iter().map(|w| w * w).sum();
        let (along, across) = (along * (importance / square), across * (importance / square));
        // Those without weight stand for another vertex, which is not theirs to wait for.
        for (&w, k) in self.weights.iter().zip(self.touched).filter(|(w, _)| **w != 0.0) {
            let vertex = &mut sums[k as usize];
            vertex.along += along * (w * w);
            vertex.across += across * (w * w);
            vertex.weight += w * importance;
        }
    }
}

impl Sums {
    /// The weighted means of a pass, along and across the normals; the sums start again at zero.
    fn take_means(&mut self) -> (Vector3<f64>, Vector3<f64>) {
        let Self { along, across, weight } = std::mem::take(self);
        if weight > 0.0 { (along / weight, across / weight) } else { (Vector3::zeros(), Vector3::zeros()) }
    }
}
