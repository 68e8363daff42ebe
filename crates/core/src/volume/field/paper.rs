//! The field of Takamatsu & Kanai (2009): unit normals at the boundary of the lattice, propagated inwards
//! layer by layer.

use nalgebra::Vector3;

use crate::volume::adjacency::{Adjacency, DIRECTIONS};

/// Computes the outward unit normal of each boundary vertex, in vertex order; zero for interior vertices.
///
/// `octants[i]` has bit `k` set iff the cell in octant `k` around vertex `i` is occupied. Octant `k` lies in
/// the direction `(k & 1, k >> 1 & 1, k >> 2 & 1)`, where 0 is the negative side. An interior vertex has all
/// eight bits.
///
/// The normal points away from the existing neighbors (Takamatsu & Kanai 2009): it is the sum of the missing
/// directions. That sum vanishes at concave edges, where no neighbor is missing, and where missing
/// directions cancel. There the normal is the first of these that does not vanish: the direction away from
/// the occupied octants, the mean normal of the neighbors, the direction away from the center of the
/// component, the first missing direction (x if there is none).
pub(super) fn boundary_normals(
    adjacency: &Adjacency,
    indices: &[[i32; 3]],
    octants: &[u8],
) -> Vec<Vector3<f64>> {
    let mut normals: Vec<Vector3<f64>> = (0..indices.len())
        .map(|i| match octants[i] {
            u8::MAX => Vector3::zeros(),
            occupied => unit(missing_directions(adjacency, i))
                .or_else(|| unit(empty_octants(occupied)))
                .unwrap_or_else(Vector3::zeros),
        })
        .collect();
    let vanished = |i: &usize| octants[*i] != u8::MAX && normals[*i] == Vector3::zeros();
    let undecided: Vec<usize> = (0..indices.len()).filter(vanished).collect();
    if undecided.is_empty() {
        return normals;
    }
    let centers = component_centers(adjacency, indices);
    let decided: Vec<Vector3<f64>> = undecided
        .iter()
        .map(|&i| {
            let mean = adjacency.linked(i).map(|j| normals[j]).sum();
            let away = position(indices[i]) - centers[adjacency.component(i)];
            unit(mean).or_else(|| unit(away)).unwrap_or_else(|| first_missing(adjacency, i))
        })
        .collect();
    for (i, normal) in undecided.into_iter().zip(decided) {
        normals[i] = normal;
    }
    normals
}

/// Normalizes `v`; `None` if it vanishes. The vectors here have small integer components or are sums of unit
/// vectors, so a length below the threshold of 1e-9 is rounding.
fn unit(v: Vector3<f64>) -> Option<Vector3<f64>> {
    v.try_normalize(1e-9)
}

/// Returns the sum of the directions without a neighbor.
fn missing_directions(adjacency: &Adjacency, i: usize) -> Vector3<f64> {
    (0..6).filter(|&side| !adjacency.has_neighbor(i, side)).map(|side| position(DIRECTIONS[side])).sum()
}

/// Returns the first direction without a neighbor; x if all neighbors exist.
fn first_missing(adjacency: &Adjacency, i: usize) -> Vector3<f64> {
    let side = (0..6).find(|&side| !adjacency.has_neighbor(i, side)).unwrap_or(1);
    position(DIRECTIONS[side])
}

/// Returns the sum of the directions of the empty octants.
fn empty_octants(occupied: u8) -> Vector3<f64> {
    let towards = |k: i32| Vector3::from([k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| f64::from(2 * bit - 1)));
    (0..8).filter(|k| occupied >> k & 1 == 0).map(towards).sum()
}

fn position(index: [i32; 3]) -> Vector3<f64> {
    Vector3::from(index.map(f64::from))
}

/// Returns the mean position of the vertices of each component.
fn component_centers(adjacency: &Adjacency, indices: &[[i32; 3]]) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); adjacency.components];
    for (i, &index) in indices.iter().enumerate() {
        let (sum, count) = &mut sums[adjacency.component(i)];
        *sum += position(index);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { sum }).collect()
}

/// Computes the field: each interior vertex gets the mean direction of its neighbors in the previous layer.
/// The length decreases from 1 at the boundary to 0 at the center.
///
/// * `depth`: number of links from the boundary to each vertex; `greatest`: the maximum in each component.
/// * `directions`: unit vectors at depth 0.
pub(super) fn fill(
    adjacency: &Adjacency,
    depth: &[u32],
    greatest: &[u32],
    mut directions: Vec<Vector3<f64>>,
) -> Vec<Vector3<f64>> {
    let mut inwards: Vec<usize> = (0..adjacency.len()).filter(|&i| depth[i] > 0).collect();
    inwards.sort_by_key(|&i| depth[i]);
    for i in inwards {
        let before = adjacency.linked(i).filter(|&j| depth[j] < depth[i]);
        // Directions from opposite sides can cancel: such a vertex does not move.
        directions[i] = unit(before.map(|j| directions[j]).sum()).unwrap_or_else(Vector3::zeros);
    }
    for (i, direction) in directions.iter_mut().enumerate() {
        let greatest = f64::from(greatest[adjacency.component(i)].max(1));
        *direction *= 1.0 - f64::from(depth[i]) / greatest;
    }
    directions
}
