//! The volume correction at its limits: degenerate deformations and shapes, caps, and invalid options.

use proptest::prelude::*;
use supple::internals::{Correction, CorrectionWorkspace, Surface, VolumeMeasures};
use supple::{
    ComponentReport, Lattice, Mesh, Preservation, Resolution, VolumeError, VolumeMeasure, VolumeOptions,
    VolumeScope,
};
use supple_tests::{apply_in, ball, block, block_at, lattice, of_mesh, posed, sphere, within};

const MEASURES: [VolumeMeasure; 2] = [VolumeMeasure::Lattice, VolumeMeasure::Cells];

/// Corrects positions, asserts that all results are finite, and returns the report of the first component.
fn report(correction: &Correction, deformed: &[[f32; 3]]) -> (ComponentReport, Vec<[f32; 3]>) {
    let (components, corrected) = apply_in(&mut CorrectionWorkspace::default(), correction, deformed, &[]);
    let component = components[0];
    assert!(corrected.iter().flatten().all(|x| x.is_finite()), "{component:?}");
    let c = component;
    assert!([c.before, c.after, c.lambda, c.residual].iter().all(|x| x.is_finite()), "{component:?}");
    (component, corrected)
}

fn of_lattice(lattice: &Lattice, measure: VolumeMeasure) -> Correction {
    Correction::new(lattice, None, &measure.into()).expect("usable").expect("not off")
}

#[test]
fn degenerate_deformations_give_finite_results_within_the_cap() {
    let lattice = lattice(&block([5, 4, 3]));
    let maps: [fn([f32; 3]) -> [f32; 3]; 7] = [
        |_| [0.0; 3],
        |_| [1e6, 3.0, -1e-20],
        |[x, y, _]| [x, y, 0.0],
        |[x, _, _]| [x, 0.0, 0.0],
        |[x, y, z]| [-x, y, z],
        |p| p.map(|x| x * 1e30),
        |[x, y, z]| [f32::MAX * (x - 2.5).signum(), f32::MIN * (y - 2.0).signum(), z * 1e-30],
    ];
    for measure in MEASURES {
        let correction = of_lattice(&lattice, measure);
        for (case, map) in maps.iter().enumerate() {
            let deformed = posed(&lattice, map);
            let (component, corrected) = report(&correction, &deformed);
            assert!(component.capped == (component.residual.abs() > 1e-6), "{case}: {component:?}");
            // No lattice vertex lies deeper than one cell below the boundary.
            assert!(component.lambda.abs() <= 1.0, "beyond the cap, {case}: {component:?}");
            let moved = corrected.iter().flatten().zip(deformed.iter().flatten()).map(|(a, b)| (a - b).abs());
            // Regression bound: the cap of one cell, and 0.07 for the rounding of coordinates of 1e6 (ulp
            // 0.0625).
            assert!(case > 3 || moved.fold(0.0, f32::max) <= 1.0 + 0.07, "{case}");
        }
    }
}

#[test]
fn a_fully_pinned_body_stays_and_reports_its_residual() {
    let lattice = lattice(&block([3, 3, 3]));
    let all: Vec<u32> = (0..lattice.len() as u32).collect();
    let correction = of_lattice(&lattice, VolumeMeasure::Cells);
    let mut workspace = CorrectionWorkspace::default();
    correction.set_constrained(&mut workspace, all.iter().copied());
    let stretched = posed(&lattice, |[x, y, z]| [x, y, 1.25 * z]);
    let (components, corrected) = apply_in(&mut workspace, &correction, &stretched, &[]);
    let component = components[0];
    assert_eq!(corrected, stretched);
    assert!(component.capped && component.lambda == 0.0);
    within(component.residual, 0.25, 1e-12);
}

#[test]
fn max_correction_is_a_fraction_of_the_thickness() {
    let lattice = lattice(&block([8, 8, 8]));
    let huge = posed(&lattice, |p| p.map(|x| 3.0 * x));
    for max_correction in [0.0, 0.1, 0.5] {
        let options = VolumeOptions { max_correction, ..VolumeMeasure::Cells.into() };
        let correction = Correction::new(&lattice, None, &options).unwrap().unwrap();
        let (component, _) = report(&correction, &huge);
        // The center of eight cells lies four cells below the boundary.
        assert_eq!((component.lambda, component.capped), (-4.0 * max_correction, true));
        within(component.before, 27.0 * 512.0, 1e-6);
        within(component.residual, component.after / 512.0 - 1.0, 1e-12);
        assert!(component.residual > 0.0 && component.after <= component.before);
    }
}

/// A block is pressed flat and released in 4,000 steps. The bounds are regression bounds.
#[test]
fn the_correction_of_a_block_pressed_flat_and_released_is_continuous() {
    let lattice = lattice(&block([6, 6, 6]));
    for measure in MEASURES {
        for scope in [VolumeScope::Global, VolumeScope::Regional] {
            let options = VolumeOptions { scope, ..measure.into() };
            let correction = Correction::new(&lattice, None, &options).unwrap().unwrap();
            let mut before: Option<(ComponentReport, Vec<[f32; 3]>)> = None;
            for step in 0..=4000 {
                let height = (step as f32 / 2000.0 - 1.0).abs();
                let now = report(&correction, &posed(&lattice, |[x, y, z]| [x, y, height * z]));
                let (component, corrected) = before.as_ref().unwrap_or(&now);
                let jump = (now.0.lambda - component.lambda).abs();
                assert!(jump < 0.02, "{measure}, {scope:?}, height {height}: {jump}");
                for (a, b) in now.1.iter().flatten().zip(corrected.iter().flatten()) {
                    assert!((a - b).abs() < 0.04, "{measure}, {scope:?}, height {height}: {a} {b}");
                }
                before = Some(now);
            }
        }
    }
}

#[test]
fn thin_parts_and_single_cells_have_a_field_and_keep_their_volume() {
    let shapes = [
        vec![[0, 0, 0]],
        block([9, 1, 1]),
        block([6, 6, 1]),
        vec![[0, 0, 0], [1, 1, 0]],
        vec![[0, 0, 0], [1, 1, 1]],
        (0..9).map(|k| [k, k % 2, 0]).collect(),
    ];
    for cells in &shapes {
        let lattice = lattice(cells);
        let squashed = posed(&lattice, |[x, y, z]| [x, y, 0.9 * z]);
        for measure in MEASURES {
            let (component, corrected) = report(&of_lattice(&lattice, measure), &squashed);
            assert!(!component.capped && component.residual.abs() < 1e-12, "{cells:?}: {component:?}");
            let distance =
                |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
            let lengths =
                corrected.iter().zip(&squashed).map(|(a, b)| f64::from(distance(a, b)) / component.lambda);
            let (sum, largest) =
                lengths.fold((0.0, 0.0_f64), |(sum, largest), length| (sum + length, largest.max(length)));
            // Regression bounds: the field has about length 1 everywhere. A corner between two cells stays.
            let mean = sum / lattice.len() as f64;
            assert!(largest < 2.0 && (0.5..1.6).contains(&mean), "{cells:?}: {mean}, {largest}");
        }
    }
}

#[test]
fn components_are_corrected_independently() {
    let mut cells = block([3, 3, 3]);
    cells.extend(block_at([10, 0, 0], [2, 4, 3]));
    let lattice = lattice(&cells);
    // The second component is moved away and squashed.
    let deformed = posed(&lattice, |[x, y, z]| if x < 5.0 { [x, y, z] } else { [x + 500.0, 0.8 * y, z] });
    let correction = of_lattice(&lattice, VolumeMeasure::Cells);
    let (reports, corrected) = apply_in(&mut CorrectionWorkspace::default(), &correction, &deformed, &[]);
    assert_eq!(reports.len(), 2);
    assert_eq!((reports[0].lambda, reports[0].rest), (0.0, 27.0));
    assert!(reports[1].lambda > 0.05 && !reports[1].capped);
    let of_vertex = &lattice.components().of_vertex;
    for (i, (a, b)) in corrected.iter().zip(&deformed).enumerate() {
        let inner = lattice.neighbors(i as u32).iter().all(Option::is_some);
        assert!(a == b || of_vertex[i] == 1, "{i} is in the first component");
        assert!(a != b || of_vertex[i] == 0 || inner, "{i} is at the boundary of the second component");
    }
    let measures = VolumeMeasures::new(&lattice, None);
    let report = measures.report_corrected(&correction, &reports, &deformed, &corrected);
    assert_eq!((report.rest, report.lambda), (51.0, reports[1].lambda));
    // f32 rounds positions 500 cells from the origin to 3e-5.
    within(report.by(VolumeMeasure::Cells).unwrap().after, 51.0, 1e-5);
}

#[test]
fn nested_surfaces_count_once_and_reversed_ones_are_cavities() {
    let merged = |spheres: &[([f64; 3], f64, bool)]| {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for &(center, radius, flipped) in spheres {
            let (own, mut own_faces) = sphere(center, radius, 8);
            let first = vertices.len() as u32;
            for face in &mut own_faces {
                face.iter_mut().for_each(|corner| *corner += first);
                if flipped {
                    face.reverse();
                }
            }
            vertices.extend(own);
            faces.extend(own_faces);
        }
        let mesh = Mesh::new(vertices, &faces).unwrap();
        let (lattice, embedding) = of_mesh(&mesh, Resolution::CellSize(0.5));
        let surface = Surface { mesh: &mesh, embedding: &embedding };
        let report = VolumeMeasures::new(&lattice, Some(surface)).report(&posed(&lattice, |p| p));
        report.by(VolumeMeasure::Mesh).expect("a usable mesh").rest
    };
    let unit = merged(&[([0.0; 3], 2.0, false)]) / 8.0;
    for outer in [false, true] {
        let head = ([0.0; 3], 2.0, outer);
        within(merged(&[head]), 8.0 * unit, 1e-6);
        // An inner surface of the same orientation, a cavity, a body in the cavity, a separate reversed body.
        within(merged(&[head, ([0.5, 0.0, 0.3], 1.0, outer)]), 8.0 * unit, 1e-6);
        within(merged(&[head, ([0.5, 0.0, 0.3], 1.0, !outer)]), 7.0 * unit, 1e-6);
        within(merged(&[head, ([0.0; 3], 1.0, !outer), ([0.1; 3], 0.5, outer)]), 7.125 * unit, 1e-6);
        within(merged(&[head, ([9.0, 0.0, 0.0], 1.0, true)]), 9.0 * unit, 1e-6);
    }
}

#[test]
fn surfaces_that_enclose_no_volume_are_errors_or_fall_back_to_cells() {
    let closed = ball(2.0);
    let open =
        Mesh::new(closed.vertices().iter().map(|p| (*p).into()).collect(), &closed.triangles()[1..]).unwrap();
    let two_sided: Vec<_> = open.triangles().iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect();
    let two_sided = Mesh::new(open.vertices().iter().map(|p| (*p).into()).collect(), &two_sided).unwrap();
    let flat = closed.vertices().iter().map(|p| [p.x, p.y, 1e-4 * p.z]).collect();
    let flat = Mesh::new(flat, closed.triangles()).unwrap();
    for (mesh, closed) in [(open, false), (two_sided, false), (flat, true)] {
        let (lattice, embedding) = of_mesh(&mesh, Resolution::CellSize(0.5));
        let surface = Some(Surface { mesh: &mesh, embedding: &embedding });
        let error = Correction::new(&lattice, surface, &VolumeMeasure::Mesh.into()).unwrap_err();
        assert!(
            matches!(error, VolumeError::Flat { .. }) == closed && error.to_string().contains("`cells`"),
            "{error}"
        );
        let auto = Correction::new(&lattice, surface, &Preservation::Auto.into()).unwrap().unwrap();
        assert_eq!(auto.measure(), VolumeMeasure::Cells);
        assert_eq!(VolumeMeasures::new(&lattice, surface).kinds().count(), 2);
    }
}

#[test]
fn invalid_options_are_errors_and_off_makes_no_correction() {
    let lattice = lattice(&[[0, 0, 0]]);
    let new = |options: &VolumeOptions| Correction::new(&lattice, None, options);
    assert_eq!(new(&VolumeMeasure::Mesh.into()).unwrap_err(), VolumeError::NoMesh);
    assert!(new(&Preservation::Off.into()).unwrap().is_none());
    for max_correction in [-1.0, f64::NAN, f64::INFINITY] {
        let error = new(&VolumeOptions { max_correction, ..Default::default() }).unwrap_err();
        let bits = max_correction.to_bits();
        assert!(matches!(error, VolumeError::MaxCorrection(value) if value.to_bits() == bits), "{error}");
    }
    let report = VolumeMeasures::new(&lattice, None).report(&posed(&lattice, |[x, y, z]| [2.0 * x, y, z]));
    assert_eq!((report.rest, report.before, report.after, report.lambda), (1.0, 2.0, 2.0, 0.0));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn arbitrary_positions_give_finite_results_within_the_cap(
        positions in prop::collection::vec(prop::array::uniform3(prop::num::f32::NORMAL | prop::num::f32::ZERO), 18),
    ) {
        let lattice = lattice(&block([2, 2, 1]));
        for measure in MEASURES {
            let correction = of_lattice(&lattice, measure);
            let (reports, corrected) =
                apply_in(&mut CorrectionWorkspace::default(), &correction, &positions, &[]);
            let c = reports[0];
            prop_assert!([c.before, c.after, c.lambda, c.residual].iter().all(|x| x.is_finite()), "{:?}", c);
            // The thickness of a body of one layer counts as half a cell.
            prop_assert!(c.lambda.abs() <= 0.5, "{:?}", c);
            prop_assert!(corrected.iter().flatten().all(|x| x.is_finite()));
        }
    }
}
