//! The deformed lattice of a body at one time, and the cell and local coordinates of a point in it.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::lattice::{monomials, polynomial};

/// Pitch of the grid of deformed cells, in cells.
const PITCH: f64 = 1.2;

/// Greatest number of grid entries, as a multiple of the number of cells. The pitch of the grid of a lattice that is
/// stretched over a large space is greater.
const MAX_ENTRIES: usize = 8;

/// Distance in local coordinates up to which a point outside a cell belongs to it. Contacts act at points that are
/// slightly outside a surface, which may be the boundary of the lattice.
const MARGIN: f64 = 2e-3;

/// Maximum number of steps of Newton's method, which doubles the number of correct digits in each step.
const NEWTON_STEPS: usize = 12;

/// Accuracy of local coordinates.
const ACCURACY: f64 = 1e-10;

/// Axis-aligned box in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: Point3<f64>,
    pub(crate) high: Point3<f64>,
}

impl Bounds {
    /// Contains no point.
    pub(crate) const EMPTY: Self = Self {
        low: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Contains the origin only.
    pub(crate) const ZERO: Self = Self { low: Point3::new(0.0, 0.0, 0.0), high: Point3::new(0.0, 0.0, 0.0) };

    /// Returns the smallest box that contains the points.
    pub(crate) fn of(points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        points.into_iter().fold(Self::EMPTY, |Self { low, high }, point| Self {
            low: low.inf(&point),
            high: high.sup(&point),
        })
    }

    /// Returns the box enlarged by `margin` on all sides.
    pub(crate) fn enlarged(self, margin: f64) -> Self {
        let margin = Vector3::repeat(margin);
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Returns the box with its coordinates times `factor`, which is not negative.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { low: self.low * factor, high: self.high * factor }
    }

    /// Returns the greatest distance between a point of this box and one of the other.
    pub(crate) fn greatest_difference(&self, other: &Self) -> f64 {
        (self.high - other.low).sup(&(other.high - self.low)).norm()
    }

    /// Returns the intersection, which may be empty.
    pub(crate) fn intersection(&self, other: &Self) -> Self {
        Self { low: self.low.sup(&other.low), high: self.high.inf(&other.high) }
    }

    /// Returns the smallest box that contains both.
    pub(crate) fn union(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Returns whether the box contains no point. A box with a NaN is empty.
    pub(crate) fn is_empty(&self) -> bool {
        !(0..3).all(|a| self.low[a] <= self.high[a])
    }

    pub(super) fn intersects(&self, other: &Self) -> bool {
        (0..3).all(|a| self.low[a] <= other.high[a] && other.low[a] <= self.high[a])
    }

    /// Returns on which sides of the box a point is outside: one bit for each of the six sides.
    fn sides_of(&self, point: &Point3<f64>) -> u8 {
        let side = |a: usize| u8::from(point[a] < self.low[a]) | u8::from(point[a] > self.high[a]) << 1;
        side(0) | side(1) << 2 | side(2) << 4
    }

    pub(super) fn contains(&self, point: &Point3<f64>) -> bool {
        (0..3).all(|a| self.low[a] <= point[a] && point[a] <= self.high[a])
    }
}

/// A lattice at one time: the world positions of its vertices, and a grid of its deformed cells.
#[derive(Clone, Debug)]
pub(crate) struct PosedLattice {
    /// Position of each lattice vertex.
    pub(super) positions: Vec<Point3<f64>>,
    /// Box of all positions.
    pub(super) bounds: Bounds,
    /// For each vertex, the sides of the region on which it is outside: one bit for each of the six sides.
    sides: Vec<u8>,
    /// The cells that are near other bodies, in increasing order, and their boxes.
    cells: Vec<(u32, Bounds)>,
    /// The linear map of each of `cells`.
    maps: Vec<LinearMap>,
    grid: Grid,
    cell_size: f64,
}

/// Linear approximation of the local coordinates in a deformed cell, with a bound of its error.
#[derive(Clone, Copy, Debug)]
struct LinearMap {
    center: Point3<f64>,
    /// Derivative of the local coordinates by the world position, at the center.
    inverse: Matrix3<f64>,
    /// Greatest difference of a local coordinate of a point of the cell to its approximation.
    error: Vector3<f64>,
}

impl LinearMap {
    /// Creates the map of a cell. If the cell is inside out at its center, the approximation has no bound.
    fn new(corners: &[Point3<f64>; 8]) -> Self {
        let terms = polynomial(corners.map(|corner| corner - corners[0]));
        let gradient = gradient(&terms, 0.5, 0.5, 0.5);
        let offset: Vector3<f64> = weighted(&terms, [0.5; 3]);
        let center = corners[0] + offset;
        let (inverse, is_valid) = match gradient.try_inverse() {
            Some(inverse) if gradient.determinant() > 0.0 => (inverse, true),
            _ => (Matrix3::zeros(), false),
        };
        if !is_valid {
            return Self { center, inverse, error: Vector3::repeat(f64::INFINITY) };
        }
        // About the center, the terms that are not linear are those of xy, xz, yz and xyz, with |x|, |y|, |z| <= half.
        let half = 0.5 + MARGIN;
        let [_, _, _, xy, _, xz, yz, xyz] = terms;
        let about_center =
            [xy + xyz * 0.5, xz + xyz * 0.5, yz + xyz * 0.5].map(|term| inverse * term * (half * half));
        let error = about_center.iter().map(Vector3::abs).sum::<Vector3<f64>>()
            + (inverse * xyz).abs() * (half * half * half);
        Self { center, inverse, error }
    }

    /// Returns the approximate local coordinates of a point, or `None` if the point is certainly not in the cell.
    #[inline]
    fn local(&self, point: &Point3<f64>) -> Option<Vector3<f64>> {
        let offset = self.inverse * (point - self.center);
        let is_possible = (0..3).all(|a| offset[a].abs() <= 0.5 + MARGIN + self.error[a]);
        is_possible.then(|| offset.add_scalar(0.5))
    }
}

/// A point in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Located {
    pub(super) cell: u32,
    pub(super) local: [f64; 3],
    /// Derivative of the world position by the local coordinates.
    pub(super) gradient: Matrix3<f64>,
}

/// Uniform grid over a box. A bin lists the entries of `PosedLattice::cells` that may contain a point of it.
#[derive(Clone, Debug)]
struct Grid {
    low: Point3<f64>,
    /// 1 / pitch.
    scale: f64,
    counts: [usize; 3],
    /// Index in `entries` of the first entry of each bin, then the number of entries.
    first: Vec<u32>,
    entries: Vec<u32>,
}

impl Default for PosedLattice {
    fn default() -> Self {
        let (low, scale) = (Point3::origin(), 1.0);
        let grid = Grid { low, scale, counts: [0; 3], first: Vec::new(), entries: Vec::new() };
        Self {
            positions: Vec::new(),
            bounds: Bounds::EMPTY,
            sides: Vec::new(),
            cells: Vec::new(),
            maps: Vec::new(),
            grid,
            cell_size: 1.0,
        }
    }
}

impl PosedLattice {
    /// Poses a lattice with the given positions of its vertices, and prepares the search of points in `region`. `cells` has
    /// the vertices at the corners of each cell.
    pub(super) fn pose(
        &mut self,
        positions: impl Iterator<Item = Point3<f64>>,
        cells: &[[u32; 8]],
        cell_size: f64,
        region: &Bounds,
    ) {
        self.positions.clear();
        self.positions.extend(positions);
        self.bounds = Bounds::of(self.positions.iter().copied());
        self.cell_size = cell_size;
        let region = region.enlarged(MARGIN * cell_size);
        self.sides.clear();
        self.sides.extend(self.positions.iter().map(|position| region.sides_of(position)));
        self.cells.clear();
        self.maps.clear();
        for (cell, corners) in (0..).zip(cells) {
            // A cell is outside the region if all its corners are outside on one side of it.
            let common = corners.iter().fold(u8::MAX, |common, &vertex| common & self.sides[vertex as usize]);
            if common == 0 {
                let corners = corners.map(|v| self.positions[v as usize]);
                self.cells.push((cell, Bounds::of(corners)));
                self.maps.push(LinearMap::new(&corners));
            }
        }
        self.grid.fill(&self.cells, &region, cell_size);
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { positions, sides, cells, maps, grid: Grid { first, entries, .. }, .. } = self;
        positions.capacity() * size_of::<Point3<f64>>()
            + sides.capacity()
            + cells.capacity() * size_of::<(u32, Bounds)>()
            + maps.capacity() * size_of::<LinearMap>()
            + (first.capacity() + entries.capacity()) * size_of::<u32>()
    }

    /// Returns the cells that are near other bodies, in increasing order, and their boxes.
    pub(super) fn cells(&self) -> &[(u32, Bounds)] {
        &self.cells
    }

    /// Returns the cell that contains a point. If several do, because the lattice overlaps itself, it is the first one
    /// that `accepts` takes. Cells that are inside out contain no point. `corners` returns the corners of a cell.
    pub(super) fn locate(
        &self,
        point: &Point3<f64>,
        corners: impl Fn(u32) -> [Point3<f64>; 8],
        accepts: impl Fn(u32) -> bool,
    ) -> Option<Located> {
        let margin = MARGIN * self.cell_size;
        self.grid.bin(point).iter().find_map(|&entry| {
            let (cell, bounds) = self.cells[entry as usize];
            if !bounds.enlarged(margin).contains(point) {
                return None;
            }
            let start = self.maps[entry as usize].local(point).filter(|_| accepts(cell))?;
            let (local, gradient) = inverse_trilinear(&corners(cell), point, start)?;
            Some(Located { cell, local, gradient })
        })
    }
}

impl Grid {
    /// Distributes cells to the bins of `region`.
    fn fill(&mut self, cells: &[(u32, Bounds)], region: &Bounds, cell_size: f64) {
        let all = cells.iter().fold(Bounds::EMPTY, |all, (_, bounds)| all.union(bounds));
        let all = all.enlarged(MARGIN * cell_size).intersection(region);
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
        let margin = MARGIN * cell_size;
        // Counts the entries of each bin, then places them: from the end, so that each bin is in increasing order.
        for (_, bounds) in cells {
            for bin in bins(self.low, self.scale, self.counts, &bounds.enlarged(margin)) {
                self.first[bin] += 1;
            }
        }
        let mut sum = 0;
        for first in &mut self.first {
            sum += *first;
            *first = sum;
        }
        self.entries.resize(sum as usize, 0);
        for (entry, (_, bounds)) in cells.iter().enumerate().rev() {
            for bin in bins(self.low, self.scale, self.counts, &bounds.enlarged(margin)) {
                self.first[bin] -= 1;
                self.entries[self.first[bin] as usize] = entry as u32;
            }
        }
    }

    /// Returns the entries of the bin of a point.
    fn bin(&self, point: &Point3<f64>) -> &[u32] {
        let place = (point - self.low) * self.scale;
        if self.counts[0] == 0 || !(0..3).all(|a| place[a] >= 0.0 && place[a] < self.counts[a] as f64) {
            return &[];
        }
        let [x, y, z]: [usize; 3] = std::array::from_fn(|a| place[a] as usize);
        let bin = (z * self.counts[1] + y) * self.counts[0] + x;
        &self.entries[self.first[bin] as usize..self.first[bin + 1] as usize]
    }
}

/// Returns the bins of a grid that a box intersects.
fn bins(
    low: Point3<f64>,
    scale: f64,
    counts: [usize; 3],
    bounds: &Bounds,
) -> impl Iterator<Item = usize> + use<> {
    // Casts saturate: below zero to 0, and beyond the last bin to it.
    let index = |a: usize, x: f64| (((x - low[a]) * scale) as usize).min(counts[a] - 1);
    let range = |a: usize| {
        let is_outside = bounds.high[a] < low[a] || (bounds.low[a] - low[a]) * scale >= counts[a] as f64;
        if is_outside { 0..0 } else { index(a, bounds.low[a])..index(a, bounds.high[a]) + 1 }
    };
    let [x, y, z] = [range(0), range(1), range(2)];
    z.flat_map(move |z| {
        let x = x.clone();
        y.clone().flat_map(move |y| x.clone().map(move |x| (z * counts[1] + y) * counts[0] + x))
    })
}

/// Returns the local coordinates of a point in a trilinear cell and the derivative of the world position by them, or
/// `None` if the point is not in the cell, or the cell is inside out there.
fn inverse_trilinear(
    corners: &[Point3<f64>; 8],
    point: &Point3<f64>,
    start: Vector3<f64>,
) -> Option<([f64; 3], Matrix3<f64>)> {
    let terms = polynomial(corners.map(|corner| corner - point));
    let mut local = start.map(|u| u.clamp(-1.0, 2.0));
    for _ in 0..NEWTON_STEPS {
        let [x, y, z] = local.into();
        let gradient = gradient(&terms, x, y, z);
        let distance = weighted(&terms, [x, y, z]);
        let determinant = gradient.determinant();
        let inverse = gradient.try_inverse()?;
        let step = inverse * distance;
        local -= step;
        if !local.iter().all(|u| (-1.0..=2.0).contains(u)) {
            local = local.map(|u| u.clamp(-1.0, 2.0));
        } else if step.amax() < ACCURACY {
            let is_inside = local.iter().all(|u| (-MARGIN..=1.0 + MARGIN).contains(u));
            return (is_inside && determinant > 0.0).then(|| (local.into(), gradient));
        }
    }
    None
}

/// Returns the value of a trilinear polynomial with the terms 1, x, y, xy, z, xz, yz, xyz.
fn weighted(terms: &[Vector3<f64>; 8], local: [f64; 3]) -> Vector3<f64> {
    terms.iter().zip(monomials(1.0, local)).map(|(term, monomial)| term * monomial).sum()
}

/// Returns the derivative of a trilinear polynomial, with the terms 1, x, y, xy, z, xz, yz, xyz, by the local coordinates.
fn gradient(terms: &[Vector3<f64>; 8], x: f64, y: f64, z: f64) -> Matrix3<f64> {
    let [_, a, b, ab, c, ac, bc, abc] = terms;
    Matrix3::from_columns(&[
        a + ab * y + (ac + abc * y) * z,
        b + ab * x + (bc + abc * x) * z,
        c + ac * x + (bc + abc * x) * y,
    ])
}

/// Returns the derivative of the world position by the local coordinates at a point of a cell.
pub(super) fn gradient_at(corners: &[Point3<f64>; 8], [x, y, z]: [f64; 3]) -> Matrix3<f64> {
    gradient(&polynomial(corners.map(|corner| corner - corners[0])), x, y, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell whose corners are moved by up to 0.3.
    fn distorted(seed: u32) -> [Point3<f64>; 8] {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.6 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
        };
        std::array::from_fn(|k| {
            let corner = |a: usize| f64::from((k >> a & 1) as u32);
            Point3::new(corner(0) + random(), corner(1) + random(), corner(2) + random())
        })
    }

    #[test]
    fn local_coordinates_of_distorted_cells_are_found() {
        for seed in 0..200 {
            let corners = distorted(seed);
            let terms = polynomial(corners.map(|corner| corner.coords));
            for k in 0..27 {
                let local = [k % 3, k / 3 % 3, k / 9].map(|i| f64::from(i) * 0.5);
                if gradient_at(&corners, local).determinant() < 0.05 {
                    continue;
                }
                let point = Point3::from(weighted(&terms, local));
                let start = LinearMap::new(&corners).local(&point).unwrap();
                let (found, _) = inverse_trilinear(&corners, &point, start).unwrap();
                let error = (Vector3::from(found) - Vector3::from(local)).amax();
                assert!(error < 1e-8, "seed {seed}, {local:?}: {found:?}");
            }
        }
    }

    #[test]
    fn cells_inside_out_and_points_outside_are_rejected() {
        let cell: [Point3<f64>; 8] =
            std::array::from_fn(|k| Point3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64));
        let center = Point3::new(0.5, 0.5, 0.5);
        let inverse = |cell, point: &Point3<f64>| {
            LinearMap::new(&cell).local(point).and_then(|start| inverse_trilinear(&cell, point, start))
        };
        assert!(inverse(cell, &center).is_some());
        assert!(inverse(cell.map(|p| Point3::new(-p.x + 1.0, p.y, p.z)), &center).is_none());
        assert!(inverse(cell.map(|p| Point3::new(p.x, 0.5, p.z)), &center).is_none());
        assert!(inverse(cell, &Point3::new(1.01, 0.5, 0.5)).is_none());
        assert!(inverse(cell, &Point3::new(f64::NAN, 0.5, 0.5)).is_none());
    }
}
