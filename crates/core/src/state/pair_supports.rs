//! The contacts between bodies that pressed on them in the last step, as supports of their rest.

use super::pressing::{Pressing, PressingContact};

/// The contacts between two connected components that pressed on each other in a step. In world space and scene units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PairSupport {
    /// The bodies, each with the index of its connected component; the lesser pair first.
    pub(crate) sides: [(u32, u32); 2],
    /// Its normal points to the first side.
    pub(crate) pressing: Pressing,
}

/// The supports of the bodies of a simulation by each other, in increasing order of the sides.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PairSupports(Vec<PairSupport>);

impl PairSupports {
    pub(crate) fn list(&self) -> &[PairSupport] {
        &self.0
    }

    /// Returns whether the supports are in increasing order of the sides, each pair once, with finite numbers.
    pub(crate) fn is_valid(&self) -> bool {
        self.0.is_sorted_by(|a, b| a.sides < b.sides)
            && self.0.iter().all(|support| support.pressing.is_valid())
    }

    /// Returns the index of the support of two sides, and whether they are in its order.
    pub(crate) fn find(&self, [first, second]: [(u32, u32); 2]) -> Option<(usize, bool)> {
        let is_in_order = first <= second;
        let sides = if is_in_order { [first, second] } else { [second, first] };
        let found = self.0.binary_search_by_key(&sides, |support| support.sides);
        found.ok().map(|index| (index, is_in_order))
    }

    pub(crate) fn list_mut(&mut self) -> &mut [PairSupport] {
        &mut self.0
    }

    /// Keeps the supports of which `keeps` returns true.
    pub(crate) fn retain(&mut self, keeps: impl Fn(&PairSupport) -> bool) {
        self.0.retain(keeps);
    }

    /// Follows the removal of a body: forgets its supports, and lowers the indices above its own.
    pub(crate) fn remove_body(&mut self, removed: u32) {
        self.0.retain(|support| support.sides.iter().all(|side| side.0 != removed));
        let sides = self.0.iter_mut().flat_map(|support| &mut support.sides);
        sides.for_each(|side| side.0 -= u32::from(side.0 > removed));
    }

    /// Replaces the supports that `replaces` selects by the supports at some contacts: the two sides, and the contact
    /// with its normal and friction towards the first side. A support that existed before keeps its deflections.
    pub(crate) fn set(
        &mut self,
        replaces: impl Fn(&PairSupport) -> bool,
        contacts: impl Iterator<Item = ([(u32, u32); 2], PressingContact)>,
    ) {
        for support in self.0.iter_mut().filter(|support| replaces(support)) {
            support.pressing.begin();
        }
        for (mut sides, mut contact) in contacts {
            if sides[0] > sides[1] {
                sides.swap(0, 1);
                (contact.normal, contact.friction) = (-contact.normal, -contact.friction);
            }
            let index =
                self.0.binary_search_by_key(&sides, |support| support.sides).unwrap_or_else(|index| {
                    self.0.insert(index, PairSupport { sides, ..PairSupport::default() });
                    index
                });
            self.0[index].pressing.add(&contact);
        }
        self.0.retain(|support| !replaces(support) || support.pressing.impulse > 0.0);
        for support in self.0.iter_mut().filter(|support| replaces(support)) {
            support.pressing.normalize();
        }
    }
}
