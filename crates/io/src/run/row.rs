//! What one frame of one body took and came to.

use std::time::Duration;

use supple::{Body, DisplayTimes, VolumeReport};

/// What one frame of one body took and came to. Times are milliseconds of wall clock for the frame,
/// volumes cubic lengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The number of the frame, as in its file's name.
    pub frame: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Name of the body.
    pub body: String,
    /// The steps since the frame before.
    pub ms_step: f64,
    /// Volume correction.
    pub ms_volume: f64,
    /// The mesh update with its normals.
    pub ms_embed: f64,
    /// Writing the frame.
    pub ms_write: f64,
    /// The volume that is kept, by the body's measure.
    pub volume_rest: f64,
    /// Its volume before correction.
    pub volume_before: f64,
    /// Its volume after correction.
    pub volume_after: f64,
    /// Length by which the correction moves along the field.
    pub lambda: f64,
    /// What the correction left over, as a fraction of the rest volume.
    pub residual: f64,
    /// Whether lambda met its cap.
    pub capped: bool,
    /// Kinetic energy of the lattice, kg length^2/s^2.
    pub energy_kinetic: f64,
    /// Speed of the fastest lattice vertex, length/s.
    pub max_speed: f64,
}

/// What a frame of a body took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    /// The steps since the frame before.
    pub(super) step: Duration,
    /// Volume correction and mesh update.
    pub(super) display: DisplayTimes,
    /// Writing.
    pub(super) write: Duration,
}

impl Row {
    /// The row of a body as it is now.
    pub(super) fn of(frame: u64, time: f64, body: &Body, volume: &VolumeReport, times: Times) -> Self {
        let milliseconds = |duration: Duration| duration.as_secs_f64() * 1e3;
        let masses = body.masses();
        let squares: Vec<f64> = body.velocities().iter().map(|velocity| velocity.norm_squared()).collect();
        Self {
            frame,
            time,
            body: body.name().to_owned(),
            ms_step: milliseconds(times.step),
            ms_volume: milliseconds(times.display.volume),
            ms_embed: milliseconds(times.display.embed),
            ms_write: milliseconds(times.write),
            volume_rest: volume.rest,
            volume_before: volume.before,
            volume_after: volume.after,
            lambda: volume.lambda,
            residual: volume.residual,
            capped: volume.capped,
            energy_kinetic: masses.iter().zip(&squares).map(|(mass, square)| mass * square / 2.0).sum(),
            max_speed: squares.iter().copied().fold(0.0, f64::max).sqrt(),
        }
    }
}
