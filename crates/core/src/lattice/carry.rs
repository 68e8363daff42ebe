//! Carries the values of a map of the surface to the vertices of a lattice.

use nalgebra::{Point3, Vector3};

use super::embedding::Locator;
use super::{Lattice, trilinear};
use crate::mesh::{Mesh, distinct};

/// Greatest distance of neighboring samples of a triangle, in cells.
const SPACING: f64 = 0.5;
/// Greatest number of samples along the longest edge of a triangle, and of strips.
const MAX_ROWS: f64 = 10_000.0;
/// Sweeps of over-relaxation for each layer of vertices inside: they reduce the error of the first means by about 1e-5.
const SWEEPS: usize = 4;

/// The value of each lattice vertex for a map of a mesh that the lattice covers.
///
/// The value of a vertex of a cell that the surface meets is the mean of the map over the surface around it: with the
/// area, and the trilinear weight of the vertex in its cell. In a face the map is linear. Any other vertex has the mean of
/// its neighbors, so that a map that is linear in space stays linear inside. The values depend on neither the size nor the
/// order of the faces, and they are within the range of the map. Vertices of parts without a surface have 0.
///
/// * `values`: one for each vertex of the mesh.
pub(crate) fn carried(lattice: &Lattice, mesh: &Mesh, values: &[f32]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); lattice.len()];
    let mut locator = Locator::new(lattice);
    for triangle in mesh.triangles() {
        let corners = triangle.map(|corner| mesh.vertices()[corner as usize]);
        let of_corners = triangle.map(|corner| f64::from(values[corner as usize]));
        for (weights, area) in samples(&corners, SPACING * lattice.cell_size()) {
            let blend = |part: &dyn Fn(usize) -> f64| (0..3).map(|k| weights[k] * part(k)).sum::<f64>();
            let point = Point3::from(Vector3::from_fn(|axis, _| blend(&|k| corners[k][axis])));
            let value = blend(&|k| of_corners[k]);
            let (cell, local) = locator.locate(&point);
            for (corner, weight) in lattice.cell_corners(cell).into_iter().zip(trilinear::weights(local)) {
                // Points outside of all cells have weights below 0.
                let weight = f64::from(weight).max(0.0) * area;
                let (sum, total) = &mut sums[corner as usize];
                *sum += weight * value;
                *total += weight;
            }
        }
    }
    let of_surface = sums.into_iter().map(|(sum, total)| (total > 0.0).then(|| sum / total));
    inwards(lattice, of_surface.collect())
}

/// Returns the values of all vertices: a vertex without one has the mean of its neighbors.
///
/// The values begin as means layer by layer, and then successive over-relaxation (Young 1954) makes them harmonic, with the
/// best factor of a cube that is as many layers deep.
fn inwards(lattice: &Lattice, mut values: Vec<Option<f64>>) -> Vec<f64> {
    let neighbors = lattice.neighbor_table();
    // A missing neighbor is the vertex itself.
    let of = |vertex: u32| neighbors[vertex as usize].into_iter().filter(move |&other| other != vertex);
    let mean = |vertex: u32, value: &dyn Fn(u32) -> Option<f64>| {
        let (sum, count) =
            of(vertex).filter_map(value).fold((0.0, 0.0), |(s, n), value| (s + value, n + 1.0));
        sum / count
    };
    let mut layer: Vec<u32> = (0..lattice.len() as u32).filter(|&v| values[v as usize].is_some()).collect();
    let (mut inner, mut layers) = (Vec::new(), 0);
    while !layer.is_empty() {
        let beside = layer.iter().flat_map(|&vertex| of(vertex));
        let next = distinct(beside.filter(|&vertex| values[vertex as usize].is_none()));
        let means: Vec<f64> =
            next.iter().map(|&vertex| mean(vertex, &|other| values[other as usize])).collect();
        next.iter().zip(means).for_each(|(&vertex, mean)| values[vertex as usize] = Some(mean));
        layers += usize::from(!next.is_empty());
        inner.extend_from_slice(&next);
        layer = next;
    }
    let mut values: Vec<f64> = values.into_iter().map(Option::unwrap_or_default).collect();
    let range = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)));
    inner.sort_unstable();
    let factor = 2.0 / (1.0 + libm::sin(std::f64::consts::PI / (2 * layers + 1) as f64));
    for _ in 0..SWEEPS * layers {
        for &vertex in &inner {
            let mean = mean(vertex, &|other| Some(values[other as usize]));
            let value = &mut values[vertex as usize];
            *value += factor * (mean - *value);
        }
    }
    // Over-relaxation may pass the range by what is left of the error.
    values.into_iter().map(|value| value.clamp(range.0, range.1)).collect()
}

/// Returns samples of a triangle, at most about `spacing` apart: their barycentric weights, and twice the area of each. A
/// triangle without area has a tiny one, so that its corners count where there is nothing else.
///
/// Strips parallel to the longest edge have samples at the height of their centroids, so that the sums are exact for maps
/// that are linear in the triangle.
fn samples(corners: &[Point3<f64>; 3], spacing: f64) -> impl Iterator<Item = ([f64; 3], f64)> {
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let first = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| (first + k) % 3);
    let area = (corners[b] - corners[a]).cross(&(corners[c] - corners[a])).norm();
    let longest = length(first);
    let count = move |extent: f64| (extent / spacing).ceil().clamp(1.0, MAX_ROWS) as u32;
    let strips = count(if longest > 0.0 { area / longest } else { 0.0 });
    let area = area.max(f64::MIN_POSITIVE.sqrt());
    (0..strips).flat_map(move |strip| {
        let height = 1.0 / f64::from(strips);
        // The widths at both sides of the strip, as shares of the longest edge.
        let [lower, upper] = [strip, strip + 1].map(|strip| 1.0 - f64::from(strip) * height);
        let at = 1.0 - lower + height / 3.0 * (lower + 2.0 * upper) / (lower + upper);
        let along = count(longest * lower);
        let part = area * height * (lower + upper) / f64::from(along);
        (0..along).map(move |k| {
            let share = (f64::from(k) + 0.5) / f64::from(along);
            let mut weights = [0.0; 3];
            (weights[a], weights[b], weights[c]) = ((1.0 - at) * (1.0 - share), (1.0 - at) * share, at);
            (weights, part)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{LatticeOptions, Resolution};
    use crate::mesh::testing::cuboid;

    /// A box of 8 vertices, and the same box with every face divided.
    fn boxes() -> [Mesh; 2] {
        let coarse = cuboid([0.0; 3], [1.0; 3]);
        let fine = coarse.refined(0.2).unwrap().unwrap().mesh;
        [coarse, fine]
    }

    fn options() -> LatticeOptions {
        LatticeOptions { resolution: Resolution::CellSize(0.1), ..LatticeOptions::default() }
    }

    #[test]
    fn samples_have_the_area_and_the_center_of_the_triangle() {
        let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.5, 2.0, 1.0]].map(Point3::from);
        for spacing in [10.0, 1.0, 0.1] {
            let (mut total, mut mean) = (0.0, [0.0; 3]);
            for (weights, area) in samples(&corners, spacing) {
                assert!(weights.iter().all(|weight| *weight >= 0.0));
                total += area;
                (0..3).for_each(|k| mean[k] += weights[k] * area);
            }
            assert!((total - (3.0_f64.powi(2) * 5.0).sqrt()).abs() < 1e-9, "{total}");
            mean.iter().for_each(|part| assert!((part / total - 1.0 / 3.0).abs() < 1e-9));
        }
    }

    /// A map that is linear in space is carried to the vertices of the surface exactly where the surface is flat around
    /// them, and within half a cell at the ends and inside; it does not depend on the faces.
    #[test]
    fn a_linear_map_is_carried_to_the_surface_for_any_faces() {
        let [coarse, fine] = boxes();
        let lattice = Lattice::from_mesh(&coarse, &options()).unwrap();
        let along = |mesh: &Mesh| mesh.vertices().iter().map(|vertex| vertex.x as f32).collect::<Vec<_>>();
        let [of_coarse, of_fine] = [&coarse, &fine].map(|mesh| carried(&lattice, mesh, &along(mesh)));
        for vertex in 0..lattice.len() as u32 {
            let (at, i) = (lattice.rest_position(vertex), vertex as usize);
            assert!((of_coarse[i] - of_fine[i]).abs() < 0.02, "{at}: {} {}", of_coarse[i], of_fine[i]);
            let is_inside_of_top =
                (at.y - 1.0).abs() < 0.06 && (at.x - 0.5).abs() < 0.35 && (at.z - 0.5).abs() < 0.35;
            let tolerance = if is_inside_of_top { 0.01 } else { 0.06 };
            assert!((of_coarse[i] - at.x).abs() < tolerance, "{at}: {}", of_coarse[i]);
        }
    }

    #[test]
    fn a_constant_map_is_the_same_constant_everywhere_also_inside() {
        let [coarse, _] = boxes();
        let lattice = Lattice::from_mesh(&coarse, &options()).unwrap();
        let values = carried(&lattice, &coarse, &[0.25; 8]);
        values.iter().for_each(|value| assert!((value - 0.25).abs() < 1e-12, "{value}"));
    }
}
