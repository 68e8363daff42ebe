//! Contacts: which points of the visible surface are inside a collider, and what that does to the lattice.
//!
//! Contacts act on sample points of the surface and are spread to the lattice vertices by the embedding weights
//! `w`: a change `c` of a sample becomes `c w_i / sum w^2` at vertex `i`, which moves the sample by exactly `c`.
//! Where several samples share a vertex their changes are averaged, weighted by `w_i`; over an evenly covered
//! face that average is again exact.
//!
//! ```text
//! body's bounds -> cells' bounds -> samples     what may touch, against each collider
//! velocities:  clamp the normal part (restitution), rub the tangential part (Coulomb)
//! positions:   take back the rubbed part of the step, then push out
//! ```

mod response;

use nalgebra::{Point3, Vector3};

use self::response::{Contact, Response};
use super::collider::PosedCollider;
use super::samples::trilinear;
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
    /// Samples that were inside a collider, counted for each collider.
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
        let (centre, half) = self.bounds(state);
        let fall = Vector3::from(gravity).norm() / state.frame.cell_size * step.dt;
        let mut report = ContactReport::default();
        for collider in colliders.during(step, state.frame) {
            if may_touch(&collider, &centre, &half) {
                self.detect(&collider, state, step, QUIET_STEPS * fall, &mut report);
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

    /// What contacts gave to the lattice vertices since [`clear_pushes`](Self::clear_pushes): the velocity
    /// changes along the collider normals, summed over the steps, in cells per second.
    ///
    /// A vertex that carries nothing but its own weight collects gravity x time. Pairs of vertex and push, for
    /// the vertices around the surface, in increasing order.
    pub fn pushes(&self) -> impl Iterator<Item = (u32, [f32; 3])> + '_ {
        self.samples.vertices.iter().copied().zip(self.pushes.iter().copied())
    }

    /// Copies the positions of the samples' vertices to `places` and gives their bounds: centre, half extents.
    fn bounds(&mut self, state: &BodyState<'_>) -> (Point3<f64>, Vector3<f64>) {
        for (place, &slot) in self.places.iter_mut().zip(&self.samples.slots) {
            *place = state.positions.get(slot);
        }
        bounds(self.places.iter())
    }

    /// Collects the samples that touch one collider.
    fn detect(
        &mut self,
        collider: &PosedCollider,
        state: &BodyState<'_>,
        step: Interval,
        quiet: f64,
        report: &mut ContactReport,
    ) {
        self.response.open_group(collider);
        for (cell, corners) in self.samples.corners.iter().enumerate() {
            let (centre, half) = bounds(corners.iter().map(|&row| &self.places[row as usize]));
            if !may_touch(collider, &centre, &half) {
                continue;
            }
            for &local in self.samples.of_cell(cell) {
                let weights = trilinear(local);
                let place = Point3::from(blend(&weights, corners.map(|row| self.places[row as usize])));
                let here = collider.shape.signed_distance(&place);
                // Written so that a distance that is not a number is no contact.
                if !(here.distance <= SKIN) {
                    continue;
                }
                let slots = corners.map(|row| self.samples.slots[row as usize]);
                let velocity = blend(&weights, slots.map(|slot| state.velocities.get(slot)));
                let surface = collider.velocity_at(&place);
                let approach = (surface - velocity).dot(&here.normal);
                // A sample that already touched when the step began rests and does not bounce, however hard
                // the body's own forces press it down.
                let came = collider.before.signed_distance(&(place - velocity * step.dt)).distance > SKIN;
                let bounce = if came && approach > quiet { collider.restitution * approach } else { 0.0 };
                if here.distance < 0.0 {
                    report.contacts += 1;
                    report.deepest = report.deepest.max(-here.distance);
                }
                self.response.add(
                    *corners,
                    Contact {
                        weights,
                        normal: here.normal,
                        surface,
                        bounce,
                        allowance: PUSH_LIMIT + approach.max(0.0) * step.dt,
                        ..Contact::default()
                    },
                );
            }
        }
        self.response.close_group();
    }
}

/// Whether anything in the box may be within the skin of the collider; false for bounds that are not numbers.
fn may_touch(collider: &PosedCollider, centre: &Point3<f64>, half: &Vector3<f64>) -> bool {
    collider.shape.lower_bound(centre, half) <= SKIN
}

/// Centre and half extents of the bounds of some points, a little larger than they are.
fn bounds<'a>(places: impl Iterator<Item = &'a [f32; 3]>) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for place in places {
        for a in 0..3 {
            low[a] = low[a].min(place[a]);
            high[a] = high[a].max(place[a]);
        }
    }
    let (low, high) = (low.map(f64::from), high.map(f64::from));
    let centre = Point3::from(std::array::from_fn(|a| 0.5 * (low[a] + high[a])));
    // Room for places within the cell that are 1 and a rounding.
    let half = Vector3::from_fn(|a, _| 0.5 * (high[a] - low[a]) * (1.0 + 1e-5));
    (centre, half)
}

/// The weighted sum of the corners' values.
fn blend(weights: &[f64; 8], values: [[f32; 3]; 8]) -> Vector3<f64> {
    weights
        .iter()
        .zip(values)
        .fold(Vector3::zeros(), |sum, (&w, value)| sum + Vector3::from(value.map(f64::from)) * w)
}
