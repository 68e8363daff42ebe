//! What contacts do to the lattice vertices under them: impulses with friction, then push-out.

use nalgebra::{Point3, Vector3};

use crate::dynamics::BodyState;
use crate::dynamics::collider::PosedCollider;

/// Passes over the contacts for velocities, and at most so many for positions.
const VELOCITY_PASSES: usize = 6;
const POSITION_PASSES: usize = 10;

/// Depth in cells that is left as it is.
const DEPTH_LEFT: f64 = 1e-5;

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
    /// How far it may still be pushed in this step, cells.
    pub(super) allowance: f64,
    /// Impulses so far, per unit of mass: along the normal, and across it.
    pub(super) normal_impulse: f64,
    pub(super) friction_impulse: Vector3<f64>,
}

/// A lattice vertex under contacts.
#[derive(Clone, Copy, Debug, Default)]
struct Touched {
    /// Row of the samples' vertices.
    row: u32,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    /// Velocity changes of this step along the normals and across them.
    pushed: Vector3<f64>,
    rubbed: Vector3<f64>,
    /// Sums of one pass: weighted changes along the normals and across them, and the weights.
    along: Vector3<f64>,
    across: Vector3<f64>,
    weight: f64,
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
    touched: Vec<Touched>,
    /// For each row of the samples' vertices, where it stands in `touched`.
    index: Vec<u32>,
}

impl Response {
    pub(super) fn new(rows: usize) -> Self {
        Self { contacts: Vec::new(), groups: Vec::new(), touched: Vec::new(), index: vec![NONE; rows] }
    }

    pub(super) fn clear(&mut self) {
        for vertex in self.touched.drain(..) {
            self.index[vertex.row as usize] = NONE;
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
        for k in 0..8 {
            let place = &mut self.index[rows[k] as usize];
            if *place == NONE && contact.weights[k] != 0.0 {
                *place = self.touched.len() as u32;
                self.touched.push(Touched { row: rows[k], ..Touched::default() });
            }
            // Without weight any vertex will do: it is multiplied by zero.
            contact.touched[k] = if *place == NONE { 0 } else { *place };
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
        self.touched.iter().map(|vertex| vertex.row)
    }

    /// Solves the contacts, writes positions and velocities, adds the normal velocity changes to `pushes`.
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
        for vertex in &mut self.touched {
            let slot = slots[vertex.row as usize];
            vertex.position = Vector3::from(state.positions.get(slot).map(f64::from));
            vertex.velocity = Vector3::from(state.velocities.get(slot).map(f64::from));
        }
        for _ in 0..VELOCITY_PASSES {
            (0..self.groups.len()).for_each(|g| self.exchange_impulses(g));
        }
        // The position was integrated with the velocity before friction. What friction took must be taken
        // from it as well, or a body that it holds would creep down a slope by g dt^2 a step.
        for vertex in &mut self.touched {
            vertex.position += vertex.rubbed * dt;
        }
        for _ in 0..POSITION_PASSES {
            let deepest = (0..self.groups.len()).fold(0.0, |deepest: f64, g| deepest.max(self.push_out(g)));
            if deepest <= DEPTH_LEFT {
                break;
            }
        }
        for vertex in &self.touched {
            let slot = slots[vertex.row as usize];
            state.positions.set(slot, vertex.position.map(|c| c as f32).into());
            state.velocities.set(slot, vertex.velocity.map(|c| c as f32).into());
            for (sum, change) in pushes[vertex.row as usize].iter_mut().zip(vertex.pushed.iter()) {
                *sum += *change as f32;
            }
        }
    }

    /// One pass of impulses over the contacts of a collider.
    ///
    /// Impulses are summed and the sums clamped, so that a later pass may take back what an earlier one gave
    /// too much: the normal one stays >= 0, the tangential one within `friction` times the normal one.
    fn exchange_impulses(&mut self, group: usize) {
        let Group { collider, first, end } = self.groups[group];
        for contact in &mut self.contacts[first..end] {
            let velocity = contact.blend(&self.touched, |vertex| vertex.velocity) - contact.surface;
            let along = velocity.dot(&contact.normal);
            let normal = (contact.normal_impulse + contact.bounce - along).max(0.0);
            let wished = contact.friction_impulse - (velocity - contact.normal * along);
            let (limit, length) = (collider.friction * normal, wished.norm());
            let friction = if length > limit { wished * (limit / length) } else { wished };
            let along = contact.normal * (normal - contact.normal_impulse);
            let across = friction - contact.friction_impulse;
            contact.normal_impulse = normal;
            contact.friction_impulse = friction;
            contact.spread(&mut self.touched, along, across);
        }
        for vertex in &mut self.touched {
            let (along, across) = vertex.take_means();
            vertex.velocity += along + across;
            vertex.pushed += along;
            vertex.rubbed += across;
        }
    }

    /// One pass of push-out over the contacts of a collider; the greatest depth that it found.
    fn push_out(&mut self, group: usize) -> f64 {
        let Group { collider, first, end } = self.groups[group];
        let mut deepest = 0.0_f64;
        for contact in &mut self.contacts[first..end] {
            let place = Point3::from(contact.blend(&self.touched, |vertex| vertex.position));
            let here = collider.shape.signed_distance(&place);
            let push = (-here.distance).min(contact.allowance);
            if push > 0.0 {
                deepest = deepest.max(push);
                contact.allowance -= push;
                contact.spread(&mut self.touched, here.normal * push, Vector3::zeros());
            }
        }
        for vertex in &mut self.touched {
            let (along, _) = vertex.take_means();
            vertex.position += along;
        }
        deepest
    }
}

impl Contact {
    /// The weighted sum of something of the vertices.
    fn blend(&self, touched: &[Touched], of: impl Fn(&Touched) -> Vector3<f64>) -> Vector3<f64> {
        let terms = self.weights.iter().zip(self.touched);
        terms.fold(Vector3::zeros(), |sum, (&w, k)| sum + of(&touched[k as usize]) * w)
    }

    /// Adds a change of the sample to the sums of its vertices.
    fn spread(&self, touched: &mut [Touched], along: Vector3<f64>, across: Vector3<f64>) {
        let square: f64 = self.weights.iter().map(|w| w * w).sum();
        for (&w, k) in self.weights.iter().zip(self.touched) {
            let vertex = &mut touched[k as usize];
            let share = w * w / square;
            vertex.along += along * share;
            vertex.across += across * share;
            vertex.weight += w;
        }
    }
}

impl Touched {
    /// The weighted means of a pass, along and across the normals; the sums start again at zero.
    fn take_means(&mut self) -> (Vector3<f64>, Vector3<f64>) {
        let weight = std::mem::take(&mut self.weight);
        let (along, across) = (std::mem::take(&mut self.along), std::mem::take(&mut self.across));
        if weight > 0.0 { (along / weight, across / weight) } else { (Vector3::zeros(), Vector3::zeros()) }
    }
}
