//! Finds faces that repeat an earlier face: a face with the same welded corners in the same cyclic order, in the same
//! or in the opposite direction. The surface has each of them once.

use std::cmp::Ordering;

use super::csr::Csr;
use super::polygons::Mesh;
use super::weld::is_degenerate;

/// The faces that repeat others.
#[derive(Debug, Default)]
pub(super) struct Repeated {
    /// Number of faces that have the same direction as the earlier face.
    pub(super) duplicate: usize,
    /// Number of faces that have the opposite direction of the earlier face.
    pub(super) two_sided: usize,
    /// The use of each face in the surface. Empty if no face is repeated.
    pub(super) uses: Vec<Use>,
}

/// The use of a face in the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// The surface has it.
    Kept,
    /// The surface has it in the opposite direction.
    Flipped,
    /// The surface does not have it.
    Left,
}

impl Repeated {
    /// Returns the use of a face in the surface.
    pub(super) fn of(&self, face: usize) -> Use {
        self.uses.get(face).copied().unwrap_or(Use::Kept)
    }
}

/// The canonical form of a face: the lexicographically least of all rotations of its list of welded corners
/// and of the reversed list.
struct Canonical {
    face: u32,
    /// Index of the first corner of the form in the array of corners of all forms.
    start: u32,
    /// Number of corners.
    len: u32,
    /// Whether the form is a rotation of the reversed list.
    reversed: bool,
}

/// Faces with the same canonical form.
struct Group {
    /// The first face.
    first: u32,
    /// The other faces.
    others: Vec<u32>,
    /// Whether the faces have both directions.
    is_two_sided: bool,
    /// Whether as many faces have the one direction as the other: they enclose nothing.
    is_balanced: bool,
}

/// Finds the repeated faces. Degenerate faces are ignored.
///
/// Of faces that are there several times the surface has the first one, in the direction that fits its neighbors.
/// Where a component of the surface is closed only without its two-sided faces, as one with a wall inside, it has
/// none of them.
pub(super) fn find(mesh: &Mesh) -> Repeated {
    let mut repeated = Repeated::default();
    let groups = groups(mesh, &mut repeated);
    if groups.is_empty() || mesh.is_cut {
        return repeated;
    }
    repeated.uses = vec![Use::Kept; mesh.face_count()];
    for group in &groups {
        group.others.iter().for_each(|&other| repeated.uses[other as usize] = Use::Left);
    }
    if groups.iter().any(|group| group.is_two_sided) {
        orient(mesh, &groups, &mut repeated.uses);
        remove_walls(mesh, &groups, &mut repeated.uses);
    }
    repeated
}

/// Finds the groups of several faces, and counts the repeated faces.
fn groups(mesh: &Mesh, repeated: &mut Repeated) -> Vec<Group> {
    let mut corners = Vec::with_capacity(mesh.corners().len());
    let mut faces = Vec::with_capacity(mesh.face_count());
    let mut backward = Vec::new();
    for (index, face) in mesh.faces().enumerate() {
        if is_degenerate(face, mesh.weld()) {
            continue;
        }
        let start = corners.len();
        corners.extend(face.iter().map(|&corner| mesh.weld()[corner as usize]));
        let reversed = make_canonical(&mut corners[start..], &mut backward);
        faces.push(Canonical { face: index as u32, start: start as u32, len: face.len() as u32, reversed });
    }
    let key = |face: &Canonical| &corners[face.start as usize..(face.start + face.len) as usize];
    let order = |a: &Canonical, b: &Canonical| -> Ordering { key(a).cmp(key(b)) };
    // The sort is stable, so the first of equal faces is the earliest.
    faces.sort_by(order);
    let mut groups = Vec::new();
    for equal in faces.chunk_by(|a, b| order(a, b).is_eq()).filter(|equal| equal.len() > 1) {
        let (first, others) = (&equal[0], &equal[1..]);
        let opposite = others.iter().filter(|face| face.reversed != first.reversed).count();
        repeated.two_sided += opposite;
        repeated.duplicate += others.len() - opposite;
        groups.push(Group {
            first: first.face,
            others: others.iter().map(|face| face.face).collect(),
            is_two_sided: opposite > 0,
            is_balanced: 2 * opposite == equal.len(),
        });
    }
    groups
}

/// Gives the first faces of two-sided groups the directions that fit their neighbors: the other faces, or
/// the first face of each component that has only two-sided faces.
fn orient(mesh: &Mesh, groups: &[Group], uses: &mut [Use]) {
    let mut is_free = vec![false; uses.len()];
    groups.iter().filter(|group| group.is_two_sided).for_each(|group| is_free[group.first as usize] = true);
    // Pairs of faces at an edge, and whether the edge has the same direction in both.
    let edges = directed_edges(mesh, |face| uses[face] != Use::Left);
    let mut pairs = Vec::new();
    for edge in (0..edges.len()).flat_map(|low| edges.row(low).chunk_by(|a, b| a.0 == b.0)) {
        if let &[(_, a, a_forward), (_, b, b_forward)] = edge {
            pairs.extend([(a, (b, a_forward == b_forward)), (b, (a, a_forward == b_forward))]);
        }
    }
    let neighbors = Csr::sorted(uses.len(), pairs.iter().copied());
    // Faces with a fixed direction come first.
    let seeds = (0..uses.len() as u32).filter(|&face| !is_free[face as usize]);
    let mut stack: Vec<u32> = seeds.collect();
    for next in 0..uses.len() as u32 {
        while let Some(face) = stack.pop() {
            for &(other, is_same) in neighbors.row(face as usize) {
                if std::mem::take(&mut is_free[other as usize]) {
                    let is_flipped = (uses[face as usize] == Use::Flipped) != is_same;
                    uses[other as usize] = if is_flipped { Use::Flipped } else { Use::Kept };
                    stack.push(other);
                }
            }
        }
        if std::mem::take(&mut is_free[next as usize]) {
            stack.push(next);
        }
    }
}

/// Leaves out all two-sided faces of the components of the surface that are closed without them, but not with them.
fn remove_walls(mesh: &Mesh, groups: &[Group], uses: &mut [Use]) {
    let mut is_wall = vec![false; uses.len()];
    groups.iter().filter(|group| group.is_balanced).for_each(|group| is_wall[group.first as usize] = true);
    let weld = mesh.weld();
    let (count, labels) = mesh.face_components();
    let label =
        |face: usize| mesh.face(face).first().map(|&corner| labels[weld[corner as usize] as usize] as usize);
    // Whether each component is open.
    let open = |is_used: &dyn Fn(usize) -> bool, uses: &[Use]| {
        let mut is_open = vec![false; count];
        let edges = directed_edges(mesh, is_used);
        for low in 0..edges.len() {
            for edge in edges.row(low).chunk_by(|a, b| a.0 == b.0) {
                let forward = edge
                    .iter()
                    .filter(|(_, face, forward)| *forward != (uses[*face as usize] == Use::Flipped));
                is_open[labels[low] as usize] |= 2 * forward.count() != edge.len();
            }
        }
        is_open
    };
    let with_walls = open(&|face| uses[face] != Use::Left, uses);
    let without_walls = open(&|face| uses[face] != Use::Left && !is_wall[face], uses);
    let mut has_others = vec![false; count];
    for face in (0..uses.len()).filter(|&face| uses[face] != Use::Left && !is_wall[face]) {
        label(face).into_iter().for_each(|label| has_others[label] = true);
    }
    for face in (0..uses.len()).filter(|&face| is_wall[face]) {
        if label(face).is_some_and(|label| has_others[label] && with_walls[label] && !without_walls[label]) {
            uses[face] = Use::Left;
        }
    }
}

/// Returns the edges of faces between different welded vertices: for each lower vertex, sorted, the higher vertex, the
/// face, and whether the edge leads to the higher vertex.
fn directed_edges(mesh: &Mesh, is_used: impl Fn(usize) -> bool) -> Csr<(u32, u32, bool)> {
    let weld = mesh.weld();
    let of_face = |(index, face): (usize, &[u32])| {
        let corners: Vec<u32> = face.iter().map(|&corner| weld[corner as usize]).collect();
        let next = |k: usize| corners[(k + 1) % corners.len()];
        let edges = (0..corners.len()).map(|k| (corners[k], next(k))).filter(|(from, to)| from != to);
        edges.map(|(from, to)| (from.min(to), (from.max(to), index as u32, from < to))).collect::<Vec<_>>()
    };
    let used = mesh.faces().enumerate().filter(|(index, _)| is_used(*index));
    let edges: Vec<_> = used.flat_map(of_face).collect();
    let mut edges = Csr::sorted(weld.len(), edges.iter().copied());
    (0..edges.len()).for_each(|low| edges.row_mut(low).sort_unstable());
    edges
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
