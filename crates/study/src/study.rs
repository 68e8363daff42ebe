//! The study of a scene: point after point, each kept as soon as it is there.

use std::path::PathBuf;

use supple::volume::Preservation;
use supple::{Body, VolumeMeasure};
use supple_io::run::{difference, fingerprint};
use supple_io::scene::Scene;

use crate::error::{Halt, StudyError};
use crate::machine::Machine;
use crate::matrix::Matrix;
use crate::observer::Observer;
use crate::physical::Physical;
use crate::points::Points;
use crate::report::Report;
use crate::setting::Method;

/// A study of a scene.
#[derive(Clone, Debug)]
pub struct Study {
    /// What is studied.
    pub scene: Scene,
    /// What it is called.
    pub name: String,
    /// Where `study.csv`, `study.json` and `study.svg` go; made if it is not there.
    pub directory: PathBuf,
    /// A few points, fewer runs of each.
    pub quick: bool,
    /// Whether to go on where an earlier study ended.
    pub resume: bool,
}

/// How a study ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All points are there.
    Finished,
    /// The observer asked to stop; the points so far are there.
    Stopped,
    /// An earlier study had finished; nothing was written.
    AlreadyFinished,
}

impl Study {
    /// Runs the study.
    ///
    /// # Errors
    ///
    /// A scene that cannot be run, a study that cannot be resumed, a folder that cannot be written.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<(Report, Outcome), StudyError> {
        if self.scene.simulation.frames == 0 {
            return Err(StudyError::NoFrames);
        }
        let fingerprint = self.fingerprint()?;
        let physical = Physical::new(self.scene.clone())?;
        let bodies = physical.as_it_is()?;
        let threads = bodies.simulation.threads();
        let methods = usable(bodies.simulation.bodies());
        let method = physical.method(&bodies.simulation.body(0), &methods);
        let matrix = Matrix::new(&physical, method, &methods, self.quick);
        let mut report = match self.earlier(&fingerprint, threads)? {
            Some(report) if report.complete => return Ok((report, Outcome::AlreadyFinished)),
            Some(report) => report,
            None => Report::new(self, fingerprint, Machine::here(threads), method.name()),
        };
        drop(bodies);
        report.open(&self.directory)?;
        let mut points = Points::new(physical, matrix, self.quick);
        match points.run(&mut report, &self.directory, observer) {
            Ok(()) => {
                report.complete = true;
                report.write(&self.directory)?;
                Ok((report, Outcome::Finished))
            }
            Err(Halt::Stopped) => {
                report.write(&self.directory)?;
                Ok((report, Outcome::Stopped))
            }
            Err(Halt::Failed(error)) => Err(error.later(Report::path(&self.directory))),
        }
    }

    /// What an earlier study must share with this one.
    fn fingerprint(&self) -> Result<String, StudyError> {
        let text = fingerprint(&self.scene)?;
        let (frames, threads) = (self.scene.simulation.frames, self.scene.simulation.threads);
        let options = format!("[study]\nframes = {frames}\nthreads = {threads}\nquick = {}\n", self.quick);
        Ok(options + &text)
    }

    /// The study to go on with.
    fn earlier(&self, fingerprint: &str, threads: usize) -> Result<Option<Report>, StudyError> {
        if !self.resume {
            return Ok(None);
        }
        let Some(report) = Report::read(&self.directory)? else { return Ok(None) };
        let machine = Machine::here(threads);
        let what = match difference(&report.fingerprint, fingerprint) {
            Some(what) => Some(what),
            None if report.machine != machine => {
                Some(format!("it was measured on {}, this is {}", report.machine.line(), machine.line()))
            }
            None => None,
        };
        match what {
            Some(what) => Err(StudyError::Resume { path: Report::path(&self.directory), what }),
            None => Ok(Some(report)),
        }
    }
}

/// The methods that all bodies can have.
fn usable(bodies: &[Body]) -> Vec<Method> {
    let closed = bodies.iter().all(|body| body.alone().volume_report().by(VolumeMeasure::Mesh).is_some());
    let needs_mesh = |method: &Method| method.measure == Preservation::By(VolumeMeasure::Mesh);
    Method::all().into_iter().filter(|method| closed || !needs_mesh(method)).collect()
}
