//! The contact problem of an island: bodies that touch each other, with their contacts with colliders.
//!
//! Impulses of all contacts are computed together (`contact::solver`), so that momentum passes through a body in one
//! step. Both bodies of a contact get the opposite impulse at the same point: linear and angular momentum are kept.
//!
//! Units of the problem: the length is the least cell size, and the mass is the greatest mass of a cell. A row is the
//! index of a lattice vertex plus the offset of its body.

use nalgebra::{Point3, Vector3};

use super::search::Search;
use super::view::{BodyView, ContactStep};
use crate::contact::colliders::Colliders;
use crate::contact::constraint::Contact;
use crate::contact::finish::ContactMover;
use crate::contact::jacobi::Tolerance;
use crate::contact::memory::buffer_bytes;
use crate::contact::solver::{Solver, Units};
use crate::contact::stage::{ALLOWED_DEPTH, Contacts, MIN_BOUNCE_STEPS};
use crate::contact::vec4::{Vec4, dot, narrow, wide};
use crate::state::{ContactKey, Interval, Twist};

/// Part of the depth by which a step pushes touching bodies apart. A greater part gives them energy.
const PUSH_PART: f64 = 0.3;

/// Greatest push in a step, in cells.
const PUSH_LIMIT: f64 = 0.08;

/// Greatest ratio of masses, so that products with inverse masses fit in f32.
pub(super) const GREATEST_RATIO: f64 = 1e30;

/// Bodies that touch each other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Island {
    pub(super) index: u32,
    pub(super) members: Vec<Member>,
    pub(super) solver: Solver,
    /// The contacts between bodies, in the order of their constraints, which follow the constraints at colliders.
    pub(super) pairs: Vec<PairContact>,
    /// Each body with the indices in `pairs` of its contacts, in increasing order.
    pairs_by_body: Vec<(u32, u32)>,
    /// Number of constraints of contacts with colliders.
    collider_constraints: usize,
    /// Impulses with which the solution begins, in the order of the constraints.
    pub(super) begin: Vec<Vec4>,
    /// Impulses of the contacts with colliders: normal impulse and friction impulse.
    collider_impulses: Vec<(f32, Vec4)>,
    /// Velocity change of each row by the impulses, in increasing order of the rows.
    impacts: Vec<(u32, Vec4)>,
    /// Displacement of each row by the pushes, in increasing order of the rows.
    pushes: Vec<(u32, Vec4)>,
    /// The impulses on each rigid body, and their displacements by the pushes.
    rigid_impulses: Vec<Twist>,
    rigid_pushes: Vec<Twist>,
    pub(super) patches: PatchBuffers,
    /// Unit of length, and unit of mass.
    pub(super) units: (f64, f64),
    /// Mean velocity of the bodies, in scene units per second.
    pub(crate) mean_velocity: Vector3<f64>,
}

/// A body of an island.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) body: u32,
    /// Row of its first vertex.
    pub(super) offset: u32,
    vertices: u32,
    /// Its first constraint of a contact with a collider.
    first: usize,
    /// Converts its velocities in cells/s and its inverse masses to units of the island.
    scale: Units,
    /// Its index among the rigid bodies of the problem; `None` if it is not rigid.
    pub(super) rigid: Option<u32>,
}

/// A contact between two bodies, or two parts of one body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairContact {
    /// The body of the samples, and the other one.
    pub(crate) bodies: [u32; 2],
    /// The connected components that touch.
    pub(crate) components: [u32; 2],
    pub(crate) key: ContactKey,
    pub(crate) point: Point3<f64>,
    /// Unit normal, to the outside of the other body.
    pub(crate) normal: Vector3<f64>,
    /// Factor of the coefficient of friction.
    pub(crate) friction_factor: f64,
    /// Greatest depth of a sample at the end of the step in scene units, negative outside.
    pub(crate) depth: f64,
    /// Impulse on the body of the samples, in scene units.
    pub(crate) impulse: Vector3<f64>,
    /// Mass times displacement of the body of the samples, in scene units.
    pub(crate) displacement: Vector3<f64>,
    /// The lesser cell size of the two bodies, in units of length of the island.
    pub(super) cell_size: f64,
}

impl PairContact {
    /// Returns the sides: each body with its connected component.
    pub(crate) fn sides(&self) -> [(u32, u32); 2] {
        [0, 1].map(|side| (self.bodies[side], self.components[side]))
    }

    /// Returns the normal impulse on the body of the samples.
    pub(crate) fn pressure(&self) -> f64 {
        self.impulse.dot(&self.normal)
    }
}

/// A key that sorts touches by contact, as in [`ContactKey::Body`]: the point of the grid, the axis, the components of
/// the other body and of the body, and the index of the touch.
pub(super) type PatchKey = ([i32; 3], u8, (u32, u32), u32);

/// Touches of a search, by contact, and links of a contact.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchBuffers {
    pub(super) keys: Vec<PatchKey>,
    pub(super) links: [Vec<(u32, f64)>; 2],
}

impl Island {
    /// Begins an island without bodies. Keeps the buffers.
    pub(super) fn begin(&mut self, index: u32) {
        self.index = index;
        self.members.clear();
        self.pairs.clear();
        self.pairs_by_body.clear();
        self.impacts.clear();
        self.pushes.clear();
        self.rigid_pushes.clear();
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { members, solver, pairs, pairs_by_body, begin, collider_impulses, .. } = self;
        let Self { impacts, pushes, patches, .. } = self;
        let lists = buffer_bytes(members)
            + buffer_bytes(pairs)
            + buffer_bytes(pairs_by_body)
            + buffer_bytes(begin)
            + buffer_bytes(collider_impulses);
        let rigid = buffer_bytes(&self.rigid_impulses) + buffer_bytes(&self.rigid_pushes);
        let changes = buffer_bytes(impacts) + buffer_bytes(pushes) + rigid;
        let links: usize = patches.links.iter().map(buffer_bytes).sum();
        lists + changes + solver.bytes() + buffer_bytes(&patches.keys) + links
    }

    /// Adds a body, greater than those before. Returns its index in the island.
    pub(super) fn add_body(&mut self, body: u32) -> u32 {
        let scale = Units { velocity: 1.0, mobility: 1.0 };
        self.members.push(Member { body, offset: 0, vertices: 0, first: 0, scale, rigid: None });
        self.members.len() as u32 - 1
    }

    /// Returns the contacts of a body with other bodies and with itself.
    pub(crate) fn pairs_of(&self, body: u32) -> impl Iterator<Item = &PairContact> {
        let first = self.pairs_by_body.partition_point(|(found, _)| *found < body);
        let own = self.pairs_by_body[first..].iter().take_while(move |(found, _)| *found == body);
        own.map(|&(_, pair)| &self.pairs[pair as usize])
    }

    /// Computes the impulses and pushes of a step. `searches`: of the bodies of the island.
    pub(super) fn solve<'a, 'b>(
        &mut self,
        view: impl Fn(u32) -> BodyView<'a>,
        searches: impl Iterator<Item = &'b Search>,
        step: ContactStep,
    ) {
        self.begin_problem(&view, step.dt);
        for search in searches {
            self.add_search(&view, search, step);
        }
        self.list_pairs_by_body();
        let slow = MIN_BOUNCE_STEPS * step.gravity * step.dt / self.units.0;
        self.solver.begin_with(&self.begin, slow as f32);
        self.solver.solve(Tolerance::IMPACT);
        self.impacts.extend(self.solver.changes_by_row());
        self.solver.rigid_totals(&mut self.rigid_impulses);
        self.store_impulses(step.dt);
        self.push(step.dt);
    }

    /// Numbers the rows, and adds the contacts with colliders.
    fn begin_problem<'a>(&mut self, view: &impl Fn(u32) -> BodyView<'a>, dt: f64) {
        let Self { members, solver, begin, .. } = self;
        let bodies = || members.iter().map(|member| view(member.body));
        let length = bodies().map(|body| body.lattice.cell_size()).fold(f64::INFINITY, f64::min);
        let mass = bodies().map(|body| body.cell_mass).fold(0.0, f64::max);
        let rows: usize = bodies().map(|body| body.lattice.len()).sum();
        self.units = (length, mass);
        solver.clear();
        solver.resize(rows);
        begin.clear();
        let (mut offset, mut momentum, mut total) = (0, Vector3::zeros(), 0.0);
        for member in members {
            let body = view(member.body);
            member.offset = offset;
            member.vertices = body.lattice.len() as u32;
            member.scale = Units {
                velocity: (body.lattice.cell_size() / length) as f32,
                mobility: (mass / body.cell_mass).min(GREATEST_RATIO) as f32,
            };
            offset += member.vertices;
            member.first = solver.len();
            let Units { velocity, mobility } = member.scale;
            member.rigid = body.rigid.map(|rigid| solver.rigid.add(rigid, velocity, mobility));
            if let Some(contacts) = body.contacts {
                let row = |row: u32| member.offset + contacts.samples().vertices[row as usize];
                solver.append(&contacts.solver, row, member.scale, member.rigid);
                begin.extend(contacts.pressures().iter().map(|pressure| {
                    narrow(body.state.touches.force(pressure.key()) * (dt / (length * mass)))
                }));
            }
            for vertex in 0..body.lattice.len() as u32 {
                let mass = body.cell_mass * f64::from(body.masses[vertex as usize]);
                momentum += body.velocity(vertex) * mass;
                total += mass;
            }
        }
        self.collider_constraints = solver.len();
        self.mean_velocity = momentum / total;
    }

    /// Returns the member of a body.
    pub(super) fn member(&self, body: u32) -> &Member {
        let index = self.members.partition_point(|member| member.body < body);
        &self.members[index]
    }

    /// Lists the contacts of each body.
    fn list_pairs_by_body(&mut self) {
        let Self { pairs, pairs_by_body, .. } = self;
        for (index, pair) in (0..).zip(&*pairs) {
            let [body, other] = pair.bodies;
            pairs_by_body.push((body, index));
            if other != body {
                pairs_by_body.push((other, index));
            }
        }
        pairs_by_body.sort_unstable();
    }

    /// Stores the impulses of the contacts between bodies.
    fn store_impulses(&mut self, dt: f64) {
        let (length, mass) = self.units;
        let Self { solver, pairs, collider_impulses, collider_constraints, .. } = self;
        collider_impulses.clear();
        collider_impulses.extend(solver.impulses().take(*collider_constraints));
        let impulses = solver.impulses().skip(*collider_constraints);
        for (pair, (normal, friction)) in pairs.iter_mut().zip(impulses) {
            pair.impulse = (pair.normal * f64::from(normal) + wide(&friction)) * (length * mass);
            pair.displacement = pair.impulse * dt;
        }
    }

    /// Pushes the bodies apart where they still overlap: changes positions, but not velocities. They are not pushed
    /// into colliders.
    fn push(&mut self, dt: f64) {
        let (length, mass) = self.units;
        let Self { members, solver, pairs, pushes, rigid_pushes, collider_constraints, .. } = self;
        let first = *collider_constraints;
        let mut deepest = 0.0_f64;
        solver.restart(|constraint, contact, change| {
            let target = match constraint.checked_sub(first) {
                None => 0.0,
                Some(pair) => {
                    let PairContact { depth, cell_size, .. } = &mut pairs[pair];
                    *depth -= dt * f64::from(dot(&contact.normal, change)) * length;
                    let remaining = *depth / length;
                    deepest = deepest.max(remaining / *cell_size);
                    (PUSH_PART * remaining).clamp(0.0, PUSH_LIMIT * *cell_size)
                }
            };
            Contact {
                normal: contact.normal,
                target: target as f32,
                approach: target as f32,
                ..Contact::default()
            }
        });
        if deepest <= ALLOWED_DEPTH {
            return;
        }
        solver.solve(Tolerance::PUSH);
        pushes.extend(solver.changes_by_row());
        rigid_pushes
            .extend(members.iter().filter_map(|member| member.rigid).map(|body| solver.rigid.change(body)));
        for (pair, (normal, _)) in pairs.iter_mut().zip(solver.impulses().skip(first)) {
            pair.displacement += pair.normal * (f64::from(normal) * length * mass);
        }
        for (pair, (_, change)) in pairs.iter_mut().zip(solver.contacts().skip(first)) {
            pair.depth -= f64::from(change) * length;
        }
    }

    /// Finishes the contacts of a member with colliders, which has been moved.
    pub(crate) fn finish_contacts(
        &self,
        member: usize,
        contacts: &mut Contacts,
        body: &mut impl ContactMover,
        surroundings: (&Colliders, Interval),
    ) {
        let Member { first, scale, .. } = self.members[member];
        contacts.finish_in_island(body, surroundings, (&self.collider_impulses[first..], scale));
    }

    /// Returns the impulse on a rigid member, in units of the body, and its displacement by pushes.
    pub(crate) fn rigid_motion(&self, member: usize) -> (Twist, Twist) {
        let Member { scale, rigid, .. } = self.members[member];
        let (velocity, mobility) = (f64::from(scale.velocity), f64::from(scale.mobility));
        let of =
            |list: &[Twist]| rigid.and_then(|index| list.get(index as usize)).copied().unwrap_or_default();
        let (impulse, push) = (of(&self.rigid_impulses), of(&self.rigid_pushes));
        let unit = mobility / velocity;
        let impulse = Twist { linear: impulse.linear * unit, angular: impulse.angular * (unit / velocity) };
        (impulse, Twist { linear: push.linear / velocity, angular: push.angular })
    }

    /// Returns the velocity changes of the vertices of a member, in cells/s.
    pub(crate) fn impacts(&self, member: usize) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        self.of_member(member, &self.impacts)
    }

    /// Returns the displacements of the vertices of a member by pushes, in cells.
    pub(crate) fn pushes(&self, member: usize) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        self.of_member(member, &self.pushes)
    }

    fn of_member(&self, member: usize, changes: &[(u32, Vec4)]) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        let &Member { offset, vertices, scale, .. } = &self.members[member];
        let scale = 1.0 / f64::from(scale.velocity);
        let first = changes.partition_point(|(row, _)| *row < offset);
        let own = changes[first..].iter().take_while(move |(row, _)| *row < offset + vertices);
        own.map(move |(row, change)| (row - offset, wide(change) * scale))
    }
}
