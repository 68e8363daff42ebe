//! Soft bodies from any surface mesh: lattice shape matching with volume preservation.
//!
//! A body is a lattice of cubic cells that covers its mesh. Each step fits a rigid motion to the region
//! around every lattice vertex and moves the vertices towards the goal positions that these motions give;
//! this method is unconditionally stable (Müller et al. 2005). The lattice deforms the mesh, and a volume
//! correction restores the volume of the displayed surface. There is no tetrahedral mesh and no stiffness
//! matrix.
//!
//! ```
//! use supple::{Body, Collider, Mesh, Simulation};
//!
//! // A cube of edge 1: six quads, counter-clockwise seen from outside.
//! let corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(f64::from)).collect();
//! let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let mesh = Mesh::new(corners, &quads)?;
//!
//! let body = Body::builder(mesh).lattice_vertices(500).preset(supple::Preset::Flesh).build()?;
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
//! # The pipeline
//!
//! [`Body::builder`] and [`Body::from_lattice`] build a body once:
//!
//! 1. **Mesh** ([`Mesh`], module `mesh`): polygons of any size. Open, non-manifold and self-intersecting
//!    surfaces are accepted and reported.
//! 2. **Lattice** ([`Lattice`], modules `voxel`, `lattice`): the cells that the surface passes through or
//!    encloses. The lattice vertices are the corners of the cells, and links join neighbors along an axis.
//!    Parts of the surface that are a cell or more apart are not linked, except by the optional bridges of
//!    [`LatticeOptions::join`].
//! 3. **Embedding** (module `lattice`): the cell that contains each mesh vertex, and the coordinates of the
//!    mesh vertex in this cell.
//!
//! [`Simulation::step`] runs these stages for each body. In the formulas, h is the step length; x, v and m
//! are the position, velocity and mass of a lattice vertex; f is the external force on the vertex; n is the
//! number of regions that contain the vertex; a is gravity; alpha and d are the stiffness and the region
//! damping per step; superscript 0 marks values in the rest pose, such as x⁰:
//!
//! 1. **Region damping** ([`RegionDamping`], module `dynamics::damping`): v += d (v̄ - v), where v̄ is the
//!    mean of the rigid velocities of the n regions at the vertex (Rivers & James 2007, section 5).
//! 2. **Damping** ([`Damping`], module `dynamics::elastic_damping`): v = r + exp(-2 c h) (v - r), where r is the
//!    reference motion of the connected component, a rigid motion, and c the decay rate of the elastic modes.
//! 3. **Shape matching** ([`Body::goals`], module `matching`): for each region the centers of mass c and c⁰,
//!    weighted by m/n, and the rotation R of Σ m/n (x - c)(x⁰ - c⁰)ᵀ ([`rotations()`]); for each vertex the
//!    goal position g, the mean of R (x⁰ - c⁰) + c over the n regions (Rivers & James 2007, Eqs. (5) and
//!    (6)). The sums over regions are window sums along x, y and z. A tangled body follows its rest shape as a whole
//!    (module `dynamics::recovery`).
//! 4. **Integration** (module `dynamics::integration`): v += alpha (g - x)/h + h a (Müller et al. 2005,
//!    Eq. (9)), then x += h v. The linear and angular momenta of connected components without constrained
//!    vertices are tracked in f64, and the velocities are corrected to them (module `dynamics::momentum`).
//! 5. **External forces** ([`Body::apply_force`], module `dynamics::forces`): v += h f/m and x += h² f/m.
//! 6. **Contacts** ([`Collider`], module `contact`): impulses in the Coulomb friction cone
//!    (`contact::constraint`), at samples of the surface or at the boundary vertices of a bare lattice. Then
//!    samples that are still inside a collider are pushed out.
//!    Bodies that touch each other form an island, whose impulses are computed together with the impulses at its colliders
//!    (module `contact::bodies`).
//! 7. **Constraints** ([`Pin`], [`Handle`], module `dynamics::constraints`): constrained vertices get the
//!    position and the velocity of their pin or handle. A handle moves along keyframes, or follows an animated mesh
//!    ([`HandleMotion::Follow`], module `dynamics::follow`) by rigid moving least squares (Schaefer et al. 2006).
//!
//! The regions of a body with [`Plasticity`] have plastic shapes, which change where they are strained beyond a limit
//! (Müller et al. 2005, module `matching::plastic`).
//!
//! alpha and the size of the regions follow from Young's modulus ([`Elasticity`], [`ElasticLaw`]) and the step length.
//! A body at rest sleeps: it is not stepped ([`Body::is_asleep`]).
//!
//! [`Display`] and [`BodyRef::surface`] evaluate the displayed surface. It never feeds back into the
//! dynamics. Its stages:
//!
//! 1. **Volume correction** ([`VolumeOptions`], module `volume`): the lattice vertices move from their
//!    positions P^ to P~ = P^ + lambda V (Takamatsu & Kanai 2009, Eq. (1)). The field V moves the surface
//!    along its normals, and the scale lambda is the root of a cubic (`volume::cubic`). The directions of
//!    external forces are first removed from V (Eq. (2), `volume::external_forces`).
//!    Before it, and after it again where needed, cells that are inside out are untangled (module `display`).
//! 2. **Mesh update** ([`SkinKind`], module `skin`): interpolation of the mesh in the cells, trilinear or smooth
//!    (`skin::mesh_update`), and normals.
//!
//! [`Simulation::plan`] lists the stages of a simulation. A stage that a body does not need takes no time and
//! no memory. The module [`reference`](mod@reference) implements the method by naive sums; the tests compare
//! the stages with it.
//!
//! # Units and conventions
//!
//! * Lengths are in the units of the mesh, times in seconds, masses in kilograms, angles in degrees. `spin`
//!   is in rad/s.
//! * Axes are right-handed. No axis is special; only gravity defines a vertical direction. Axes 0, 1, 2 are
//!   x, y, z.
//! * Arrays of positions and vectors have nalgebra's `Point3<f64>` and `Vector3<f64>` as elements. A single
//!   point or vector is passed as `[f64; 3]`. Mesh vertices are passed, and displayed surfaces written, as
//!   rows `[T; 3]`.
//! * Corner k of a cell is at the offset `(k & 1, k >> 1 & 1, k >> 2 & 1)`. Lattice vertices are sorted by z,
//!   then y, then x.
//! * Results are bit-identical for any number of threads.
//! * Bodies touch each other ([`SimulationBuilder::contact`], [`BodyBuilder::ignore`]), and themselves on request
//!   ([`SimulationBuilder::self_contact`]). [`Simulation::contacts`] lists the contacts of the last step.
//!
//! # Features
//!
//! | feature | default | effect |
//! |---|---|---|
//! | `rayon` | yes | multithreading |
//! | `serde` | no | serialization of [`SimulationState`] and [`BodySnapshot`] |
//!
//! The crate `supple-io` reads and writes OBJ files, frame sequences and TOML scenes.
//!
//! # References
//!
//! * K. Takamatsu, T. Kanai: Volume-Preserving LSM Deformations, SIGGRAPH Asia 2009 Sketches.
//! * A. Rivers, D. James: FastLSM: Fast Lattice Shape Matching for Robust Real-Time Deformation, SIGGRAPH
//!   2007.
//! * M. Müller, B. Heidelberger, M. Teschner, M. Gross: Meshless Deformations Based on Shape Matching,
//!   SIGGRAPH 2005.
//! * S. Schaefer, T. McPhail, J. Warren: Image Deformation Using Moving Least Squares, SIGGRAPH 2006.
//! * W. von Funck, H. Theisel, H.-P. Seidel: Volume-Preserving Mesh Skinning, VMV 2008.

// Items that only the feature `internals` exports are `pub` with and without it.
#![cfg_attr(not(feature = "internals"), allow(unreachable_pub))]

mod body;
mod clearance;
mod contact;
mod display;
mod dynamics;
mod error;
mod fracture;
mod lattice;
mod matching;
pub mod mesh;
mod motion;
mod parallel;
mod plan;
mod range;
pub mod reference;
mod simd;
mod simulation;
mod skin;
mod sparse_set;
mod state;
mod volume;
mod voxel;

/// The crate whose vectors and points the functions take and return.
pub use nalgebra;

pub use body::{
    AdoptedSettings, Body, BodyBuilder, BodyRef, BodySnapshot, HoldForce, MassProperties, PieceMesh,
    Softened, TouchingOptions,
};
pub use contact::{Collider, ColliderError, ColliderFault, CollisionMesh, Shape, SignedDistance};
pub use display::{Display, DisplayTimes, Displayed, DisplayedSurface, UntanglingReport};
pub use dynamics::{
    Accuracy, Attraction, Constraint, ConstraintError, Damping, ElasticLaw, Elasticity, Field, FieldError,
    FieldLaw, Force, ForceDuration, Goal, Handle, HandleMotion, KeyedMaterial, Link, LinkError, Map,
    Material, Pin, Plasticity, Preset, RegionDamping, RegionSize, RigidError, Selection, SelectionError,
    SelectionPose, Stiffness, TimeWindow, Vortex, Wind, Zone,
};
pub use error::{Error, StateError};
pub use fracture::{
    BreakLimit, BrokenJoint, CrackPlane, CutMesh, CutSurface, FaceSource, FractureOptions, Origin, cut,
};
pub use lattice::{
    Components, FloatingPart, Joint, Lattice, LatticeError, LatticeOptions, LatticeReport, Resolution,
};
pub use matching::{HalfWidth, rotations};
pub use mesh::{AnimationError, Interior, Mesh, MeshAnimation, MeshError, Refine, RefinedMesh, Scale};
pub use motion::{
    Curve, CurveKey, CurveValue, Interpolation, Key, MotionError, Switch, SwitchKey, euler_degrees,
    euler_degrees_near, quaternion_rotation,
};
pub use parallel::Executor;
pub use plan::{BodyPlan, CONTACT_OF_BODIES, Plan, PlannedStage, When};
pub use range::{Range, RangeError};
pub use simd::{Coordinate, SimdError, check_simd_request, simd_level};
pub use simulation::{
    ChosenSubsteps, ColliderMut, ColliderRef, ContactPoint, FoundPoint, LinkRef, Simulation,
    SimulationBuilder, SimulationState, StepReason, Substeps, Touched,
};
pub use skin::{SkinKind, VertexNormals, vertex_normals};
pub use state::{ArrayError, Placement};
pub use volume::{
    ComponentReport, FieldKind, Preservation, VolumeError, VolumeMeasure, VolumeOptions, VolumeReport,
    VolumeScope, Volumes,
};

/// Internals of the stages, for studies, benches and tests. They are not part of the public API.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals {
    pub use crate::body::constraint_factors;
    pub use crate::contact::{Colliders, ContactReport, Contacts, SampleCells};
    pub use crate::dynamics::{Constraint, Constraints};
    pub use crate::lattice::Embedding;
    pub use crate::motion::Motion;
    pub use crate::simd::lanes::Lanes;
    pub use crate::state::{BodyFrame, BodyState, Interval};
    pub use crate::volume::{
        Correction, CorrectionWorkspace, ExternalForce, Root, Surface, VolumeMeasures, smallest_root,
    };
}
