//! The factors by which a lattice with regions differs from the laws of a bar: see [`theory`](super::theory).

use std::ops::RangeInclusive;

use nalgebra::{DMatrix, DVector};
use supple::HalfWidth;

use super::theory::TORSION;

/// A lattice of `cells` cells across a bar, with its regions. It differs from a solid by factors.
///
/// A window of one cell has the laws of a solid for the linear part of a displacement; the rest of it, which no linear map
/// fits, resists as well. The regions of wider windows are thinner at the surface: their factors of stretch and bending
/// were measured in the linear limit, to 2 % for R up to 0.4 t. Those of dilation and torsion are computed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Regions {
    pub(super) cells: i32,
    pub(super) half_width: HalfWidth,
    pub(super) poisson_ratio: f64,
}

impl Regions {
    /// Returns the radius R = √(w (w + 1)) of the regions over the thickness.
    pub(super) fn radius(&self) -> f64 {
        self.half_width.radius() / f64::from(self.cells)
    }

    /// Returns the factor of Young's modulus: 1 - 0.47 ν R/t, or 1 of cells.
    pub(super) fn stretch(&self) -> f64 {
        if self.half_width.is_cell() { 1.0 } else { 1.0 - 0.47 * self.poisson_ratio * self.radius() }
    }

    /// Returns the factor of the bulk modulus of a cube that is evenly dilated. The energy of a region of the mass M with the
    /// variances V of its coordinates is M (tr V + 9 k/tr V⁻¹)/18 times the square of the change of its volume, with
    /// k = 3 ν/(1 - 2 ν); that of a whole region is (1 + k) V/6.
    pub(super) fn dilation(&self) -> f64 {
        let k = 3.0 * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio);
        let windows = self.windows();
        let mut sum = 0.0;
        for (x, y) in windows.iter().flat_map(|x| windows.iter().map(move |y| (x, y))) {
            for z in &windows {
                let variances = [x, y, z].map(|window| window.variance);
                let [trace, inverse] =
                    [1, -1].map(|power| variances.iter().map(|v| v.powi(power)).sum::<f64>());
                sum += x.mass * y.mass * z.mass * (trace / 3.0 + 3.0 * k / inverse);
            }
        }
        sum / (f64::from(self.cells).powi(3) * (1.0 + k) * self.variance())
    }

    /// Returns the variance w (w + 1)/3 of the coordinate of a whole region along an axis, in squared cells.
    fn variance(&self) -> f64 {
        let w = self.half_width.cells();
        w * (w + 1.0) / 3.0
    }

    /// Returns the factor of E I: (1 + 2/t²) (1 + 0.6 R²/t²) max(1 - ν R/t, 1/(1 + ν)) with t in cells, or the one of
    /// [`bending_of_cells`](Self::bending_of_cells).
    pub(super) fn bending(&self) -> f64 {
        if self.half_width.is_cell() {
            return self.bending_of_cells();
        }
        let (radius, ratio) = (self.radius(), self.poisson_ratio);
        let lattice = 1.0 + 2.0 / f64::from(self.cells).powi(2);
        lattice * (1.0 + 0.6 * radius * radius) * (1.0 - ratio * radius).max(1.0 / (1.0 + ratio))
    }

    /// Returns the factor of E I of cells. Bent about y with the curvature 1, a bar has the displacements
    /// (-(z² + a (x² - y²))/2, -a x y, x z), with a = ν in a solid.
    ///
    /// The strain in the middle of the cells, x and -a x twice, has the second moment (t² - 1)/12 of a cell, and the energy
    /// E/2 + 2 (λ + G) (a - ν)² times its square. The parts x z and a x y about the middle of a cell fit no linear map: their
    /// squares are 1/16 at all corners, and their energy is E0/8 (1 + a²) with E0 = E/(1 + ν) = 2 G. In this unit,
    /// λ = k/3 with k = 3 ν/(1 - 2 ν). The energy, half of E I, is least for the a below. Other displacements of the
    /// cross-section would lower it further: with two cells by up to 2 %, else by less.
    fn bending_of_cells(&self) -> f64 {
        let (ratio, square) = (self.poisson_ratio, f64::from(self.cells).powi(2));
        let moment = (square - 1.0) / 12.0;
        let lateral = 4.0 * moment * (ratio / (1.0 - 2.0 * ratio) + 0.5);
        let a = ratio * lateral / (lateral + 0.25);
        let stiffness = moment * (1.0 + ratio) + lateral * (a - ratio).powi(2) + 0.25 * (1.0 + a * a);
        12.0 * stiffness / (square * (1.0 + ratio))
    }

    /// Returns the factor of G J, by Saint-Venant's problem on the lattice: a bar with the twist 1 has the displacements
    /// (-y z, x z, W(x, y)), of which the warping W has the least energy. There is no change of volume, so that the factor
    /// does not depend on ν.
    ///
    /// The energy of a region is the mass-weighted square of the displacements that its rigid motion leaves, to first order:
    /// M (Vz <x² + y²> + <W²> - <W>² - (<y' W> - Vz <x>)²/(Vy + Vz) - (<x' W> + Vz <y>)²/(Vx + Vz)), with means <> over the
    /// region, x' = x - <x>, and the variances V of its coordinates.
    pub(super) fn torsion(&self) -> f64 {
        let windows = self.windows();
        let count = self.cells as usize + 1;
        let size = count * count;
        // The variance of the coordinate z of a region.
        let depth = self.variance();
        // The energy is W H W + 2 g W + c. A constant W has none; the ones make H regular.
        let (mut h, mut g, mut c) = (DMatrix::from_element(size, size, 1.0), DVector::zeros(size), 0.0);
        for (x, y) in windows.iter().flat_map(|x| windows.iter().map(move |y| (x, y))) {
            let mass = x.mass * y.mass;
            let [mean, by_x, by_y] = [(0, 0), (1, 0), (0, 1)]
                .map(|(i, j)| DVector::from_fn(size, |k, _| x.weight(k % count, i) * y.weight(k / count, j)));
            let [about_x, about_y] = [y, x].map(|window| window.variance + depth);
            h += (DMatrix::from_diagonal(&mean)
                - &mean * mean.transpose()
                - &by_y * by_y.transpose() / about_x
                - &by_x * by_x.transpose() / about_y)
                * mass;
            g += (by_y * (x.mean / about_x) - by_x * (y.mean / about_y)) * (mass * depth);
            let squares = x.variance + y.variance + x.mean.powi(2) + y.mean.powi(2);
            c += mass * depth * (squares - depth * (x.mean.powi(2) / about_x + y.mean.powi(2) / about_y));
        }
        let warping = h.cholesky().map_or_else(|| DVector::from_element(size, f64::NAN), |h| h.solve(&g));
        // Half the energy is G J/2, and G is half of E0, the `depth` in the unit of the energy.
        2.0 * (c - g.dot(&warping)) / depth / (TORSION * f64::from(self.cells).powi(4))
    }

    /// Returns the windows of the regions along an axis across the bar.
    fn windows(&self) -> Vec<Window> {
        let last = self.cells as usize;
        let ranges: Vec<RangeInclusive<usize>> = match self.half_width.whole_cells() {
            None => (0..last).map(|cell| cell..=cell + 1).collect(),
            Some(w) => (0..=last).map(|i| i.saturating_sub(w)..=last.min(i + w)).collect(),
        };
        // The mass of a vertex, half as much at the surface, is shared by the windows that contain it.
        let share = |vertex: usize| {
            let count = ranges.iter().filter(|range| range.contains(&vertex)).count();
            (if vertex == 0 || vertex == last { 0.5 } else { 1.0 }) / count as f64
        };
        let shares: Vec<f64> = (0..=last).map(share).collect();
        ranges.into_iter().map(|range| Window::new(range, &shares)).collect()
    }
}

/// Vertices of a region along an axis. Coordinates are in cells from the axis of the bar.
struct Window {
    vertices: RangeInclusive<usize>,
    /// Mass of each vertex over the mass of the window.
    weights: Vec<f64>,
    /// Coordinate of each vertex.
    coordinates: Vec<f64>,
    mass: f64,
    mean: f64,
    variance: f64,
}

impl Window {
    /// Creates a window of some vertices, of which `shares` has the masses of all.
    fn new(vertices: RangeInclusive<usize>, shares: &[f64]) -> Self {
        let middle = (shares.len() - 1) as f64 / 2.0;
        let mass: f64 = shares[vertices.clone()].iter().sum();
        let weights: Vec<f64> = shares[vertices.clone()].iter().map(|share| share / mass).collect();
        let coordinates: Vec<f64> = vertices.clone().map(|vertex| vertex as f64 - middle).collect();
        let moment = |mean: f64, power: i32| -> f64 {
            weights.iter().zip(&coordinates).map(|(weight, x)| weight * (x - mean).powi(power)).sum()
        };
        let mean = moment(0.0, 1);
        let variance = moment(mean, 2);
        Self { vertices, weights, coordinates, mass, mean, variance }
    }

    /// Returns the weight of a vertex times a power of its distance from the mean; 0 outside the window.
    fn weight(&self, vertex: usize, power: i32) -> f64 {
        if !self.vertices.contains(&vertex) {
            return 0.0;
        }
        let index = vertex - self.vertices.start();
        self.weights[index] * (self.coordinates[index] - self.mean).powi(power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A single row of cells does not warp: each corner is moved by its twist alone, 1/4 in x z and y z, so that J = h⁴. The
    /// middles of 2 x 2 cells move too, by 1/2, which adds 2 h⁴; they do not warp either, because the warping of a square is
    /// 0 on its axes and diagonals. A fine lattice of cells has the J of a solid and h² t² beside it.
    #[test]
    fn torsion_of_cells_is_that_of_their_corners_and_of_a_solid() {
        let factor = |cells: i32, half_width: HalfWidth| {
            Regions { cells, half_width, poisson_ratio: 0.0 }.torsion() * TORSION * f64::from(cells).powi(4)
        };
        assert!((factor(1, HalfWidth::CELL) - 1.0).abs() < 1e-12);
        assert!((factor(2, HalfWidth::CELL) - 6.0).abs() < 1e-12);
        let solid = TORSION * 10_f64.powi(4) + 100.0;
        // The error of a lattice falls with the square of the cells.
        assert!(
            (factor(10, HalfWidth::CELL) / solid - 1.0).abs() < 0.5 / 10_f64.powi(2),
            "{}",
            factor(10, HalfWidth::CELL)
        );
        // Regions that are wider than the bar do not turn: they resist by twice the variances of their corners, 1/4 each.
        let wide = factor(1, 3.into());
        assert!((wide - 1.0).abs() < 1e-12, "{wide}");
    }

    /// Measured for a cube of 8 cells in the linear limit, to two digits: 0.89 and 0.84 with half-width 1; in general about
    /// 1 - 0.6 R/t and 1 - 0.85 R/t.
    #[test]
    fn thin_regions_at_the_surface_resist_dilation_less() {
        let factor = |cells: i32, half_width: HalfWidth, poisson_ratio: f64| {
            Regions { cells, half_width, poisson_ratio }.dilation()
        };
        assert!((factor(5, HalfWidth::CELL, 0.45) - 1.0).abs() < 1e-12);
        for (poisson_ratio, expected, slope) in [(0.0, 0.89, 0.6), (0.45, 0.84, 0.85)] {
            assert!((factor(8, 1.into(), poisson_ratio) - expected).abs() < 0.006);
            for (cells, w) in [(6, 1), (10, 1), (10, 2)] {
                let regions = Regions { cells, half_width: w.into(), poisson_ratio };
                let expected = 1.0 - slope * regions.radius();
                assert!((regions.dilation() / expected - 1.0).abs() < 0.03, "{}", regions.dilation());
            }
        }
    }

    #[test]
    fn cells_bend_like_a_solid_with_a_share_of_their_own() {
        let factor = |cells: i32, poisson_ratio: f64| {
            Regions { cells, half_width: HalfWidth::CELL, poisson_ratio }.bending()
        };
        for cells in [1, 2, 4, 10] {
            let expected = 1.0 + 2.0 / f64::from(cells * cells);
            assert!((factor(cells, 0.0) - expected).abs() < 1e-12);
        }
        // In a row of single cells only x z counts, 3 E0/E of E I.
        assert!((factor(1, 0.45) - 3.0 / 1.45).abs() < 1e-12);
        assert!((factor(100, 0.45) - 1.0).abs() < 2e-4);
    }
}
