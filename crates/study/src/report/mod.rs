//! A study as it is written: JSON with all of it, CSV, a plot, a table for the terminal.

mod csv;
mod plot;
mod table;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::StudyError;
use crate::front;
use crate::machine::Machine;
use crate::output::{open_folder, write_json};
use crate::point::Point;
use crate::study::Study;

/// A study as it is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// What is studied.
    pub scene: String,
    /// Whether all points are there.
    pub complete: bool,
    /// Whether it is the quick one.
    pub quick: bool,
    /// Where it was run.
    pub machine: Machine,
    /// Frames of the motion.
    pub frames: u32,
    /// Frames per second.
    pub fps: f64,
    /// How the scene itself keeps the volume of its first body.
    pub method: String,
    /// The points.
    pub points: Vec<Point>,
    /// What a study that goes on must share: the scene and the options as text.
    pub fingerprint: String,
}

impl Report {
    pub(crate) fn new(study: &Study, fingerprint: String, machine: Machine, method: String) -> Self {
        Self {
            scene: study.name.clone(),
            complete: false,
            quick: study.quick,
            machine,
            frames: study.scene.simulation.frames,
            fps: study.scene.simulation.fps,
            method,
            points: Vec::new(),
            fingerprint,
        }
    }

    /// Where the report lies in a folder.
    pub(crate) fn path(directory: &Path) -> PathBuf {
        directory.join("study.json")
    }

    /// The report in a folder, if there is one.
    pub(crate) fn read(directory: &Path) -> Result<Option<Self>, StudyError> {
        let path = Self::path(directory);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(StudyError::file("read", &path, error)),
        };
        match serde_json::from_str(&text) {
            Ok(report) => Ok(Some(report)),
            Err(error) => Err(StudyError::Resume { path, what: format!("it is no study: {error}") }),
        }
    }

    /// Whether a point is there.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.points.iter().any(|point| point.name == name)
    }

    /// Makes the folder and writes what is there, so that a folder that cannot be written is found before the work.
    pub(crate) fn open(&self, directory: &Path) -> Result<(), StudyError> {
        open_folder(directory)?;
        self.save(directory)
    }

    /// Adds a point, and keeps it.
    pub(crate) fn add(&mut self, point: Point, directory: &Path) -> Result<(), StudyError> {
        self.points.push(point);
        front::mark(&mut self.points, &self.method);
        self.save(directory)
    }

    /// Writes all files.
    pub(crate) fn write(&self, directory: &Path) -> Result<(), StudyError> {
        self.save(directory)?;
        csv::write(self, &directory.join("study.csv"))?;
        plot::write(self, &directory.join("study.svg"))
    }

    /// Writes `study.json`: under its name only when it is whole.
    fn save(&self, directory: &Path) -> Result<(), StudyError> {
        write_json(&Self::path(directory), self)
    }

    /// A table of at most 80 columns.
    pub fn table(&self) -> String {
        table::of(self)
    }
}
