//! The measures, built from a lattice and its surface.

use super::adjacency::{Adjacency, DIRECTIONS};
use super::cell_measure::{CellMeasure, FACE_CORNERS};
use super::lattice_measure::LatticeMeasure;
use super::line::Moving;
use super::mesh_measure::MeshMeasure;
use super::surface::{self, Surface};
use super::{Preservation, VolumeError, VolumeMeasure};
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// A volume as an exact cubic of the scale `lambda`, for each component of the lattice.
#[derive(Clone, Debug)]
pub(super) enum Measure {
    Lattice(LatticeMeasure),
    Cells(CellMeasure),
    Mesh(MeshMeasure),
}

impl Measure {
    /// The measure that a choice means; none for [`Preservation::Off`].
    pub(super) fn choose(
        choice: Preservation,
        lattice: &Lattice,
        surface: Option<Surface<'_>>,
        adjacency: &Adjacency,
    ) -> Result<Option<Self>, VolumeError> {
        let mesh = || surface::measure(surface, lattice, adjacency);
        match choice {
            Preservation::Off => Ok(None),
            Preservation::Auto => {
                Ok(Some(mesh().map_or_else(|_| Self::cells(lattice, adjacency), Self::Mesh)))
            }
            Preservation::By(VolumeMeasure::Lattice) => Ok(Some(Self::lattice(adjacency))),
            Preservation::By(VolumeMeasure::Cells) => Ok(Some(Self::cells(lattice, adjacency))),
            Preservation::By(VolumeMeasure::Mesh) => mesh().map(|mesh| Some(Self::Mesh(mesh))),
        }
    }

    pub(super) fn lattice(adjacency: &Adjacency) -> Self {
        let rows = adjacency.rows().to_vec();
        Self::Lattice(LatticeMeasure::new(rows, adjacency.components(), adjacency.of_vertex()))
    }

    pub(super) fn cells(lattice: &Lattice, adjacency: &Adjacency) -> Self {
        let mut faces = Vec::new();
        for (cell, index) in lattice.cells().iter().enumerate() {
            let corners = lattice.cell_corners(cell as u32);
            for (direction, face) in DIRECTIONS.iter().zip(FACE_CORNERS) {
                let beyond = std::array::from_fn(|k| index[k] + direction[k]);
                if lattice.cell_at(beyond).is_none() {
                    faces.push(face.map(|corner| corners[corner]));
                }
            }
        }
        Self::Cells(CellMeasure::new(faces, adjacency.components(), adjacency.of_vertex()))
    }

    pub(super) fn kind(&self) -> VolumeMeasure {
        match self {
            Self::Lattice(_) => VolumeMeasure::Lattice,
            Self::Cells(_) => VolumeMeasure::Cells,
            Self::Mesh(_) => VolumeMeasure::Mesh,
        }
    }

    /// The coefficients of each component's volume in cubed cells, that of `lambda^k` at index `k`.
    pub(super) fn coefficients(&mut self, executor: &Executor, points: &[Moving], out: &mut [[f64; 4]]) {
        match self {
            Self::Lattice(measure) => measure.coefficients(executor, points, out),
            Self::Cells(measure) => measure.coefficients(executor, points, out),
            Self::Mesh(measure) => measure.coefficients(executor, points, out),
        }
    }
}

/// The links of a lattice.
pub(super) fn adjacency(lattice: &Lattice) -> Adjacency {
    let row = |i: u32| lattice.neighbours(i).map(|j| j.unwrap_or(i));
    let components = lattice.components();
    Adjacency::new(
        (0..lattice.len() as u32).map(row).collect(),
        components.of_vertex.clone(),
        components.count,
    )
}

/// Which of the eight cells around each vertex are occupied, as [`super::normals::boundary_normals`] numbers them.
pub(super) fn octants(lattice: &Lattice) -> Vec<u8> {
    let mut octants = vec![0; lattice.len()];
    for cell in 0..lattice.cells().len() as u32 {
        for (corner, vertex) in lattice.cell_corners(cell).into_iter().enumerate() {
            // Seen from its corner `k`, a cell lies towards the opposite corner.
            octants[vertex as usize] |= 1 << (7 - corner);
        }
    }
    octants
}
