//! Counts the faces that repeat an earlier face: a face with the same welded corners in the same cyclic
//! order, in the same or in the opposite direction.

use std::cmp::Ordering;

use super::{Mesh, is_degenerate};

/// Numbers of faces that repeat an earlier face.
#[derive(Debug, Default)]
pub(super) struct Repeated {
    /// Number of faces that have the same direction as the earlier face.
    pub(super) duplicate: usize,
    /// Number of faces that have the opposite direction of the earlier face.
    pub(super) two_sided: usize,
}

/// The canonical form of a face: the lexicographically least of all rotations of its list of welded corners
/// and of the reversed list.
struct Canonical {
    /// Index of the first corner of the form in the array of corners of all forms.
    start: u32,
    /// Number of corners.
    len: u32,
    /// Whether the form is a rotation of the reversed list.
    reversed: bool,
}

/// Counts the repeated faces. Degenerate faces are ignored.
pub(super) fn count(mesh: &Mesh) -> Repeated {
    let mut corners = Vec::with_capacity(mesh.corners().len());
    let mut faces = Vec::with_capacity(mesh.face_count());
    let mut backward = Vec::new();
    for face in mesh.faces() {
        if is_degenerate(face, mesh.weld()) {
            continue;
        }
        let start = corners.len();
        corners.extend(face.iter().map(|&corner| mesh.weld()[corner as usize]));
        let reversed = make_canonical(&mut corners[start..], &mut backward);
        faces.push(Canonical { start: start as u32, len: face.len() as u32, reversed });
    }
    let key = |face: &Canonical| &corners[face.start as usize..(face.start + face.len) as usize];
    let order = |a: &Canonical, b: &Canonical| -> Ordering { key(a).cmp(key(b)) };
    // The sort is stable, so the first of equal faces is the earliest.
    faces.sort_by(order);
    let mut repeated = Repeated::default();
    for equal in faces.chunk_by(|a, b| order(a, b).is_eq()) {
        for face in &equal[1..] {
            if face.reversed == equal[0].reversed {
                repeated.duplicate += 1;
            } else {
                repeated.two_sided += 1;
            }
        }
    }
    repeated
}

/// Converts `face` to its canonical form and returns whether the form is reversed. `backward`: scratch.
fn make_canonical(face: &mut [u32], backward: &mut Vec<u32>) -> bool {
    backward.clear();
    backward.extend(face.iter().rev());
    rotate_smallest(face);
    rotate_smallest(backward);
    let reversed = *backward.as_slice() < *face;
    if reversed {
        face.copy_from_slice(backward);
    }
    reversed
}

/// Rotates `face` to its lexicographically least rotation (Booth 1980; two-pointer form of Shiloach).
///
/// Takes linear time even if corners repeat.
fn rotate_smallest(face: &mut [u32]) {
    let n = face.len();
    let (mut i, mut j, mut k) = (0, 1, 0);
    while i < n && j < n && k < n {
        match face[(i + k) % n].cmp(&face[(j + k) % n]) {
            Ordering::Equal => k += 1,
            unequal => {
                let start = if unequal == Ordering::Greater { &mut i } else { &mut j };
                *start += k + 1;
                k = 0;
                if i == j {
                    j += 1;
                }
            }
        }
    }
    face.rotate_left(i.min(j));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotate_smallest_returns_the_least_of_all_rotations() {
        for face in
            [vec![3, 1, 2], vec![2, 1, 2, 1, 1], vec![5, 5, 5, 4], vec![1, 2, 1, 2], vec![7, 0, 7, 0, 3]]
        {
            let rotations = |face: &[u32]| {
                let face = face.to_vec();
                (0..face.len()).map(move |steps| {
                    let mut rotated = face.clone();
                    rotated.rotate_left(steps);
                    rotated
                })
            };
            let smallest = rotations(&face).min().unwrap();
            for mut rotated in rotations(&face) {
                rotate_smallest(&mut rotated);
                assert_eq!(rotated, smallest);
            }
        }
    }
}
