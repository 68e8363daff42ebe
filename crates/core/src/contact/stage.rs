//! The contact stage of a body: stores the velocities before the step, detects contacts, applies impulses,
//! and pushes out samples that are still inside a collider.
//!
//! A row is an index into `SampleCells::vertices`.

use nalgebra::{Point3, Vector3};

use super::SKIN;
use super::colliders::Colliders;
use super::constraint::{Contact, SurfacePoint, mean, mean_position};
use super::detection::{ContactReport, Detection};
use super::patch::Patch;
use super::rows::buffer_bytes;
use super::samples::SampleCells;
use super::shape::PosedShape;
use super::solver::{Solver, Tolerance};
use super::vec4::{Vec4, narrow, read, wide};
use crate::simd::lanes::Lanes;
use crate::state::{BodyState, Interval, Support};

/// Least speed of approach that bounces, divided by the speed that one step of free fall adds. A body with
/// slower impacts comes to rest.
const MIN_BOUNCE_STEPS: f64 = 2.0;

/// Penetration that is tolerated without a push-out, in cells.
pub(super) const ALLOWED_DEPTH: f64 = 3e-4;

/// Tolerance for the impulses. The solved quantities are velocities in cells per second.
const IMPACT: Tolerance = Tolerance { passes: 13, relative: 1e-4, absolute: 0.0 };

/// Greatest push-out in a step, in cells. Deeper samples leave the collider over several steps, because a
/// greater push-out would flatten the body on the surface, and its elastic energy would then throw it up.
pub(super) const PUSH_LIMIT: f64 = 0.25;

/// Depth in cells up to which a push-out is soft: it has one round, which moves the samples by [`SOFT_PART`] of the way. A
/// resting body sinks slowly within the tolerance of the impulses. If it were lifted at once, single steps would move its
/// surface visibly.
const SOFT_DEPTH: f64 = 0.01;

/// Part of the way by which a soft push-out moves the samples.
const SOFT_PART: f64 = 0.1;

/// Maximum number of push-out rounds in a step. Each round moves the contact point of each patch to the
/// surface of the collider. The samples that remain inside form the patches of the next round.
const PUSH_ROUNDS: usize = 4;

/// Tolerance for a push-out round. The solved quantities are displacements in cells.
const PUSH: Tolerance = Tolerance { passes: 9, relative: 0.0, absolute: 1e-5 };

/// A contact of the last step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pressure {
    /// Index of the collider.
    pub(crate) collider: u32,
    /// One of the lattice vertices of the contact.
    pub(crate) vertex: u32,
    /// Normal impulse, 0 if the contact does not press on the body.
    pub(crate) impulse: f64,
    /// Contact point, in cells from the body's origin.
    pub(crate) point: Vector3<f64>,
    /// Normal of the collider, a unit vector.
    pub(crate) normal: Vector3<f64>,
    /// Velocity of the surface of the collider, in cells/s.
    pub(crate) velocity: Vector3<f64>,
    /// Angular velocity of the collider in rad/s.
    pub(crate) spin: Vector3<f64>,
}

impl Pressure {
    /// Returns the contact as a support of a component.
    pub(crate) fn support_of(&self, component: u32) -> Support {
        let Self { collider, impulse, point, normal, velocity, spin, .. } = *self;
        let [point, normal, velocity, spin] = [point, normal, velocity, spin].map(Into::into);
        Support { component, collider, impulse, point, normal, velocity, spin, ..Support::default() }
    }
}

/// Contact stage of one body. Its buffers are reused, and grow if more contacts than before occur at once.
#[derive(Clone, Debug)]
pub struct Contacts {
    samples: SampleCells,
    /// Velocity of the vertex of each row before the step.
    velocities_before: Vec<Vec4>,
    /// Velocity of the vertex of each row at the end of the step, before the impulses.
    velocities: Vec<Vec4>,
    detection: Detection,
    solver: Solver,
    /// Rows of the components that leave colliders. They have no contacts.
    leaving: Vec<u32>,
    /// The contacts of the last step.
    pressures: Vec<Pressure>,
    /// Rows of the vertices that the contacts of the last step may have moved.
    touched: Vec<u32>,
    /// Contact displacement of the vertex of each row since `clear_displacements`, in cells; see
    /// [`displacements`](Self::displacements).
    displacements: Vec<[f32; 3]>,
}

impl Contacts {
    /// Creates the stage of a body with these surface samples.
    pub fn new(samples: SampleCells) -> Self {
        let rows = samples.vertices.len();
        Self {
            velocities_before: vec![Vec4::zeros(); rows],
            velocities: vec![Vec4::zeros(); rows],
            detection: Detection::new(rows),
            solver: Solver::new(rows),
            leaving: Vec::new(),
            pressures: Vec::new(),
            touched: Vec::new(),
            displacements: vec![[0.0; 3]; rows],
            samples,
        }
    }

    /// Returns the samples on which contacts act.
    pub fn samples(&self) -> &SampleCells {
        &self.samples
    }

    /// Returns the memory of the samples and the buffers in bytes.
    pub fn bytes(&self) -> usize {
        let velocities = buffer_bytes(&self.velocities_before) + buffer_bytes(&self.velocities);
        let scratch =
            velocities + self.detection.bytes() + self.solver.bytes() + buffer_bytes(&self.pressures);
        let lists = buffer_bytes(&self.leaving) + buffer_bytes(&self.touched);
        self.samples.bytes() + scratch + lists + buffer_bytes(&self.displacements)
    }

    /// Returns false only if no sample is in the shape. May return true in this case as well.
    pub(crate) fn may_touch(&mut self, shape: &PosedShape, positions: &Lanes<3>) -> bool {
        self.detection.read(positions, &self.samples.slots, &[]);
        self.detection.may_touch(shape, &self.samples, 0.0)
    }

    /// Sets the lattice vertices that have no contacts: those of components that leave colliders.
    pub(crate) fn set_leaving(&mut self, is_leaving: impl Fn(u32) -> bool) {
        let rows = (0..).zip(&self.samples.vertices).filter(|(_, vertex)| is_leaving(**vertex));
        self.leaving.clear();
        self.leaving.extend(rows.map(|(row, _)| row));
    }

    /// Stores the velocities before the step. Called first in each step, before the shape matching.
    pub fn begin(&mut self, velocities: &Lanes<3>) {
        read(&mut self.velocities_before, velocities, &self.samples.slots);
    }

    /// Resolves the contacts. Called second in each step, after the integration of the positions.
    ///
    /// Normal and friction impulses change the velocities. The positions change by these velocity changes
    /// times the step. Samples that are still inside a collider are then pushed out by a change of the
    /// positions alone, by at most a quarter of a cell per step. Components that leave colliders as a whole
    /// ([`set_leaving`](Self::set_leaving)) have no contacts. `gravity` is in scene units per second squared.
    pub fn resolve(
        &mut self,
        state: &mut BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
        gravity: [f64; 3],
    ) -> ContactReport {
        let Self { samples, velocities_before, velocities, detection, solver, pressures, touched, .. } = self;
        let leaving = &self.leaving;
        pressures.clear();
        touched.clear();
        solver.clear();
        detection.read(state.positions, &samples.slots, leaving);
        let min_bounce = MIN_BOUNCE_STEPS * Vector3::from(gravity).norm() / state.frame.cell_size * step.dt;
        let mut report = ContactReport::default();
        for (index, collider) in colliders.during(step, state.frame).enumerate() {
            let untouched = report.contacts == 0;
            detection.find(&collider.shape, samples, SKIN, &mut report);
            if untouched && report.contacts > 0 {
                read(velocities, state.velocities, &samples.slots);
            }
            for patch in detection.patches() {
                let position = mean_position(patch.vertices(), detection.positions());
                let point = SurfacePoint {
                    position,
                    offset: samples.offset(patch, &collider.shape, &position),
                    velocity: mean(patch.vertices(), |row| velocities[row]),
                    velocity_before: mean(patch.vertices(), |row| velocities_before[row]),
                };
                let contact = point.contact(&collider, patch.deepest, step.dt, min_bounce);
                let (normal, position) = (wide(&contact.normal), point.position);
                pressures.push(Pressure {
                    collider: index as u32,
                    vertex: 0,
                    impulse: 0.0,
                    point: position.coords,
                    normal,
                    velocity: collider.velocity_at(&position),
                    spin: collider.spin(),
                });
                solver.add(contact, patch.vertices(), &samples.mobilities);
            }
        }
        if report.contacts > 0 {
            solver.solve(IMPACT);
            for (pressure, (impulse, row)) in pressures.iter_mut().zip(solver.normal_impulses()) {
                pressure.impulse = f64::from(impulse);
                pressure.vertex = samples.vertices[row as usize];
            }
            if self.apply_impulses(state, step.dt) > ALLOWED_DEPTH {
                self.push_out(state, colliders, step);
            }
            self.touched.sort_unstable();
            self.touched.dedup();
        }
        report
    }

    /// Adds the velocity changes to the velocities, and the velocity changes times the step to the positions.
    ///
    /// Returns the greatest remaining depth in cells, assuming that every sample of a patch moves like the
    /// contact point of the patch.
    fn apply_impulses(&mut self, state: &mut BodyState<'_>, dt: f64) -> f64 {
        for (row, change) in self.solver.changes() {
            let (slot, change) = (self.samples.slots[row as usize], wide(change));
            state.set_position(slot, state.position(slot) + change * dt);
            state.set_velocity(slot, state.velocity(slot) + change);
            self.touched.push(row);
        }
        let depths = self.solver.contacts();
        let depths = depths.map(|(contact, change)| f64::from(contact.depth) - f64::from(change) * dt);
        let remaining = depths.fold(0.0, f64::max);
        for (row, change) in self.solver.normal_changes() {
            // The displacement plus the velocity change times the step; the two are equal.
            add_displacement(&mut self.displacements[row as usize], change, 2.0 * dt as f32);
        }
        remaining
    }

    /// Pushes samples that are still inside a collider out of it. Changes positions, but not velocities.
    ///
    /// Few steps need a push-out. The possible causes are a body that was placed inside a collider or is
    /// constrained to be inside it, a patch that rotated about its contact point, and a penetration within
    /// the tolerance of the impulses.
    fn push_out(&mut self, state: &mut BodyState<'_>, colliders: &Colliders, step: Interval) {
        let Self { samples, detection, solver, leaving, touched, displacements, .. } = self;
        for round in 0..PUSH_ROUNDS {
            solver.clear();
            detection.read(state.positions, &samples.slots, leaving);
            let mut report = ContactReport::default();
            for collider in colliders.during(step, state.frame) {
                detection.find(&collider.shape, samples, 0.0, &mut report);
                for patch in detection.patches() {
                    let position = mean_position(patch.vertices(), detection.positions());
                    let sdf = collider.shape.signed_distance(&position);
                    let distance = sdf.distance + samples.offset(patch, &collider.shape, &position);
                    let (normal, target) = (narrow(sdf.normal), (-distance).min(PUSH_LIMIT) as f32);
                    let contact = Contact { normal, target, limit: target, ..Contact::default() };
                    solver.add(contact, patch.vertices(), &samples.mobilities);
                }
            }
            if report.deepest <= ALLOWED_DEPTH {
                break;
            }
            let is_soft = round == 0 && report.deepest <= SOFT_DEPTH;
            let part = if is_soft { SOFT_PART } else { 1.0 };
            solver.solve(PUSH);
            for (row, displacement) in solver.changes() {
                let slot = samples.slots[row as usize];
                state.set_position(slot, state.position(slot) + wide(displacement) * part);
                add_displacement(&mut displacements[row as usize], displacement, part as f32);
                touched.push(row);
            }
            if is_soft || report.deepest > PUSH_LIMIT {
                break;
            }
        }
    }

    /// Returns the contacts of the last step, by collider.
    pub(crate) fn pressures(&self) -> &[Pressure] {
        &self.pressures
    }

    /// Returns the lattice vertices that the contacts of the last step may have moved, in increasing order.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().map(|&row| self.samples.vertices[row as usize])
    }

    /// Sets the contact displacements to zero. Called at the start of each frame.
    pub fn clear_displacements(&mut self) {
        self.displacements.fill([0.0; 3]);
    }

    /// Returns the contact displacement of the vertex of each row, for a snapshot.
    pub(crate) fn all_displacements(&self) -> &[[f32; 3]] {
        &self.displacements
    }

    /// Restores [`all_displacements`](Self::all_displacements). Sets all of them to zero if `displacements`
    /// has another length, which means that it belongs to another body.
    pub(crate) fn set_displacements(&mut self, displacements: &[[f32; 3]]) {
        match displacements.len() == self.displacements.len() {
            true => self.displacements.copy_from_slice(displacements),
            false => self.clear_displacements(),
        }
    }

    /// Returns the contact displacements in cells since [`clear_displacements`](Self::clear_displacements).
    ///
    /// Each step adds the displacement by the normal impulses and by the push-out, and the velocity change by
    /// the normal impulses times the step. Returns pairs of lattice vertex and displacement in increasing
    /// order of the vertices, without the vertices that contacts did not displace.
    pub fn displacements(&self) -> impl Iterator<Item = (u32, [f32; 3])> + '_ {
        let all = self.samples.vertices.iter().copied().zip(self.displacements.iter().copied());
        all.filter(|(_, displacement)| *displacement != [0.0; 3])
    }
}

impl SampleCells {
    /// Returns the mean distance of the touching samples of a patch from the shape, minus the distance of the contact point:
    /// contacts act on the smooth surface, and move it by the trilinear weights of the samples. Zero if the skin is linear,
    /// which uses the distance of the contact point. `position`: contact point of the patch.
    fn offset(&self, patch: &Patch, shape: &PosedShape, position: &Point3<f64>) -> f64 {
        match self.stencils() {
            None => 0.0,
            Some(_) => patch.mean_distance() - shape.signed_distance(position).distance,
        }
    }
}

/// Adds `vector * scale` to a contact displacement.
fn add_displacement(displacement: &mut [f32; 3], vector: &Vec4, scale: f32) {
    for (sum, component) in displacement.iter_mut().zip(vector) {
        *sum += component * scale;
    }
}
