//! Contacts: which points of the visible surface are inside a collider, and what that does to the lattice.
//!
//! Contacts act on sample points of the surface and are spread to the lattice vertices by the embedding weights
//! `w`: a change `c` of a sample becomes `c w_i / sum w^2` at vertex `i`, which moves the sample by exactly `c`.
//! Where several samples share a vertex their changes are averaged, weighted by `w_i` (for the push-out also by
//! depth); over an evenly covered face that average is again exact. A few passes do the rest.
//!
//! ```text
//! body's bounds -> cells' bounds -> samples     what may touch, against each collider
//! velocities:  clamp the normal part (restitution), rub the tangential part (Coulomb)
//! positions:   take back the rubbed part of the step, then push out
//! ```

mod bounds;
mod detection;
mod response;

use nalgebra::Vector3;

use self::bounds::{bounds_of_slots, may_touch};
use self::detection::Step;
use self::response::Response;
use super::{BodyState, Colliders, Interval, SampleCells};

/// Distance in cells up to which a sample outside a collider still counts as touching it: a body that rests and
/// trembles stays in contact. It is clamped and rubbed there, and not pushed.
const SKIN: f64 = 1e-3;

/// Impacts slower than this many steps of free fall do not bounce, so that a body comes to rest.
const QUIET_STEPS: f64 = 2.0;

/// How far a step may push a sample out, in cells, beyond what it came in that step. Deeper ones come out over
/// several steps: pushing all of a deep body out at once would flatten it on the surface, and its elasticity
/// would then throw it up.
const PUSH_LIMIT: f64 = 0.25;

/// The contact stage of one body.
#[derive(Clone, Debug)]
pub struct Contacts {
    samples: SampleCells,
    /// Local positions of the samples' vertices at detection.
    places: Vec<[f32; 3]>,
    response: Response,
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
            places: vec![[0.0; 3]; count],
            response: Response::new(count),
            pushes: vec![[0.0; 3]; count],
            samples,
        }
    }

    /// The samples on which contacts act.
    pub fn samples(&self) -> &SampleCells {
        &self.samples
    }

    /// Resolves the contacts of a step, after positions were integrated to its end.
    ///
    /// Positions change by the push-out, which does not feed the velocities, and by what friction held back.
    /// Velocities change by the clamped normal and the rubbed tangential part, relative to the collider.
    /// A sample is pushed at most a quarter of a cell a step beyond what it came in that step: a body that starts
    /// deep inside comes out bit by bit. `gravity` is in scene units per second squared.
    pub fn resolve(
        &mut self,
        state: &mut BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
        gravity: [f64; 3],
    ) -> ContactReport {
        self.response.clear();
        let (centre, half) = bounds_of_slots(state.positions);
        let fall = Vector3::from(gravity).norm() / state.frame.cell_size * step.dt;
        let mut report = ContactReport::default();
        let mut gathered = false;
        for collider in colliders.during(step, state.frame) {
            if may_touch(&collider, &centre, &half) {
                if !gathered {
                    self.gather(state.positions);
                    gathered = true;
                }
                let step = Step { collider: &collider, dt: step.dt, quiet: QUIET_STEPS * fall };
                self.detect(&step, state.velocities, &mut report);
            }
        }
        self.response.solve(state, &self.samples.slots, &mut self.pushes, step.dt);
        report
    }

    /// Lattice vertices that the contacts of the last step could move, in a fixed order.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.response.rows().map(|row| self.samples.vertices[row as usize])
    }

    /// Forgets the pushes: at the start of a frame.
    pub fn clear_pushes(&mut self) {
        self.pushes.fill([0.0; 3]);
    }

    /// All pushes, one per sampled lattice vertex, to be saved.
    #[cfg(feature = "scene")]
    pub(crate) fn all_pushes(&self) -> &[[f32; 3]] {
        &self.pushes
    }

    /// Puts back what [`all_pushes`](Self::all_pushes) gave; those of another body count as none.
    #[cfg(feature = "scene")]
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
