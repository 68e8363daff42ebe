//! Joins vertices at the same position.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// The vertices by the bits of their positions as `f32`.
#[derive(Debug, Default)]
pub(super) struct Weld(HashMap<[u32; 3], u32>);

impl Weld {
    /// Returns the index of the vertex at a position. Appends the position to `positions` if it is new.
    pub(super) fn vertex(&mut self, position: [f64; 3], positions: &mut Vec<[f64; 3]>) -> u32 {
        let next = positions.len() as u32;
        match self.0.entry(position.map(|x| (x as f32).to_bits())) {
            Entry::Occupied(found) => *found.get(),
            Entry::Vacant(place) => {
                positions.push(position);
                *place.insert(next)
            }
        }
    }
}
