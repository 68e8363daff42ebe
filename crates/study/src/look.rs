//! What is shown of a point: run times, volumes, and the surface beside the finest.

use std::time::Duration;

use nalgebra::Point3;
use supple::{Body, Display, VolumeMeasure};
use supple_io::run::Prepared;

use crate::cells;
use crate::error::Halt;
use crate::moments::is_moment;
use crate::motion::Motion;
use crate::observer::Meter;
use crate::physical::Physical;
use crate::setting::Setting;
use crate::surface::distance;
use crate::timing::Sample;

/// Moments at which surfaces and the volumes of the cells are looked at, evenly spread, the last frame among them.
const MOMENTS: u32 = 12;

/// The surfaces of all bodies at each moment.
pub(crate) type Surfaces = Vec<Vec<Vec<Point3<f64>>>>;

/// What a whole run of a point has shown.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shown {
    pub(crate) sample: Sample,
    /// Greatest relative error of the volume that the meshes enclose; `None` where a mesh encloses none.
    pub(crate) mesh_volume: Option<f64>,
    /// Greatest relative error of the volume of all cells of a body.
    pub(crate) cells_volume: f64,
    /// Root mean square of the relative errors of the cells' volumes.
    pub(crate) cell_volumes: f64,
    pub(crate) surfaces: Surfaces,
    /// Frames in which the correction of any body met its cap.
    pub(crate) capped: u32,
}

/// Runs a point once, through so many frames, and looks at all that it shows. `model` is the point without a correction.
pub(crate) fn run(
    physical: &Physical,
    setting: &Setting,
    model: &Prepared,
    frames: u32,
    meter: &mut Meter<'_>,
) -> Result<Shown, Halt> {
    let sums = setting.dynamics.sums;
    let mut motion = Motion::new(physical.prepare(setting)?, model, physical.scene(), sums)?;
    let mut shown = Shown { mesh_volume: Some(0.0), ..Shown::default() };
    let (mut watch, mut count, mut squares) = (Watch::new(model), 0, 0.0);
    for frame in 1..=frames {
        watch.frame(&mut motion)?;
        let (simulation, mut capped) = (&motion.simulation, false);
        let bodies = || (0..simulation.bodies().len()).map(|index| simulation.body(index));
        for body in bodies() {
            let report = body.volume_report();
            let error =
                |measure| report.by(measure).map(|volumes| (volumes.after / volumes.rest - 1.0).abs());
            shown.cells_volume = shown.cells_volume.max(error(VolumeMeasure::Cells).unwrap_or(0.0));
            shown.mesh_volume = shown.mesh_volume.zip(error(VolumeMeasure::Mesh)).map(|(a, b)| a.max(b));
            capped |= report.capped;
        }
        shown.capped += u32::from(capped);
        if is_moment(frame, frames, MOMENTS) {
            shown.surfaces.push(bodies().map(|body| body.surface().positions).collect());
            for body in bodies() {
                squares += cells::errors(body).map(|error| error * error).sum::<f64>();
                count += body.lattice().cells().len();
            }
        }
        meter.tick()?;
    }
    shown.sample = watch.sample(frames);
    shown.cell_volumes = (squares / count as f64).sqrt();
    Ok(shown)
}

/// Runs a point of the fast sums so many times, and does nothing but what a run of the program does.
pub(crate) fn time(
    physical: &Physical,
    setting: &Setting,
    repeats: u32,
    meter: &mut Meter<'_>,
) -> Result<Vec<Sample>, Halt> {
    let frames = physical.scene().simulation.frames;
    let prepared = physical.prepare(setting)?;
    let mut watch = Watch::new(&prepared);
    let start = prepared.simulation.state();
    let mut motion = Motion::fast(prepared);
    let mut samples = Vec::new();
    for _ in 0..repeats {
        motion.simulation.restore(&start)?;
        watch.reset();
        for _ in 0..frames {
            watch.frame(&mut motion)?;
            meter.tick()?;
        }
        samples.push(watch.sample(frames));
    }
    Ok(samples)
}

/// Adds up the times of frames.
struct Watch {
    /// One for each body: positions and normals as a frame writer takes them.
    buffers: Vec<(Display, [Vec<[f32; 3]>; 2])>,
    step: Duration,
    correction: Duration,
    update: Duration,
}

impl Watch {
    fn new(prepared: &Prepared) -> Self {
        let vertices = |body: &Body| body.mesh().map_or(0, |mesh| mesh.vertices().len());
        let buffer = |body| (Display::new(), [(); 2].map(|()| vec![[0.0; 3]; vertices(body)]));
        let buffers = prepared.simulation.bodies().iter().map(buffer).collect();
        Self { buffers, step: Duration::ZERO, correction: Duration::ZERO, update: Duration::ZERO }
    }

    fn reset(&mut self) {
        (self.step, self.correction, self.update) = (Duration::ZERO, Duration::ZERO, Duration::ZERO);
    }

    /// Steps a frame and shows it.
    fn frame(&mut self, motion: &mut Motion<'_>) -> Result<(), Halt> {
        self.step += motion.frame()?;
        for (index, (display, [positions, normals])) in self.buffers.iter_mut().enumerate() {
            let mut shown = display.evaluate(motion.simulation.body(index));
            shown.surface_into(positions, Some(normals));
            let times = shown.times();
            self.correction += times.volume;
            self.update += times.embed;
        }
        Ok(())
    }

    fn sample(&self, frames: u32) -> Sample {
        let each = |time: Duration| time.as_secs_f64() * 1e3 / f64::from(frames);
        Sample { step: each(self.step), correction: each(self.correction), update: each(self.update) }
    }
}

/// How far surfaces are from others: root mean square and Hausdorff distance, over the diagonals of the bodies at rest.
pub(crate) fn beside(bodies: &[Body], a: &Surfaces, b: &Surfaces) -> (f64, f64) {
    let (mut squares, mut count, mut hausdorff) = (0.0, 0, 0.0_f64);
    for (a, b) in a.iter().zip(b) {
        for ((a, b), body) in a.iter().zip(b).zip(bodies) {
            let Some(mesh) = body.mesh() else { continue };
            let (low, high) = mesh.bounds();
            let diagonal = (high - low).norm();
            let distance = distance(a, b, mesh.triangles());
            squares += distance.squares / (diagonal * diagonal);
            count += a.len();
            hausdorff = hausdorff.max(distance.hausdorff / diagonal);
        }
    }
    ((squares / count as f64).sqrt(), hausdorff)
}
