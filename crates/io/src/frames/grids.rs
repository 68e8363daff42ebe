//! Writes grids of VTK: the surface or the lattice of a body in a file per frame, `NAME_0007.vtu` or
//! `NAME_0007.lattice.vtu`, and when the run ends `NAME.pvd` or `NAME.lattice.pvd` with their times.

use std::io::Write;
use std::path::PathBuf;

use nalgebra::{Matrix3, Point3, Vector3};
use supple::{Body, Lattice};

use super::error::check_finite;
use super::record::Record;
use super::sink::{BodyFrame, Ending, FrameRun, FrameSink};
use super::{Format, OutputError, Sequence, Source};
use crate::file::{remove_if_present, write_atomically, write_durably};
use crate::space::FileSpace;
use crate::vtk::{Cells, Data, Grid, collection};

/// The files of a body.
#[derive(Debug)]
pub(super) struct GridWriter {
    sequence: Sequence,
    cells: Cells,
    /// The cells after a break, with the version of the topology of the body.
    broken: Option<(u64, Cells)>,
    space: FileSpace,
    /// Young's modulus of the material.
    modulus: Option<f64>,
    fps: f64,
    /// Number of the last frame that was written or kept; `None` if there is none.
    last: Option<u64>,
    /// Numbers of the frames whose files are not flushed to disk yet.
    unsynced: Vec<u64>,
}

impl GridWriter {
    /// Starts the files of a body, or continues them.
    pub(super) fn open(sequence: Sequence, body: usize, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let cells = match sequence.format {
            Format::Lattice => Cells::of_lattice(run.simulation.body(body).lattice()),
            _ => Cells::of_mesh(run.sources[body].mesh()),
        };
        let last =
            run.kept.and_then(|kept| kept.checked_sub(1)).map(|kept| sequence.first + kept * sequence.every);
        let writer = Self {
            cells,
            broken: None,
            space: run.space,
            modulus: run.simulation.body(body).youngs_modulus(),
            fps: run.fps,
            last,
            unsynced: Vec::new(),
            sequence,
        };
        for times in writer.sequence.whole_files() {
            remove_if_present(&times).map_err(OutputError::io("remove", &times))?;
        }
        Ok(writer)
    }

    /// Returns the cells of a body as it is now.
    fn cells(&mut self, body: &Body) -> &Cells {
        let version = body.topology_version();
        if version == 0 {
            return &self.cells;
        }
        if self.broken.as_ref().is_none_or(|(known, _)| *known != version) {
            let cells = match (self.sequence.format, body.mesh()) {
                (Format::Vtu, Some(mesh)) => Cells::of_mesh(mesh),
                _ => Cells::of_lattice(body.lattice()),
            };
            self.broken = Some((version, cells));
        }
        self.broken.as_ref().map_or(&self.cells, |(_, cells)| cells)
    }

    /// Returns the file of the surface of a body.
    fn surface(&mut self, frame: &BodyFrame<'_>) -> Vec<u8> {
        let &BodyFrame { positions, normals, body, .. } = frame;
        let of_points = [("Normals", Data::Vectors(normals))];
        Grid { points: positions, cells: self.cells(body), of_points: &of_points, of_cells: &[] }.bytes()
    }

    /// Returns the file of the lattice of a body.
    fn lattice(&mut self, frame: &BodyFrame<'_>) -> Result<Vec<u8>, OutputError> {
        let (body, space) = (frame.body, self.space);
        let places = body.positions();
        let file = |vector: [f64; 3]| vector.map(|number| number as f32);
        let points: Vec<[f32; 3]> = places.iter().map(|&place| file(space.position(place.into()))).collect();
        check_finite(frame.number, &points)?;
        let scale = space.length(1.0);
        let velocities: Vec<[f32; 3]> =
            body.velocities().iter().map(|&v| file(space.direction((v * scale).into()))).collect();
        let (strains, volumes): (Vec<f32>, Vec<f32>) = deformations(body.lattice(), &places)
            .map(|deformation| {
                let stretches = deformation.singular_values();
                ((stretches.max() - 1.0) as f32, deformation.determinant() as f32)
            })
            .unzip();
        let of_points = [("velocity", Data::Vectors(&velocities))];
        let moduli = self.modulus.map(|modulus| moduli(body, modulus / scale));
        let mut of_cells =
            vec![("strain", Data::Numbers(&strains)), ("volume_ratio", Data::Numbers(&volumes))];
        of_cells.extend(moduli.iter().map(|moduli| ("E", Data::Numbers(moduli))));
        let (cells, of_points, of_cells) = (self.cells(body), &of_points[..], &of_cells[..]);
        Ok(Grid { points: &points, cells, of_points, of_cells }.bytes())
    }
}

/// Returns Young's modulus of each cell: that of the material times the mean factor of its corners.
fn moduli(body: &Body, modulus: f64) -> Vec<f32> {
    let lattice = body.lattice();
    let Some(factors) = body.stiffness_factors() else {
        return vec![modulus as f32; lattice.cells().len()];
    };
    let of_cell = |cell: u32| {
        let corners = lattice.cell_corners(cell).map(|corner| factors[corner as usize]);
        (modulus * corners.iter().sum::<f64>() / 8.0) as f32
    };
    (0..lattice.cells().len() as u32).map(of_cell).collect()
}

/// Returns the deformation gradient of each cell: the mean of its edges along each axis, relative to those at rest.
fn deformations<'a>(
    lattice: &'a Lattice,
    positions: &'a [Point3<f64>],
) -> impl Iterator<Item = Matrix3<f64>> + 'a {
    (0..lattice.cells().len() as u32).map(|cell| {
        let corners = lattice.cell_corners(cell).map(|corner| positions[corner as usize]);
        let edge = |axis: usize| -> Vector3<f64> {
            let starts = (0..8).filter(|corner| corner >> axis & 1 == 0);
            let sum: Vector3<f64> = starts.map(|corner| corners[corner | 1 << axis] - corners[corner]).sum();
            sum / (4.0 * lattice.cell_size())
        };
        Matrix3::from_columns(&[0, 1, 2].map(edge))
    })
}

impl FrameSink for GridWriter {
    fn needs_normals(&self) -> bool {
        self.sequence.format == Format::Vtu
    }

    fn push_body(&mut self, body: &BodyFrame<'_>) -> Result<Option<Record>, OutputError> {
        check_finite(body.number, body.positions)?;
        let bytes =
            if self.sequence.format == Format::Lattice { self.lattice(body)? } else { self.surface(body) };
        let path = self.sequence.path(body.number);
        write_atomically(&path, |file| file.write_all(&bytes)).map_err(OutputError::io("write", &path))?;
        self.unsynced.push(body.number);
        self.last = Some(body.number);
        Ok(Some(Record::of(&bytes)))
    }

    fn take_unsynced(&mut self) -> Vec<PathBuf> {
        self.unsynced.drain(..).map(|frame| self.sequence.path(frame)).collect()
    }

    fn finish(self: Box<Self>, _: Ending) -> Result<Vec<String>, OutputError> {
        let Sequence { first, every, .. } = self.sequence;
        let Some(last) = self.last else { return Ok(Vec::new()) };
        let files: Vec<(f64, String)> = (first..=last)
            .step_by(every as usize)
            .filter_map(|frame| {
                let name = self.sequence.path(frame).file_name()?.to_str()?.to_owned();
                Some(((frame - first) as f64 / self.fps, name))
            })
            .collect();
        let text = collection(files.iter().map(|(time, name)| (*time, &**name)));
        for path in self.sequence.whole_files() {
            write_durably(&path, |file| file.write_all(text.as_bytes()))
                .map_err(OutputError::io("write", &path))?;
        }
        Ok(Vec::new())
    }
}

/// Returns the size of a frame of the surface of a body, in bytes, approximately.
pub(super) fn surface_bytes(source: &Source<'_>) -> u64 {
    let mesh = source.mesh();
    let corners: usize = mesh.faces().map(<[u32]>::len).sum();
    (24 * mesh.vertices().len() + 8 * corners + 9 * mesh.face_count() + 1000) as u64
}

/// Returns the size of a frame of a lattice in the format [`Format::Lattice`], in bytes, approximately.
pub fn lattice_frame_bytes(lattice: &Lattice) -> u64 {
    (24 * lattice.len() + 85 * lattice.cells().len() + 1000) as u64
}

/// Returns whether a sequence whose run has ended has its file with the times.
pub(super) fn is_complete(sequence: &Sequence) -> bool {
    sequence.whole_files().iter().all(|times| times.exists())
}
