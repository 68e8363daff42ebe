//! What a scene says, as plain data: one field for each key, defaults filled in.

use std::path::PathBuf;

use crate::frames::Format;
use supple::dynamics::{Handle, Pin};
use supple::volume::VolumeOptions;
use supple::{Collider, Material, Placement, Resolution};

/// A scene: what is simulated, and how its frames are written.
///
/// Lengths are in whatever unit the meshes use, times in seconds, masses in kilograms.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The folder that `mesh` and `output.directory` are relative to: that of the scene file.
    pub base: PathBuf,
    /// `[simulation]`: time and gravity.
    pub simulation: SimulationData,
    /// `[output]`: where the frames go.
    pub output: OutputData,
    /// `[[body]]`, in the order of the file; at least one.
    pub bodies: Vec<BodyData>,
    /// `[[collider]]`, in the order of the file.
    pub colliders: Vec<Collider>,
}

/// `[simulation]`: time, gravity and threads.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationData {
    /// Frames after frame 0; default 240.
    pub frames: u32,
    /// Frames per second, above 0; default 30.
    pub fps: f64,
    /// Steps per frame; default 2.
    pub substeps: Substeps,
    /// Acceleration of every body, length/s^2; default `[0, -9.81, 0]`.
    pub gravity: [f64; 3],
    /// Threads; 0, the default, takes all.
    pub threads: usize,
}

/// Steps per frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// This many, at least 1.
    Fixed(u32),
    /// As many as the stiffest body and the fastest motion need; see `run::substeps`.
    Auto,
}

/// `[output]`: where the frames go and what they look like.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputData {
    /// Folder of the frames, relative to the scene file; default `frames`.
    pub directory: PathBuf,
    /// File format; default OBJ.
    pub format: Format,
}

/// `[[body]]`: a mesh, how it is placed, and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyData {
    /// Unique name: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// OBJ file, relative to the scene file.
    pub mesh: PathBuf,
    /// Only this `o` or `g` of the file.
    pub object: Option<String>,
    /// Factor on the mesh, applied first; above 0, default 1.
    pub scale: f64,
    /// `rotate`, then `translate`, applied after the scale; `velocity` and `spin` at the start.
    pub placement: Placement,
    /// How fine the lattice is; default 1,000 lattice vertices.
    pub resolution: Resolution,
    /// Whether parts that float apart are bridged to the largest; default true.
    pub join: bool,
    /// `half_width` or `stiffness_radius`, `stiffness` or `frequency`, `damping` or `damping_rate`, `density`.
    pub material: Material,
    /// How the volume is kept; default automatic.
    pub volume: VolumeOptions,
    /// `[[body.pin]]`, in the order of the file.
    pub pins: Vec<Pin>,
    /// `[[body.handle]]`, in the order of the file.
    pub handles: Vec<Handle>,
}
