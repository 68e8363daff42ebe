//! The lattice vertices under the contacts, by number, and the contacts as means of them.

use std::ops::Range;

use super::numbered::Numbered;
use super::quad::{Quad, add};

/// A vertex under a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    /// Where the vertex stands among the touched ones.
    pub(super) vertex: u32,
    pub(super) weight: f32,
    /// Its velocity for a unit of impulse: the weight over the mass.
    pub(super) response: f32,
}

/// Links of all contacts; buffers that grow with the largest number of them and are kept.
#[derive(Clone, Debug, Default)]
pub(super) struct Links {
    pub(super) list: Vec<Link>,
    /// Rows of the touched vertices, in the order in which they were first named.
    pub(super) rows: Numbered,
}

impl Links {
    /// For vertices in so many rows.
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: Numbered::new(rows), ..Self::default() }
    }

    /// Forgets all contacts.
    pub(super) fn clear(&mut self) {
        self.rows.clear();
        self.list.clear();
    }

    /// Adds links to vertices: rows and weights; `mobilities` has 1/mass of each row.
    pub(super) fn extend(&mut self, vertices: impl Iterator<Item = (u32, f32)>, mobilities: &[f32]) {
        for (row, weight) in vertices {
            let (vertex, response) = (self.rows.number(row), weight * mobilities[row as usize]);
            self.list.push(Link { vertex, weight, response });
        }
    }

    /// The links of one contact.
    #[inline(always)]
    pub(super) fn of(&self, contact: &Range<usize>) -> &[Link] {
        &self.list[contact.clone()]
    }
}

/// The weighted mean of what vertices are given.
#[inline(always)]
pub(super) fn mean(links: &[Link], given: &[Quad]) -> Quad {
    // Two sums, so that one need not wait for the other.
    let (mut sum, mut other) = ([0.0; 4], [0.0; 4]);
    let (pairs, last) = links.as_chunks::<2>();
    for [a, b] in pairs {
        add(&mut sum, &given[a.vertex as usize], a.weight);
        add(&mut other, &given[b.vertex as usize], b.weight);
    }
    for link in last {
        add(&mut sum, &given[link.vertex as usize], link.weight);
    }
    add(&mut sum, &other, 1.0);
    sum
}
