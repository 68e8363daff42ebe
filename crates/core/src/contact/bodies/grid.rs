//! A grid of the boxes of cells, to find those that contain a point or intersect a box.

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
    /// The cells in each bin, in increasing order.
    entries: Vec<Entry>,
}

/// A cell in a bin.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    /// Index in the list of [`Grid::fill`].
    index: u32,
    begins: Begins,
}

/// Whether a bin is the first one of a box along each axis: one bit for each axis.
type Begins = u8;

/// The bins that a box intersects.
#[derive(Clone, Copy)]
struct Bins {
    /// Number of bins of the grid along each axis.
    counts: [usize; 3],
    /// The first bin and the end along each axis.
    ranges: [[usize; 2]; 3],
}

impl Bins {
    /// Calls `test` for each bin, x fastest, until it returns true. Returns whether it did.
    ///
    /// Loops: an iterator over three nested ranges takes several times as long.
    #[inline]
    fn any(self, mut test: impl FnMut(usize, Begins) -> bool) -> bool {
        let Self { counts, ranges: [x, y, z] } = self;
        for k in z[0]..z[1] {
            for j in y[0]..y[1] {
                let row = (k * counts[1] + j) * counts[0];
                let begins = Begins::from(k == z[0]) << 2 | Begins::from(j == y[0]) << 1;
                for i in x[0]..x[1] {
                    if test(row + i, begins | Begins::from(i == x[0])) {
                        return true;
                    }
                }
            }
        }
        false
    }
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
            let bins = self.bins(bounds);
            bins.any(|bin, _| {
                self.first[bin] += 1;
                false
            });
        }
        let mut sum = 0;
        for first in &mut self.first {
            sum += *first;
            *first = sum;
        }
        self.entries.resize(sum as usize, Entry::default());
        for (index, (_, bounds)) in (0..cells.len() as u32).zip(cells).rev() {
            let bins = self.bins(bounds);
            bins.any(|bin, begins| {
                let first = &mut self.first[bin];
                *first -= 1;
                self.entries[*first as usize] = Entry { index, begins };
                false
            });
        }
    }

    /// Returns the cells in the bin of a point, as indices in the list of [`fill`](Self::fill).
    pub(super) fn at(&self, point: &Point3<f64>) -> impl Iterator<Item = u32> {
        let place = (point - self.low) * self.scale;
        let is_inside =
            self.counts[0] > 0 && (0..3).all(|a| place[a] >= 0.0 && place[a] < self.counts[a] as f64);
        let entries = match is_inside.then(|| std::array::from_fn(|a| place[a] as usize)) {
            Some([x, y, z]) => self.entries_of((z * self.counts[1] + y) * self.counts[0] + x),
            None => &[],
        };
        entries.iter().map(|entry| entry.index)
    }

    /// Calls `test` for the cells in the bins that a box intersects, each cell once: in the first bin that the box and the
    /// cell have in common, which along each axis is the first one of the box or of the cell. Ends, and returns true, as
    /// soon as `test` does. Cells are indices in the list of [`fill`](Self::fill).
    #[inline]
    pub(super) fn any_within(&self, bounds: &Bounds, mut test: impl FnMut(u32) -> bool) -> bool {
        self.bins(bounds).any(|bin, begins| {
            self.entries_of(bin).iter().any(|entry| entry.begins | begins == 0b111 && test(entry.index))
        })
    }

    /// Returns the entries of a bin.
    fn entries_of(&self, bin: usize) -> &[Entry] {
        &self.entries[self.first[bin] as usize..self.first[bin + 1] as usize]
    }

    /// Returns the bins that a box intersects.
    #[inline]
    fn bins(&self, bounds: &Bounds) -> Bins {
        let Self { low, scale, counts, .. } = *self;
        // Casts saturate: below zero to 0, and beyond the last bin to it.
        let index = |a: usize, x: f64| (((x - low[a]) * scale) as usize).min(counts[a] - 1);
        let range = |a: usize| {
            let is_outside = counts[a] == 0
                || bounds.high[a] < low[a]
                || (bounds.low[a] - low[a]) * scale >= counts[a] as f64;
            if is_outside { [0, 0] } else { [index(a, bounds.low[a]), index(a, bounds.high[a]) + 1] }
        };
        Bins { counts, ranges: [range(0), range(1), range(2)] }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        buffer_bytes(&self.first) + buffer_bytes(&self.entries)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::mesh::testing::Random;

    /// Boxes of several sizes in and around the region, some of them in many bins.
    #[test]
    fn each_box_in_reach_is_listed_once() {
        let mut random = Random(5);
        let mut box_of = |size: f64| {
            let low = Point3::from([(); 3].map(|()| 12.0 * random.next() - 1.0));
            let size = Vector3::from([(); 3].map(|()| size * random.next()));
            Bounds { low, high: low + size }
        };
        let cells: Vec<(u32, Bounds)> =
            (0..150).map(|k| (1000 + k, box_of(if k % 10 == 0 { 6.0 } else { 1.5 }))).collect();
        let region = Bounds { low: Point3::origin(), high: Point3::new(9.0, 10.0, 8.0) };
        let mut grid = Grid::default();
        grid.fill(&cells, &region, 1.0);
        for k in 0..300 {
            let query = box_of(if k % 3 == 0 { 0.0 } else { 3.0 }).intersection(&region);
            if query.is_empty() {
                continue;
            }
            let all = (0..).zip(&cells);
            let expected: Vec<u32> = all
                .clone()
                .filter_map(|(index, (_, bounds))| bounds.intersects(&query).then_some(index))
                .collect();
            let mut listed = Vec::new();
            grid.any_within(&query, |index| {
                listed.push(index);
                false
            });
            let mut found = listed.clone();
            found.sort_unstable();
            found.dedup();
            assert_eq!(found.len(), listed.len(), "a box is listed twice");
            found.retain(|&index| cells[index as usize].1.intersects(&query));
            assert_eq!(found, expected);
            let mut tested = 0;
            let ends = grid.any_within(&query, |index| {
                tested += 1;
                Some(&index) == listed.get(listed.len() / 2)
            });
            assert_eq!((ends, tested), (!listed.is_empty(), (listed.len() / 2 + 1).min(listed.len())));
            let at: Vec<u32> = grid.at(&query.low).collect();
            let mut containing = all.filter(|(_, (_, bounds))| bounds.contains(&query.low));
            assert!(containing.all(|(index, _)| at.contains(&index)));
        }
    }
}
