//! What is inside a collider all the same comes out: by positions alone, so that it gains no speed.
//!
//! A step seldom needs it: where a body was put into a collider or is held there, where a patch turned while its mean
//! stayed, where impulses were not yet quite right.

use super::exchange::Contact;
use super::impact::Motion;
use super::quad::{quad, vector};
use super::solver::Effort;
use super::{Colliders, ContactReport, Contacts, DEPTH_LEFT, add_push};
use crate::state::{BodyState, Interval};

/// How far a step may push the surface out, in cells. What is deeper comes out over several steps: pushing all of a
/// deep body out at once would flatten it on the surface, and its elasticity would then throw it up.
const LIMIT: f64 = 0.25;

/// At most so many rounds. The mean of a patch comes out in each, and what is less deep makes up the next one's.
const ROUNDS: usize = 4;

/// When a round is good enough: its pushes are lengths, in cells.
const EFFORT: Effort = Effort { passes: 9, share: 0.0, least: 1e-5 };

impl Contacts {
    /// Pushes out what is inside a collider at the end of a step.
    pub(super) fn push_out(&mut self, state: &mut BodyState<'_>, colliders: &Colliders, step: Interval) {
        let Self { samples, detection, meeting, touched, pushes, .. } = self;
        for _ in 0..ROUNDS {
            meeting.clear();
            detection.read(state.positions, &samples.slots);
            let mut report = ContactReport::default();
            for collider in colliders.during(step, state.frame) {
                detection.find(&collider.shape, samples, 0.0, &mut report);
                for patch in detection.patches() {
                    let still = |row| Motion { place: *detection.place(row), ..Motion::default() };
                    let point = meeting.point(patch, &samples.mobilities, still);
                    let here = collider.shape.signed_distance(&point.place());
                    let leave = (-here.distance).min(LIMIT) as f32;
                    let normal = quad(here.normal);
                    meeting.solver.add(Contact { normal, leave, most: leave, ..Contact::default() });
                }
            }
            if report.deepest <= DEPTH_LEFT {
                break;
            }
            meeting.solver.solve(EFFORT);
            for (row, push) in meeting.solver.given() {
                let slot = samples.slots[row as usize];
                state.set_position(slot, state.position(slot) + vector(push));
                add_push(&mut pushes[row as usize], push, 1.0);
                touched.push(row);
            }
            if report.deepest > LIMIT {
                break;
            }
        }
    }
}
