//! The data of the contact stage that snapshots store, and that a body takes over when it breaks.

use super::sides::Side;
use super::stage::Contacts;
use crate::lattice::Lattice;

impl Contacts {
    /// Returns the contact displacement of the vertex of each row, for a snapshot.
    pub(crate) fn all_displacements(&self) -> &[[f32; 3]] {
        &self.displacements
    }

    /// Restores [`all_displacements`](Self::all_displacements). Sets all of them to zero if `displacements`
    /// has another length, which means that it belongs to another body.
    pub(crate) fn set_displacements(&mut self, displacements: &[[f32; 3]]) {
        match displacements.len() == self.displacements.len() {
            true => self.displacements.copy_from_slice(displacements),
            false => self.clear_displacements(),
        }
    }

    /// Takes the displacements and the side points of the contacts of a body before it broke. `parents` has the
    /// vertex before of each vertex of the `lattice`. Samples at the same place at rest have the same side points.
    pub(crate) fn continue_from(&mut self, before: &Self, parents: &[u32], lattice: &Lattice) {
        for (displacement, &vertex) in self.displacements.iter_mut().zip(&self.samples.vertices) {
            let parent = parents[vertex as usize];
            if let Ok(row) = before.samples.vertices.binary_search(&parent) {
                *displacement = before.displacements[row];
            }
        }
        if before.sides().is_empty() {
            return;
        }
        // A vertex before is one of its children, at the same place at rest.
        let mut child = vec![0; parents.iter().max().map_or(0, |&last| last as usize + 1)];
        (0..).zip(parents).for_each(|(vertex, &parent)| child[parent as usize] = vertex);
        let places = before
            .samples
            .places(|vertex| lattice.rest_position(child[vertex as usize]), lattice.cell_size());
        let mut sides: Vec<_> =
            before.sides().iter().map(|side| (places[side.sample as usize], *side)).collect();
        sides.sort_unstable_by_key(|(place, side)| (*place, side.collider, side.sample));
        let places = self.samples.places(|vertex| lattice.rest_position(vertex), lattice.cell_size());
        let mut transferred = Vec::new();
        for (sample, place) in (0..).zip(places).filter(|(_, place)| place.is_some()) {
            let first = sides.partition_point(|(other, _)| *other < place);
            let same = sides[first..].iter().take_while(|(other, _)| *other == place);
            let mut same: Vec<Side> = same.map(|(_, side)| Side { sample, ..*side }).collect();
            same.dedup_by_key(|side| side.collider);
            transferred.extend(same);
        }
        self.set_sides(&transferred);
    }

    /// Returns the side points of the samples, for a snapshot.
    pub(crate) fn sides(&self) -> &[Side] {
        self.detection.sides()
    }

    /// Restores [`sides`](Self::sides). Without side points each sample is on the side of its position.
    pub(crate) fn set_sides(&mut self, sides: &[Side]) {
        self.detection.set_sides(sides, &self.samples);
    }
}
