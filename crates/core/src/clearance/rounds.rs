//! Finds limits and moves vertices within them, in turns.

use super::bodies;
use super::colliders::{self, Obstacles};
use super::found::Found;
use crate::body::{BodyRef, NearBodies};
use crate::contact::MovedSamples;
use crate::contact::bodies::GapSearch;
use crate::volume::Limits;

/// Maximum number of rounds. Each round finds limits and moves the vertices again.
///
/// A further round is needed if vertices move farther than the search distance, or beyond a limit at a body that was not
/// searched yet, or if the moved surface still enters a collider other than a plane, or with a smooth skin any collider.
/// One or two rounds are common.
const ROUNDS: usize = 16;

/// Search distance for limits, as a multiple of the greatest displacement. The margin avoids a second search
/// if the displacements grow in a later round.
const MARGIN: f64 = 2.0;

/// Search distance for limits of a vertex at bodies, as a multiple of its displacement. A second search is only one of the
/// vertices that move farther, so the margin is small.
const REACH_MARGIN: f32 = 1.25;

/// Moves the vertices of a body from their start, as far as limits allow.
pub(crate) trait Mover {
    /// Moves the vertices from their start within limits. Returns the moved positions, one per lattice vertex.
    fn move_within(&mut self, limits: &Limits) -> &[[f32; 3]];

    /// Removes the soft limits that the mover cannot keep. Returns whether there were any.
    fn remove_soft(&mut self, _: &mut Limits) -> bool {
        false
    }
}

/// The search for the limits of one body after another.
#[derive(Debug, Default)]
pub(crate) struct Clearance {
    found: Found,
    surface: MovedSamples,
    gaps: GapSearch,
    /// Displacement of each vertex in cells up to which limits at bodies are searched.
    reach: Vec<f32>,
}

impl Clearance {
    /// Begins a frame of a body: forgets what was found in the frame before. Within a frame, gaps to other bodies are kept
    /// from one displacement to the next.
    pub(crate) fn begin(&mut self) {
        self.gaps.begin();
    }

    /// Moves the vertices of a body such that no sample of its surface moves into a collider or deeper into it, and that
    /// the surface takes at most half of a gap to another body.
    ///
    /// Limits are searched up to a distance. If a vertex moves farther, or a sample enters a collider that is not a
    /// plane, the vertices are moved again from their start with more limits. Returns false if the limits are not complete
    /// after [`ROUNDS`]. Without colliders and near bodies, and outside a simulation, there are no limits.
    ///
    /// * `start`: the positions before the displacement, one per lattice vertex.
    /// * `distance`: distance in cells up to which limits at colliders are searched before the first displacement; 0 for
    ///   none. Limits at bodies are then those of touching samples, and of gaps that were found earlier in the frame;
    ///   further gaps are searched where vertices moved, because the search takes longer than the displacement.
    pub(crate) fn move_clear(
        &mut self,
        body: BodyRef<'_>,
        start: &[[f32; 3]],
        mut distance: f64,
        mover: &mut impl Mover,
    ) -> bool {
        let obstacles = Obstacles::around(body);
        let near = body.context().and_then(|context| context.near).filter(|near| near.is_any());
        let is_free = obstacles.is_none() && near.is_none();
        self.found.limits.list_mut().clear();
        self.reach.clear();
        if near.is_some() {
            self.reach.resize(start.len(), 0.0);
        }
        if distance > 0.0 && !is_free {
            self.find(body, obstacles.as_ref(), near, start, distance);
        }
        let mut moved = mover.move_within(&self.found.limits);
        if is_free {
            return true;
        }
        let factor = obstacles.as_ref().map_or(1.0, Obstacles::greatest_factor);
        let curved = obstacles.as_ref().filter(|obstacles| obstacles.is_any_curved());
        for _ in 0..ROUNDS {
            let greatest = factor * greatest_displacement(start, moved);
            let must_reach = self.extend_reach(start, moved);
            let has_more = if greatest > distance {
                distance = MARGIN * greatest;
                self.find(body, obstacles.as_ref(), near, start, distance)
            } else {
                let is_exceeded = must_reach
                    && self.find(body, obstacles.as_ref(), near, start, distance)
                    && self.found.limits.are_exceeded(start, moved);
                is_exceeded
                    || curved.is_some_and(|obstacles| {
                        distance > 0.0
                            && colliders::add_entered(
                                &mut self.surface,
                                obstacles,
                                [start, moved],
                                &mut self.found,
                            )
                    })
            };
            if !has_more && !mover.remove_soft(&mut self.found.limits) {
                return true;
            }
            self.found.limits.sort();
            moved = mover.move_within(&self.found.limits);
        }
        false
    }

    /// Increases the distances up to which limits at bodies are searched, where vertices moved farther. Returns whether any
    /// did.
    fn extend_reach(&mut self, start: &[[f32; 3]], moved: &[[f32; 3]]) -> bool {
        let mut has_extended = false;
        for (reach, ends) in self.reach.iter_mut().zip(start.iter().zip(moved)) {
            let displacement = squared_displacement(ends).sqrt();
            if displacement > *reach {
                *reach = REACH_MARGIN * displacement;
                has_extended = true;
            }
        }
        has_extended
    }

    /// Replaces the limits by those of displacements of up to `distance`, at bodies of up to `reach`. Returns whether there
    /// are any.
    fn find(
        &mut self,
        body: BodyRef<'_>,
        obstacles: Option<&Obstacles<'_>>,
        near: Option<NearBodies<'_>>,
        start: &[[f32; 3]],
        distance: f64,
    ) -> bool {
        let Self { found, surface, gaps, reach } = self;
        found.limits.list_mut().clear();
        if let Some(obstacles) = obstacles {
            colliders::find(surface, obstacles, start, distance, found);
        }
        if let Some(near) = near {
            bodies::find(gaps, body, near, (start, reach), found);
        }
        found.limits.sort();
        !found.limits.list().is_empty()
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.found.bytes() + self.surface.bytes() + self.gaps.bytes() + size_of_val(&*self.reach)
    }
}

/// Returns the greatest displacement of a vertex from its start, in cells.
fn greatest_displacement(start: &[[f32; 3]], moved: &[[f32; 3]]) -> f64 {
    f64::from(start.iter().zip(moved).map(squared_displacement).fold(0.0_f32, f32::max).sqrt())
}

/// Returns the squared displacement of a vertex from its start to its moved position, in cells.
fn squared_displacement((start, moved): (&[f32; 3], &[f32; 3])) -> f32 {
    (0..3).map(|k| (moved[k] - start[k]).powi(2)).sum()
}
