//! Computes the field of Takamatsu & Kanai (2009): unit normals at the boundary vertices of the lattice,
//! extended inwards layer by layer.

use nalgebra::Vector3;

use crate::mesh::Csr;
use crate::volume::adjacency::{Adjacency, DIRECTIONS};

/// Computes the outward unit normal of each boundary vertex, in vertex order; zero for interior vertices.
///
/// `octants`: occupied cells around each vertex; see [`octants`](crate::volume::adjacency::octants). An
/// interior vertex has all eight bits.
///
/// The normal points away from the existing neighbors (Takamatsu & Kanai 2009): it is the normalized sum of
/// the missing directions, that is, the directions along the axes without a neighbor. The sum vanishes at
/// concave edges, where no neighbor is missing, and where missing directions cancel. The normal is then the
/// first of the following vectors that does not vanish, normalized:
///
/// 1. the sum of the directions of the empty octants,
/// 2. the sum of the normals of the neighbors,
/// 3. the direction away from the center of the component,
/// 4. the first missing direction; +x if no direction is missing.
pub(super) fn boundary_normals(
    adjacency: &Adjacency,
    indices: &[[i32; 3]],
    octants: &[u8],
) -> Vec<Vector3<f64>> {
    let mut normals: Vec<Vector3<f64>> = (0..indices.len())
        .map(|i| match octants[i] {
            u8::MAX => Vector3::zeros(),
            occupied => normalized(missing_directions(adjacency, i))
                .or_else(|| normalized(empty_octants(occupied)))
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
            let neighbor_sum = adjacency.linked(i).map(|j| normals[j]).sum();
            let from_center = to_vector(indices[i]) - centers[adjacency.component(i)];
            normalized(neighbor_sum)
                .or_else(|| normalized(from_center))
                .unwrap_or_else(|| first_missing_direction(adjacency, i))
        })
        .collect();
    for (i, normal) in undecided.into_iter().zip(decided) {
        normals[i] = normal;
    }
    normals
}

/// Returns `v`, normalized; `None` if `v` vanishes. The vectors here have small integer components or are
/// sums of unit vectors, so a length below the threshold of 1e-9 is a rounding error.
fn normalized(v: Vector3<f64>) -> Option<Vector3<f64>> {
    v.try_normalize(1e-9)
}

/// Returns the sum of the missing directions of vertex `i`.
fn missing_directions(adjacency: &Adjacency, i: usize) -> Vector3<f64> {
    (0..6).filter(|&side| !adjacency.has_neighbor(i, side)).map(|side| to_vector(DIRECTIONS[side])).sum()
}

/// Returns the first missing direction of vertex `i`; +x if all neighbors exist.
fn first_missing_direction(adjacency: &Adjacency, i: usize) -> Vector3<f64> {
    let side = (0..6).find(|&side| !adjacency.has_neighbor(i, side)).unwrap_or(1);
    to_vector(DIRECTIONS[side])
}

/// Returns the sum of the directions of the empty octants. `occupied`: bit mask of the occupied octants.
fn empty_octants(occupied: u8) -> Vector3<f64> {
    let direction = |k: i32| Vector3::from([k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| f64::from(2 * bit - 1)));
    (0..8).filter(|k| occupied >> k & 1 == 0).map(direction).sum()
}

/// Converts an integer vector to floating-point numbers.
fn to_vector(index: [i32; 3]) -> Vector3<f64> {
    Vector3::from(index.map(f64::from))
}

/// Returns the mean position of the vertices of each component, in cells.
fn component_centers(adjacency: &Adjacency, indices: &[[i32; 3]]) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); adjacency.component_count];
    for (i, &index) in indices.iter().enumerate() {
        let (sum, count) = &mut sums[adjacency.component(i)];
        *sum += to_vector(index);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { sum }).collect()
}

/// Computes the field. An interior vertex gets the mean direction of its neighbors in the previous layer,
/// that is, one link nearer to the boundary. The length decreases from 1 at the boundary to 0 at the center.
///
/// * `depth`: number of links from the boundary to each vertex.
/// * `greatest_depth`: greatest depth in each component.
/// * `directions`: normals of the boundary vertices, which have depth 0.
pub(super) fn fill(
    adjacency: &Adjacency,
    depth: &[u32],
    greatest_depth: &[u32],
    mut directions: Vec<Vector3<f64>>,
) -> Vec<Vector3<f64>> {
    let layers = greatest_depth.iter().fold(0, |layers, &depth| layers.max(depth)) as usize + 1;
    let by_depth = Csr::sorted(layers, depth.iter().copied().zip(0_u32..));
    for &i in by_depth.rows().skip(1).flatten() {
        let i = i as usize;
        let previous_layer = adjacency.linked(i).filter(|&j| depth[j] < depth[i]);
        // Directions from opposite sides can cancel. Such a vertex does not move.
        let sum = previous_layer.map(|j| directions[j]).sum();
        directions[i] = normalized(sum).unwrap_or_else(Vector3::zeros);
    }
    for (i, direction) in directions.iter_mut().enumerate() {
        let greatest = f64::from(greatest_depth[adjacency.component(i)].max(1));
        *direction *= 1.0 - f64::from(depth[i]) / greatest;
    }
    directions
}
