//! Contact samples: on the faces of coarse meshes, and on the boundary of bare lattices.

use nalgebra::Point3;
use supple::internals::{
    BodyFrame, BodyState, Colliders, ContactReport, Contacts, Interval, Lanes, SampleCells,
};
use supple::{Collider, Lattice, LatticeOptions, Resolution};
use supple_tests::{mesh_of, plain_box};

/// Returns the contacts of a lattice at rest with one collider.
fn touch(lattice: &Lattice, samples: SampleCells, collider: Collider) -> ContactReport {
    let blocks = lattice.len().div_ceil(8);
    let (mut positions, mut velocities) = (Lanes::zeros(blocks), Lanes::zeros(blocks));
    for (slot, index) in (0u32..).zip(lattice.indices()) {
        positions.set(slot, index.map(|i| i as f32));
    }
    let frame = BodyFrame { origin: lattice.origin(), cell_size: lattice.cell_size() };
    let mut state =
        BodyState { positions: &mut positions, compensation: None, velocities: &mut velocities, frame };
    let colliders = Colliders::new(&[collider]).unwrap();
    Contacts::new(samples).resolve(&mut state, &colliders, Interval::of_step(0, 1.0 / 60.0), [0.0; 3])
}

fn slots(lattice: &Lattice) -> Vec<u32> {
    (0..lattice.len() as u32).collect()
}

/// Returns the masses of full cells.
fn masses(lattice: &Lattice) -> Vec<f32> {
    lattice.occupied_cells().iter().map(|&cells| f32::from(cells) / 8.0).collect()
}

#[test]
fn contacts_are_found_between_the_vertices_of_coarse_faces() {
    let mesh = mesh_of(plain_box([0.0; 3], [2.0; 3]));
    let options = LatticeOptions { resolution: Resolution::CellSize(0.25), ..LatticeOptions::default() };
    let lattice = Lattice::from_mesh(&mesh, &options).unwrap();
    // Spheres of more than the cell size in radius, on faces and edges away from mesh vertices.
    for (center, radius) in [
        ([1.0, 1.0, -0.1], 0.3),
        ([0.61, 1.37, 2.05], 0.3),
        ([-0.05, 0.55, 1.42], 0.3),
        ([1.13, 2.0, 2.0], 0.3),
        ([0.42, -0.1, 0.87], 0.3),
    ] {
        let samples = SampleCells::of_mesh(&mesh, &lattice, &slots(&lattice), &masses(&lattice));
        let report = touch(&lattice, samples, Collider::sphere(center, radius));
        assert!(report.contacts > 0, "no contact at {center:?}");
        let samples = SampleCells::of_lattice(&lattice, &slots(&lattice), &masses(&lattice));
        assert!(touch(&lattice, samples, Collider::sphere(center, radius)).contacts > 0);
    }
    // The interior has no samples.
    let samples = SampleCells::of_mesh(&mesh, &lattice, &slots(&lattice), &masses(&lattice));
    assert_eq!(touch(&lattice, samples, Collider::sphere([1.0; 3], 0.7)).contacts, 0);
}

#[test]
fn samples_lie_on_the_surface_of_the_mesh_and_are_few() {
    let mesh = mesh_of(plain_box([0.0; 3], [2.0; 3]));
    let options = LatticeOptions { resolution: Resolution::CellSize(0.25), ..LatticeOptions::default() };
    let lattice = Lattice::from_mesh(&mesh, &options).unwrap();
    let samples = SampleCells::of_mesh(&mesh, &lattice, &slots(&lattice), &masses(&lattice));
    // A box that ends 1e-3 below the surface contains no sample; a box that ends at the surface contains all.
    let inner = Collider::cuboid([1.0; 3], [1.0 - 1e-3; 3], [0.0; 3]);
    assert_eq!(touch(&lattice, samples.clone(), inner).contacts, 0);
    let outer = Collider::cuboid([1.0; 3], [1.0; 3], [0.0; 3]);
    assert_eq!(touch(&lattice, samples.clone(), outer).contacts, samples.count());
    // Regression bound: fewer than two samples per cell face, of 1/16 each on an area of 24.
    assert!(samples.count() < 2 * 24 * 16, "{}", samples.count());
}

#[test]
fn a_bare_lattice_has_one_sample_at_each_boundary_vertex() {
    let cells: Vec<[i32; 3]> =
        (0..4).flat_map(|z| (0..3).flat_map(move |y| (0..5).map(move |x| [x, y, z]))).collect();
    let lattice = Lattice::from_cells(&cells, 0.5, Point3::new(3.0, 0.0, -1.0), true).unwrap();
    let samples = SampleCells::of_lattice(&lattice, &slots(&lattice), &masses(&lattice));
    assert_eq!(samples.count(), 6 * 4 * 5 - 4 * 2 * 3);
    let ground = Collider::plane([0.0, 0.01, 0.0], [0.0, 1.0, 0.0]);
    let report = touch(&lattice, samples, ground);
    assert_eq!(report.contacts, 6 * 5);
    assert!((report.deepest - 0.02).abs() < 1e-12);
}
