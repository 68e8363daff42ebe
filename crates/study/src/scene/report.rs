//! Defines the report of a study, which is written as JSON and CSV.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::flight::Free;
use super::point::{self, Distances, Front, Point};
use crate::error::StudyError;
use crate::machine::Machine;
use crate::output::{create_directory, write_json};

/// Report of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Name of the scene.
    pub scene: String,
    /// Whether all points are measured.
    pub complete: bool,
    /// Whether the study is quick: fewer points, each with fewer runs.
    pub quick: bool,
    /// Machine that ran the study.
    pub machine: Machine,
    /// Number of frames of the motion.
    pub frames: u32,
    /// Frames per second.
    pub fps: f64,
    /// Method of volume preservation of the scene's first body, e.g. `off` or `mesh global`.
    pub method: String,
    /// Names of the bodies that the scene lets break. In the study they stay whole.
    #[serde(default)]
    pub kept_whole: Vec<String>,
    /// The measured points.
    pub points: Vec<Point>,
    /// Scene and options as text; a resumed study must have the same text.
    pub fingerprint: String,
}

impl Report {
    /// Returns the path of the report in a directory.
    pub(super) fn path(directory: &Path) -> PathBuf {
        directory.join("study.json")
    }

    /// Reads the report in a directory. Returns `None` if there is no report.
    pub(super) fn read(directory: &Path) -> Result<Option<Self>, StudyError> {
        let path = Self::path(directory);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(StudyError::file("read", &path, error)),
        };
        match serde_json::from_str(&text) {
            Ok(report) => Ok(Some(report)),
            Err(error) => Err(StudyError::Resume { path, what: format!("it is not a study: {error}") }),
        }
    }

    /// Returns whether a point is measured.
    pub(super) fn has(&self, name: &str) -> bool {
        self.points.iter().any(|point| point.name == name)
    }

    /// Creates the directory and writes the report, so that an unwritable directory is an error before a
    /// point is measured.
    pub(super) fn open(&self, directory: &Path) -> Result<(), StudyError> {
        create_directory(directory)?;
        self.save(directory)
    }

    /// Adds a point, updates the fronts and writes the report.
    pub(super) fn add(&mut self, point: Point, directory: &Path) -> Result<(), StudyError> {
        self.points.push(point);
        point::mark(&mut self.points, &self.method);
        self.save(directory)
    }

    /// Returns the rows of `study.csv`: the column names, then one row per point.
    pub(super) fn records(&self) -> Vec<Vec<String>> {
        let mut records = Vec::new();
        for point in &self.points {
            let (names, values): (Vec<_>, Vec<_>) = columns(point).into_iter().unzip();
            if records.is_empty() {
                records.push(names.into_iter().map(str::to_owned).collect());
            }
            records.push(values);
        }
        records
    }

    /// Writes `study.json` to a temporary file and renames it.
    pub(super) fn save(&self, directory: &Path) -> Result<(), StudyError> {
        write_json(&Self::path(directory), self)
    }
}

/// Returns column names and values of a point in `study.csv`. Unknown values are empty.
fn columns(point: &Point) -> Vec<(&'static str, String)> {
    let Point { timing, errors, free, .. } = point;
    // `{:?}` gives the shortest text that parses to the same number.
    let number = |value: f64| format!("{value:?}");
    let optional = |value: Option<f64>| value.map_or_else(String::new, number);
    let goals = |part: fn(&Distances) -> f64| optional(errors.goals.as_ref().map(part));
    let path = |part: fn(&super::point::Path) -> f64| optional(errors.path.as_ref().map(part));
    let free = |part: fn(&Free) -> Option<f64>| optional(free.as_ref().and_then(part));
    let front: Vec<String> = Front::ALL.iter().map(|front| point.front.contains(front).to_string()).collect();
    vec![
        ("axis", point.axis.name().to_owned()),
        ("method", point.method.clone()),
        ("sums", point.sums.clone()),
        ("lattice_vertices", point.lattice_vertices.to_string()),
        ("cell_size", number(point.cell_size)),
        ("half_width", point.half_width.to_string()),
        ("region_factor", number(point.region_factor)),
        ("substeps", point.substeps.to_string()),
        ("alpha", number(point.alpha)),
        ("softened", point.softened.to_string()),
        ("finest", point.finest.to_string()),
        ("ms_step", number(timing.step.median)),
        ("ms_correction", number(timing.correction.median)),
        ("ms_update", number(timing.update.median)),
        ("ms_total", number(timing.total.median)),
        ("ms_total_low", number(timing.total.low)),
        ("ms_total_high", number(timing.total.high)),
        ("repeats", timing.samples.len().to_string()),
        ("goals_rms_cells", goals(|goals| goals.rms_cells)),
        ("goals_max_cells", goals(|goals| goals.max_cells)),
        ("goals_rms", goals(|goals| goals.rms)),
        ("goals_max", goals(|goals| goals.max)),
        ("path_frames", errors.path.map_or_else(String::new, |path| path.frames.to_string())),
        ("path_rms_cells", path(|path| path.distances.rms_cells)),
        ("path_max_cells", path(|path| path.distances.max_cells)),
        ("path_rms", path(|path| path.distances.rms)),
        ("path_max", path(|path| path.distances.max)),
        ("mesh_volume", optional(errors.mesh_volume)),
        ("cells_volume", optional(errors.cells_volume)),
        ("cell_volumes", optional(errors.cell_volumes)),
        ("surface_rms", optional(errors.surface_rms)),
        ("surface_hausdorff", optional(errors.surface_hausdorff)),
        ("capped_frames", errors.capped.to_string()),
        ("linear_momentum", free(|free| Some(free.linear_momentum))),
        ("angular_momentum", free(|free| Some(free.angular_momentum))),
        ("energy_gain", free(|free| free.energy_gain)),
        ("energy_loss", free(|free| free.energy_loss)),
        ("front_surface", front[0].clone()),
        ("front_volume", front[1].clone()),
        ("front_cells", front[2].clone()),
        ("front_path", front[3].clone()),
    ]
}
