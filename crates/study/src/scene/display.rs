//! Measures a point of a study: run times, volumes, and the distance from the surface of the finest lattice.

use std::time::Duration;

use nalgebra::{Point3, Vector3};
use supple::{Body, BodyRef, Display, VolumeMeasure};
use supple_io::run::Prepared;

use super::motion::{Motion, is_sampled};
use super::physical::Physical;
use super::point::Errors;
use super::setting::Setting;
use super::surface::distance;
use crate::error::Halt;
use crate::observer::Meter;
use crate::timing::Sample;

/// Number of frames at which surfaces and cell volumes are compared. They are evenly distributed and include
/// the last frame.
const SAMPLES: u32 = 12;

/// Vertex positions of the evaluated surfaces, by sampled frame, body and mesh vertex.
pub(super) type Surfaces = Vec<Vec<Vec<Point3<f64>>>>;

/// Measurements of one run of a point.
pub(super) struct Measured {
    pub(super) sample: Sample,
    /// Errors of the volumes, and the number of frames in which a correction reached its cap; the other
    /// errors are unknown.
    pub(super) errors: Errors,
    pub(super) surfaces: Surfaces,
}

/// Runs a point once for `frames` frames and measures run times, volumes and surfaces. `model` is the same
/// point, prepared without a volume correction.
pub(super) fn run(
    physical: &Physical,
    setting: &Setting,
    model: &Prepared,
    frames: u32,
    meter: &mut Meter<'_>,
) -> Result<Measured, Halt> {
    let sums = setting.dynamics.sums;
    let mut motion = Motion::new(physical.prepare(setting)?, model, physical.scene(), sums)?;
    let (mut cells_volume, mut mesh_volume, mut capped) = (0.0_f64, Some(0.0_f64), 0);
    let (mut timer, mut surfaces, mut count, mut squares) = (Timer::new(model), Vec::new(), 0, 0.0);
    for frame in 1..=frames {
        timer.frame(&mut motion)?;
        let simulation = &motion.simulation;
        let bodies = || (0..simulation.bodies().len()).map(|index| simulation.body(index));
        let reports: Vec<_> = bodies().map(|body| body.volume_report()).collect();
        for report in &reports {
            let error =
                |measure| report.by(measure).map(|volumes| (volumes.after / volumes.rest - 1.0).abs());
            cells_volume = cells_volume.max(error(VolumeMeasure::Cells).unwrap_or(0.0));
            mesh_volume = mesh_volume.zip(error(VolumeMeasure::Mesh)).map(|(a, b)| a.max(b));
        }
        capped += u32::from(reports.iter().any(|report| report.capped));
        if is_sampled(frame, frames, SAMPLES) {
            surfaces.push(bodies().map(|body| body.surface().positions).collect());
            for body in bodies() {
                squares += cell_errors(body).map(|error| error * error).sum::<f64>();
                count += body.lattice().cells().len();
            }
        }
        meter.tick()?;
    }
    let errors = Errors {
        mesh_volume,
        cells_volume: Some(cells_volume),
        cell_volumes: Some((squares / count as f64).sqrt()),
        capped,
        ..Errors::default()
    };
    Ok(Measured { sample: timer.sample(frames), errors, surfaces })
}

/// Times `repeats` runs of a point whose motion the library computes. The runs do the work of `supple run`
/// except writing files, and measure no errors.
pub(super) fn time(
    physical: &Physical,
    setting: &Setting,
    repeats: u32,
    meter: &mut Meter<'_>,
) -> Result<Vec<Sample>, Halt> {
    let frames = physical.scene().simulation.frames;
    let prepared = physical.prepare(setting)?;
    let mut timer = Timer::new(&prepared);
    let start = prepared.simulation.state();
    let mut motion = Motion::fast(prepared);
    let mut samples = Vec::new();
    for _ in 0..repeats {
        motion.simulation.restore(&start)?;
        timer.times = [Duration::ZERO; 3];
        for _ in 0..frames {
            timer.frame(&mut motion)?;
            meter.tick()?;
        }
        samples.push(timer.sample(frames));
    }
    Ok(samples)
}

/// Runs frames and adds up their times.
struct Timer {
    /// Display of each body, and buffers for positions and normals in the format of the frame writers.
    buffers: Vec<(Display, [Vec<[f32; 3]>; 2])>,
    /// Total times of the steps, of the volume correction and of the mesh update.
    times: [Duration; 3],
}

impl Timer {
    fn new(prepared: &Prepared) -> Self {
        let vertices = |body: &Body| body.mesh().map_or(0, |mesh| mesh.vertices().len());
        let buffer = |body| (Display::new(), [(); 2].map(|()| vec![[0.0; 3]; vertices(body)]));
        let buffers = prepared.simulation.bodies().iter().map(buffer).collect();
        Self { buffers, times: [Duration::ZERO; 3] }
    }

    /// Makes the steps of one frame and evaluates the surfaces.
    fn frame(&mut self, motion: &mut Motion<'_>) -> Result<(), Halt> {
        self.times[0] += motion.frame()?;
        for (index, (display, [positions, normals])) in self.buffers.iter_mut().enumerate() {
            let mut evaluated = display.evaluate(motion.simulation.body(index));
            evaluated.surface_into(positions, Some(normals));
            let times = evaluated.times();
            self.times[1] += times.volume;
            self.times[2] += times.mesh_update;
        }
        Ok(())
    }

    /// Returns the mean times per frame.
    fn sample(&self, frames: u32) -> Sample {
        let milliseconds = |time: Duration| time.as_secs_f64() * 1e3 / f64::from(frames);
        let [step, correction, update] = self.times.map(milliseconds);
        Sample { step, correction, update }
    }
}

/// Returns the root mean square distance of corresponding vertices and the Hausdorff distance between the
/// surfaces `a` and `b`, relative to the diagonal of the bounding box of each mesh at rest.
pub(super) fn surface_distance(bodies: &[Body], a: &Surfaces, b: &Surfaces) -> (f64, f64) {
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

/// Returns the relative volume error of each cell of the corrected lattice.
fn cell_errors(body: BodyRef<'_>) -> impl Iterator<Item = f64> {
    let (lattice, positions) = (body.lattice(), body.corrected_positions());
    let rest = lattice.cell_size().powi(3);
    (0..lattice.cells().len() as u32).map(move |cell| {
        let corners = lattice.cell_corners(cell).map(|vertex| positions[vertex as usize].coords);
        volume(&corners) / rest - 1.0
    })
}

/// Corners of the faces of a cell, counter-clockwise seen from outside.
const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Returns the volume of a trilinear cell. The volume between the first corner and a bilinear face is the
/// mean of the volumes for the two triangulations of the face.
fn volume(corners: &[Vector3<f64>; 8]) -> f64 {
    let twelve_times_volume = |face: &[usize; 4]| {
        let [a, b, c, d] = face.map(|corner| corners[corner] - corners[0]);
        let product = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| a.dot(&b.cross(c));
        product(&a, &b, &c) + product(&a, &c, &d) + product(&a, &b, &d) + product(&b, &c, &d)
    };
    FACES.iter().map(twelve_times_volume).sum::<f64>() / 12.0
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use supple::Lattice;
    use supple::Preservation;

    use super::*;

    /// Returns the corners of the unit cube, mapped by `map`.
    fn corners(map: impl Fn(Vector3<f64>) -> Vector3<f64>) -> [Vector3<f64>; 8] {
        std::array::from_fn(|k| map(Vector3::from_fn(|axis, _| (k >> axis & 1) as f64)))
    }

    #[test]
    fn the_volume_of_an_affine_cell_is_the_determinant() {
        let map = Matrix3::new(1.0, 0.3, 0.0, -0.2, 2.0, 0.1, 0.4, 0.0, 1.5);
        let cell = corners(|x| map * x + Vector3::repeat(7.0));
        assert!((volume(&cell) - map.determinant()).abs() < 1e-13);
        assert!((volume(&corners(|x| Vector3::new(-x.x, x.y, x.z))) + 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_sum_of_cell_volumes_equals_the_measure_cells_of_the_library() {
        let cells: Vec<[i32; 3]> = (0..24).map(|i| [i % 2, i / 2 % 3, i / 6]).collect();
        let lattice = Lattice::from_cells(&cells, 0.5, Point3::origin(), true).unwrap();
        let mut body = Body::from_lattice(lattice).volume(Preservation::Off).build().unwrap();
        let bent = |x: &Point3<f64>| {
            Point3::new(x.x + 0.2 * (3.0 * x.y).sin(), 1.3 * x.y * x.x.cosh(), x.z + x.x * x.y)
        };
        let positions: Vec<_> = body.positions().iter().map(bent).collect();
        body.set_positions(&positions).unwrap();
        let sum: f64 = cell_errors(body.alone()).map(|error| (error + 1.0) * 0.125).sum();
        let measured = body.alone().volume_report().by(VolumeMeasure::Cells).unwrap().after;
        assert!((sum / measured - 1.0).abs() < 1e-6, "{sum} {measured}");
    }
}
