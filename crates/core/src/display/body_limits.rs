//! The limits of the displayed surface of a body at the bodies that it touches or that are near.

use nalgebra::Vector3;

use super::near_bodies::GREATEST_GAP;
use crate::body::BodyRef;
use crate::contact::bodies::{GapBody, GapSearch};
use crate::sparse_set::SparseSet;
use crate::volume::Limit;

/// Greatest clearance in cells that is searched: half of a gap.
const GREATEST_DISTANCE: f64 = GREATEST_GAP / 2.0;

/// Buffers for the limits of one body after another.
#[derive(Debug, Default)]
pub(super) struct BodyLimits {
    gaps: GapSearch,
    /// Twelve rows for each lattice vertex: one for each dominant axis and sign of the normal of a limit, and six
    /// more for soft limits.
    rows: SparseSet,
    /// The limit of each of `rows`.
    limits: Vec<Limit>,
}

impl BodyLimits {
    /// Returns a function that adds the limits of a body for one set of positions, as far as they limit displacements
    /// of up to a distance in cells. With them, the displayed surface takes at most half of a gap to another body,
    /// and does not move towards a body that it touches. A body outside a simulation has no limits.
    pub(super) fn finder<'a>(
        &'a mut self,
        body: BodyRef<'a>,
    ) -> impl FnMut(&[[f32; 3]], f64, &mut Vec<Limit>) + 'a {
        self.limits.clear();
        let mut searched = 0.0;
        move |positions, distance, limits| {
            let distance = distance.min(GREATEST_DISTANCE);
            if distance > searched {
                // With limits, the vertices without them move farther.
                searched = (2.0 * distance).min(GREATEST_DISTANCE);
                self.find(body, positions, searched);
            }
            limits.extend_from_slice(&self.limits);
        }
    }

    /// Replaces the limits by those within `distance`.
    fn find(&mut self, body: BodyRef<'_>, positions: &[[f32; 3]], distance: f64) {
        let (Some(near), Some(surface)) =
            (body.context().and_then(|context| context.near), body.get().surface_of_contact())
        else {
            return;
        };
        let Self { gaps, rows, limits } = self;
        rows.resize(12 * positions.len());
        let is_in_pieces = body.get().is_in_pieces();
        limits.clear();
        let mut add = |sample: u32, normal: Vector3<f64>, clearance: f64, is_own: bool| {
            let axis = normal.iamax();
            let side = axis + if normal[axis] < 0.0 { 3 } else { 0 };
            // Where a body breaks, its pieces overlap. Their volume is more important.
            let is_soft = is_own && is_in_pieces;
            let row = side + if is_soft { 6 } else { 0 };
            for vertex in surface.vertices_of(sample) {
                let index = rows.index_or_insert(12 * vertex + row as u32) as usize;
                let limit = Limit { vertex, normal, clearance, is_soft };
                match limits.get_mut(index) {
                    None => limits.push(limit),
                    Some(found) if clearance < found.clearance => *found = limit,
                    // Of several touches, the direction of the sum of their normals.
                    Some(found) if clearance == 0.0 => found.normal += normal,
                    Some(_) => {}
                }
            }
        };
        for touch in body.state().touches.samples() {
            let normal = Vector3::from(touch.normal.map(f64::from));
            add(touch.sample, normal, 0.0, near.index == touch.other);
        }
        let own = GapBody {
            surface,
            lattice: body.get().lattice(),
            positions,
            frame: body.frame(),
            connected_parts_touch: body.get().has_self_contact(),
            touches_itself: near.touches_itself(),
        };
        gaps.find(&own, near.surfaces(2.0 * distance), distance, |gap| {
            add(gap.sample, gap.normal, gap.clearance, gap.is_own)
        });
        for limit in limits {
            limit.normal = limit.normal.try_normalize(0.0).unwrap_or(limit.normal);
        }
    }

    /// Returns the memory of the buffers in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.gaps.bytes() + self.rows.bytes() + size_of_val(&*self.limits)
    }
}
