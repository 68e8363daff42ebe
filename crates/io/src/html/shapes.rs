//! Triangles of colliders that are no meshes, small enough for light that is evaluated at their vertices.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// Positions, and triangles that turn to the left as seen from outside.
pub(super) type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Divisions around a capsule, from each pole to its middle, and of an edge of a box.
const AROUND: usize = 64;
const RINGS: usize = 16;
const EDGE: usize = 12;

/// Returns a grid of triangles: `rows` times `columns` quadrilaterals.
fn grid(columns: usize, rows: usize, first: u32) -> impl Iterator<Item = [u32; 3]> {
    let quad = move |k: usize| {
        let a = first + (k / columns * (columns + 1) + k % columns) as u32;
        let (b, c, d) = (a + 1, a + columns as u32 + 2, a + columns as u32 + 1);
        [[a, b, c], [a, c, d]]
    };
    (0..columns * rows).flat_map(quad)
}

/// Returns a capsule, or a ball if the ends coincide.
pub(super) fn capsule(a: Point3<f64>, b: Point3<f64>, radius: f64) -> Triangles {
    let axis = Unit::try_new(b - a, 0.0).unwrap_or_else(Vector3::y_axis);
    let side = if axis.y.abs() < 0.9 { Vector3::y() } else { Vector3::x() };
    let u = axis.cross(&side).normalize();
    let v = axis.cross(&u);
    let mut points = Vec::new();
    for ring in 0..=2 * RINGS + 1 {
        // The ring in the middle is there twice, at either end.
        let (center, step) = if ring <= RINGS { (a, ring) } else { (b, ring - 1) };
        let angle = std::f64::consts::FRAC_PI_2 * (step as f64 / RINGS as f64 - 1.0);
        for around in 0..=AROUND {
            let turn = std::f64::consts::TAU * (around % AROUND) as f64 / AROUND as f64;
            let out = angle.cos() * (turn.cos() * u + turn.sin() * v) + angle.sin() * axis.into_inner();
            points.push((center + radius * out).coords.into());
        }
    }
    (points, grid(AROUND, 2 * RINGS + 1, 0).collect())
}

/// Returns a box.
pub(super) fn cuboid(center: Point3<f64>, half: [f64; 3], rotation: Matrix3<f64>) -> Triangles {
    let (mut points, mut triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>) = Default::default();
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
        let first = points.len() as u32;
        for k in 0..(EDGE + 1) * (EDGE + 1) {
            let [along, across] =
                [k % (EDGE + 1), k / (EDGE + 1)].map(|k| 2.0 * k as f64 / EDGE as f64 - 1.0);
            let mut point = Vector3::zeros();
            point[axis] = sign * half[axis];
            point[(axis + 1) % 3] = sign * along * half[(axis + 1) % 3];
            point[(axis + 2) % 3] = across * half[(axis + 2) % 3];
            points.push((center + rotation * point).coords.into());
        }
        triangles.extend(grid(EDGE, EDGE, first));
    }
    (points, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume of a closed surface that turns to the left as seen from outside.
    fn volume((points, triangles): &Triangles) -> f64 {
        let tetrahedron = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| Vector3::from(points[corner as usize]));
            a.cross(&b).dot(&c) / 6.0
        };
        triangles.iter().map(tetrahedron).sum()
    }

    #[test]
    fn shapes_have_their_volumes_and_face_outwards() {
        let (a, b) = (Point3::new(1.0, 2.0, 3.0), Point3::new(1.0, 2.0, 7.0));
        let ball = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        // The shapes are inside of what they stand for: by a part of about (2 pi / AROUND)^2 / 4.
        assert!((volume(&capsule(a, a, 2.0)) / ball - 1.0).abs() < 0.01);
        let rod = ball + 4.0 * std::f64::consts::PI * 4.0;
        assert!((volume(&capsule(a, b, 2.0)) / rod - 1.0).abs() < 0.01);
        let turn = supple::euler_degrees([20.0, 30.0, 40.0]);
        assert!((volume(&cuboid(a, [1.0, 2.0, 3.0], turn)) - 48.0).abs() < 1e-9);
    }
}
