//! Contacts: which points of the visible surface touch a collider, and what that does to the lattice.
//!
//! | file | what |
//! |---|---|
//! | `detection`, `bounds`, `field` | the samples that touch: strips of cells, then cells, then samples |
//! | `patch` | those about one lattice vertex, which act as one |
//! | `impact` | how fast a patch comes, and how fast it is to leave |
//! | `exchange` | the impulses along the normal and across it that this asks of it alone |
//! | `solver`, `links` | those of all patches together |
//! | `numbered` | rows of vertices, numbered as they come |
//! | `push_out` | what is inside all the same comes out, by positions alone |
//! | `clearance` | for those who look: how far lattice vertices may be moved beside a collider |
//!
//! A velocity that a contact changes changes the position with it, by the change times the step, so that a step stays
//! one of Verlet's. Then no contact gives energy, whatever the restitution. With masses M, a quadratic energy of
//! deformation V and a step h from x- by x to x+, an impulse changes the energy of the step, |x+ - x|² / 2h² in the
//! norm of M and V between x and x+, by its product with (x+ - x-) / 2h: the mean of the velocities after and before
//! the step. A contact that pushes and leaves no faster than it came does no work; nor does friction that is
//! against that mean. (The time-stepping of impacts by Paoli & Schatzman, 1993, rests on the same product.)
//!
//! Exceptions are small: a point that was leaving and was turned back by more than it can come back stops at the
//! surface, and what is pushed out by positions is lifted. Impulses that are not yet right let a body sink, which the
//! push-out then makes good: how still a body rests depends on them.

mod bounds;
mod clearance;
mod collider;
mod colliders;
mod detection;
mod exchange;
mod field;
mod impact;
mod links;
mod numbered;
mod patch;
mod posed;
mod push_out;
mod quad;
mod samples;
mod shape;
mod solver;

use nalgebra::Vector3;

pub(crate) use self::clearance::{Clearance, Obstacles};
pub use self::collider::{Collider, ColliderError};
pub use self::colliders::Colliders;
use self::detection::Detection;
use self::impact::{Meeting, Motion};
use self::quad::{Quad, quad, vector};
pub use self::samples::{SampleCells, surface_points};
pub use self::shape::{Shape, SignedDistance};
use self::solver::Effort;
use crate::Lanes;
use crate::state::{BodyState, Interval};

/// Distance in cells up to which a sample outside a collider still counts as touching it: a body that rests and
/// trembles stays in contact. It is clamped and rubbed there, and not pushed.
const SKIN: f64 = 1e-3;

/// Impacts slower than this many steps of free fall do not bounce, so that a body comes to rest.
const QUIET_STEPS: f64 = 2.0;

/// Depth in cells that is left as it is.
const DEPTH_LEFT: f64 = 3e-4;

/// When the impulses of impacts are good enough.
const IMPULSES: Effort = Effort { passes: 13, share: 1e-4, least: 0.0 };

/// The contact stage of one body.
#[derive(Clone, Debug)]
pub struct Contacts {
    samples: SampleCells,
    /// Velocities of the samples' vertices when the step began.
    came: Vec<Quad>,
    detection: Detection,
    meeting: Meeting,
    /// Rows of the vertices that the last step could move.
    touched: Vec<u32>,
    /// What contacts did to each of the samples' vertices since `clear_pushes`.
    pushes: Vec<[f32; 3]>,
}

/// What the contacts of one step were.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Samples inside a collider or within a thousandth of a cell of it, counted for each collider. With none the
    /// step changed nothing.
    pub contacts: usize,
    /// Greatest depth of a sample before it was pushed out, in cells.
    pub deepest: f64,
}

impl Contacts {
    /// The stage for a body with these surface samples.
    ///
    /// Its buffers grow with the largest number of simultaneous contacts and are kept.
    pub fn new(samples: SampleCells) -> Self {
        let count = samples.vertices.len();
        Self {
            came: vec![[0.0; 4]; count],
            detection: Detection::new(count),
            meeting: Meeting::new(count),
            touched: Vec::new(),
            pushes: vec![[0.0; 3]; count],
            samples,
        }
    }

    /// The samples on which contacts act.
    pub fn samples(&self) -> &SampleCells {
        &self.samples
    }

    /// Opens a step, before velocities change: those with which the surface comes are kept.
    pub fn begin(&mut self, velocities: &Lanes<3>) {
        quad::read(&mut self.came, velocities, &self.samples.slots);
    }

    /// Resolves the contacts of a step, after positions were integrated to its end.
    ///
    /// Velocities change by impulses along the normals and by friction, relative to the colliders, and positions with
    /// them. What is inside a collider all the same is pushed out by positions alone, at most a quarter of a cell a
    /// step: a body that starts deep inside comes out bit by bit. `gravity` is in scene units per second squared.
    pub fn resolve(
        &mut self,
        state: &mut BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
        gravity: [f64; 3],
    ) -> ContactReport {
        let Self { samples, came, detection, meeting, touched, .. } = self;
        touched.clear();
        meeting.clear();
        detection.read(state.positions, &samples.slots);
        let quiet = QUIET_STEPS * Vector3::from(gravity).norm() / state.frame.cell_size * step.dt;
        let mut report = ContactReport::default();
        for collider in colliders.during(step, state.frame) {
            detection.find(&collider.shape, samples, SKIN, &mut report);
            for patch in detection.patches() {
                let point = meeting.point(patch, &samples.mobilities, |row| Motion {
                    place: *detection.place(row),
                    velocity: quad(state.velocity(samples.slots[row as usize])),
                    came: came[row as usize],
                });
                meeting.solver.add(point.contact(&collider, patch.deepest, step.dt, quiet));
            }
        }
        if !meeting.solver.is_empty() {
            meeting.solver.solve(IMPULSES);
            let left = self.exchange(state, step.dt);
            if left > DEPTH_LEFT {
                self.push_out(state, colliders, step);
            }
            self.touched.sort_unstable();
            self.touched.dedup();
        }
        report
    }

    /// Gives the vertices the velocities that were found, and the way that these take in a step. Returns the depth
    /// that this leaves, in cells, where each patch moves like its mean.
    fn exchange(&mut self, state: &mut BodyState<'_>, dt: f64) -> f64 {
        let solver = &mut self.meeting.solver;
        for (row, change) in solver.given() {
            let (slot, change) = (self.samples.slots[row as usize], vector(change));
            state.set_position(slot, state.position(slot) + change * dt);
            state.set_velocity(slot, state.velocity(slot) + change);
            self.touched.push(row);
        }
        let depths = solver.gains().map(|(contact, gain)| f64::from(contact.depth) - f64::from(gain) * dt);
        let left = depths.fold(0.0, f64::max);
        for (row, along) in solver.given_along() {
            // The way, and the velocity times the step.
            add_push(&mut self.pushes[row as usize], along, 2.0 * dt as f32);
        }
        left
    }

    /// Lattice vertices that the contacts of the last step could move, in a fixed order.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().map(|&row| self.samples.vertices[row as usize])
    }

    /// Forgets the pushes: at the start of a frame.
    pub fn clear_pushes(&mut self) {
        self.pushes.fill([0.0; 3]);
    }

    /// All pushes, one per sampled lattice vertex, to be saved.
    pub(crate) fn all_pushes(&self) -> &[[f32; 3]] {
        &self.pushes
    }

    /// Puts back what [`all_pushes`](Self::all_pushes) gave; those of another body count as none.
    pub(crate) fn set_pushes(&mut self, pushes: &[[f32; 3]]) {
        match pushes.len() == self.pushes.len() {
            true => self.pushes.copy_from_slice(pushes),
            false => self.clear_pushes(),
        }
    }

    /// What contacts did to the lattice vertices since [`clear_pushes`](Self::clear_pushes), in cells: each step
    /// adds the push-out and, times the step, the velocity change, both along the collider normals.
    ///
    /// Pairs of vertex and push, in increasing order of vertex; vertices that were not touched are left out.
    pub fn pushes(&self) -> impl Iterator<Item = (u32, [f32; 3])> + '_ {
        let all = self.samples.vertices.iter().copied().zip(self.pushes.iter().copied());
        all.filter(|(_, push)| *push != [0.0; 3])
    }
}

/// Adds `b` times `s` to a push.
fn add_push(push: &mut [f32; 3], b: &Quad, s: f32) {
    for (push, b) in push.iter_mut().zip(b) {
        *push += b * s;
    }
}
