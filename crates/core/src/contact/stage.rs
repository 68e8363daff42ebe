//! The contact stage of a body.

use nalgebra::Vector3;

use super::SKIN;
use super::collider::Colliders;
use super::constraint::{Contact, SurfacePoint, mean, mean_place};
use super::detection::{ContactReport, Detection};
use super::rows::held;
use super::samples::SampleCells;
use super::solver::{Solver, Tolerance};
use super::vec4::{Vec4, narrow, read, wide};
use crate::simd::lanes::Lanes;
use crate::state::{BodyState, Interval};

/// Impacts slower than this many steps of free fall do not bounce, so that a body comes to rest.
const QUIET_STEPS: f64 = 2.0;

/// Depth in cells that is not pushed out.
const DEPTH_LEFT: f64 = 3e-4;

/// Tolerance of the impulses of impacts, which are velocities.
const IMPACT: Tolerance = Tolerance { passes: 13, relative: 1e-4, absolute: 0.0 };

/// Greatest push-out of a step, in cells. Deeper samples come out over several steps: pushing all of a deep body out at
/// once would flatten it on the surface, and its elasticity would then throw it up.
const PUSH_LIMIT: f64 = 0.25;

/// Most rounds of a push-out. Each pushes out the mean of a patch; the samples that stay inside make up the next patch.
const PUSH_ROUNDS: usize = 4;

/// Tolerance of a round of the push-out, which finds lengths in cells.
const PUSH: Tolerance = Tolerance { passes: 9, relative: 0.0, absolute: 1e-5 };

/// The contact stage of one body. Its buffers grow with the largest number of simultaneous contacts and are kept.
#[derive(Clone, Debug)]
pub struct Contacts {
    samples: SampleCells,
    /// Velocities of the samples' vertices before the step, and at its end.
    velocities_before: Vec<Vec4>,
    velocities: Vec<Vec4>,
    detection: Detection,
    solver: Solver,
    /// Rows of the vertices that the last step may have moved.
    touched: Vec<u32>,
    /// Sum of the pushes of each of the samples' vertices since `clear_pushes`.
    pushes: Vec<[f32; 3]>,
}

impl Contacts {
    /// The stage for a body with these surface samples.
    pub fn new(samples: SampleCells) -> Self {
        let rows = samples.vertices.len();
        Self {
            velocities_before: vec![Vec4::zeros(); rows],
            velocities: vec![Vec4::zeros(); rows],
            detection: Detection::new(rows),
            solver: Solver::new(rows),
            touched: Vec::new(),
            pushes: vec![[0.0; 3]; rows],
            samples,
        }
    }

    /// The samples on which contacts act.
    pub fn samples(&self) -> &SampleCells {
        &self.samples
    }

    /// Memory in bytes: samples and buffers.
    pub fn bytes(&self) -> usize {
        let velocities = held(&self.velocities_before) + held(&self.velocities);
        let scratch = velocities + self.detection.bytes() + self.solver.bytes();
        self.samples.bytes() + scratch + held(&self.touched) + held(&self.pushes)
    }

    /// First call of a step, before the matching: keeps the velocities, which are those with which the surface hits
    /// colliders.
    pub fn begin(&mut self, velocities: &Lanes<3>) {
        read(&mut self.velocities_before, velocities, &self.samples.slots);
    }

    /// Second call of a step, after positions were integrated to its end: resolves the contacts.
    ///
    /// Velocities change by impulses along the normals and by friction, relative to the colliders, and positions change
    /// by these velocities times the step. Samples that are still inside a collider are pushed out by positions alone, at
    /// most a quarter of a cell a step: a body that starts deep inside comes out over several steps. `gravity` is in scene
    /// units per second squared.
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
        let quiet = QUIET_STEPS * Vector3::from(gravity).norm() / state.frame.cell_size * step.dt;
        let mut report = ContactReport::default();
        for collider in colliders.during(step, state.frame) {
            let untouched = report.contacts == 0;
            detection.find(&collider.shape, samples, SKIN, &mut report);
            if untouched && report.contacts > 0 {
                read(velocities, state.velocities, &samples.slots);
            }
            for patch in detection.patches() {
                let point = SurfacePoint {
                    place: mean_place(patch.vertices(), detection.places()),
                    velocity: mean(patch.vertices(), |row| velocities[row]),
                    velocity_before: mean(patch.vertices(), |row| velocities_before[row]),
                };
                let contact = point.contact(&collider, patch.deepest, step.dt, quiet);
                solver.add(contact, patch.vertices(), &samples.mobilities);
            }
        }
        if report.contacts > 0 {
            solver.solve(IMPACT);
            if self.apply_impulses(state, step.dt) > DEPTH_LEFT {
                self.push_out(state, colliders, step);
            }
            self.touched.sort_unstable();
            self.touched.dedup();
        }
        report
    }

    /// Adds the velocity changes, and these times the step to the positions. Returns the greatest depth that is left, in
    /// cells, if each patch moves like its mean.
    fn apply_impulses(&mut self, state: &mut BodyState<'_>, dt: f64) -> f64 {
        for (row, change) in self.solver.changes() {
            let (slot, change) = (self.samples.slots[row as usize], wide(change));
            state.set_position(slot, state.position(slot) + change * dt);
            state.set_velocity(slot, state.velocity(slot) + change);
            self.touched.push(row);
        }
        let depths = self.solver.contacts();
        let depths = depths.map(|(contact, change)| f64::from(contact.depth) - f64::from(change) * dt);
        let left = depths.fold(0.0, f64::max);
        for (row, change) in self.solver.normal_changes() {
            // The displacement, and the velocity times the step.
            add_push(&mut self.pushes[row as usize], change, 2.0 * dt as f32);
        }
        left
    }

    /// Pushes samples that are inside a collider at the end of a step out of it, by positions alone: they gain no speed.
    ///
    /// Few steps need it: those of a body that was put or is held in a collider, of a patch that turned while its mean
    /// stayed, of impulses within their tolerance.
    fn push_out(&mut self, state: &mut BodyState<'_>, colliders: &Colliders, step: Interval) {
        let Self { samples, detection, solver, touched, pushes, .. } = self;
        for _ in 0..PUSH_ROUNDS {
            solver.clear();
            detection.read(state.positions, &samples.slots);
            let mut report = ContactReport::default();
            for collider in colliders.during(step, state.frame) {
                detection.find(&collider.shape, samples, 0.0, &mut report);
                for patch in detection.patches() {
                    let place = mean_place(patch.vertices(), detection.places());
                    let here = collider.shape.signed_distance(&place);
                    let (normal, target) = (narrow(here.normal), (-here.distance).min(PUSH_LIMIT) as f32);
                    let contact = Contact { normal, target, limit: target, ..Contact::default() };
                    solver.add(contact, patch.vertices(), &samples.mobilities);
                }
            }
            if report.deepest <= DEPTH_LEFT {
                break;
            }
            solver.solve(PUSH);
            for (row, push) in solver.changes() {
                let slot = samples.slots[row as usize];
                state.set_position(slot, state.position(slot) + wide(push));
                add_push(&mut pushes[row as usize], push, 1.0);
                touched.push(row);
            }
            if report.deepest > PUSH_LIMIT {
                break;
            }
        }
    }

    /// Lattice vertices that the contacts of the last step may have moved, in increasing order.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().map(|&row| self.samples.vertices[row as usize])
    }

    /// Sets the pushes to zero: at the start of a frame.
    pub fn clear_pushes(&mut self) {
        self.pushes.fill([0.0; 3]);
    }

    /// All pushes, one per sampled lattice vertex, for a snapshot.
    pub(crate) fn all_pushes(&self) -> &[[f32; 3]] {
        &self.pushes
    }

    /// Restores [`all_pushes`](Self::all_pushes); clears them if they are of another body.
    pub(crate) fn set_pushes(&mut self, pushes: &[[f32; 3]]) {
        match pushes.len() == self.pushes.len() {
            true => self.pushes.copy_from_slice(pushes),
            false => self.clear_pushes(),
        }
    }

    /// The effect of contacts on the lattice vertices since [`clear_pushes`](Self::clear_pushes), in cells: each step adds
    /// the push-out and, times the step, the velocity change, both along the collider normals.
    ///
    /// Pairs of vertex and push, in increasing order of vertex; vertices that were not touched are left out.
    pub fn pushes(&self) -> impl Iterator<Item = (u32, [f32; 3])> + '_ {
        let all = self.samples.vertices.iter().copied().zip(self.pushes.iter().copied());
        all.filter(|(_, push)| *push != [0.0; 3])
    }
}

/// Adds `b` times `s` to a push.
fn add_push(push: &mut [f32; 3], b: &Vec4, s: f32) {
    for (push, b) in push.iter_mut().zip(b) {
        *push += b * s;
    }
}
