//! Surfaces of colliders that are no meshes, in the coordinates of their shape: see [`local`](super::local).

use nalgebra::Vector3;
use supple::Shape;

/// Vertices and faces, counter-clockwise seen from outside.
pub(crate) type Faces = (Vec<[f64; 3]>, Vec<Vec<u32>>);

/// How finely shapes are divided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Divisions {
    /// Number of parts of a turn about the axis of a sphere or a capsule.
    pub(crate) around: usize,
    /// Number of parts of a quarter turn from its equator to a pole.
    pub(crate) quarter: usize,
    /// Number of parts of an edge of a box.
    pub(crate) edge: usize,
}

/// Returns the surface of a shape; `None` for a mesh. A plane, which has no end, is a square.
pub(crate) fn faces(shape: &Shape, divisions: Divisions) -> Option<Faces> {
    match shape {
        Shape::Plane { .. } => Some(square()),
        Shape::Sphere { radius, .. } => Some(rounded(*radius, 0.0, divisions)),
        Shape::Box { .. } => Some(cuboid(divisions.edge)),
        Shape::Capsule { a, b, radius } => {
            Some(rounded(*radius, (Vector3::from(*b) - Vector3::from(*a)).norm(), divisions))
        }
        Shape::Mesh { .. } => None,
    }
}

fn square() -> Faces {
    let vertices = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    (vertices, vec![vec![0, 1, 2, 3]])
}

/// Returns a box with half extents of 1, whose sides have vertices of their own.
fn cuboid(edge: usize) -> Faces {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let row = edge + 1;
    for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        let first = vertices.len();
        for k in 0..row * row {
            let [u, v] = [k % row, k / row].map(|k| 2.0 * k as f64 / edge as f64 - 1.0);
            let mut vertex = [0.0; 3];
            // The order of the corners turns about the axis that points outwards.
            (vertex[axis], vertex[(axis + 1) % 3], vertex[(axis + 2) % 3]) = (side, side * u, v);
            vertices.push(vertex);
        }
        faces.extend((0..edge * edge).map(|k| {
            let corner = first + k / edge * row + k % edge;
            [corner, corner + 1, corner + row + 1, corner + row].map(|corner| corner as u32).to_vec()
        }));
    }
    (vertices, faces)
}

/// Returns a capsule along z: the points at a distance of a radius from a segment of a length.
fn rounded(radius: f64, length: f64, Divisions { around, quarter, .. }: Divisions) -> Faces {
    let mut vertices = Vec::new();
    let turn = std::f64::consts::TAU / around as f64;
    let part = std::f64::consts::FRAC_PI_2 / quarter as f64;
    // The rings of the lower half and those of the upper one, which share the equator of a sphere; poles are points.
    let second = if length > 0.0 { quarter } else { quarter + 1 };
    let heights = (1..=quarter).map(|k| (k, -0.5)).chain((second..2 * quarter).map(|k| (k, 0.5)));
    for (k, half) in heights {
        let angle = part * k as f64 - std::f64::consts::FRAC_PI_2;
        let (ring, z) = (radius * angle.cos(), radius * angle.sin() + half * length);
        for k in 0..around {
            let angle = turn * k as f64;
            vertices.push([ring * angle.cos(), ring * angle.sin(), z]);
        }
    }
    let rings = vertices.len() / around;
    let (lower, upper) = (vertices.len() as u32, vertices.len() as u32 + 1);
    vertices.extend([-1.0, 1.0].map(|side| [0.0, 0.0, side * (radius + 0.5 * length)]));
    let at = |ring: usize, k: usize| (ring * around + k % around) as u32;
    let mut faces = Vec::new();
    for k in 0..around {
        faces.push(vec![lower, at(0, k + 1), at(0, k)]);
        faces.push(vec![upper, at(rings - 1, k), at(rings - 1, k + 1)]);
        faces.extend(
            (1..rings).map(|ring| vec![at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)]),
        );
    }
    (vertices, faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collider::local;
    use supple::Mesh;

    /// Volume of the surface of a shape where it stands, positive if the faces are counter-clockwise seen from outside.
    fn volume(shape: &Shape) -> f64 {
        let (vertices, faces) = faces(shape, Divisions { around: 64, quarter: 16, edge: 12 }).unwrap();
        let placed = vertices.into_iter().map(|vertex| local(shape).transform_point(&vertex.into()).into());
        Mesh::new(placed.collect(), &faces).unwrap().signed_volume()
    }

    #[test]
    fn shapes_have_their_volumes_and_face_outwards() {
        let (a, b, radius) = ([1.0, 2.0, 3.0], [1.0, 2.0, 7.0], 2.0);
        let ball = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        // The shapes are inside of what they stand for: by a part of about (2 pi / around)^2 / 4.
        assert!((volume(&Shape::Sphere { center: a, radius }) / ball - 1.0).abs() < 0.01);
        let rod = ball + 4.0 * std::f64::consts::PI * 4.0;
        assert!((volume(&Shape::Capsule { a, b, radius }) / rod - 1.0).abs() < 0.01);
        let cuboid = Shape::Box { center: a, half_extents: [1.0, 2.0, 3.0], rotate: [20.0, 30.0, 40.0] };
        assert!((volume(&cuboid) - 48.0).abs() < 1e-9);
    }
}
