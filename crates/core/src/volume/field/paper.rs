//! The field of Takamatsu & Kanai (2009), from the lattice alone: unit normals at the boundary, and the interior layer
//! by layer from there inwards.

use nalgebra::Vector3;

use crate::volume::adjacency::{Adjacency, DIRECTIONS};

/// The outward unit normal at each boundary vertex, in vertex order; zero at interior ones.
///
/// `octants[i]` has bit `k` set iff the cell around vertex `i` in octant `k` is occupied (octant `k` lies towards
/// `(k & 1, k >> 1 & 1, k >> 2 & 1)`, 0 being the negative side); an interior vertex has all eight.
///
/// The normal points away from the existing neighbours (Takamatsu & Kanai 2009), which is the sum of the missing
/// directions. That sum vanishes at concave edges and in parts that are thin in both directions of an axis. What
/// takes its place there, first that does not vanish: away from the occupied octants; the mean normal of the
/// neighbours; away from the middle of the component; the first missing direction, or x.
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
    let middles = middles(adjacency, indices);
    let decided: Vec<Vector3<f64>> = undecided
        .iter()
        .map(|&i| {
            let mean = adjacency.linked(i).map(|j| normals[j]).sum();
            let away = position(indices[i]) - middles[adjacency.component(i)];
            unit(mean).or_else(|| unit(away)).unwrap_or_else(|| first_missing(adjacency, i))
        })
        .collect();
    for (i, normal) in undecided.into_iter().zip(decided) {
        normals[i] = normal;
    }
    normals
}

/// `v` at length one; none if it vanishes. The vectors here are small integers or means of unit vectors, so that
/// what is below the threshold is rounding.
fn unit(v: Vector3<f64>) -> Option<Vector3<f64>> {
    v.try_normalize(1e-9)
}

fn missing_directions(adjacency: &Adjacency, i: usize) -> Vector3<f64> {
    (0..6).filter(|&side| !adjacency.has(i, side)).map(|side| position(DIRECTIONS[side])).sum()
}

fn first_missing(adjacency: &Adjacency, i: usize) -> Vector3<f64> {
    let side = (0..6).find(|&side| !adjacency.has(i, side)).unwrap_or(1);
    position(DIRECTIONS[side])
}

fn empty_octants(occupied: u8) -> Vector3<f64> {
    let towards = |k: i32| Vector3::from([k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| f64::from(2 * bit - 1)));
    (0..8).filter(|k| occupied >> k & 1 == 0).map(towards).sum()
}

fn position(index: [i32; 3]) -> Vector3<f64> {
    Vector3::from(index.map(f64::from))
}

fn middles(adjacency: &Adjacency, indices: &[[i32; 3]]) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); adjacency.components];
    for (i, &index) in indices.iter().enumerate() {
        let (sum, count) = &mut sums[adjacency.component(i)];
        *sum += position(index);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { sum }).collect()
}

/// Gives each inner vertex the mean direction of its neighbours in the layer before. The length falls from 1 at the
/// boundary to 0 at the center.
///
/// * `depth`: layers from the boundary to each vertex; `greatest`: the most in each component.
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
        // Opposite walls can cancel: such a vertex stays where it is.
        directions[i] = unit(before.map(|j| directions[j]).sum()).unwrap_or_else(Vector3::zeros);
    }
    for (i, direction) in directions.iter_mut().enumerate() {
        let greatest = f64::from(greatest[adjacency.component(i)].max(1));
        *direction *= 1.0 - f64::from(depth[i]) / greatest;
    }
    directions
}
