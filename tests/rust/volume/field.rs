//! Correction fields compared with exact solutions: uniformly stretched bars and inflated balls.
//!
//! Unless a comment derives them, the factors and errors of the assertions are regression bounds.

use std::collections::HashMap;

use nalgebra::{Rotation3, Vector3};
use supple::internals::{Correction, CorrectionWorkspace, Surface};
use supple::{FieldKind, Interior, Mesh, Resolution, VolumeMeasure, VolumeOptions};
use supple_tests::{apply_in, block, of_mesh, rms, surface_of};

const FIELDS: [FieldKind; 3] = [FieldKind::Paper, FieldKind::Cells, FieldKind::Surface];

/// Returns the vertices of a mesh whose lattice is deformed by `pose`, after the correction with the measure
/// `mesh`.
fn corrected(
    mesh: &Mesh,
    cell: f64,
    field: FieldKind,
    pose: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> Vec<Vector3<f64>> {
    let (lattice, embedding) = of_mesh(mesh, Resolution::CellSize(cell));
    let options = VolumeOptions { field, ..VolumeMeasure::Mesh.into() };
    let surface = Surface { mesh, embedding: &embedding };
    let correction = Correction::new(&lattice, Some(surface), &options).unwrap().unwrap();
    let to_cells = |p: Vector3<f64>| ((p - lattice.origin().coords) / cell).map(|x| x as f32).into();
    let deformed: Vec<[f32; 3]> =
        (0..lattice.len() as u32).map(|i| to_cells(pose(lattice.rest_position(i).coords))).collect();
    let (report, positions) = apply_in(&mut CorrectionWorkspace::default(), &correction, &deformed, &[]);
    assert!(report.iter().all(|component| !component.capped && component.residual.abs() < 1e-12));
    let mut points = vec![[0.0_f32; 3]; mesh.vertices().len()];
    embedding.interpolate(&positions, &mut points);
    let to_world = |p: [f32; 3]| Vector3::from(p.map(f64::from)) * cell + lattice.origin().coords;
    points.into_iter().map(to_world).collect()
}

/// Rotates a bar of length 40 and width 1, stretches it by 1.5 and corrects its volume. Returns the mean
/// width of its middle half, and the rms distance of the vertices there from an incompressible solid, in
/// cells.
fn bar(field: FieldKind, cell: f64, turn: Rotation3<f64>) -> (f64, f64) {
    let (vertices, quads) = surface_of(&block([160, 4, 4]));
    let at_rest: Vec<Vector3<f64>> =
        vertices.iter().map(|v| (Vector3::from(*v) - Vector3::new(80.0, 2.0, 2.0)) / 4.0).collect();
    let mesh = Mesh::new(at_rest.iter().map(|v| (turn * v).into()).collect(), &quads).unwrap();
    let along = |v: Vector3<f64>| turn * (turn.inverse() * v).component_mul(&Vector3::new(1.5, 1.0, 1.0));
    let width = (1.0_f64 / 1.5).sqrt();
    let exact = |v: &Vector3<f64>| v.component_mul(&Vector3::new(1.5, width, width));
    let surface = corrected(&mesh, cell, field, along).into_iter().map(|p| turn.inverse() * p);
    let pairs: Vec<_> = surface.zip(&at_rest).filter(|(_, rest)| rest.x.abs() <= 10.0).collect();
    let sides = pairs.iter().filter(|(_, rest)| rest.y.abs() == 0.5).map(|(p, _)| p.y.abs());
    let count = pairs.iter().filter(|(_, rest)| rest.y.abs() == 0.5).count();
    let mean = 2.0 * sides.sum::<f64>() / count as f64;
    (mean, rms(pairs.iter().map(|(p, rest)| (p - exact(rest)).norm() / cell)))
}

#[test]
fn a_stretched_bar_has_the_width_of_an_incompressible_solid() {
    // 1/sqrt(1.5) = 0.8165.
    let [paper, cells, surface] = FIELDS.map(|field| bar(field, 0.25, Rotation3::identity()));
    for (width, error) in [cells, surface] {
        assert!((width / 0.8165 - 1.0).abs() < 0.006 && error < 0.5 * paper.1, "{width}, {error} {paper:?}");
    }
}

#[test]
fn a_rotated_stretched_bar_has_the_width_of_an_incompressible_solid() {
    for axis in [Vector3::z(), Vector3::new(1.0, 1.0, 1.0).normalize()] {
        let turn = Rotation3::new(axis * 30.0_f64.to_radians());
        let [paper, _, surface] = FIELDS.map(|field| bar(field, 0.25, turn));
        assert!(surface.1 < 0.5 * paper.1, "{surface:?} {paper:?}");
        assert!((surface.0 / 0.8165 - 1.0).abs() < 0.025, "{surface:?}");
    }
}

#[test]
fn an_inflated_ball_regains_its_radius() {
    for radius in [3.0, 5.0, 5.3, 8.0] {
        let (vertices, quads) = surface_of(&block([24; 3]));
        let on_ball = |v: &[f64; 3]| {
            let tangents = v.map(|x| ((x / 12.0 - 1.0) * std::f64::consts::FRAC_PI_4).tan());
            (Vector3::from(tangents).normalize() * radius).into()
        };
        let mesh = Mesh::new(vertices.iter().map(on_ball).collect(), &quads).unwrap();
        let errors = FIELDS.map(|field| {
            let surface = corrected(&mesh, 1.0, field, |v| v * 1.1);
            rms(surface.iter().map(|p| p.norm() - radius))
        });
        let [paper, _, surface] = errors;
        assert!(surface < 0.5 * paper && surface < 0.014, "radius {radius}: {errors:?}");
    }
}

#[test]
fn a_reversed_surface_is_corrected_like_an_outward_one() {
    let (vertices, mut quads) = surface_of(&block([4; 3]));
    let outwards = Mesh::new(vertices.clone(), &quads).unwrap();
    quads.iter_mut().for_each(|quad| quad[1..].reverse());
    let inwards = Mesh::new(vertices, &quads).unwrap();
    let [one, other] =
        [outwards, inwards].map(|mesh| corrected(&mesh, 1.0, FieldKind::Surface, |v| v * 1.25));
    let difference = one.iter().zip(&other).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
    assert!(difference < 1e-4, "{difference}");
}

/// Returns the greatest angle between the normals of triangles with a common edge, in degrees.
fn greatest_angle(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let point = |corner: u32| Vector3::from(points[corner as usize].map(f64::from));
    let mut sides = HashMap::new();
    let mut greatest = 0.0_f64;
    for &[a, b, c] in triangles {
        let normal = (point(b) - point(a)).cross(&(point(c) - point(a))).normalize();
        for (from, to) in [(a, b), (b, c), (c, a)] {
            sides.insert((from, to), normal);
            if let Some(other) = sides.get(&(to, from)) {
                greatest = greatest.max(normal.angle(other).to_degrees());
            }
        }
    }
    greatest
}

#[test]
fn a_flattened_terrain_regains_its_volume_without_creases() {
    // A terrain of 60 x 60 squares, of which each has two triangles, in a layer of cells along it.
    let count = 60;
    let height = |x: f64, z: f64| 0.5 * (1.7 * x).sin() * (1.3 * z).cos() + 0.2 * (3.1 * z + x).sin();
    let place = |i: u32| f64::from(i) * 0.1 - 3.0;
    let corners = (0..=count).flat_map(|i| (0..=count).map(move |k| (place(i), place(k))));
    let vertices: Vec<[f64; 3]> = corners.map(|(x, z)| [x, height(x, z), z]).collect();
    let triangles: Vec<[u32; 3]> = (0..count * count)
        .map(|square| square / count * (count + 1) + square % count)
        .flat_map(|a| [[a, a + 1, a + count + 2], [a, a + count + 2, a + count + 1]])
        .collect();
    let mesh = Mesh::new(vertices, &triangles.iter().map(|t| t.to_vec()).collect::<Vec<_>>()).unwrap();
    assert_eq!(mesh.interior(), Interior::Sheet);
    let (lattice, embedding) = of_mesh(&mesh, Resolution::Vertices(5000));
    let cell = lattice.cell_size();
    let deformed: Vec<[f32; 3]> = (0..lattice.len() as u32)
        .map(|i| {
            (lattice.rest_position(i) - lattice.origin()).component_mul(&Vector3::new(1.0, 0.9, 1.0)) / cell
        })
        .map(|p| p.map(|x| x as f32).into())
        .collect();
    // (the scale in cells, the volume error, the greatest angle before and after the correction)
    let correct = |options: VolumeOptions| {
        let surface = Surface { mesh: &mesh, embedding: &embedding };
        let correction = Correction::new(&lattice, Some(surface), &options).unwrap().unwrap();
        assert_eq!(correction.measure(), VolumeMeasure::Cells);
        let (report, positions) = apply_in(&mut CorrectionWorkspace::default(), &correction, &deformed, &[]);
        let angle = |positions: &[[f32; 3]]| {
            let mut points = vec![[0.0_f32; 3]; mesh.vertices().len()];
            embedding.interpolate(positions, &mut points);
            greatest_angle(&points, &triangles)
        };
        (report[0].lambda / cell, report[0].residual, angle(&deformed), angle(&positions))
    };
    let (scale, residual, before, after) = correct(VolumeOptions::default());
    // The layer regains the tenth of its thickness that it has lost, half of it on each side. The layer is one cell thick,
    // two at steps of the lattice.
    assert!(scale > 0.5 * 0.1 && scale < 0.5 * 0.1 * 2.0, "{scale}");
    assert!(residual.abs() < 1e-6, "{residual}");
    // The two sides of the layer move apart, by the scale each. The surface between them moves less, so that over a cell
    // its displacement changes by at most the scale: each of two neighboring normals turns by at most atan(scale).
    assert!(after < before + 2.0 * scale.atan().to_degrees(), "{before} to {after}, {scale}");
    let cells = VolumeOptions { field: FieldKind::Cells, ..VolumeOptions::default() };
    assert_eq!(correct(cells), (scale, residual, before, after));
    // The field along the normals of the surface moves both sides of the layer the same way, and creases it. It is used if it
    // is asked for.
    let surface = VolumeOptions { field: FieldKind::Surface, ..VolumeOptions::default() };
    let (.., along_normals) = correct(surface);
    assert!(along_normals > 2.0 * before, "{along_normals}");
}

#[test]
fn the_default_field_of_a_solid_is_that_of_its_surface() {
    // An open mesh and the measure of the cells: a box without its top.
    let (vertices, mut quads) = surface_of(&block([6, 4, 5]));
    let is_top = |quad: &[u32; 4]| quad.iter().all(|&corner| vertices[corner as usize][1] == 4.0);
    for is_open in [false, true] {
        if is_open {
            quads.retain(|quad| !is_top(quad));
        }
        let mesh = Mesh::new(vertices.to_vec(), &quads).unwrap();
        let (lattice, embedding) = of_mesh(&mesh, Resolution::CellSize(0.7));
        let moved = |field| {
            let options = VolumeOptions { field, ..VolumeMeasure::Cells.into() };
            let surface = Surface { mesh: &mesh, embedding: &embedding };
            let correction = Correction::new(&lattice, Some(surface), &options).unwrap().unwrap();
            let deformed: Vec<[f32; 3]> =
                lattice.indices().iter().map(|i| [0.9 * i[0] as f32, i[1] as f32, i[2] as f32]).collect();
            apply_in(&mut CorrectionWorkspace::default(), &correction, &deformed, &[]).1
        };
        assert_eq!(moved(FieldKind::Auto), moved(FieldKind::Surface));
        assert_ne!(moved(FieldKind::Auto), moved(FieldKind::Cells));
    }
}
