//! The study of the summation as it is written: JSON, CSV, a table for the terminal.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::Vector3;
use serde::Serialize;

use super::block::{Block, DISTANCES};
use crate::error::StudyError;
use crate::machine::Machine;
use crate::output::{open_folder, small, write_csv, write_json};
use crate::timing::Spread;

/// The study of the summation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SumsReport {
    /// Whether all rows are there.
    pub complete: bool,
    /// Where it was run.
    pub machine: Machine,
    /// A row a way to sum and block.
    pub rows: Vec<SumsRow>,
}

/// One way to sum on one block.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SumsRow {
    /// How it sums.
    pub sums: String,
    /// Lattice vertices of the block.
    pub lattice_vertices: usize,
    /// Half-width of the regions, in cells.
    pub half_width: usize,
    /// Errors of the goal positions, an entry a distance.
    pub errors: Vec<SumsError>,
    /// Nanoseconds a vertex: of the sums, without rotations; of the core a whole step.
    pub ns_per_vertex: Option<Spread>,
    /// All of them.
    pub samples: Vec<f64>,
}

/// Errors of goal positions, in cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SumsError {
    /// How far the block's corner is from the origin along each axis, in cells.
    pub distance: f64,
    /// Root mean square.
    pub rms: f64,
    /// Greatest.
    pub max: f64,
}

impl SumsRow {
    pub(super) fn new(block: &Block, sums: String) -> Self {
        let (lattice_vertices, half_width) = (block.len(), block.half_width);
        Self {
            sums,
            lattice_vertices,
            half_width,
            errors: Vec::new(),
            ns_per_vertex: None,
            samples: Vec::new(),
        }
    }

    /// Notes how long it took, in seconds for so many vertices.
    pub(super) fn time(&mut self, seconds: &[f64], vertices: usize) {
        self.samples = seconds.iter().map(|seconds| seconds * 1e9 / vertices as f64).collect();
        self.ns_per_vertex = Some(Spread::of(self.samples.iter().copied()));
    }

    /// Notes how far goal positions are from the true ones.
    pub(super) fn error(&mut self, distance: f64, goals: &[Vector3<f64>], truth: &[Vector3<f64>]) {
        let squares = || goals.iter().zip(truth).map(|(a, b)| (a - b).norm_squared());
        let rms = (squares().sum::<f64>() / goals.len() as f64).sqrt();
        self.errors.push(SumsError { distance, rms, max: squares().fold(0.0, f64::max).sqrt() });
    }
}

const LEGEND: &str = "\
rms error of the goal positions in cells, a block of lattice vertices with its
corner so many cells from the origin along each axis. ns a vertex: of the sums in
plain code on one thread, without rotations; of supple a whole step on one thread.";

impl SumsReport {
    /// Writes `sums.json` and `sums.csv`.
    pub(super) fn write(&self, directory: &Path) -> Result<(), StudyError> {
        open_folder(directory)?;
        write_json(&directory.join("sums.json"), self)?;
        write_csv(&directory.join("sums.csv"), &self.records())
    }

    /// A row a way to sum, block and distance.
    fn records(&self) -> Vec<Vec<String>> {
        let names =
            ["sums", "lattice_vertices", "half_width", "distance", "rms_cells", "max_cells", "ns_per_vertex"];
        let mut records = vec![names.map(str::to_owned).to_vec()];
        for row in &self.rows {
            let time = row.ns_per_vertex.map_or_else(String::new, |spread| format!("{:?}", spread.median));
            records.extend(row.errors.iter().map(|error| {
                let numbers = [error.distance, error.rms, error.max].map(|number| format!("{number:?}"));
                let mut record =
                    vec![row.sums.clone(), row.lattice_vertices.to_string(), row.half_width.to_string()];
                record.extend(numbers);
                record.push(time.clone());
                record
            }));
        }
        records
    }

    /// A table of at most 80 columns.
    pub fn table(&self) -> String {
        let mut text = format!("{}\n", self.machine.line());
        let mut last = None;
        for row in &self.rows {
            let case = (row.lattice_vertices, row.half_width);
            if last != Some(case) {
                let heading = format!("{} vertices, half-width {}", case.0, case.1);
                let _ = write!(text, "\n{heading:<33}");
                for distance in DISTANCES {
                    let _ = write!(text, " {distance:>8}");
                }
                let _ = writeln!(text, " {:>9}", "ns");
                last = Some(case);
            }
            let _ = write!(text, "{:<33}", row.sums);
            for error in &row.errors {
                let _ = write!(text, " {:>8}", small(Some(error.rms)));
            }
            let time = row.ns_per_vertex.map_or_else(String::new, |spread| format!("{:.1}", spread.median));
            let _ = writeln!(text, " {time:>9}");
        }
        text + "\n" + LEGEND
    }
}
