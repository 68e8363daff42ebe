//! Studies a scene: error against run time for many settings. A point is the scene run with one setting.
//!
//! | file | contents |
//! |---|---|
//! | `physical`, `grid` | the scene with materials in lengths and seconds; regions and stiffness of a body |
//! | `setting`, `matrix` | the parameters of a point; the list of all points |
//! | `points` | measures all points, with the following modules |
//! | `display`, `surface` | run times, volumes, and the distance from the surface of the finest lattice |
//! | `motion_errors`, `motion`, `naive` | goal positions and path, compared with the naive sums |
//! | `flight` | conservation of momenta and energy in free flight |
//! | `point`, `report`, `table`, `plot` | the results |

mod display;
mod flight;
mod grid;
mod matrix;
mod motion;
mod motion_errors;
mod naive;
mod physical;
mod plot;
mod point;
mod points;
mod report;
mod setting;
mod surface;
mod table;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use supple::{Body, Preservation, VolumeMeasure};
use supple_io::run::{difference, fingerprint, prepare};
use supple_io::scene::{BodyData, Scene};

use crate::error::{Halt, StudyError};
use crate::machine::Machine;
use crate::observer::{Observer, Outcome};
use crate::output::write_csv;
use matrix::Matrix;
use physical::Physical;
use points::Points;
use setting::Method;

pub use flight::Free;
pub use point::{Distances, Errors, Front, Path, Point};
pub use report::Report;
pub use setting::Axis;

/// A study of a scene.
#[derive(Clone, Debug)]
pub struct Study {
    /// Scene to study.
    pub scene: Scene,
    /// Name of the scene in the report.
    pub name: String,
    /// Output directory of `study.csv`, `study.json` and `study.svg`; created if it does not exist.
    pub directory: PathBuf,
    /// Whether to measure fewer points, each with fewer runs.
    pub quick: bool,
    /// Whether to continue an earlier study.
    pub resume: bool,
}

impl Study {
    /// Runs the study.
    ///
    /// # Errors
    ///
    /// The scene cannot be run, the study cannot be resumed, or the output directory cannot be written.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<(Report, Outcome), StudyError> {
        if self.scene.simulation.frames == 0 {
            return Err(StudyError::NoFrames);
        }
        if let Some(data) = self.scene.bodies.iter().find(|data| !data.zones.is_empty()) {
            return Err(StudyError::Zones { body: data.name.clone() });
        }
        let Scene { simulation, bodies, .. } = &self.scene;
        let touches_itself = |data: &BodyData| data.touching.self_contact.unwrap_or(simulation.self_contact);
        if simulation.contact && bodies.len() > 1 || bodies.iter().any(touches_itself) {
            return Err(StudyError::BodyContact);
        }
        let fingerprint = self.fingerprint()?;
        // The reference does not break, so that the study compares bodies that stay whole.
        let (mut scene, mut kept_whole) = (self.scene.clone(), Vec::new());
        for data in scene.bodies.iter_mut().filter(|data| data.fracture.is_some()) {
            kept_whole.push(data.name.clone());
            data.fracture = None;
        }
        let physical = Physical::new(scene)?;
        let bodies = prepare(physical.scene())?;
        let threads = bodies.simulation.threads();
        let methods = usable(bodies.simulation.bodies());
        let method = physical.method(&bodies.simulation.body(0), &methods);
        let matrix = Matrix::new(&physical, method, &methods, self.quick);
        let mut report = match self.earlier(&fingerprint, threads)? {
            Some(report) if report.complete => return Ok((report, Outcome::AlreadyFinished)),
            Some(report) => report,
            None => Report {
                scene: self.name.clone(),
                complete: false,
                quick: self.quick,
                machine: Machine::here(threads),
                frames: self.scene.simulation.frames,
                fps: self.scene.simulation.fps,
                method: method.name(),
                kept_whole,
                points: Vec::new(),
                fingerprint,
            },
        };
        drop(bodies);
        report.open(&self.directory)?;
        let mut points = Points::new(physical, matrix, self.quick);
        let outcome = match points.run(&mut report, &self.directory, observer) {
            Ok(()) => Outcome::Finished,
            Err(Halt::Stopped) => Outcome::Stopped,
            Err(Halt::Failed(error)) => return Err(error.after_writing(Report::path(&self.directory))),
        };
        report.complete = outcome == Outcome::Finished;
        self.write(&report)?;
        Ok((report, outcome))
    }

    /// Writes all output files.
    fn write(&self, report: &Report) -> Result<(), StudyError> {
        report.save(&self.directory)?;
        write_csv(&self.directory.join("study.csv"), &report.records())?;
        plot::write(report, &self.directory.join("study.svg"))
    }

    /// Returns scene and options as text. A study can be resumed only if this text has not changed.
    fn fingerprint(&self) -> Result<String, StudyError> {
        let text = fingerprint(&self.scene)?;
        let (frames, threads) = (self.scene.simulation.frames, self.scene.simulation.threads);
        let options = format!("[study]\nframes = {frames}\nthreads = {threads}\nquick = {}\n", self.quick);
        Ok(options + &text)
    }

    /// Reads the earlier study to resume, if there is one.
    fn earlier(&self, fingerprint: &str, threads: usize) -> Result<Option<Report>, StudyError> {
        if !self.resume {
            return Ok(None);
        }
        let Some(report) = Report::read(&self.directory)? else { return Ok(None) };
        let machine = Machine::here(threads);
        let other_machine = || {
            (report.machine != machine)
                .then(|| format!("it was measured on {}, not on {}", report.machine.line(), machine.line()))
        };
        match difference(&report.fingerprint, fingerprint).or_else(other_machine) {
            Some(what) => Err(StudyError::Resume { path: Report::path(&self.directory), what }),
            None => Ok(Some(report)),
        }
    }
}

/// Returns the methods that all bodies support.
fn usable(bodies: &[Body]) -> Vec<Method> {
    let closed = bodies.iter().all(|body| body.alone().volume_report().by(VolumeMeasure::Mesh).is_some());
    let needs_mesh = |method: &Method| method.measure == Preservation::By(VolumeMeasure::Mesh);
    Method::all().into_iter().filter(|method| closed || !needs_mesh(method)).collect()
}
