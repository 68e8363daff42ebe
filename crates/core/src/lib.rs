//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.
//!
//! A body is a lattice of cubic cells that covers its mesh. Each step fits a rigid motion to the region around every
//! lattice vertex, and draws the vertices to the goal positions that these motions give; that cannot blow up. The mesh is
//! carried along, and what is shown has its volume restored. No tetrahedra, no stiffness matrix.
//!
//! ```
//! use supple::{Body, Collider, Mesh, Simulation};
//!
//! // A cube of edge 1, as six quads seen from outside.
//! let corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(f64::from)).collect();
//! let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let mesh = Mesh::new(corners, &quads)?;
//!
//! let body = Body::builder(mesh).lattice_vertices(500).half_width(2).region_damping_rate(4.0).build()?;
//! let ground = Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]);
//! let mut simulation = Simulation::builder().body(body).collider(ground).dt(1.0 / 120.0).build()?;
//! simulation.steps(240);
//!
//! let surface = simulation.body(0).surface();
//! assert!(surface.positions.iter().all(|p| p.y > -0.51));
//! let volume = simulation.body(0).volume_report();
//! assert!((volume.after - 1.0).abs() < 1e-5);
//! # Ok::<(), supple::Error>(())
//! ```
//!
//! # The pipeline, in order
//!
//! Once for a body ([`Body::builder`], [`Body::from_lattice`]):
//!
//! 1. **Mesh** ([`Mesh`]): polygons of any kind; what is unusual is reported, not refused.
//! 2. **Lattice** ([`Lattice`]): the cells that the surface passes through or encloses. Vertices sit on their corners, links
//!    join neighbours along an axis. Nothing is glued across a gap of a cell or more.
//! 3. **Embedding**: the cell of each mesh vertex and its place in it.
//!
//! In each step ([`Simulation::step`]), with h its length, x and v the positions and velocities, f external forces and a
//! gravity:
//!
//! 1. **Forces** ([`Body::apply_force`]): v += h f/m.
//! 2. **Region damping** ([`RegionDamping`]): the velocities move towards the mean rigid velocity of the regions.
//! 3. **Matching** ([`Body::goals`]): moments of all regions by window sums along x, y and z, a rotation for each
//!    ([`rotations()`]), and the adjoint of the sums, which gives the goal positions g. v += alpha (g - x)/h + h a.
//! 4. **Integration**: x += h v, with the momenta of free bodies kept in f64.
//! 5. **Contacts** ([`Collider`]): impulses on the visible surface.
//! 6. **Constraints** ([`Pin`], [`Handle`]): held vertices follow their motion.
//!
//! Where a body is shown ([`Display`], [`BodyRef::surface`]), and never fed back:
//!
//! 1. **Volume correction** ([`VolumeOptions`]): the lattice moves along a smooth field that moves the surface by its
//!    normals, by the root of a cubic.
//! 2. **Mesh update**: trilinear in the cells, with normals.
//!
//! [`Simulation::plan`] lists the stages of a simulation; a stage that it does not need takes no time and no memory.
//! [`reference`](mod@reference) is the same method in its naive form, the oracle of the tests.
//!
//! # Units and conventions
//!
//! Lengths are in the units of the mesh, times in seconds, masses in kilograms, angles in degrees but for `spin` (rad/s). Axes are
//! right-handed, and none is "up" but for gravity. Positions are `Point3<f64>` and vectors `Vector3<f64>` of nalgebra; where one is
//! passed, `[f64; 3]` will do, and long arrays that are passed or written have rows `[T; 3]`. Axes 0, 1, 2 are x, y, z; corner k of a cell lies at the offset
//! `(k & 1, k >> 1 & 1, k >> 2 & 1)`; lattice vertices are sorted by z, then y, then x. Results have the same bits for any
//! number of threads. Contact between bodies is not simulated.
//!
//! # Features
//!
//! | feature | default | what |
//! |---|---|---|
//! | `rayon` | yes | threads |
//! | `serde` | no | serialises [`SimulationState`] and [`BodySnapshot`] |
//!
//! OBJ files, frame sequences and TOML scenes are in the package `supple-io`.
//!
//! # Sources
//!
//! * K. Takamatsu, T. Kanai: Volume-Preserving LSM Deformations, SIGGRAPH Asia 2009 Sketches.
//! * A. Rivers, D. James: FastLSM: Fast Lattice Shape Matching for Robust Real-Time Deformation, SIGGRAPH 2007.
//! * M. Müller, B. Heidelberger, M. Teschner, M. Gross: Meshless Deformations Based on Shape Matching, SIGGRAPH 2005.
//! * W. von Funck, H. Theisel, H.-P. Seidel: Volume-Preserving Mesh Skinning, VMV 2008.

// Stage internals are public for `internals`; without it parts of them are not used.
#![cfg_attr(not(feature = "internals"), allow(dead_code, unreachable_pub, unused_imports))]

mod body;
mod contact;
mod dynamics;
mod error;
mod lattice;
mod matching;
pub mod mesh;
mod parallel;
mod plan;
mod range;
pub mod reference;
mod simd;
mod simulation;
mod skin;
mod state;
mod volume;
mod voxel;

pub use body::{
    ArrayError, Body, BodyBuilder, BodyRef, BodySnapshot, Display, DisplayTimes, Displayed, DisplayedSurface,
    StateError,
};
pub use contact::{Collider, ColliderError, ColliderFault, Shape, SignedDistance};
pub use dynamics::{
    ConstraintError, Handle, Key, Material, MotionError, Pin, RegionDamping, RegionSize, Selection,
    SelectionError, Stiffness, TimeWindow,
};
pub use error::Error;
pub use lattice::{
    Components, FloatingPart, Lattice, LatticeError, LatticeOptions, LatticeReport, Resolution,
};
pub use matching::rotations;
pub use mesh::{Mesh, MeshError};
pub use parallel::Executor;
pub use plan::{BodyPlan, Plan, PlannedStage, When};
pub use range::RangeError;
pub use simd::{Coordinate, SimdError, check_simd_request, simd_level};
pub use simulation::{Simulation, SimulationBuilder, SimulationState};
pub use skin::{VertexNormals, vertex_normals};
pub use state::{Placement, euler_degrees};
pub use volume::{
    ComponentReport, FieldKind, Preservation, VolumeError, VolumeMeasure, VolumeOptions, VolumeReport,
    VolumeScope, Volumes,
};

/// Internals of the stages, for studies, benches and tests. Not part of the interface: they may change at any time.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals {
    pub use crate::contact::{Colliders, ContactReport, Contacts, SampleCells};
    pub use crate::dynamics::{Constraint, Constraints, Motion, Pose};
    pub use crate::lattice::{CellPoints, Embedding};
    pub use crate::simd::lanes::{Lanes, Row};
    pub use crate::state::{BodyFrame, BodyState, Interval, sin_cos_degrees};
    pub use crate::volume::{
        Correction, CorrectionWorkspace, ExternalForce, HALF_FORCE, Root, Surface, VolumeMeasures,
        smallest_root,
    };
}
