//! The frame files of a run: evaluates its bodies, and writes them to the sinks of each body and of all bodies.

use std::cell::OnceCell;
use std::time::Instant;

use supple::{Display, Simulation};

use super::flush::Flusher;
use super::prepare::Input;
use crate::frames::{
    BodyFrame, Ending, Format, FrameRun, FrameSink, OutputError, Pieces, Record, Sequence, Source, open_sink,
};
use crate::space::FileSpace;

/// A sink and the index of its sequence.
type Sink = (usize, Box<dyn FrameSink>);

/// Returns the simulated seconds per second of the frames: the time scale of a run, and otherwise 1.
fn pace(simulation: &Simulation) -> f64 {
    let fps = simulation.fps().unwrap_or(1.0 / simulation.dt() / simulation.substeps() as f64);
    let pace = fps * simulation.dt() * simulation.substeps() as f64;
    // Without rounding, so that files have the same bits with a time scale of 1 and without one.
    if (pace - 1.0).abs() < 1e-9 { 1.0 } else { pace }
}

/// The open frame files of a run.
#[derive(Debug)]
pub(super) struct Output {
    /// For each body, the sinks of its files.
    bodies: Vec<Vec<Sink>>,
    /// The sinks of the files with all bodies, in the order of the formats.
    run: Vec<Sink>,
    /// The written files that are not on disk yet.
    flusher: Flusher,
    /// Coordinates of the files.
    space: FileSpace,
    /// Evaluated surfaces, one per body.
    displays: Vec<Display>,
    /// Positions of the body that is being written, one per mesh vertex.
    positions: Vec<[f32; 3]>,
    /// Normals of the body that is being written, one per mesh vertex; empty if no sink needs them.
    normals: Vec<[f32; 3]>,
}

impl Output {
    /// Opens the files of `sequences`. Those with one body are, for each format, in the order of the bodies.
    pub(super) fn open(sequences: Vec<Sequence>, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let mut bodies: Vec<Vec<Sink>> = run.sources.iter().map(|_| Vec::new()).collect();
        let mut of_run: Vec<(Format, Sink)> = Vec::new();
        let mut body = 0;
        for (index, sequence) in sequences.into_iter().enumerate() {
            let format = sequence.format;
            let sink = (index, open_sink(sequence, body, run)?);
            if format.is_per_run() {
                of_run.push((format, sink));
            } else {
                bodies[body].push(sink);
                body = (body + 1) % bodies.len();
            }
        }
        of_run.sort_by_key(|(format, _)| *format as u8);
        Ok(Self {
            bodies,
            run: of_run.into_iter().map(|(_, sink)| sink).collect(),
            flusher: Flusher::default(),
            space: run.space,
            displays: Vec::new(),
            positions: Vec::new(),
            normals: Vec::new(),
        })
    }

    /// Evaluates and writes the frame `number` of all bodies, and appends its records to those of their sequences.
    /// `inputs`: one per body, or empty if the inputs are the meshes of the bodies. After each body, calls `written` with
    /// its index, its frame, and the time at which its surface was evaluated.
    pub(super) fn write(
        &mut self,
        number: u64,
        simulation: &Simulation,
        inputs: &[Input],
        records: &mut [Vec<Record>],
        mut written: impl FnMut(usize, &BodyFrame<'_>, Instant),
    ) -> Result<(), OutputError> {
        let Self { bodies, run, space, displays, positions, normals, .. } = self;
        displays.resize_with(simulation.bodies().len(), Display::new);
        for (index, display) in displays.iter_mut().enumerate() {
            let body = simulation.body(index);
            let vertices = body.mesh().map_or(0, |mesh| mesh.vertices().len());
            let needs_normals = bodies[index].iter().chain(&*run).any(|(_, sink)| sink.needs_normals());
            positions.resize(vertices, [0.0; 3]);
            normals.resize(if needs_normals { vertices } else { 0 }, [0.0; 3]);
            let mut displayed = display.evaluate(body);
            displayed.surface_into(positions, needs_normals.then_some(&mut normals[..]));
            let evaluated = Instant::now();
            space.convert_positions(positions);
            space.convert_directions(normals);
            let source = inputs.get(index).map(Input::source).or(body.whole_mesh().map(Source::Mesh));
            let pieces = source.and_then(|source| Pieces::of(&body, source));
            let pace = pace(simulation);
            let (displayed, volumes) = (&displayed, OnceCell::new());
            let body = &*body;
            let frame = BodyFrame { number, positions, normals, pieces, pace, body, displayed, volumes };
            for (sequence, sink) in bodies[index].iter_mut().chain(&mut *run) {
                records[*sequence].extend(sink.push_body(&frame)?);
            }
            written(index, &frame, evaluated);
        }
        for (sequence, sink) in run {
            records[*sequence].extend(sink.finish_frame(simulation)?);
        }
        self.flush();
        Ok(())
    }

    /// Starts to flush the files that were written since the last call.
    fn flush(&mut self) {
        let sinks = self.run.iter_mut().chain(self.bodies.iter_mut().flatten());
        self.flusher.add(sinks.flat_map(|(_, sink)| sink.take_unsynced()));
    }

    /// Removes the bodies of a frame that is not complete.
    pub(super) fn discard(&mut self) {
        self.run.iter_mut().for_each(|(_, sink)| sink.discard());
    }

    /// Returns when the contents of all written frames are on disk. Their names are on disk when the directory is
    /// synchronized too.
    pub(super) fn sync(&mut self) -> Result<(), OutputError> {
        self.flush();
        self.flusher.finish().map_err(|(path, error)| OutputError::io("write", &path)(error))
    }

    /// Gives all files their final form and names. Returns lines about them for the summary of the run.
    pub(super) fn finish(&mut self, ending: Ending) -> Result<Vec<String>, OutputError> {
        let sinks = self.bodies.drain(..).flatten().chain(self.run.drain(..));
        let lines = sinks.map(|(_, sink)| sink.finish(ending)).collect::<Result<Vec<_>, _>>()?;
        Ok(lines.into_iter().flatten().collect())
    }
}
