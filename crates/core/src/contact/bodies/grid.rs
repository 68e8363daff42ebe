//! A grid of the boxes of cells, to find those that contain a point or intersect a box.

use std::ops::Range;

use nalgebra::Point3;

use super::bounds::Bounds;
use crate::contact::memory::buffer_bytes;

/// Pitch of the grid, in cells.
const PITCH: f64 = 1.2;

/// Greatest number of entries, as a multiple of the number of cells. The pitch of the grid of a lattice that is
/// stretched over a large space is greater.
const MAX_ENTRIES: usize = 8;

/// Uniform grid over a box. A bin lists the cells whose boxes intersect it.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    low: Point3<f64>,
    /// 1 / pitch.
    scale: f64,
    counts: [usize; 3],
    /// Index in `entries` of the first entry of each bin, then the number of entries.
    first: Vec<u32>,
    /// Indices of the cells in each bin, in increasing order.
    entries: Vec<u32>,
}

impl Default for Grid {
    fn default() -> Self {
        let (low, scale) = (Point3::origin(), 1.0);
        Self { low, scale, counts: [0; 3], first: Vec::new(), entries: Vec::new() }
    }
}

impl Grid {
    /// Replaces the cells by those with the boxes `cells`, in the part of space that is in `region`.
    pub(super) fn fill(&mut self, cells: &[(u32, Bounds)], region: &Bounds, cell_size: f64) {
        let all = cells.iter().fold(Bounds::EMPTY, |all, (_, bounds)| all.union(bounds)).intersection(region);
        self.first.clear();
        self.entries.clear();
        self.counts = [0; 3];
        if all.is_empty() {
            return;
        }
        let extent = all.high - all.low;
        let mut pitch = PITCH * cell_size;
        let limit = (MAX_ENTRIES * cells.len()) as f64;
        while extent.map(|length| (length / pitch).floor() + 1.0).product() > limit {
            pitch *= 1.5;
        }
        self.low = all.low;
        self.scale = 1.0 / pitch;
        self.counts = std::array::from_fn(|a| (extent[a] / pitch) as usize + 1);
        self.first.resize(self.counts.iter().product::<usize>() + 1, 0);
        // Counts the entries of each bin, then places them: from the end, so that each bin is in increasing order.
        for (_, bounds) in cells {
            self.rows(bounds).for_each(|bins| self.first[bins].iter_mut().for_each(|first| *first += 1));
        }
        let mut sum = 0;
        for first in &mut self.first {
            sum += *first;
            *first = sum;
        }
        self.entries.resize(sum as usize, 0);
        for (entry, (_, bounds)) in cells.iter().enumerate().rev() {
            self.rows(bounds).for_each(|bins| {
                for first in &mut self.first[bins] {
                    *first -= 1;
                    self.entries[*first as usize] = entry as u32;
                }
            });
        }
    }

    /// Returns the cells in the bin of a point.
    pub(super) fn bin(&self, point: &Point3<f64>) -> &[u32] {
        let place = (point - self.low) * self.scale;
        if self.counts[0] == 0 || !(0..3).all(|a| place[a] >= 0.0 && place[a] < self.counts[a] as f64) {
            return &[];
        }
        let [x, y, z]: [usize; 3] = std::array::from_fn(|a| place[a] as usize);
        let bin = (z * self.counts[1] + y) * self.counts[0] + x;
        self.cells_of(bin..bin + 1)
    }

    /// Returns the cells in consecutive bins, one bin after the other.
    pub(super) fn cells_of(&self, bins: Range<usize>) -> &[u32] {
        &self.entries[self.first[bins.start] as usize..self.first[bins.end] as usize]
    }

    /// Returns the bins that a box intersects, as rows of consecutive ones.
    #[inline]
    pub(super) fn rows(&self, bounds: &Bounds) -> impl Iterator<Item = Range<usize>> + use<> {
        let Self { low, scale, counts, .. } = *self;
        // Casts saturate: below zero to 0, and beyond the last bin to it.
        let index = |a: usize, x: f64| (((x - low[a]) * scale) as usize).min(counts[a] - 1);
        let range = |a: usize| {
            let is_outside = counts[a] == 0
                || bounds.high[a] < low[a]
                || (bounds.low[a] - low[a]) * scale >= counts[a] as f64;
            if is_outside { 0..0 } else { index(a, bounds.low[a])..index(a, bounds.high[a]) + 1 }
        };
        let [x, y, z] = [range(0), range(1), range(2)];
        z.flat_map(move |z| {
            let x = x.clone();
            y.clone().map(move |y| (z * counts[1] + y) * counts[0]).map(move |row| row + x.start..row + x.end)
        })
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        buffer_bytes(&self.first) + buffer_bytes(&self.entries)
    }
}
