//! Window sums in f64 along the axes of the lattice, for the constants of the regions.

use super::half_width::HalfWidth;
use crate::lattice::{Layout, LooseCell};
use crate::simd::lanes::LANES;

/// Window sums in f64 over arrays by slot, for constants that are computed once.
///
/// The window of a vertex along an axis contains the vertices that are connected to it by up to `half_width`
/// links along this axis; the window of a cell has the vertex and the next one. A line is a maximal sequence of
/// linked vertices along an axis.
pub(super) struct LineWindows<'a> {
    /// Lines of each axis, the result of [`lines`].
    axes: [(Vec<u32>, Vec<usize>); 3],
    half_width: HalfWidth,
    /// The loose cells; empty unless the regions are cells.
    loose: &'a [LooseCell],
}

impl<'a> LineWindows<'a> {
    /// Finds the lines along each axis.
    pub(super) fn new(layout: &'a Layout, half_width: HalfWidth) -> Self {
        let loose = if half_width.is_cell() { layout.loose_cells().all() } else { &[] };
        Self { axes: [0, 1, 2].map(|axis| lines(layout, axis)), half_width, loose }
    }

    /// Computes n, the number of regions that contain each vertex. `mass` is positive in slots with a vertex.
    ///
    /// A region contains the vertices that links connect to its center vertex: first along z, then along y,
    /// then along x. So each center vertex counts as 1, and window sums of these counts along z, then y, then
    /// x give the number of regions that contain each vertex.
    pub(super) fn region_counts(&self, mass: &[f64]) -> Vec<f64> {
        self.sums_over_regions(mass.iter().map(|&m| if m > 0.0 { 1.0 } else { 0.0 }).collect())
    }

    /// Computes, for each vertex, the sum over the regions that contain it of the value of `field` at the center vertex
    /// of the region.
    pub(super) fn sums_over_regions(&self, mut field: Vec<f64>) -> Vec<f64> {
        let is_cell = self.half_width.is_cell();
        let links = if is_cell { [1, 0] } else { [self.half_width.links(); 2] };
        let taken: Vec<f64> =
            self.loose.iter().map(|cell| std::mem::take(&mut field[cell.slot as usize])).collect();
        let mut sums =
            (0..3).rev().fold(field, |field, axis| self.moment_within(links, 0.0, axis, 0, &field));
        for (cell, value) in self.loose.iter().zip(taken) {
            cell.corners.iter().for_each(|&corner| sums[corner as usize] += value);
        }
        sums
    }

    /// Computes Σ f of each region, where f is the value of `field` at a vertex.
    pub(super) fn sums(&self, field: &[f64]) -> Vec<f64> {
        self.moments([0; 3], field)
    }

    /// Computes Σ f, Σ i f, Σ j f and Σ k f of each region, where f is the value of `field` at a vertex and
    /// (i, j, k) is the offset of the vertex from the center vertex.
    pub(super) fn first_moments(&self, field: &[f64]) -> [Vec<f64>; 4] {
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|powers| self.moments(powers, field))
    }

    /// Computes the sums of f times ii, jj, kk, ij, ik and jk of each region, with f and (i, j, k) as in
    /// [`Self::first_moments`].
    pub(super) fn second_moments(&self, field: &[f64]) -> [Vec<f64>; 6] {
        [[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [1, 0, 1], [0, 1, 1]]
            .map(|powers| self.moments(powers, field))
    }

    /// Computes the sum of f times powers of i, j and k of each region.
    fn moments(&self, powers: [usize; 3], field: &[f64]) -> Vec<f64> {
        let mut moments = (0..3).fold(field.to_vec(), |field, axis| self.moment(axis, powers[axis], &field));
        for cell in self.loose {
            let term = |(k, &corner): (usize, &u32)| {
                let offset = |axis: usize| ((k >> axis & 1) as f64 - 0.5).powi(powers[axis] as i32);
                field[corner as usize] * offset(0) * offset(1) * offset(2)
            };
            moments[cell.slot as usize] = cell.corners.iter().enumerate().map(term).sum();
        }
        moments
    }

    /// Computes Σ iᵖ f over the window of each vertex along `axis`, where f is a value of `field`, i is the
    /// signed number of links from the center of the window, and p = `power` is 0, 1 or 2.
    fn moment(&self, axis: usize, power: usize, field: &[f64]) -> Vec<f64> {
        match self.half_width.is_cell() {
            true => self.moment_within([0, 1], 0.5, axis, power, field),
            false => self.moment_within([self.half_width.links(); 2], 0.0, axis, power, field),
        }
    }

    /// As [`Self::moment`], for windows that reach some numbers of links back and forth from a vertex, with their
    /// centers `shift` links further than the vertex.
    fn moment_within(
        &self,
        [back, forth]: [usize; 2],
        shift: f64,
        axis: usize,
        power: usize,
        field: &[f64],
    ) -> Vec<f64> {
        let (slots, starts) = &self.axes[axis];
        let mut out = vec![0.0; field.len()];
        // Prefix sums of f, j f and j² f along a line, where j is the index of a vertex in the line.
        let mut sums: Vec<[f64; 3]> = Vec::new();
        for line in starts.windows(2).map(|start_end| &slots[start_end[0]..start_end[1]]) {
            sums.clear();
            sums.push([0.0; 3]);
            let mut sum = [0.0; 3];
            for (j, &slot) in line.iter().enumerate() {
                let (j, f) = (j as f64, field[slot as usize]);
                sum = [sum[0] + f, sum[1] + j * f, sum[2] + j * j * f];
                sums.push(sum);
            }
            for (center, &slot) in line.iter().enumerate() {
                let before = sums[center.saturating_sub(back)];
                let up_to = sums[line.len().min(center + forth + 1)];
                let [s, sj, sjj] = [0, 1, 2].map(|p| up_to[p] - before[p]);
                let c = center as f64 + shift;
                out[slot as usize] = match power {
                    0 => s,
                    1 => sj - c * s,
                    _ => sjj - 2.0 * c * sj + c * c * s,
                };
            }
        }
        out
    }
}

/// Returns the lines of linked vertices along an axis: the slots of all lines, line by line, and the index of
/// the first slot of each line in this list, followed by the length of the list.
fn lines(layout: &Layout, axis: usize) -> (Vec<u32>, Vec<usize>) {
    let links = layout.axis(axis);
    let mut has_previous = vec![false; layout.blocks() * LANES];
    for &slot in layout.slots() {
        if let Some(next) = links.next_slot(slot) {
            has_previous[next as usize] = true;
        }
    }
    let (mut slots, mut starts) = (Vec::with_capacity(layout.slots().len()), vec![0]);
    for &start in layout.slots().iter().filter(|&&slot| !has_previous[slot as usize]) {
        slots.extend(std::iter::successors(Some(start), |&slot| links.next_slot(slot)));
        starts.push(slots.len());
    }
    (slots, starts)
}
