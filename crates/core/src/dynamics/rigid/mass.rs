//! Mass, center of mass and inertia tensor of a rigid body.

use nalgebra::{Matrix3, Vector3};

use crate::lattice::Lattice;
use crate::mesh::{Interior, Mesh};

/// Least volume of a mesh whose volume counts, as a fraction of the volume of the cells of its lattice. A flatter mesh is
/// a sheet, which has the masses of its lattice.
const LEAST_VOLUME: f64 = 1e-3;

/// Mass, center of mass and inertia of a body at rest. The mass is in units of a full cell's mass, lengths in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RigidMass {
    pub(crate) mass: f64,
    /// Center of mass, from the lattice vertex with the indices 0.
    pub(crate) center: Vector3<f64>,
    /// Inertia tensor about the center of mass.
    pub(crate) inertia: Matrix3<f64>,
}

impl RigidMass {
    /// Returns the mass of a body: the exact integrals over the volume inside a closed mesh, or the sums over the lattice
    /// vertices, of `masses`, of a bare lattice, an open mesh or a sheet.
    pub(crate) fn new(lattice: &Lattice, mesh: Option<&Mesh>, masses: &[f32]) -> Self {
        let closed = mesh.filter(|mesh| mesh.interior() == Interior::Closed);
        closed
            .and_then(|mesh| Self::of_mesh(lattice, mesh))
            .unwrap_or_else(|| Self::of_vertices(lattice, masses))
    }

    /// Returns the integrals over the volume inside a closed mesh; `None` for a sheet.
    fn of_mesh(lattice: &Lattice, mesh: &Mesh) -> Option<Self> {
        let cell_size = lattice.cell_size();
        let (volume, center, moments) = mesh.volume_moments();
        let mass = volume / cell_size.powi(3);
        let is_solid = mass > LEAST_VOLUME * lattice.cells().len() as f64;
        is_solid.then(|| {
            let moments = moments * (mass / (cell_size * cell_size));
            Self { mass, center: (center - lattice.origin()) / cell_size, inertia: inertia_of(moments) }
        })
    }

    /// Returns the sums over the lattice vertices. `masses`: of each vertex in units of a full cell's mass.
    fn of_vertices(lattice: &Lattice, masses: &[f32]) -> Self {
        let (mass, center, moments) = vertex_moments(lattice, masses);
        Self { mass, center, inertia: inertia_of(moments) }
    }
}

/// Returns the sum M of the masses m of the lattice vertices, their center of mass c in cells from the vertex with the
/// indices 0, and their second moments Σ m (x - c)(x - c)ᵀ in squared cells.
pub(crate) fn vertex_moments(lattice: &Lattice, masses: &[f32]) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let vertices = || {
        let points = lattice.indices().iter().map(|index| Vector3::from(index.map(f64::from)));
        points.zip(masses.iter().map(|&mass| f64::from(mass)))
    };
    let mass: f64 = vertices().map(|(_, mass)| mass).sum();
    let center = vertices().map(|(point, mass)| mass * point).sum::<Vector3<f64>>() / mass;
    let moment = |(point, mass): (Vector3<f64>, f64)| mass * (point - center) * (point - center).transpose();
    (mass, center, vertices().map(moment).sum())
}

/// Returns the inertia tensor with the second moments Σ m x xᵀ.
fn inertia_of(moments: Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * moments.trace() - moments
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::lattice::{LatticeOptions, Resolution};
    use crate::mesh::testing::cuboid;

    #[test]
    fn mass_of_a_closed_mesh_is_exact() {
        // A box of 2 x 3 x 5 about (1, 2, 3).
        let mesh = cuboid([0.0, 0.5, 0.5], [2.0, 3.5, 5.5]);
        let options = LatticeOptions { resolution: Resolution::CellSize(0.7), ..LatticeOptions::default() };
        let lattice = Lattice::from_mesh(&mesh, &options).unwrap();
        let cell = lattice.cell_size();
        let RigidMass { mass, center, inertia } =
            RigidMass::new(&lattice, Some(&mesh), &vec![1.0; lattice.len()]);
        assert!((mass * cell.powi(3) - 30.0).abs() < 1e-12);
        let center: Point3<f64> = lattice.origin() + center * cell;
        assert!((center - Point3::new(1.0, 2.0, 3.0)).norm() < 1e-12);
        // m/12 (b² + c²), of the edges 2, 3, 5.
        let expected = Matrix3::from_diagonal(&(Vector3::new(34.0, 29.0, 13.0) * (30.0 / 12.0)));
        assert!((inertia * cell.powi(5) - expected).norm() < 1e-10);
    }

    #[test]
    fn mass_of_a_bare_lattice_is_that_of_its_vertices() {
        let lattice = Lattice::from_cells(&[[0, 0, 0]], 0.5, Point3::origin(), false).unwrap();
        let RigidMass { mass, center, inertia } = RigidMass::new(&lattice, None, &[0.125; 8]);
        assert_eq!((mass, center), (1.0, Vector3::repeat(0.5)));
        assert!((inertia - Matrix3::identity() * 0.5).norm() < 1e-12);
    }
}
