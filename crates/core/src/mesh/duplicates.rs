//! Faces that occur twice, in the same or in opposite directions.

use std::cmp::Ordering;

use super::{Mesh, is_degenerate};

/// How many faces repeat an earlier one.
#[derive(Debug, Default)]
pub(super) struct Repeated {
    pub(super) duplicate: usize,
    pub(super) two_sided: usize,
}

/// A face rotated and, if need be, reversed to the smallest sequence of welded corners that describes it.
struct Canonical {
    start: u32,
    len: u32,
    reversed: bool,
}

/// Counts repeated faces among those that are not degenerate.
pub(super) fn count(mesh: &Mesh) -> Repeated {
    let mut corners = Vec::with_capacity(mesh.corners().len());
    let mut faces = Vec::with_capacity(mesh.face_count());
    let mut turned = Vec::new();
    for face in mesh.faces() {
        if is_degenerate(face, mesh.weld()) {
            continue;
        }
        let start = corners.len();
        corners.extend(face.iter().map(|&corner| mesh.weld()[corner as usize]));
        let reversed = make_canonical(&mut corners[start..], &mut turned);
        faces.push(Canonical { start: start as u32, len: face.len() as u32, reversed });
    }
    let key = |face: &Canonical| &corners[face.start as usize..(face.start + face.len) as usize];
    let order = |a: &Canonical, b: &Canonical| -> Ordering { key(a).cmp(key(b)) };
    // Stable: equal faces keep their order, so that the first of them is the earlier one.
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

/// Turns `face` into the smallest of its rotations in both directions; returns whether that one is reversed.
fn make_canonical(face: &mut [u32], turned: &mut Vec<u32>) -> bool {
    turned.clear();
    turned.extend(face.iter().rev());
    rotate_smallest(face);
    rotate_smallest(turned);
    let reversed = *turned.as_slice() < *face;
    if reversed {
        face.copy_from_slice(turned);
    }
    reversed
}

/// The lexicographically least rotation (Booth 1980 in the two-pointer form of Shiloach): linear also where corners
/// repeat.
fn rotate_smallest(face: &mut [u32]) {
    let n = face.len();
    let (mut i, mut j, mut k) = (0, 1, 0);
    while i < n && j < n && k < n {
        match face[(i + k) % n].cmp(&face[(j + k) % n]) {
            Ordering::Equal => k += 1,
            unequal => {
                let loser = if unequal == Ordering::Greater { &mut i } else { &mut j };
                *loser += k + 1;
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
    fn rotations_have_one_smallest_form() {
        for face in
            [vec![3, 1, 2], vec![2, 1, 2, 1, 1], vec![5, 5, 5, 4], vec![1, 2, 1, 2], vec![7, 0, 7, 0, 3]]
        {
            let rotations = |face: &[u32]| {
                let face = face.to_vec();
                (0..face.len()).map(move |by| {
                    let mut rotated = face.clone();
                    rotated.rotate_left(by);
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
