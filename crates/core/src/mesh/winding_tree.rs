//! Generalized winding numbers of triangles that need not be closed (Jacobson et al. 2013), by a tree of clusters
//! (Barill et al. 2018).
//!
//! The winding number at q is the sum of the solid angles of the triangles seen from q, divided by 4 π. Inside a closed
//! surface with outward normals it is 1, outside 0; in front of an opening it falls smoothly from 1 to 0. Far away a
//! cluster counts by the first three terms of its expansion about its center p, with d = p - q and r = |d|. They are
//! the terms of the integrals of n, n x and n x x over its triangles, with the unit normal n and the offset x from p:
//!
//! ```text
//! n . d / r^3,   n . x / r^3 - 3 (n . d) (x . d) / r^5,
//! 15/2 (n . d) (x . d)^2 / r^7 - 3 (n . x) (x . d) / r^5 - 3/2 (n . d) (x . x) / r^5
//! ```

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::{Matrix3, Point3, Vector3};

/// Number of triangles up to which a cluster is not divided.
const LEAF: usize = 8;

/// Distance from the center of a cluster, in its radii, from which on the expansion is used (Barill et al. 2018, beta).
const FAR: f64 = 2.0;

/// Triangles in clusters.
#[derive(Clone, Debug)]
pub(crate) struct WindingTree {
    /// Depth first: the first part of a cluster follows it.
    clusters: Vec<Cluster>,
    /// The corners of the triangles, cluster by cluster.
    triangles: Vec<[Point3<f64>; 3]>,
    /// The index of each of them in the order in which they were given.
    indices: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Cluster {
    center: Point3<f64>,
    /// Greatest distance of a corner from the center.
    radius: f64,
    moments: Moments,
    triangles: Range<u32>,
    /// The cluster after this one and its parts.
    next: u32,
}

/// Integrals over the triangles of a cluster, with the unit normal n and the offset x from the center.
#[derive(Clone, Debug, Default)]
struct Moments {
    /// Integral of n.
    normal: Vector3<f64>,
    /// Integral of n x^T.
    first: Matrix3<f64>,
    /// Integrals of n[i] x x^T, for each axis i.
    second: [Matrix3<f64>; 3],
    /// Integral of 2 (n . x) x + (x . x) n.
    contracted: Vector3<f64>,
}

impl Moments {
    /// Adds a triangle with the offsets of its corners.
    fn add(&mut self, corners: [Vector3<f64>; 3]) {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a)) / 2.0;
        let sum = a + b + c;
        self.normal += normal;
        self.first += normal * (sum / 3.0).transpose();
        // The mean of x x^T over the triangle.
        let square =
            corners.iter().fold(sum * sum.transpose(), |square, x| square + x * x.transpose()) / 12.0;
        for (second, n) in self.second.iter_mut().zip(normal.iter()) {
            *second += square * *n;
        }
        self.contracted += 2.0 * square * normal + square.trace() * normal;
    }

    /// Returns the solid angle seen from the point at `-d` from the center. `square`: |d|^2.
    fn solid_angle(&self, d: &Vector3<f64>, square: f64) -> f64 {
        let quadratic = |matrix: &Matrix3<f64>| d.dot(&(matrix * d));
        let second: f64 = self.second.iter().zip(d.iter()).map(|(second, d)| d * quadratic(second)).sum();
        let first =
            self.first.trace() - (3.0 * quadratic(&self.first) + 1.5 * self.contracted.dot(d)) / square;
        (self.normal.dot(d) + first + 7.5 * second / (square * square)) / (square * square.sqrt())
    }
}

impl WindingTree {
    /// Builds the tree.
    pub(super) fn new(triangles: impl Iterator<Item = [Point3<f64>; 3]>) -> Self {
        let given: Vec<_> = triangles.collect();
        let mut indices: Vec<u32> = (0..given.len() as u32).collect();
        let mut clusters = Vec::with_capacity(4 * given.len() / LEAF + 1);
        divide(&given, &mut indices, 0, &mut clusters);
        let triangles = indices.iter().map(|&index| given[index as usize]).collect();
        Self { clusters, triangles, indices }
    }

    /// Returns the winding number at a point. The triangle with index `except` does not count.
    pub(crate) fn number(&self, point: &Point3<f64>, except: Option<u32>) -> f64 {
        let mut sum = 0.0;
        let mut at = 0;
        while let Some(cluster) = self.clusters.get(at) {
            let d = cluster.center - point;
            let square = d.norm_squared();
            if square > (FAR * cluster.radius).powi(2) {
                sum += cluster.moments.solid_angle(&d, square);
                at = cluster.next as usize;
                continue;
            }
            at += 1;
            if at == cluster.next as usize {
                let range = cluster.triangles.start as usize..cluster.triangles.end as usize;
                for (triangle, index) in self.triangles[range.clone()].iter().zip(&self.indices[range]) {
                    if Some(*index) != except {
                        sum += solid_angle(triangle, point);
                    }
                }
            }
        }
        sum / (4.0 * PI)
    }

    /// Returns the number of triangles of which [`number`](Self::number) computes the solid angle at a point.
    pub(crate) fn cost(&self, point: &Point3<f64>) -> usize {
        let (mut cost, mut at) = (0, 0);
        while let Some(cluster) = self.clusters.get(at) {
            let is_far = (cluster.center - point).norm_squared() > (FAR * cluster.radius).powi(2);
            at = if is_far { cluster.next as usize } else { at + 1 };
            if !is_far && at == cluster.next as usize {
                cost += cluster.triangles.len();
            }
        }
        cost
    }

    /// Returns whether a point is inside: whether the magnitude of the winding number exceeds 1/2.
    pub(crate) fn encloses(&self, point: &Point3<f64>) -> bool {
        self.number(point, None).abs() > 0.5
    }
}

/// Appends the cluster of some triangles and its parts. `first`: index of the first of them among all.
fn divide(given: &[[Point3<f64>; 3]], indices: &mut [u32], first: u32, clusters: &mut Vec<Cluster>) {
    if indices.is_empty() {
        return;
    }
    let own = clusters.len();
    clusters.push(cluster(given, indices, first));
    if indices.len() > LEAF {
        let middle = |index: &u32| {
            given[*index as usize].iter().fold(Vector3::zeros(), |sum, corner| sum + corner.coords)
        };
        let (low, high) = indices.iter().map(middle).fold(
            (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)),
            |(low, high), middle| (low.inf(&middle), high.sup(&middle)),
        );
        let axis = (high - low).imax();
        let half = indices.len() / 2;
        indices
            .select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(b)));
        let (lower, upper) = indices.split_at_mut(half);
        divide(given, lower, first, clusters);
        divide(given, upper, first + half as u32, clusters);
    }
    clusters[own].next = clusters.len() as u32;
}

/// Returns the cluster of some triangles, without its parts.
fn cluster(given: &[[Point3<f64>; 3]], indices: &[u32], first: u32) -> Cluster {
    let triangles = || indices.iter().map(|&index| &given[index as usize]);
    let area = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a)) / 2.0;
    let centroid = |[a, b, c]: &[Point3<f64>; 3]| Point3::from((a.coords + b.coords + c.coords) / 3.0);
    // The center is the mean of the centroids, weighted by area.
    let (sum, total) = triangles().fold((Vector3::zeros(), 0.0), |(sum, total), triangle| {
        let weight = area(triangle).norm();
        (sum + weight * centroid(triangle).coords, total + weight)
    });
    let center = if total > 0.0 { Point3::from(sum / total) } else { given[indices[0] as usize][0] };
    let radius = triangles().flatten().map(|corner| (corner - center).norm()).fold(0.0, f64::max);
    let mut moments = Moments::default();
    triangles().for_each(|triangle| moments.add(triangle.map(|corner| corner - center)));
    Cluster { center, radius, moments, triangles: first..first + indices.len() as u32, next: 0 }
}

/// Returns the solid angle of a triangle seen from a point: positive if its normal points away from the point (Van
/// Oosterom & Strackee 1983). Seen from its own plane it is 0 outside of the triangle.
fn solid_angle(triangle: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - point);
    let volume = a.dot(&b.cross(&c));
    if volume == 0.0 {
        return 0.0;
    }
    let [x, y, z] = [a, b, c].map(|corner| corner.norm());
    2.0 * angle(volume, x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y)
}

/// Returns the angle of the point (`x`, `y`), to 1e-7 where it is small, which most are.
fn angle(y: f64, x: f64) -> f64 {
    let ratio = y / x;
    if x > 0.0 && ratio.abs() < 0.3 {
        let square = ratio * ratio;
        // The series of the arc tangent, up to the ninth power.
        return ratio * (1.0 - square * (1.0 / 3.0 - square * (0.2 - square * (1.0 / 7.0 - square / 9.0))));
    }
    libm::atan2(y, x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of radius 1 about the origin, of n parallels and 2 n meridians, without the faces above a height.
    fn sphere(n: usize, height: f64) -> Vec<[Point3<f64>; 3]> {
        let at = |i: usize, j: usize| {
            let (theta, phi) = (PI * i as f64 / n as f64, PI * (j % (2 * n)) as f64 / n as f64);
            Point3::new(
                libm::sin(theta) * libm::cos(phi),
                libm::sin(theta) * libm::sin(phi),
                libm::cos(theta),
            )
        };
        let quads = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
        let quads = quads.filter(|&(i, j)| at(i, j).z <= height);
        quads
            .flat_map(|(i, j)| {
                [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
            })
            .collect()
    }

    #[test]
    fn numbers_of_the_tree_are_the_sums_of_solid_angles() {
        let triangles = sphere(20, 0.8);
        let tree = WindingTree::new(triangles.iter().copied());
        for k in 0..1000 {
            let point = Point3::from([k % 10, k / 10 % 10, k / 100].map(|i| 0.3 * f64::from(i) - 1.37));
            let exact =
                triangles.iter().map(|triangle| solid_angle(triangle, &point)).sum::<f64>() / (4.0 * PI);
            // An error of 0.01 moves the limit of 1/2 in front of an opening by a hundredth of its width.
            assert!((tree.number(&point, None) - exact).abs() < 0.01, "{point}: {exact}");
        }
    }

    #[test]
    fn closed_surface_has_the_numbers_one_and_zero() {
        let tree = WindingTree::new(sphere(20, 1.0).into_iter());
        for (point, number) in
            [([0.0; 3], 1.0), ([0.5, 0.5, -0.6], 1.0), ([0.8, 0.8, 0.0], 0.0), ([3.0; 3], 0.0)]
        {
            assert!((tree.number(&point.into(), None) - number).abs() < 0.01, "{point:?}");
        }
    }

    #[test]
    fn number_on_a_closed_surface_is_one_half_without_its_own_triangle() {
        let triangles = sphere(20, 1.0);
        let tree = WindingTree::new(triangles.iter().copied());
        // The triangles at the poles have no area.
        for index in (80..triangles.len() - 80).step_by(37) {
            let [a, b, c] = triangles[index].map(|corner| corner.coords);
            let number = tree.number(&Point3::from((a + b + c) / 3.0), Some(index as u32));
            assert!((number - 0.5).abs() < 0.01, "{index}: {number}");
        }
    }
}
