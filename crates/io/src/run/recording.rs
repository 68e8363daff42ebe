//! Records a simulation that a program advances.

use std::path::Path;

use super::output::Output;
use crate::frames::{Ending, Format, FormatOptions, FrameRun, OutputError, Sequence, Source};
use crate::space::{FileSpace, Up};
use supple::{Body, Simulation};

/// Axes, rate and formats of a recording.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RecordingOptions {
    /// Axis of the file that points up; by default that of the simulation, by [`Up::of_gravity`].
    pub up: Option<Up>,
    /// Length in the file of a length 1 of the simulation, above 0; default 1.
    pub scale: f64,
    /// Frames per second at which the file is played, above 0; by default those of the simulation, or one frame per
    /// step.
    pub fps: Option<f64>,
    /// Settings of single formats.
    pub formats: FormatOptions,
}

impl Default for RecordingOptions {
    fn default() -> Self {
        Self { up: None, scale: 1.0, fps: None, formats: FormatOptions::default() }
    }
}

/// A file with all bodies of a simulation that a program advances: a USD stage, a page, a GLB file or a film. A
/// [`Job`](super::Job) writes such files for scenes.
#[derive(Debug)]
pub struct Recording {
    output: Output,
    /// Number of the next frame.
    next: u64,
}

impl Recording {
    /// Starts the file `path`, and replaces an existing one. Its format is that of the extension: `.usd`, `.html`,
    /// `.glb`, `.webp` or `.gif`. Until the recording ends, the frames are in `path` with `.part`, `.data` or
    /// `.pc2.part` appended.
    ///
    /// # Errors
    ///
    /// If the extension is another one, a body has no mesh, or the file cannot be created.
    pub fn create(
        path: &Path,
        simulation: &Simulation,
        options: &RecordingOptions,
    ) -> Result<Self, OutputError> {
        let extension = path.extension().and_then(|extension| extension.to_str());
        let format = extension.and_then(Format::of_recording);
        let (Some(format), Some(name)) = (format, path.file_stem().and_then(|stem| stem.to_str())) else {
            return Err(OutputError::NoRecording { path: path.to_owned() });
        };
        if let Some(body) = simulation.bodies().iter().find(|body| body.whole_mesh().is_none()) {
            return Err(OutputError::NoMesh { body: body.name().to_owned() });
        }
        let directory = path.parent().unwrap_or(Path::new("")).to_owned();
        let sequence = Sequence { directory, name: name.to_owned(), format, first: 0, every: 1, last: 0 };
        let from = Up::of_gravity(simulation.gravity());
        let run = FrameRun {
            simulation,
            sources: simulation.bodies().iter().filter_map(Body::whole_mesh).map(Source::Mesh).collect(),
            name: name.to_owned(),
            fps: options.fps.or(simulation.fps()).unwrap_or(1.0 / simulation.dt()),
            space: FileSpace::new(from, options.up.unwrap_or(from), options.scale),
            options: options.formats.clone(),
            kept: None,
        };
        sequence.remove_existing()?;
        let output = Output::open(vec![sequence], &run)?;
        Ok(Self { output, next: 0 })
    }

    /// Returns the number of frames so far.
    pub fn frames(&self) -> u64 {
        self.next
    }

    /// Appends a frame with the present state. The bodies and their meshes must be those of [`Recording::create`].
    ///
    /// # Errors
    ///
    /// If the frame cannot be written. The earlier frames stay valid.
    pub fn write(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        let written = self.output.write(self.next, simulation, &[], &mut [Vec::new()], |_, _, _| {});
        written.inspect_err(|_| self.output.discard())?;
        self.next += 1;
        Ok(())
    }

    /// Completes the file and gives it its name. Returns lines about what it holds approximately or not at all, as
    /// [`RunReport::files`](super::RunReport::files).
    ///
    /// # Errors
    ///
    /// If the file cannot be written, or a GLB file or a film has no frames.
    pub fn finish(mut self) -> Result<Vec<String>, OutputError> {
        self.output.sync()?;
        self.output.finish(Ending::Complete)
    }
}
