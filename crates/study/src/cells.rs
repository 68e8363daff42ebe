//! The volumes of single cells.

use nalgebra::Vector3;
use supple::BodyRef;

/// The relative error of the volume of each cell, as it is shown.
pub(crate) fn errors(body: BodyRef<'_>) -> impl Iterator<Item = f64> {
    let (lattice, positions) = (body.lattice(), body.corrected_positions());
    let rest = lattice.cell_size().powi(3);
    (0..lattice.cells().len() as u32).map(move |cell| {
        let corners = lattice.cell_corners(cell).map(|vertex| positions[vertex as usize].coords);
        volume(&corners) / rest - 1.0
    })
}

/// The faces of a cell, seen from outside.
const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The volume of a trilinear cell: under each of its bilinear faces lies the mean of what lies under its two
/// triangulations.
fn volume(corners: &[Vector3<f64>; 8]) -> f64 {
    let under = |face: &[usize; 4]| {
        let [a, b, c, d] = face.map(|corner| corners[corner] - corners[0]);
        let triangle = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| a.dot(&b.cross(c));
        triangle(&a, &b, &c) + triangle(&a, &c, &d) + triangle(&a, &b, &d) + triangle(&b, &c, &d)
    };
    FACES.iter().map(under).sum::<f64>() / 12.0
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Point3};
    use supple::volume::Preservation;
    use supple::{Lattice, VolumeMeasure};

    use super::*;

    fn corners(place: impl Fn(Vector3<f64>) -> Vector3<f64>) -> [Vector3<f64>; 8] {
        std::array::from_fn(|k| place(Vector3::from_fn(|axis, _| (k >> axis & 1) as f64)))
    }

    #[test]
    fn affine_cells_have_the_volume_of_the_determinant() {
        let map = Matrix3::new(1.0, 0.3, 0.0, -0.2, 2.0, 0.1, 0.4, 0.0, 1.5);
        let cell = corners(|x| map * x + Vector3::repeat(7.0));
        assert!((volume(&cell) - map.determinant()).abs() < 1e-13);
        assert!((volume(&corners(|x| Vector3::new(-x.x, x.y, x.z))) + 1.0).abs() < 1e-15);
    }

    #[test]
    fn all_cells_together_have_the_volume_that_the_core_measures() {
        let cells: Vec<[i32; 3]> = (0..24).map(|i| [i % 2, i / 2 % 3, i / 6]).collect();
        let lattice = Lattice::from_cells(&cells, 0.5, Point3::origin(), true).unwrap();
        let mut body = supple::Body::from_lattice(lattice).volume(Preservation::Off).build().unwrap();
        let bent = |x: &Point3<f64>| {
            Point3::new(x.x + 0.2 * (3.0 * x.y).sin(), 1.3 * x.y * x.x.cosh(), x.z + x.x * x.y)
        };
        let positions: Vec<_> = body.positions().iter().map(bent).collect();
        body.set_positions(&positions).unwrap();
        let sum: f64 = errors(body.alone()).map(|error| (error + 1.0) * 0.125).sum();
        let measured = body.alone().volume_report().by(VolumeMeasure::Cells).unwrap().after;
        assert!((sum / measured - 1.0).abs() < 1e-6, "{sum} {measured}");
    }
}
