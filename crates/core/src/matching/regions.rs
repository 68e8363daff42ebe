//! The constants of the regions: region weights m/n, mass, rest centroid and rest inertia.

use nalgebra::{Matrix3, Vector3};

use crate::lattice::{Lattice, Layout};
use crate::simd::lanes::{LANES, Lanes};

/// The regions of a lattice: one around each vertex, of half-width w. [`cascade`](super::cascade) defines them.
///
/// Masses are in units of a full cell's mass: m = (number of occupied cells of the vertex) / 8. The weight of
/// vertex i in each of its regions is m/n, with n the number of regions that contain i. So Σ m g = Σ m x, and
/// the shape matching conserves linear momentum.
#[derive(Clone, Debug)]
pub(crate) struct Regions {
    /// m and 1/n of each vertex: their product is its weight in a region ([`Weighted`](super::Weighted)), and
    /// 1/n averages over its regions. Zero in lanes without a vertex.
    pub(crate) weights: Lanes<2>,
    /// 1/M of the region around each vertex, and d, its rest centroid relative to its center vertex in cells.
    /// Zero in lanes without a vertex.
    pub(crate) constants: Lanes<4>,
    half_width: usize,
}

impl Regions {
    /// Creates the regions of half-width `half_width` in cells.
    pub(crate) fn new(lattice: &Lattice, layout: &Layout, half_width: usize) -> Self {
        let windows = LineWindows::new(layout, half_width);
        let mut mass = vec![0.0; layout.blocks() * LANES];
        for (&slot, &cells) in layout.slots().iter().zip(lattice.occupied_cells()) {
            mass[slot as usize] = f64::from(cells) / 8.0;
        }
        let region_counts = windows.region_counts(&mass);

        let (mut weights, mut constants) = (Lanes::zeros(layout.blocks()), Lanes::zeros(layout.blocks()));
        let mut m_over_n = mass.clone();
        for &slot in layout.slots() {
            let inverse_count = (1.0 / region_counts[slot as usize]) as f32;
            let m = mass[slot as usize] as f32;
            // Rounded to f32, as in the window sums of the step.
            m_over_n[slot as usize] = f64::from(m * inverse_count);
            weights.set(slot, [m, inverse_count]);
        }
        let [s, sx, sy, sz] = windows.first_moments(&m_over_n);
        for &slot in layout.slots() {
            let i = slot as usize;
            let [x, y, z] = [sx[i], sy[i], sz[i]].map(|moment| (moment / s[i]) as f32);
            constants.set(slot, [(1.0 / s[i]) as f32, x, y, z]);
        }
        Self { weights, constants, half_width }
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.weights.bytes() + self.constants.bytes()
    }

    /// The half-width of the regions in cells.
    pub(crate) fn half_width(&self) -> usize {
        self.half_width
    }

    /// Computes Σ over regions Σ m/n y², with y the rest offset from the region's rest centroid in cells.
    pub(crate) fn rest_spread(&self, layout: &Layout) -> f64 {
        let [xx, yy, zz, ..] = self.second_moments(layout);
        let spread = layout.slots().iter().map(|&slot| {
            let [inverse_mass, x, y, z] = self.constants.get(slot).map(f64::from);
            let i = slot as usize;
            xx[i] + yy[i] + zz[i] - (x * x + y * y + z * z) / inverse_mass
        });
        spread.sum()
    }

    /// Computes the second moments of each region by slot: Σ m/n times the products xx, yy, zz, xy, xz, yz of
    /// the offsets from its center vertex.
    fn second_moments(&self, layout: &Layout) -> [Vec<f64>; 6] {
        let mut m_over_n = vec![0.0; layout.blocks() * LANES];
        for &slot in layout.slots() {
            let [m, inverse_count] = self.weights.get(slot);
            m_over_n[slot as usize] = f64::from(m * inverse_count);
        }
        LineWindows::new(layout, self.half_width).second_moments(&m_over_n)
    }

    /// Computes the inverse of M⁻¹ Σ m/n ((y·y) I - y yᵀ), the rest inertia of each region over its mass,
    /// with y the offset from the rest centroid in cells. The order of its entries is xx, yy, zz, xy, xz, yz.
    pub(crate) fn inverse_inertia(&self, layout: &Layout) -> Lanes<6> {
        let second = self.second_moments(layout);
        let mut lanes = Lanes::zeros(layout.blocks());
        for &slot in layout.slots() {
            let [inverse_mass, x, y, z] = self.constants.get(slot).map(f64::from);
            let moments = second.each_ref().map(|moment| moment[slot as usize] * inverse_mass);
            lanes.set(slot, inverse_inertia(moments, Vector3::new(x, y, z)));
        }
        lanes
    }
}

/// Computes the inverse inertia from the second moments about the center vertex and the rest centroid `d`.
/// Every region contains the corners of a cell, so its inertia is invertible.
fn inverse_inertia([xx, yy, zz, xy, xz, yz]: [f64; 6], d: Vector3<f64>) -> [f32; 6] {
    let spread = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - d * d.transpose();
    let inertia = Matrix3::identity() * spread.trace() - spread;
    let inverse = inertia.try_inverse().unwrap_or_else(Matrix3::zeros);
    [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| inverse[at] as f32)
}

/// Window sums in f64 over arrays by slot, for constants that are built once.
struct LineWindows {
    /// The result of [`lines`] for each axis.
    axes: [(Vec<u32>, Vec<usize>); 3],
    half_width: usize,
}

impl LineWindows {
    /// Finds the lines of linked vertices along each axis.
    fn new(layout: &Layout, half_width: usize) -> Self {
        Self { axes: [0, 1, 2].map(|axis| lines(layout, axis)), half_width }
    }

    /// Computes n, the number of regions that contain each vertex: the adjoint passes z, y, x over ones.
    fn region_counts(&self, mass: &[f64]) -> Vec<f64> {
        let ones: Vec<f64> = mass.iter().map(|&m| if m > 0.0 { 1.0 } else { 0.0 }).collect();
        (0..3).rev().fold(ones, |field, axis| self.moment(axis, 0, &field))
    }

    /// Computes S, Sx, Sy and Sz of each region.
    fn first_moments(&self, field: &[f64]) -> [Vec<f64>; 4] {
        let (s, sx) = (self.moment(0, 0, field), self.moment(0, 1, field));
        let (s, sx, sy) = (self.moment(1, 0, &s), self.moment(1, 0, &sx), self.moment(1, 1, &s));
        [self.moment(2, 0, &s), self.moment(2, 0, &sx), self.moment(2, 0, &sy), self.moment(2, 1, &s)]
    }

    /// Computes Sxx, Syy, Szz, Sxy, Sxz and Syz of each region.
    fn second_moments(&self, field: &[f64]) -> [Vec<f64>; 6] {
        let at = |powers: [usize; 3]| {
            (0..3).fold(field.to_vec(), |field, axis| self.moment(axis, powers[axis], &field))
        };
        [[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [1, 0, 1], [0, 1, 1]].map(at)
    }

    /// Computes Σ iᵖ f over the window of each vertex along `axis`, with i the signed number of links from
    /// the vertex and p = `power` up to 2.
    fn moment(&self, axis: usize, power: usize, field: &[f64]) -> Vec<f64> {
        let (slots, starts) = &self.axes[axis];
        let mut out = vec![0.0; field.len()];
        // Prefix sums of f, j f and j² f along a line, with j the index in the line.
        let mut sums: Vec<[f64; 3]> = Vec::new();
        for line in starts.windows(2).map(|ends| &slots[ends[0]..ends[1]]) {
            sums.clear();
            sums.push([0.0; 3]);
            let mut sum = [0.0; 3];
            for (j, &slot) in line.iter().enumerate() {
                let (j, f) = (j as f64, field[slot as usize]);
                sum = [sum[0] + f, sum[1] + j * f, sum[2] + j * j * f];
                sums.push(sum);
            }
            for (center, &slot) in line.iter().enumerate() {
                let before = sums[center.saturating_sub(self.half_width)];
                let up_to = sums[line.len().min(center + self.half_width + 1)];
                let [s, sj, sjj] = [0, 1, 2].map(|p| up_to[p] - before[p]);
                let c = center as f64;
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

/// Returns the slots of the lines of linked vertices along an axis, line by line, and the start of each line
/// in this list, then its end.
fn lines(layout: &Layout, axis: usize) -> (Vec<u32>, Vec<usize>) {
    let links = layout.axis(axis);
    let mut has_previous = vec![false; layout.blocks() * LANES];
    for &slot in layout.slots() {
        if let Some(next) = links.next_slot(slot as usize) {
            has_previous[next] = true;
        }
    }
    let (mut slots, mut starts) = (Vec::with_capacity(layout.slots().len()), vec![0]);
    for &start in layout.slots().iter().filter(|&&slot| !has_previous[slot as usize]) {
        let line = std::iter::successors(Some(start as usize), |&slot| links.next_slot(slot));
        slots.extend(line.map(|slot| slot as u32));
        starts.push(slots.len());
    }
    (slots, starts)
}
