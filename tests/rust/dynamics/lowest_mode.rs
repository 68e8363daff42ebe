//! The lowest elastic mode, compared with the eigenvalues of the linearized reference.

use nalgebra::{DMatrix, Vector3};
use supple::reference::{self, Regions};
use supple::{Body, Material, Simulation};
use supple_tests::{block, lattice, rest};

/// Returns the smallest eigenvalue of K that is not that of a rigid displacement, from the derivatives of the goal
/// positions of the reference: a displacement u moves the goal positions by (1 - K) u.
fn smallest_eigenvalue(size: [i32; 3], half_width: usize) -> f64 {
    let lattice = lattice(&block(size));
    let x = rest(&lattice);
    let masses: Vec<f64> = lattice.occupied_cells().iter().map(|&cells| f64::from(cells) / 8.0).collect();
    let count = 3 * x.len();
    let mut matrix = DMatrix::identity(count, count);
    for column in 0..count {
        let goals = |step: f64| {
            let mut moved = x.clone();
            moved[column / 3][column % 3] += step;
            reference::goals(&lattice, &moved, half_width, Regions::Staircase)
        };
        // The error of the central difference is about the square of the step.
        let (after, before): (Vec<Vector3<f64>>, Vec<Vector3<f64>>) = (goals(1e-4), goals(-1e-4));
        for row in 0..count {
            let derivative = (after[row / 3][row % 3] - before[row / 3][row % 3]) / 2e-4;
            // In the scalar product of the masses, K is symmetric.
            matrix[(row, column)] -= derivative * (masses[row / 3] / masses[column / 3]).sqrt();
        }
    }
    let mut eigenvalues: Vec<f64> =
        ((&matrix + matrix.transpose()) / 2.0).symmetric_eigenvalues().as_slice().to_vec();
    eigenvalues.sort_by(f64::total_cmp);
    assert!(eigenvalues[5].abs() < 1e-6, "six rigid displacements: {eigenvalues:?}");
    eigenvalues[6]
}

#[test]
fn the_lowest_frequency_equals_that_of_the_linearized_reference() {
    for (size, half_width) in
        [([1, 1, 1], 1), ([2, 2, 2], 1), ([3, 3, 3], 1), ([3, 3, 3], 2), ([4, 3, 2], 1), ([8, 2, 2], 2)]
    {
        let body =
            Body::from_lattice(lattice(&block(size))).material(Material::fast_lsm()).half_width(half_width);
        // The angular frequency is sqrt(eigenvalue x alpha)/dt with alpha = 1.
        let world = Simulation::builder().body(body.build().unwrap()).dt(1.0 / std::f64::consts::TAU);
        let found = world.threads(1).build().unwrap().body(0).lowest_frequency().unwrap();
        let expected = smallest_eigenvalue(size, half_width).sqrt();
        // The documented accuracy.
        assert!((found / expected - 1.0).abs() < 0.02, "{size:?}, {half_width}: {found} for {expected}");
    }
}
