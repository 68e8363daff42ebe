//! Which samples touch a collider: strips of cells, then cells, then samples.

use nalgebra::Point3;

use super::bounds::{bounds, may_touch};
use super::response::Contact;
use super::{ContactReport, Contacts, PUSH_LIMIT, SKIN};
use crate::Lanes;
use crate::dynamics::colliders::PosedCollider;
use crate::dynamics::frame::wide;
use crate::dynamics::samples::{CellMap, STRIP, trilinear};

/// Room in cells for the rounding of distances that are weighted sums of the corners'.
const ROUNDING: f64 = 1e-4;

/// One collider during one step.
pub(super) struct Step<'a> {
    pub(super) collider: &'a PosedCollider,
    /// Seconds.
    pub(super) dt: f64,
    /// Approach in cells per second up to which nothing bounces.
    pub(super) quiet: f64,
}

impl Contacts {
    /// Copies the positions of the samples' vertices to `places`.
    pub(super) fn gather(&mut self, positions: &Lanes<3>) {
        for (place, &slot) in self.places.iter_mut().zip(&self.samples.slots) {
            *place = positions.get(slot);
        }
    }

    /// Collects the samples that touch the collider.
    pub(super) fn detect(&mut self, step: &Step<'_>, velocities: &Lanes<3>, report: &mut ContactReport) {
        self.response.open_group(step.collider);
        for strip in 0..self.samples.strips.len() {
            let rows = self.samples.strips[strip].iter();
            let (centre, half) = bounds(rows.map(|&row| &self.places[row as usize]));
            if may_touch(step.collider, &centre, &half) {
                let first = strip * STRIP;
                for cell in first..(first + STRIP).min(self.samples.corners.len()) {
                    self.detect_in_cell(cell, step, velocities, report);
                }
            }
        }
        self.response.close_group();
    }

    /// Collects the samples of one cell that touch the collider.
    fn detect_in_cell(
        &mut self,
        cell: usize,
        step: &Step<'_>,
        velocities: &Lanes<3>,
        report: &mut ContactReport,
    ) {
        let Step { collider, dt, quiet } = *step;
        let rows = self.samples.corners[cell];
        let places = rows.map(|row| self.places[row as usize]);
        let corners = places.map(wide);
        let distances = collider.shape.linear_distances(&corners);
        let may_touch = match &distances {
            // A sample lies between the corners, and so does its distance.
            Some(distances) => distances.iter().any(|&d| d <= SKIN + ROUNDING),
            None => {
                let (centre, half) = bounds(places.iter());
                may_touch(collider, &centre, &half)
            }
        };
        if !may_touch {
            return;
        }
        let distance_of = distances.map(CellMap::new);
        let place_of = CellMap::new(corners);
        let mut velocity_of = None;
        for &sample in self.samples.of_cell(cell) {
            if distance_of.is_some_and(|distance| distance.at(sample) > SKIN + ROUNDING) {
                continue;
            }
            let place = Point3::from(place_of.at(sample));
            let here = collider.shape.signed_distance(&place);
            let touches = here.distance <= SKIN;
            // Also where the distance is not a number.
            if !touches {
                continue;
            }
            let velocity = velocity_of
                .get_or_insert_with(|| {
                    CellMap::new(rows.map(|row| wide(velocities.get(self.samples.slots[row as usize]))))
                })
                .at(sample);
            let surface = collider.velocity_at(&place);
            let approach = (surface - velocity).dot(&here.normal);
            // A sample that already touched when the step began rests and does not bounce, however hard the
            // body's own forces press it down.
            let came = collider.before.signed_distance(&(place - velocity * dt)).distance > SKIN;
            report.contacts += 1;
            report.deepest = report.deepest.max(-here.distance);
            self.response.add(
                rows,
                Contact {
                    weights: trilinear(sample),
                    normal: here.normal,
                    surface,
                    bounce: if came && approach > quiet { collider.restitution * approach } else { 0.0 },
                    left: (-here.distance - PUSH_LIMIT - approach.max(0.0) * dt).max(0.0),
                    ..Contact::default()
                },
            );
        }
    }
}
