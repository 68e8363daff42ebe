//! Defines the report of the summation study, and formats it as JSON, CSV and a table for the terminal.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::Vector3;
use serde::Serialize;

use super::block::{Block, DISTANCES};
use crate::error::StudyError;
use crate::machine::Machine;
use crate::output::{compact, create_directory, write_csv, write_json};
use crate::timing::Spread;

/// Report of the summation study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SumsReport {
    /// Whether all rows are measured.
    pub complete: bool,
    /// Machine that ran the study.
    pub machine: Machine,
    /// One row per variant and block.
    pub rows: Vec<SumsRow>,
}

/// Result of one variant on one block.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SumsRow {
    /// Name of the variant.
    pub sums: String,
    /// Number of lattice vertices of the block.
    pub lattice_vertices: usize,
    /// Half-width of the regions, in cells.
    pub half_width: usize,
    /// Errors of the goal positions, one entry per distance.
    pub errors: Vec<SumsError>,
    /// Run time in nanoseconds per vertex, of the sums without rotations; for the library, of a whole step.
    pub ns_per_vertex: Option<Spread>,
    /// All time samples, in nanoseconds per vertex.
    pub samples: Vec<f64>,
}

/// Errors of goal positions, in cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SumsError {
    /// Distance of the block's corner from the origin along each axis, in cells.
    pub distance: f64,
    /// Root mean square error.
    pub rms: f64,
    /// Maximum error.
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

    /// Sets the run time from samples in seconds, each for `vertices` vertices.
    pub(super) fn time(&mut self, seconds: &[f64], vertices: usize) {
        self.samples = seconds.iter().map(|seconds| seconds * 1e9 / vertices as f64).collect();
        self.ns_per_vertex = Some(Spread::of(self.samples.iter().copied()));
    }

    /// Adds the error of goal positions against the reference.
    pub(super) fn error(&mut self, distance: f64, goals: &[Vector3<f64>], reference: &[Vector3<f64>]) {
        let squares = || goals.iter().zip(reference).map(|(a, b)| (a - b).norm_squared());
        let rms = (squares().sum::<f64>() / goals.len() as f64).sqrt();
        self.errors.push(SumsError { distance, rms, max: squares().fold(0.0, f64::max).sqrt() });
    }
}

const LEGEND: &str = "\
rms error of the goal positions, in cells, of a block of lattice vertices, by the
distance of its corner from the origin along each axis, in cells. ns: time per
vertex on one thread, of the sums in scalar code without rotations; of supple, of
a whole step.";

impl SumsReport {
    /// Writes `sums.json` and `sums.csv`.
    pub(super) fn write(&self, directory: &Path) -> Result<(), StudyError> {
        create_directory(directory)?;
        write_json(&directory.join("sums.json"), self)?;
        write_csv(&directory.join("sums.csv"), &self.records())
    }

    /// Returns the rows of `sums.csv`: one per variant, block and distance.
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

    /// Formats a table of at most 80 columns.
    pub fn table(&self) -> String {
        let mut text = format!("{}\n", self.machine.line());
        let mut last = None;
        for row in &self.rows {
            let block = (row.lattice_vertices, row.half_width);
            if last != Some(block) {
                let heading = format!("{} vertices, half-width {}", block.0, block.1);
                let _ = write!(text, "\n{heading:<33}");
                for distance in DISTANCES {
                    let _ = write!(text, " {distance:>8}");
                }
                let _ = writeln!(text, " {:>9}", "ns");
                last = Some(block);
            }
            let _ = write!(text, "{:<33}", row.sums);
            for error in &row.errors {
                let _ = write!(text, " {:>8}", compact(Some(error.rms)));
            }
            let time = row.ns_per_vertex.map_or_else(String::new, |spread| format!("{:.1}", spread.median));
            let _ = writeln!(text, " {time:>9}");
        }
        text + "\n" + LEGEND
    }
}
