//! The geometry of a deformed cell: world positions, their derivatives, and the local coordinates of a point.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::lattice::{monomials, polynomial};

/// Distance in local coordinates up to which a point outside a cell belongs to it. Contacts act at points that are
/// slightly outside a surface, which may be the boundary of the lattice.
pub(super) const MARGIN: f64 = 2e-3;

/// Maximum number of steps of Newton's method.
const NEWTON_STEPS: usize = 12;

/// Length of a step of Newton's method in local coordinates after which it ends. The number of correct digits doubles
/// in each step, so the error that remains is about the square of this length.
const LAST_STEP: f64 = 1e-5;

/// A deformed cell: the trilinear interpolant of the world positions of its corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeformedCell {
    /// Corner 0.
    origin: Point3<f64>,
    /// Coefficients of 1, x, y, xy, z, xz, yz, xyz, without the origin.
    terms: [Vector3<f64>; 8],
}

/// The derivative F of the world position by the local coordinates at a point of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gradient {
    matrix: Matrix3<f64>,
    /// det F · F⁻ᵀ.
    cofactors: Matrix3<f64>,
    determinant: f64,
}

impl Gradient {
    fn new(matrix: Matrix3<f64>) -> Self {
        let [a, b, c] = [0, 1, 2].map(|column| matrix.fixed_view::<3, 1>(0, column).into_owned());
        let cofactors = Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)]);
        Self { matrix, cofactors, determinant: a.dot(&cofactors.column(0)) }
    }

    /// Returns whether the cell is not inside out at the point.
    pub(super) fn is_regular(&self) -> bool {
        self.determinant > 0.0
    }

    /// Converts a normal of a surface from rest to world space: F⁻ᵀ n, as a unit vector. Returns `None` if the cell is
    /// flat or inside out.
    pub(super) fn normal(&self, rest: &Vector3<f64>) -> Option<Vector3<f64>> {
        (self.cofactors * rest).try_normalize(0.0).filter(|_| self.is_regular())
    }

    /// Converts a normal of a surface from world space to rest: Fᵀ n, as a unit vector.
    pub(super) fn rest_normal(&self, normal: &Vector3<f64>) -> Option<Vector3<f64>> {
        self.matrix.tr_mul(normal).try_normalize(0.0)
    }

    /// Converts an offset from world space to local coordinates: F⁻¹ v.
    pub(super) fn local_offset(&self, offset: &Vector3<f64>) -> Vector3<f64> {
        self.cofactors.tr_mul(offset) / self.determinant
    }
}

impl DeformedCell {
    /// Creates the cell with the given world positions of its corners.
    pub(super) fn new(corners: &[Point3<f64>; 8]) -> Self {
        let origin = corners[0];
        Self { origin, terms: polynomial(corners.map(|corner| corner - origin)) }
    }

    /// Returns the world position of a point.
    #[inline]
    pub(super) fn position(&self, local: [f64; 3]) -> Point3<f64> {
        self.origin + self.offset(local)
    }

    #[inline]
    fn offset(&self, local: [f64; 3]) -> Vector3<f64> {
        let monomials = monomials(1.0, local);
        let mut sum = self.terms[0];
        for k in 1..8 {
            sum += self.terms[k] * monomials[k];
        }
        sum
    }

    /// Returns the derivative at a point.
    #[inline]
    pub(super) fn gradient(&self, [x, y, z]: [f64; 3]) -> Gradient {
        let [_, a, b, ab, c, ac, bc, abc] = self.terms;
        Gradient::new(Matrix3::from_columns(&[
            a + ab * y + (ac + abc * y) * z,
            b + ab * x + (bc + abc * x) * z,
            c + ac * x + (bc + abc * x) * y,
        ]))
    }

    /// Returns the local coordinates of a point and the derivative near it, or `None` if the point is not in the cell,
    /// or the cell is inside out there. `start` are approximate local coordinates. The cell is continued by its own
    /// size beyond each of `continued_sides`, one bit for each of the sides at -x, +x, -y, +y, -z, +z.
    pub(super) fn locate(
        &self,
        point: &Point3<f64>,
        start: Vector3<f64>,
        continued_sides: u8,
    ) -> Option<([f64; 3], Gradient)> {
        let target = point - self.origin;
        let mut local = start.map(|u| u.clamp(-1.0, 2.0));
        for _ in 0..NEWTON_STEPS {
            let gradient = self.gradient(local.into());
            if gradient.determinant == 0.0 {
                return None;
            }
            let step = gradient.local_offset(&(self.offset(local.into()) - target));
            local -= step;
            if !local.iter().all(|u| (-1.0..=2.0).contains(u)) {
                local = local.map(|u| u.clamp(-1.0, 2.0));
            } else if step.amax() < LAST_STEP {
                let is_inside = contains(local.into(), continued_sides);
                return (is_inside && gradient.is_regular()).then(|| (local.into(), gradient));
            }
        }
        None
    }

    /// Returns the distance of a point outside the cell from the point of the cell to which the edges of the cell lead,
    /// the local coordinates of the point, continued linearly from there, and the derivative there. `None` if the cell
    /// is flat or inside out.
    pub(super) fn locate_outside(&self, point: &Point3<f64>) -> Option<(f64, [f64; 3], Gradient)> {
        let target = point - self.origin;
        let mut local = Vector3::repeat(0.5);
        for _ in 0..NEWTON_STEPS {
            let gradient = self.gradient(local.into());
            if !gradient.is_regular() {
                return None;
            }
            let rest = target - self.offset(local.into());
            let continued = local + gradient.local_offset(&rest);
            let next = continued.map(|u| u.clamp(0.0, 1.0));
            if (next - local).amax() < LAST_STEP {
                return Some((rest.norm(), continued.into(), gradient));
            }
            local = next;
        }
        None
    }
}

/// Returns whether a cell, continued beyond `continued_sides`, contains the point with these local coordinates.
fn contains(local: [f64; 3], continued_sides: u8) -> bool {
    let is_inside = |u: f64| (-MARGIN..=1.0 + MARGIN).contains(&u);
    let mut outside = (0..3).filter(|&a| !is_inside(local[a]));
    let Some(axis) = outside.next() else { return true };
    let side = 2 * axis + usize::from(local[axis] > 0.5);
    outside.next().is_none() && continued_sides >> side & 1 != 0
}

/// Linear approximation of the local coordinates in a deformed cell, with a bound of its error.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearMap {
    center: Point3<f64>,
    /// Derivative of the local coordinates by the world position, at the center.
    inverse: Matrix3<f64>,
    /// Greatest difference of the approximation of a local coordinate between a point of the cell and the center.
    range: Vector3<f64>,
}

impl LinearMap {
    /// Creates the map of a cell, which is continued beyond `continued_sides`: see [`DeformedCell::locate`]. If the
    /// cell is flat or inside out at its center, the approximation has no bound.
    pub(super) fn new(cell: &DeformedCell, continued_sides: u8) -> Self {
        let center = cell.position([0.5; 3]);
        let gradient = cell.gradient([0.5; 3]);
        if !gradient.is_regular() {
            return Self { center, inverse: Matrix3::zeros(), range: Vector3::repeat(f64::INFINITY) };
        }
        let inverse = gradient.cofactors.transpose() / gradient.determinant;
        // About the center, only the terms of xy, xz, yz and xyz are not linear, with |x|, |y|, |z| <= half.
        let half =
            [0, 1, 2].map(|a| if continued_sides >> (2 * a) & 3 == 0 { 0.5 + MARGIN } else { 1.5 + MARGIN });
        let [hx, hy, hz] = half;
        let [_, _, _, xy, _, xz, yz, xyz] = cell.terms;
        let about_center = [(xy, hx * hy), (xz, hx * hz), (yz, hy * hz)]
            .map(|(term, size)| inverse * (term + xyz * 0.5) * size);
        let error = about_center.iter().map(Vector3::abs).sum::<Vector3<f64>>()
            + (inverse * xyz).abs() * (hx * hy * hz);
        Self { center, inverse, range: Vector3::from(half) + error }
    }

    /// Returns the approximate local coordinates of a point, or `None` if the point is certainly not in the cell.
    #[inline]
    pub(super) fn local(&self, point: &Point3<f64>) -> Option<Vector3<f64>> {
        let offset = self.inverse * (point - self.center);
        let is_possible = (0..3).all(|a| offset[a].abs() <= self.range[a]);
        is_possible.then(|| offset.add_scalar(0.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell whose corners are moved by up to 0.3.
    fn distorted(seed: u32) -> DeformedCell {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.6 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
        };
        DeformedCell::new(&std::array::from_fn(|k| {
            let corner = |a: usize| f64::from((k >> a & 1) as u32);
            Point3::new(corner(0) + random(), corner(1) + random(), corner(2) + random())
        }))
    }

    #[test]
    fn local_coordinates_of_distorted_cells_are_found() {
        for seed in 0..200 {
            let cell = distorted(seed);
            for k in 0..27 {
                let local = [k % 3, k / 3 % 3, k / 9].map(|i| f64::from(i) * 0.5);
                if cell.gradient(local).determinant < 0.05 {
                    continue;
                }
                let point = cell.position(local);
                let start = LinearMap::new(&cell, 0).local(&point).unwrap();
                let (found, _) = cell.locate(&point, start, 0).unwrap();
                let error = (Vector3::from(found) - Vector3::from(local)).amax();
                assert!(error < 1e-8, "seed {seed}, {local:?}: {found:?}");
            }
        }
    }

    #[test]
    fn normals_stay_perpendicular_to_the_surface() {
        for seed in 0..50 {
            let gradient = distorted(seed).gradient([0.3, 0.6, 0.8]);
            let (normal, tangent) = (Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.8, 0.5, -0.6));
            let Some(world) = gradient.normal(&normal) else { continue };
            assert!(world.dot(&(gradient.matrix * tangent)).abs() < 1e-12, "seed {seed}");
            assert!((gradient.rest_normal(&world).unwrap() - normal).norm() < 1e-12, "seed {seed}");
            let offset = gradient.local_offset(&(gradient.matrix * tangent));
            assert!((offset - tangent).norm() < 1e-10, "seed {seed}");
        }
    }

    #[test]
    fn cells_inside_out_and_points_outside_are_rejected() {
        let cell: [Point3<f64>; 8] =
            std::array::from_fn(|k| Point3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64));
        let center = Point3::new(0.5, 0.5, 0.5);
        let locate = |corners, point: &Point3<f64>| {
            let cell = DeformedCell::new(&corners);
            LinearMap::new(&cell, 0).local(point).and_then(|start| cell.locate(point, start, 0))
        };
        assert!(locate(cell, &center).is_some());
        assert!(locate(cell.map(|p| Point3::new(-p.x + 1.0, p.y, p.z)), &center).is_none());
        assert!(locate(cell.map(|p| Point3::new(p.x, 0.5, p.z)), &center).is_none());
        assert!(locate(cell, &Point3::new(1.01, 0.5, 0.5)).is_none());
        assert!(locate(cell, &Point3::new(f64::NAN, 0.5, 0.5)).is_none());
    }

    #[test]
    fn points_outside_a_cell_have_local_coordinates_that_continue_it() {
        let map = Matrix3::new(1.0, 0.3, 0.0, -0.2, 0.8, 0.1, 0.0, 0.0, 1.2);
        let corner = |k: usize| Vector3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let cell = DeformedCell::new(&std::array::from_fn(|k| Point3::from(map * corner(k))));
        // Beyond a face, an edge and a corner.
        for local in [[0.3, 1.6, 0.5], [-0.7, 0.4, 1.2], [1.5, -0.5, 2.5]] {
            let point = Point3::from(map * Vector3::from(local));
            let (distance, found, _) = cell.locate_outside(&point).unwrap();
            assert!((Vector3::from(found) - Vector3::from(local)).amax() < 1e-9, "{local:?}: {found:?}");
            let inside = Vector3::from(local.map(|u: f64| u.clamp(0.0, 1.0)));
            assert!((distance - (map * (Vector3::from(local) - inside)).norm()).abs() < 1e-9);
        }
        let flat = DeformedCell::new(&std::array::from_fn(|k| {
            Point3::from(corner(k).component_mul(&Vector3::new(1.0, 0.0, 1.0)))
        }));
        assert!(flat.locate_outside(&Point3::new(0.5, 0.5, 0.5)).is_none());
        assert!(cell.locate_outside(&Point3::new(f64::NAN, 0.5, 0.5)).is_none());
    }

    #[test]
    fn cells_are_continued_beyond_the_given_sides_only() {
        for seed in 0..50 {
            let cell = distorted(seed);
            let locate = |local: [f64; 3], continued_sides: u8| {
                let point = cell.position(local);
                let start = LinearMap::new(&cell, continued_sides).local(&point)?;
                cell.locate(&point, start, continued_sides).map(|(found, _)| found)
            };
            let beyond = [0.4, 1.5, 0.7];
            if cell.gradient(beyond).determinant < 0.05 {
                continue;
            }
            let found = locate(beyond, 1 << 3).unwrap();
            assert!((Vector3::from(found) - Vector3::from(beyond)).amax() < 1e-8, "seed {seed}");
            // Not beyond another side, and not beyond two sides.
            assert!(locate(beyond, 1 << 2 | 1 << 1).is_none(), "seed {seed}");
            assert!(locate([1.5, 1.5, 0.5], u8::MAX).is_none(), "seed {seed}");
        }
    }
}
