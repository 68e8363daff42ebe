//! The triangles of the faces of the uncut mesh.
//!
//! A mesh defines a face as the fan of triangles from its first corner. In the fan of a concave face, triangles can be
//! turned over and lie outside of the face, and so would the parts of them that a cut leaves. Ears take their place where
//! they enclose the same volume.

use std::borrow::Cow;

use nalgebra::{Point3, Vector3};

use super::triangulate::{Planar, triangulate};
use crate::mesh::Mesh;

/// Greatest change of the volume by the ears of all faces, relative to the volume of the mesh. The faces share it by their
/// areas. In a flat face both kinds of triangles enclose the same volume up to rounding, which is below this limit unless
/// the mesh is about a thousand times as wide as it is thick.
const VOLUME_CHANGE: f64 = 1e-13;

/// Triangles of a face with n corners: n - 2, as those of its fan.
struct Ears {
    face: usize,
    triangles: Vec<[u32; 3]>,
}

/// Returns the triangles of all faces, as many for each face and in the same order as [`Mesh::triangles`]: ears for
/// concave faces, and the fans of all others and of concave faces that are not flat.
pub(super) fn face_triangles(mesh: &Mesh) -> Cow<'_, [[u32; 3]]> {
    let concave: Vec<Ears> =
        mesh.faces().enumerate().filter_map(|(face, corners)| ears(mesh, face, corners)).collect();
    if concave.is_empty() {
        return Cow::Borrowed(mesh.triangles());
    }
    let area = |triangle: &[u32; 3]| doubled_area(mesh, *triangle).norm();
    let total: f64 = mesh.triangles().iter().map(area).sum();
    let limit = VOLUME_CHANGE * mesh.signed_volume().abs() / total;
    let mut triangles = mesh.triangles().to_vec();
    let mut concave = concave.iter().peekable();
    let mut first = 0;
    for (face, corners) in mesh.faces().enumerate() {
        let end = first + corners.len().saturating_sub(2);
        if let Some(ears) = concave.next_if(|ears| ears.face == face) {
            let own: f64 = ears.triangles.iter().map(area).sum();
            if volume_beyond(mesh, &ears.triangles, corners[0]) <= limit * own {
                triangles[first..end].copy_from_slice(&ears.triangles);
            }
        }
        first = end;
    }
    Cow::Owned(triangles)
}

/// Returns the ears of a face; `None` if no triangle of its fan is turned over, or one of its ears is.
fn ears(mesh: &Mesh, face: usize, corners: &[u32]) -> Option<Ears> {
    let normal: Vector3<f64> = fan(corners).map(|triangle| doubled_area(mesh, triangle)).sum();
    let is_turned = |triangle: [u32; 3]| doubled_area(mesh, triangle).dot(&normal) < 0.0;
    if !fan(corners).any(is_turned) {
        return None;
    }
    let normal = normal.normalize();
    let u = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let v = normal.cross(&u);
    let start = at(mesh, corners[0]);
    let planar = |&corner: &u32| -> Planar {
        let offset = at(mesh, corner) - start;
        [u.dot(&offset), v.dot(&offset)]
    };
    let ears = triangulate(&corners.iter().map(planar).collect::<Vec<_>>());
    let triangles: Vec<_> = ears.into_iter().map(|ear| ear.map(|corner| corners[corner])).collect();
    (!triangles.iter().copied().any(is_turned)).then_some(Ears { face, triangles })
}

fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners.windows(2).skip(1).map(|edge| [corners[0], edge[0], edge[1]])
}

fn at(mesh: &Mesh, vertex: u32) -> Point3<f64> {
    mesh.vertices()[vertex as usize]
}

/// Returns twice the area of a triangle, times its unit normal.
fn doubled_area(mesh: &Mesh, triangle: [u32; 3]) -> Vector3<f64> {
    let [a, b, c] = triangle.map(|corner| at(mesh, corner));
    (b - a).cross(&(c - a))
}

/// Returns the magnitude of the volume between triangles of a face and its fan from a corner: that of the tetrahedra from
/// this corner to the triangles.
fn volume_beyond(mesh: &Mesh, triangles: &[[u32; 3]], first: u32) -> f64 {
    let start = at(mesh, first);
    let volume =
        |triangle: &[u32; 3]| (at(mesh, triangle[0]) - start).dot(&doubled_area(mesh, *triangle)) / 6.0;
    triangles.iter().map(volume).sum::<f64>().abs()
}
