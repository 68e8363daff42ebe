//! Meshes of figures with limbs: round cones that blend into each other. The surface of the cells inside is moved onto
//! the surface of the figure.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};
use supple::{Mesh, MeshError};

type Vec3 = Vector3<f64>;

/// A figure, approximately one unit long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Figure {
    /// A head on eight arms.
    Octopus,
    /// A standing body with arms, legs, ears and a tail.
    Armadillo,
    /// A sitting body with a head, long ears and a tail.
    Bunny,
}

/// A ball swept along a segment, with a linearly varying radius.
struct Cone {
    ends: [Vec3; 2],
    radii: [f64; 2],
}

/// Edge of the cells whose surface becomes the mesh.
const CELL: f64 = 0.012;

/// Length over which cones blend into each other.
const BLEND: f64 = 0.008;

impl Figure {
    /// All figures with their names.
    pub(super) const NAMED: [(&'static str, Self); 3] =
        [("octopus", Self::Octopus), ("armadillo", Self::Armadillo), ("bunny", Self::Bunny)];

    /// Returns the closed mesh of the figure.
    pub(super) fn mesh(self) -> Result<Mesh, MeshError> {
        let cones = match self {
            Self::Octopus => octopus(),
            Self::Armadillo => armadillo(),
            Self::Bunny => bunny(),
        };
        surface(&cones)
    }
}

fn octopus() -> Vec<Cone> {
    const ARMS: u32 = 8;
    const JOINTS: u32 = 10;
    let mut cones = vec![cone([0.0, 0.1, 0.0], [0.0, 0.3, 0.05], 0.09, 0.12)];
    for arm in 0..ARMS {
        let outward = Rotation3::from_axis_angle(&Vec3::y_axis(), TAU * f64::from(arm) / f64::from(ARMS));
        let point = |joint: u32| -> [f64; 3] {
            let t = f64::from(joint) / f64::from(JOINTS);
            let phase = f64::from(arm);
            let (sway, lift) = ((6.0 * t + 0.8 * phase).sin(), (5.0 * t + 0.5 * phase).cos());
            (outward * Vec3::new(0.05 + 0.5 * t, 0.07 + 0.05 * t * lift, 0.1 * t * sway)).into()
        };
        let radius = |joint: u32| 0.045 - 0.025 * f64::from(joint) / f64::from(JOINTS);
        cones.extend((0..JOINTS).map(|k| cone(point(k), point(k + 1), radius(k), radius(k + 1))));
    }
    cones
}

fn armadillo() -> Vec<Cone> {
    let mut cones = vec![
        cone([0.0, 0.4, 0.0], [0.0, 0.62, 0.0], 0.15, 0.14),
        cone([0.0, 0.78, 0.03], [0.0, 0.78, 0.14], 0.1, 0.05),
        cone([0.0, 0.33, -0.1], [0.0, 0.12, -0.28], 0.07, 0.05),
        cone([0.0, 0.12, -0.28], [0.0, 0.06, -0.42], 0.05, 0.03),
    ];
    for side in [-1.0, 1.0] {
        let limb = |a: [f64; 3], b: [f64; 3], radii: [f64; 2]| {
            let mirrored = |[x, y, z]: [f64; 3]| [side * x, y, z];
            cone(mirrored(a), mirrored(b), radii[0], radii[1])
        };
        cones.extend([
            limb([0.12, 0.34, 0.0], [0.18, 0.2, 0.05], [0.09, 0.07]),
            limb([0.18, 0.2, 0.05], [0.18, 0.05, 0.0], [0.07, 0.05]),
            limb([0.18, 0.05, 0.0], [0.2, 0.05, 0.12], [0.05, 0.04]),
            limb([0.14, 0.66, 0.0], [0.32, 0.6, 0.04], [0.06, 0.05]),
            limb([0.32, 0.6, 0.04], [0.36, 0.72, 0.14], [0.05, 0.035]),
            limb([0.07, 0.85, 0.0], [0.13, 0.97, -0.02], [0.035, 0.025]),
        ]);
    }
    cones
}

fn bunny() -> Vec<Cone> {
    let mut cones = vec![
        cone([0.0, 0.27, 0.0], [0.0, 0.3, 0.12], 0.25, 0.2),
        cone([0.0, 0.55, 0.24], [0.0, 0.53, 0.32], 0.13, 0.1),
        cone([0.0, 0.2, -0.28], [0.0, 0.22, -0.3], 0.07, 0.07),
    ];
    for side in [-1.0, 1.0] {
        cones.extend([
            cone([side * 0.06, 0.64, 0.2], [side * 0.1, 0.95, 0.08], 0.05, 0.035),
            cone([side * 0.16, 0.1, 0.0], [side * 0.18, 0.06, 0.24], 0.1, 0.05),
        ]);
    }
    cones
}

fn cone(a: [f64; 3], b: [f64; 3], radius_a: f64, radius_b: f64) -> Cone {
    Cone { ends: [a.into(), b.into()], radii: [radius_a, radius_b] }
}

impl Cone {
    /// Returns the distance of a point from the surface, negative inside.
    fn distance(&self, point: &Vec3) -> f64 {
        let [a, b] = self.ends;
        let axis = b - a;
        let t = ((point - a).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
        (a + axis * t - point).norm() - (self.radii[0] + (self.radii[1] - self.radii[0]) * t)
    }
}

/// Returns the distance from the blended cones: the smooth minimum -B ln Σ exp(-d/B).
fn field(cones: &[Cone], point: &Vec3) -> f64 {
    let distances = || cones.iter().map(|cone| cone.distance(point));
    let least = distances().fold(f64::INFINITY, f64::min);
    if least > 4.0 * CELL {
        return least;
    }
    least - BLEND * distances().map(|distance| ((least - distance) / BLEND).exp()).sum::<f64>().ln()
}

/// Returns the mesh: the quads between cells whose centers are inside and those outside, with the vertices moved onto
/// the surface.
fn surface(cones: &[Cone]) -> Result<Mesh, MeshError> {
    let ends = || cones.iter().flat_map(|cone| cone.ends.into_iter().zip(cone.radii));
    let margin = BLEND * (cones.len() as f64).ln() + 2.0 * CELL;
    let low = ends().fold(Vec3::repeat(f64::INFINITY), |low, (end, r)| low.inf(&end.add_scalar(-r - margin)));
    let high =
        ends().fold(Vec3::repeat(-f64::INFINITY), |high, (end, r)| high.sup(&end.add_scalar(r + margin)));
    let size: [usize; 3] = std::array::from_fn(|axis| ((high[axis] - low[axis]) / CELL).ceil() as usize);
    let place = |[x, y, z]: [f64; 3]| low + CELL * Vec3::new(x, y, z);
    let cells = size[0] * size[1] * size[2];
    let index = |[x, y, z]: [usize; 3]| (z * size[1] + y) * size[0] + x;
    let cell = |k: usize| [k % size[0], k / size[0] % size[1], k / size[0] / size[1]];
    let inside: Vec<bool> =
        (0..cells).map(|k| field(cones, &place(cell(k).map(|i| i as f64 + 0.5))) < 0.0).collect();
    let mut vertices = Vec::new();
    let mut indices = BTreeMap::new();
    let mut quads = Vec::new();
    // The margin leaves the outermost cells empty.
    for k in (0..cells).filter(|&k| inside[k]) {
        for (axis, forward) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let mut neighbor = cell(k);
            neighbor[axis] = if forward { neighbor[axis] + 1 } else { neighbor[axis] - 1 };
            if inside[index(neighbor)] {
                continue;
            }
            let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                let mut corner = cell(k);
                corner[axis] += usize::from(forward);
                corner[(axis + 1) % 3] += u;
                corner[(axis + 2) % 3] += v;
                *indices.entry(corner).or_insert_with(|| {
                    vertices.push(projected(cones, place(corner.map(|i| i as f64))).into());
                    vertices.len() as u32 - 1
                })
            });
            if !forward {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
    Mesh::new(vertices, &quads)
}

/// Moves a point near the surface onto it, by at most a cell, with three steps of Newton's method.
fn projected(cones: &[Cone], start: Vec3) -> Vec3 {
    const DIFFERENCE: f64 = 1e-6;
    let mut point = start;
    for _ in 0..3 {
        let value = field(cones, &point);
        let gradient = Vec3::from_fn(|axis, _| {
            let offset = DIFFERENCE * Vec3::ith(axis, 1.0);
            (field(cones, &(point + offset)) - field(cones, &(point - offset))) / (2.0 * DIFFERENCE)
        });
        // At the medial axis the gradient vanishes.
        point -= gradient * (value / gradient.norm_squared().max(0.25));
    }
    start + (point - start).cap_magnitude(CELL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_closed_and_have_their_size() {
        for (name, figure) in Figure::NAMED {
            let mesh = figure.mesh().unwrap();
            let (low, high) = mesh.bounds();
            let extent = (high - low).max();
            assert!(mesh.is_closed() && mesh.signed_volume() > 0.01, "{name}: {}", mesh.signed_volume());
            assert!((0.7..1.4).contains(&extent), "{name}: {extent}");
        }
    }
}
