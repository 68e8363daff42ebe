//! The volume is kept in every frame in which no cell is inside out, also where a single cubic has no root within the
//! cap.
//!
//! The bound 1e-6 of the volume error is the error up to which a report says that the volume is kept.

use nalgebra::Vector3;
use supple::internals::{Correction, CorrectionWorkspace};
use supple::{
    Body, Handle, Key, Material, Mesh, Pin, Preservation, Selection, Simulation, TimeWindow, VolumeMeasure,
    VolumeOptions, VolumeScope,
};
use supple_tests::{apply_in, block, lattice, surface_of};

/// The measures, each with both scopes.
fn options() -> impl Iterator<Item = VolumeOptions> {
    let measures = [VolumeMeasure::Lattice, VolumeMeasure::Cells, VolumeMeasure::Mesh];
    let scopes = [VolumeScope::Global, VolumeScope::Regional];
    measures.into_iter().flat_map(move |measure| {
        scopes.map(|scope| VolumeOptions { scope, measure: Preservation::By(measure), ..Default::default() })
    })
}

/// Returns the least determinant of the edges at a corner of a cell, in cubed cells: positive if no cell is inside
/// out at a corner.
fn least_determinant(body: &Body, positions: &[nalgebra::Point3<f64>]) -> f64 {
    let lattice = body.lattice();
    let cells = 0..lattice.cells().len() as u32;
    let corners = cells.flat_map(|cell| {
        let at = lattice.cell_corners(cell).map(|vertex| positions[vertex as usize] / lattice.cell_size());
        (0..8).map(move |k| {
            let edge = |axis: usize| {
                let edge: Vector3<f64> = at[k ^ (1 << axis)] - at[k];
                if k >> axis & 1 == 0 { edge } else { -edge }
            };
            edge(0).dot(&edge(1).cross(&edge(2)))
        })
    });
    corners.fold(f64::INFINITY, f64::min)
}

/// Holds the lowest eighth of a block, moves its highest eighth along `keys`, and checks the volume after every frame
/// of 1/30 s, for 1.2 s.
fn check_frames(size: [i32; 3], material: Material, keys: &[Key]) -> usize {
    let (vertices, quads) = surface_of(&block(size));
    let mesh = Mesh::new(vertices, &quads).unwrap();
    let height = f64::from(size[1]);
    let beyond = |at: f64, side: f64| Selection::Plane { point: [0.0, at, 0.0], normal: [0.0, side, 0.0] };
    let mut checked = 0;
    for volume in options() {
        let handle = Handle {
            goal: None,
            selection: beyond(0.875 * height, 1.0),
            motion: keys.to_vec().into(),
            window: TimeWindow::default(),
        };
        let pin = Pin { goal: None, selection: beyond(0.125 * height, -1.0), window: TimeWindow::default() };
        let body = Body::builder(mesh.clone()).material(material).cell_size(1.0).volume(volume);
        let body = body.pin(pin).handle(handle).build().unwrap();
        let simulation = Simulation::builder().body(body).gravity([0.0, -9.81, 0.0]).dt(1.0 / 60.0);
        let mut simulation = simulation.build().unwrap();
        for frame in 1..=36 {
            simulation.steps(2);
            let body = simulation.body(0);
            if least_determinant(body.get(), &body.positions()) <= 0.0 {
                continue;
            }
            let report = body.volume_report();
            assert!(report.residual.abs() <= 1e-6 && !report.capped, "{volume:?}, frame {frame}: {report:?}");
            let kept = report.by(report.measure).unwrap();
            assert!((kept.after / kept.rest - 1.0).abs() <= 2e-6, "{volume:?}, frame {frame}: {kept:?}");
            checked += usize::from((report.before / report.rest - 1.0).abs() > 0.5);
        }
    }
    checked
}

fn key(time: f64, up: f64, turn: f64) -> Key {
    Key { time, translate: [0.0, up, 0.0], rotate: [0.0, turn, 0.0] }
}

#[test]
fn volume_of_a_bar_that_is_stretched_to_five_times_its_length_is_kept() {
    let checked = check_frames([4, 16, 4], Material::fast_lsm(), &[key(0.0, 0.0, 0.0), key(1.0, 64.0, 0.0)]);
    assert!(checked > 100, "{checked}");
}

#[test]
fn volume_of_a_plate_that_is_stretched_to_four_times_its_length_is_kept() {
    let checked = check_frames([16, 16, 2], Material::fast_lsm(), &[key(0.0, 0.0, 0.0), key(1.0, 48.0, 0.0)]);
    assert!(checked > 100, "{checked}");
}

#[test]
fn volume_of_a_bar_that_is_twisted_and_pressed_is_kept() {
    check_frames([4, 16, 4], Material::fast_lsm(), &[key(0.0, 0.0, 0.0), key(1.0, -9.0, 540.0)]);
}

/// A bar with held ends is stretched to eight times its length. At the cap of the scale, the cells beside
/// the ends alone have more than the rest volume.
#[test]
fn passes_keep_the_orientation_of_sections() {
    let lattice = lattice(&block([12, 6, 6]));
    let options = VolumeMeasure::Cells.into();
    let correction = Correction::new(&lattice, None, &options).unwrap().unwrap();
    let ends = (0..lattice.len() as u32).filter(|&i| {
        let x = lattice.indices()[i as usize][0];
        x <= 2 || x >= 10
    });
    let mut workspace = CorrectionWorkspace::default();
    correction.set_constrained(&mut workspace, ends.collect::<Vec<_>>().iter().copied());
    // Only the part between the ends is stretched, evenly.
    let stretched = |x: f32| x + 7.0 * (x - 2.0).clamp(0.0, 8.0);
    let deformed: Vec<[f32; 3]> =
        lattice.indices().iter().map(|&[x, y, z]| [stretched(x as f32), y as f32, z as f32]).collect();
    let (components, corrected) = apply_in(&mut workspace, &correction, &deformed, &[]);
    assert!(components[0].residual.abs() < 1e-12 && !components[0].capped, "{components:?}");
    let moved =
        corrected.iter().zip(&deformed).flat_map(|(a, b)| (0..3).map(move |k| f64::from(a[k] - b[k]).abs()));
    let moved = moved.fold(0.0, f64::max);
    assert!(moved > 1.2 * components[0].lambda.abs(), "no single scale: {moved} {components:?}");
    for x in 0..=12 {
        let at = |index| corrected[lattice.vertex_at(index).unwrap() as usize];
        let widths = [at([x, 6, 3])[1] - at([x, 0, 3])[1], at([x, 3, 6])[2] - at([x, 3, 0])[2]];
        assert!(widths.iter().all(|width| *width > 0.0), "section {x}: {widths:?}");
    }
    // A second evaluation in the same workspace has the same bits.
    assert_eq!(apply_in(&mut workspace, &correction, &deformed, &[]).1, corrected);
}
