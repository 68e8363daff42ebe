//! What is constant of a region: its mass, its rest centroid and its rest inertia.

use nalgebra::{Matrix3, Vector3};

use crate::lattice::{Lattice, Layout};
use crate::simd::lanes::{LANES, Lanes};

/// The regions of a lattice: one around each vertex, of half-width w.
///
/// Masses are in units of a full cell's mass: a vertex has m = (its occupied cells) / 8. In a region vertex i
/// weighs m/n, with n the number of regions that hold i, so that the goals keep the momentum of all vertices.
#[derive(Clone, Debug)]
pub(crate) struct Regions {
    /// For each vertex m and 1/n. Zero in lanes without a vertex.
    pub(crate) weights: Lanes<2>,
    /// For the region around each vertex 1/M and its rest centroid, from its center vertex, in cells. Zero in lanes
    /// without a vertex.
    pub(crate) constants: Lanes<4>,
    half_width: usize,
}

impl Regions {
    /// The regions of half-width `half_width` in cells.
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
            // The weight that the sums use, rounded as they round it.
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

    /// Memory that they take.
    pub(crate) fn bytes(&self) -> usize {
        self.weights.bytes() + self.constants.bytes()
    }

    /// The half-width of the regions in cells.
    pub(crate) fn half_width(&self) -> usize {
        self.half_width
    }

    /// Σ over regions Σ m/n y², with y the rest offset from the region's rest centroid in cells.
    pub(crate) fn rest_spread(&self, layout: &Layout) -> f64 {
        let [xx, yy, zz, ..] = self.second_moments(layout);
        let spread = layout.slots().iter().map(|&slot| {
            let [inverse_mass, x, y, z] = self.constants.get(slot).map(f64::from);
            let i = slot as usize;
            xx[i] + yy[i] + zz[i] - (x * x + y * y + z * z) / inverse_mass
        });
        spread.sum()
    }

    /// Σ m/n of the products xx, yy, zz, xy, xz, yz of the offsets from each region's center vertex, by slot.
    fn second_moments(&self, layout: &Layout) -> [Vec<f64>; 6] {
        let mut m_over_n = vec![0.0; layout.blocks() * LANES];
        for &slot in layout.slots() {
            let [m, inverse_count] = self.weights.get(slot);
            m_over_n[slot as usize] = f64::from(m * inverse_count);
        }
        LineWindows::new(layout, self.half_width).second_moments(&m_over_n)
    }

    /// The inverse of each region's rest inertia over its mass, M⁻¹ Σ m/n ((y·y) I - y yᵀ) with y the offset from
    /// the rest centroid in cells: xx, yy, zz, xy, xz, yz.
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

/// The inverse inertia from the second moments xx, yy, zz, xy, xz, yz about the center vertex. Every region holds
/// the corners of a cell, so its inertia is regular.
fn inverse_inertia([xx, yy, zz, xy, xz, yz]: [f64; 6], d: Vector3<f64>) -> [f32; 6] {
    let spread = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - d * d.transpose();
    let inertia = Matrix3::identity() * spread.trace() - spread;
    let inverse = inertia.try_inverse().unwrap_or_else(Matrix3::zeros);
    [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| inverse[at] as f32)
}

/// Window sums in f64 over arrays by slot, for what is built once.
struct LineWindows {
    /// For each axis the slots of its lines of linked vertices, one line after another, and where each begins.
    axes: [(Vec<u32>, Vec<usize>); 3],
    half_width: usize,
}

impl LineWindows {
    fn new(layout: &Layout, half_width: usize) -> Self {
        Self { axes: [0, 1, 2].map(|axis| lines(layout, axis)), half_width }
    }

    /// The number of regions that hold each vertex: the adjoint's passes z, y, x over ones.
    fn region_counts(&self, mass: &[f64]) -> Vec<f64> {
        let ones: Vec<f64> = mass.iter().map(|&m| if m > 0.0 { 1.0 } else { 0.0 }).collect();
        (0..3).rev().fold(ones, |field, axis| self.moment(axis, 0, &field))
    }

    /// S, Sx, Sy, Sz.
    fn first_moments(&self, field: &[f64]) -> [Vec<f64>; 4] {
        let (s, sx) = (self.moment(0, 0, field), self.moment(0, 1, field));
        let (s, sx, sy) = (self.moment(1, 0, &s), self.moment(1, 0, &sx), self.moment(1, 1, &s));
        [self.moment(2, 0, &s), self.moment(2, 0, &sx), self.moment(2, 0, &sy), self.moment(2, 1, &s)]
    }

    /// Sxx, Syy, Szz, Sxy, Sxz, Syz.
    fn second_moments(&self, field: &[f64]) -> [Vec<f64>; 6] {
        let at = |powers: [usize; 3]| {
            (0..3).fold(field.to_vec(), |field, axis| self.moment(axis, powers[axis], &field))
        };
        [[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [1, 0, 1], [0, 1, 1]].map(at)
    }

    /// Σ iᵖ f over the window of each vertex along `axis`, i the signed number of links from it; p up to 2.
    fn moment(&self, axis: usize, power: usize, field: &[f64]) -> Vec<f64> {
        let (slots, starts) = &self.axes[axis];
        let mut out = vec![0.0; field.len()];
        // Σ f, Σ j f, Σ j² f up to each vertex of a line, j counted along the line.
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
                let upto = sums[line.len().min(center + self.half_width + 1)];
                let [s, sj, sjj] = [0, 1, 2].map(|p| upto[p] - before[p]);
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

/// The slots of the lines of linked vertices along an axis, one line after another, and where each begins.
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
