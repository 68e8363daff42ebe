//! What a scene says, as plain data: one field for each key, defaults filled in.

use std::path::PathBuf;

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
    pub colliders: Vec<ColliderData>,
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
    pub format: FormatName,
}

/// The formats of a frame sequence, as they are named in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormatName {
    /// `obj`: one Wavefront OBJ a frame, the input's bytes with new positions and normals.
    Obj,
    /// `ply`: one binary PLY a frame.
    Ply,
    /// `pc2`: one point cache a body.
    Pc2,
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
    /// Degrees about the fixed axes x, then y, then z, applied second; default 0.
    pub rotate: [f64; 3],
    /// Length, applied last; default 0.
    pub translate: [f64; 3],
    /// How fine the lattice is; default 1,000 lattice vertices.
    pub resolution: ResolutionData,
    /// Whether parts that float apart are bridged to the largest; default true.
    pub join: bool,
    /// How far a region reaches; default 2 cells.
    pub reach: Reach,
    /// How strongly goals pull; default alpha = 1 per step.
    pub stiffness: Stiffness,
    /// How much relative motion within a region dies away; default 0.
    pub damping: Damping,
    /// kg per cubic length, above 0; default 1000.
    pub density: f64,
    /// How the volume is kept; default automatic.
    pub volume: VolumeData,
    /// Velocity at the start, length/s; default 0.
    pub velocity: [f64; 3],
    /// Angular velocity at the start, rad/s about the centre of mass; default 0.
    pub spin: [f64; 3],
    /// `[[body.pin]]`, in the order of the file.
    pub pins: Vec<PinData>,
    /// `[[body.handle]]`, in the order of the file.
    pub handles: Vec<HandleData>,
}

/// How fine a lattice is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResolutionData {
    /// `lattice_vertices`: a wished number, met within 5 % where the shape allows; at least 8.
    LatticeVertices(usize),
    /// `cell_size`: a length in the model's frame after `scale`; above 0.
    CellSize(f64),
}

/// How far the region of a lattice vertex reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// `half_width`: linked steps along each axis; at least 1.
    HalfWidth(usize),
    /// `stiffness_radius`: a length, whatever the resolution; above 0.
    StiffnessRadius(f64),
}

/// How strongly goal positions pull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stiffness {
    /// `stiffness`: alpha per step, in (0, 1].
    Alpha(f64),
    /// `frequency`: of the free oscillation about a goal, Hz, above 0.
    Frequency(f64),
}

/// How much the motion within a region is damped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping {
    /// `damping`: share per step, in [0, 1].
    Share(f64),
    /// `damping_rate`: 1/s, at least 0.
    Rate(f64),
}

/// `volume`: how the shown volume is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeData {
    /// Which volume; default automatic.
    pub measure: MeasureData,
    /// Cap on |lambda| as a fraction of the body's thickness; above 0, default 1.
    pub max_correction: f64,
}

/// Which volume is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureData {
    /// `auto`: that of the mesh where it is usable.
    Auto,
    /// `off`: none.
    Off,
    /// `lattice`: the paper's, over lattice vertices.
    Lattice,
    /// `mesh`: the exact volume of the embedded mesh.
    Mesh,
}

/// Which part of a body a pin or a handle takes: world space, frame 0, bounds included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SelectionData {
    /// `box = { min, max }`.
    Box {
        /// Least corner.
        min: [f64; 3],
        /// Greatest corner.
        max: [f64; 3],
    },
    /// `sphere = { center, radius }`.
    Sphere {
        /// Centre.
        center: [f64; 3],
        /// Length, above 0.
        radius: f64,
    },
    /// `plane = { point, normal }`: the side that the normal points to.
    Plane {
        /// A point of the plane.
        point: [f64; 3],
        /// Any length but 0.
        normal: [f64; 3],
    },
}

/// `[[body.pin]]`: held as it is at `from`.
#[derive(Clone, Debug, PartialEq)]
pub struct PinData {
    /// What is held.
    pub selection: SelectionData,
    /// Seconds; default 0.
    pub from: f64,
    /// Seconds, after `from`; `None` is for ever.
    pub until: Option<f64>,
}

/// `[[body.handle]]`: moved along keys, relative to the pose captured at `from`.
#[derive(Clone, Debug, PartialEq)]
pub struct HandleData {
    /// What is moved.
    pub selection: SelectionData,
    /// In the order of time; at least one.
    pub keys: Vec<KeyData>,
    /// Seconds; default 0.
    pub from: f64,
    /// Seconds, after `from`; `None` is for ever.
    pub until: Option<f64>,
}

/// A pose at a time; poses between keys are linear in time, angles too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyData {
    /// Seconds.
    pub time: f64,
    /// Length; default 0.
    pub translate: [f64; 3],
    /// Degrees about the fixed axes x, then y, then z; may exceed a turn; default 0.
    pub rotate: [f64; 3],
}

/// `[[collider]]`: what bodies cannot enter.
#[derive(Clone, Debug, PartialEq)]
pub struct ColliderData {
    /// Its shape at the start.
    pub shape: ShapeData,
    /// Coulomb coefficient, at least 0; default 0.5.
    pub friction: f64,
    /// Share of the normal speed that comes back, [0, 1]; default 0.
    pub restitution: f64,
    /// In the order of time; empty for one that stands still.
    pub keys: Vec<KeyData>,
}

/// The shape of a collider, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeData {
    /// `plane = { point, normal }`: solid on the side that the normal points away from.
    Plane {
        /// A point of the plane.
        point: [f64; 3],
        /// Any length but 0.
        normal: [f64; 3],
    },
    /// `sphere = { center, radius }`.
    Sphere {
        /// Centre.
        center: [f64; 3],
        /// Length, above 0.
        radius: f64,
    },
    /// `box = { center, half_extents, rotate }`.
    Box {
        /// Centre.
        center: [f64; 3],
        /// Half of each edge, above 0.
        half_extents: [f64; 3],
        /// Degrees about the fixed axes x, then y, then z; default 0.
        rotate: [f64; 3],
    },
    /// `capsule = { a, b, radius }`.
    Capsule {
        /// One end of its axis.
        a: [f64; 3],
        /// The other end.
        b: [f64; 3],
        /// Length, above 0.
        radius: f64,
    },
}
