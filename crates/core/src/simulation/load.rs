//! The weight of the bodies that may come to lie on each other.

use nalgebra::{Point3, Vector3};

use crate::body::Body;
use crate::contact::bodies::BodyContacts;

/// Returns for each body the sum of its mass and the masses of the bodies above it, along gravity, which it touches
/// if they fall on it. Of a body above, the part counts whose box, seen along gravity, covers the box of the body.
/// `contacts` is `None` if bodies do not touch each other.
pub(super) fn stacked_masses(
    bodies: &[Body],
    contacts: Option<&BodyContacts>,
    gravity: &Vector3<f64>,
) -> Vec<f64> {
    let mut masses: Vec<f64> = bodies.iter().map(Body::mass).collect();
    let (Some(contacts), Some(down)) = (contacts, gravity.try_normalize(0.0)) else { return masses };
    let first = down.cross(&Vector3::ith(down.iamin(), 1.0)).normalize();
    let across = [first, down.cross(&first)];
    let columns: Vec<Column> = bodies.iter().map(|body| Column::of(body, &down, &across)).collect();
    for (index, own) in (0..).zip(&columns) {
        let others =
            (0..).zip(&columns).filter(|(other, _)| *other != index && contacts.may_touch(index, *other));
        let above = others.map(|(other, column)| bodies[other as usize].mass() * column.part_above(own));
        masses[index as usize] += above.sum::<f64>();
    }
    masses
}

/// The box of a body, along gravity and across it.
struct Column {
    /// Coordinate of the center of its box, along gravity.
    depth: f64,
    /// The intervals that its box covers along two axes perpendicular to gravity.
    intervals: [(f64, f64); 2],
}

impl Column {
    fn of(body: &Body, down: &Vector3<f64>, across: &[Vector3<f64>; 2]) -> Self {
        let (low, high) = body.bounds();
        let (center, half): (Point3<f64>, _) = (nalgebra::center(&low, &high), (high - low) / 2.0);
        let interval = |axis: &Vector3<f64>| {
            let (middle, extent) = (axis.dot(&center.coords), axis.abs().dot(&half));
            (middle - extent, middle + extent)
        };
        Self { depth: down.dot(&center.coords), intervals: [interval(&across[0]), interval(&across[1])] }
    }

    /// Returns the part of this box that covers another one, seen along gravity, if it is above; else 0.
    fn part_above(&self, other: &Self) -> f64 {
        let part = |(a, b): (&(f64, f64), &(f64, f64))| {
            let (common, length) = (a.1.min(b.1) - a.0.max(b.0), a.1 - a.0);
            // A box without length is inside or outside as a whole.
            if length > 0.0 { (common / length).max(0.0) } else { f64::from(common >= 0.0) }
        };
        match self.depth < other.depth {
            true => self.intervals.iter().zip(&other.intervals).map(part).product(),
            false => 0.0,
        }
    }
}
