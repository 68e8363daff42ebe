//! The evaluated surface compared with finite-element solutions of a nearly incompressible solid.
//!
//! `tests/data/README.md` describes the reference solutions in `tests/data/fem`. The factors of the
//! assertions are regression bounds.

use nalgebra::Point3;
use supple::{Body, BodyBuilder, FieldKind, Material, Mesh, Preservation, VolumeMeasure, VolumeOptions};
use supple_tests::{block, pull_apart, rms, surface_of};

/// Returns the rows of numbers of a reference solution.
fn rows(name: &str) -> Vec<Vec<f64>> {
    let path = supple_tests::data(&format!("fem/{name}.csv"));
    let text = std::fs::read_to_string(path).expect("the reference is there");
    text.lines().filter_map(|line| line.split(',').map(|x| x.parse().ok()).collect()).collect()
}

/// Returns the evaluated surface of a stiff body at rest, after the part above `bounds[1]` along `axis` has
/// moved by `distance` and the part below `bounds[0]` has been pinned.
fn stretched_surface(body: BodyBuilder, axis: usize, bounds: [f64; 2], distance: f64) -> Vec<Point3<f64>> {
    let body = body.half_width(2).stiffness(0.8).region_damping(0.1);
    pull_apart(body, axis, bounds, distance, 600).body(0).surface().positions
}

/// Returns the options without a correction, with the field of the paper, and with the default field.
fn options() -> [VolumeOptions; 3] {
    let by = |field| VolumeOptions { field, ..Preservation::By(VolumeMeasure::Mesh).into() };
    [VolumeOptions::off(), by(FieldKind::Paper), by(FieldKind::Surface)]
}

/// A bar of 4 x 1 x 1 with clamped ends is stretched to 1.5 times its length.
#[test]
fn the_surface_field_brings_a_stretched_bar_closer_to_finite_elements() {
    let (vertices, quads) = surface_of(&block([32, 8, 8]));
    let place = |v: [f64; 3]| [v[0] / 8.0, v[1] / 8.0 - 0.5, v[2] / 8.0 - 0.5];
    let mesh = Mesh::new(vertices.into_iter().map(place).collect(), &quads).unwrap();
    let reference = rows("bar");
    for cell in [0.25, 0.125] {
        let errors = options().map(|volume| {
            let body =
                Body::builder(mesh.clone()).material(Material::fast_lsm()).cell_size(cell).volume(volume);
            let surface = stretched_surface(body, 0, [1e-6, 4.0 - 1e-6], 2.0);
            rms(reference.iter().map(|row| {
                let rest = Point3::new(row[0], row[1], row[2]);
                let vertex = mesh.vertices().iter().position(|v| (v - rest).norm() < 1e-4).unwrap();
                (surface[vertex] - Point3::new(row[3], row[4], row[5])).norm()
            }))
        });
        let [uncorrected, paper, surface] = errors;
        assert!(surface < paper && surface < 0.85 * uncorrected, "cells of {cell}: {errors:?}");
    }
}

/// The shoulders are pinned and the crown moves up by half of the height.
#[test]
fn the_surface_field_brings_a_stretched_bust_closer_to_finite_elements() {
    let mesh = supple_tests::bust();
    let reference = rows("bust");
    for vertices in [1000, 4000] {
        let errors = options().map(|volume| {
            let body = Body::builder(mesh.clone())
                .material(Material::fast_lsm())
                .lattice_vertices(vertices)
                .volume(volume);
            let surface = stretched_surface(body, 1, [6.303, 8.766], 1.759);
            rms(reference
                .iter()
                .map(|row| (surface[row[0] as usize] - Point3::new(row[4], row[5], row[6])).norm()))
        });
        let [uncorrected, paper, surface] = errors;
        assert!(surface < 0.85 * uncorrected && surface < 1.05 * paper, "{vertices} vertices: {errors:?}");
    }
}
