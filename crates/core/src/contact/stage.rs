//! The contact stage of a body: velocity before, detection, contact constraints, push-out.

use nalgebra::Vector3;

use super::SKIN;
use super::collider::Colliders;
use super::constraint::{Contact, SurfacePoint, mean, mean_position};
use super::detection::{ContactReport, Detection};
use super::rows::buffer_bytes;
use super::samples::SampleCells;
use super::solver::{Solver, Tolerance};
use super::vec4::{Vec4, narrow, read, wide};
use crate::simd::lanes::Lanes;
use crate::state::{BodyState, Interval};

/// Least speed of approach that bounces, in steps of free fall. Slower impacts let the body come to rest.
const MIN_BOUNCE_STEPS: f64 = 2.0;

/// Penetration that is tolerated without a push-out, in cells.
const ALLOWED_DEPTH: f64 = 3e-4;

/// Tolerance of the impulses of impacts; the solved quantities are velocities in cells per second.
const IMPACT: Tolerance = Tolerance { passes: 13, relative: 1e-4, absolute: 0.0 };

/// Greatest push-out in a step, in cells. Deeper samples leave the collider over several steps: pushing a
/// deep body out at once would flatten it on the surface, and its elastic energy would then throw it up.
const PUSH_LIMIT: f64 = 0.25;

/// Maximum number of push-out rounds in a step. Each round pushes out the contact point of each patch; the
/// samples that remain inside form the patches of the next round.
const PUSH_ROUNDS: usize = 4;

/// Tolerance of a push-out round; the solved quantities are lengths in cells.
const PUSH: Tolerance = Tolerance { passes: 9, relative: 0.0, absolute: 1e-5 };

/// Contact stage of one body. Its buffers grow with the number of simultaneous contacts and are reused.
#[derive(Clone, Debug)]
pub struct Contacts {
    samples: SampleCells,
    /// Velocities of the samples' vertices before the step.
    velocities_before: Vec<Vec4>,
    /// Velocities of the samples' vertices at the end of the step, before the impulses.
    velocities: Vec<Vec4>,
    detection: Detection,
    solver: Solver,
    /// Rows of the vertices that contacts of the last step may have moved.
    touched: Vec<u32>,
    /// Contact displacement of each of the samples' vertices since `clear_displacements`, in cells; see `displacements()`.
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
            touched: Vec::new(),
            displacements: vec![[0.0; 3]; rows],
            samples,
        }
    }

    /// Returns the samples on which contacts act.
    pub fn samples(&self) -> &SampleCells {
        &self.samples
    }

    /// Returns the memory in bytes of samples and buffers.
    pub fn bytes(&self) -> usize {
        let velocities = buffer_bytes(&self.velocities_before) + buffer_bytes(&self.velocities);
        let scratch = velocities + self.detection.bytes() + self.solver.bytes();
        self.samples.bytes() + scratch + buffer_bytes(&self.touched) + buffer_bytes(&self.displacements)
    }

    /// Stores the velocities before the step. The first call of a step, before the shape matching.
    pub fn begin(&mut self, velocities: &Lanes<3>) {
        read(&mut self.velocities_before, velocities, &self.samples.slots);
    }

    /// Resolves the contacts. The second call of a step, after the integration of the positions.
    ///
    /// Impulses along the normals and friction impulses change the velocities relative to the colliders.
    /// Positions change by these velocity changes times the step. Samples that are still inside a collider
    /// are pushed out by positions alone, at most a quarter of a cell per step; a body that starts deep
    /// inside leaves the collider over several steps. `gravity` is in scene units per second squared.
    pub fn resolve(
        &mut self,
        state: &mut BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
        gravity: [f64; 3],
    ) -> ContactReport {
        let Self { samples, velocities_before, velocities, detection, solver, touched, .. } = self;
        touched.clear();
        solver.clear();
        detection.read(state.positions, &samples.slots);
        let min_bounce = MIN_BOUNCE_STEPS * Vector3::from(gravity).norm() / state.frame.cell_size * step.dt;
        let mut report = ContactReport::default();
        for collider in colliders.during(step, state.frame) {
            let untouched = report.contacts == 0;
            detection.find(&collider.shape, samples, SKIN, &mut report);
            if untouched && report.contacts > 0 {
                read(velocities, state.velocities, &samples.slots);
            }
            for patch in detection.patches() {
                let point = SurfacePoint {
                    place: mean_position(patch.vertices(), detection.places()),
                    velocity: mean(patch.vertices(), |row| velocities[row]),
                    velocity_before: mean(patch.vertices(), |row| velocities_before[row]),
                };
                let contact = point.contact(&collider, patch.deepest, step.dt, min_bounce);
                solver.add(contact, patch.vertices(), &samples.mobilities);
            }
        }
        if report.contacts > 0 {
            solver.solve(IMPACT);
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
    /// Returns the greatest remaining depth in cells, assuming that every sample of a patch moves like its
    /// contact point.
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
            // The displacement, and the velocity change times the step.
            add_displacement(&mut self.displacements[row as usize], change, 2.0 * dt as f32);
        }
        remaining
    }

    /// Pushes samples that are still inside a collider out of it by positions alone, without a velocity
    /// change.
    ///
    /// Few steps need a push-out: the body was placed inside a collider or is constrained to it, a patch
    /// rotated about its contact point, or the impulses left a penetration within their tolerance.
    fn push_out(&mut self, state: &mut BodyState<'_>, colliders: &Colliders, step: Interval) {
        let Self { samples, detection, solver, touched, displacements, .. } = self;
        for _ in 0..PUSH_ROUNDS {
            solver.clear();
            detection.read(state.positions, &samples.slots);
            let mut report = ContactReport::default();
            for collider in colliders.during(step, state.frame) {
                detection.find(&collider.shape, samples, 0.0, &mut report);
                for patch in detection.patches() {
                    let place = mean_position(patch.vertices(), detection.places());
                    let here = collider.shape.signed_distance(&place);
                    let (normal, target) = (narrow(here.normal), (-here.distance).min(PUSH_LIMIT) as f32);
                    let contact = Contact { normal, target, limit: target, ..Contact::default() };
                    solver.add(contact, patch.vertices(), &samples.mobilities);
                }
            }
            if report.deepest <= ALLOWED_DEPTH {
                break;
            }
            solver.solve(PUSH);
            for (row, push) in solver.changes() {
                let slot = samples.slots[row as usize];
                state.set_position(slot, state.position(slot) + wide(push));
                add_displacement(&mut displacements[row as usize], push, 1.0);
                touched.push(row);
            }
            if report.deepest > PUSH_LIMIT {
                break;
            }
        }
    }

    /// Returns the lattice vertices that the contacts of the last step may have moved, in increasing order.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().map(|&row| self.samples.vertices[row as usize])
    }

    /// Sets the contact displacements to zero. Called at the start of a frame.
    pub fn clear_displacements(&mut self) {
        self.displacements.fill([0.0; 3]);
    }

    /// Returns the contact displacements of all of the samples' vertices, for a snapshot.
    pub(crate) fn all_displacements(&self) -> &[[f32; 3]] {
        &self.displacements
    }

    /// Restores [`all_displacements`](Self::all_displacements); sets them to zero if the length is that of another body.
    pub(crate) fn set_displacements(&mut self, displacements: &[[f32; 3]]) {
        match displacements.len() == self.displacements.len() {
            true => self.displacements.copy_from_slice(displacements),
            false => self.clear_displacements(),
        }
    }

    /// Returns the contact displacements in cells since [`clear_displacements`](Self::clear_displacements).
    ///
    /// Each step adds the displacement by normal impulses and push-out, and the velocity change by normal
    /// impulses times the step. The result is pairs of vertex and displacement in increasing order of vertex,
    /// without the vertices that contacts did not displace.
    pub fn displacements(&self) -> impl Iterator<Item = (u32, [f32; 3])> + '_ {
        let all = self.samples.vertices.iter().copied().zip(self.displacements.iter().copied());
        all.filter(|(_, push)| *push != [0.0; 3])
    }
}

/// Adds `b` times `s` to a contact displacement.
fn add_displacement(push: &mut [f32; 3], b: &Vec4, s: f32) {
    for (push, b) in push.iter_mut().zip(b) {
        *push += b * s;
    }
}
