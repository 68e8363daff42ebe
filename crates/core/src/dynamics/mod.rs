//! Defines the motion of a body: material, forces, integration, damping, momentum, pins and handles.
//!
//! | file | contents |
//! |---|---|
//! | `material` | region size, stiffness, damping and density |
//! | `plasticity` | yield strain, creep and greatest plastic strain |
//! | `selection` | the part of a body that a pin, a handle, a force or a zone acts on |
//! | `zone` | zones, and the factors of their quantities |
//! | `stiffness_factors` | the factors with which the stiffness varies over a body |
//! | `inflation` | rest volumes that change over time |
//! | `goal` | soft goals: springs in place of prescribed positions |
//! | `handle` | descriptions of pins and handles |
//! | `link` | glue and springs between bodies |
//! | `follow` | handles that follow an animated mesh |
//! | `constraint` | a pin or a handle: prescribed positions and velocities |
//! | `constraint_error` | errors of pins and handles |
//! | `constraints` | all pins and handles of a body |
//! | `field` | accelerations by place and time: wind, drag, vortices, attraction |
//! | `force` | a force on a part of a body: its duration, and its distribution over the vertices |
//! | `forces` | external forces, applied in a step |
//! | `momentum` | the momentum tracker, which keeps the momenta of connected components in f64 |
//! | `elastic_law` | Young's modulus from the parameters of the regions, and back |
//! | `keyed` | numbers of the material that change along keyframes |
//! | `lowest_mode` | the frequency of the lowest elastic mode of a free body |
//! | `elastic_damping` | damping of the elastic modes |
//! | `constrained` | the motion of constrained vertices, for `elastic_damping` |
//! | `varied_damping` | damping at rates that vary over a body, for `elastic_damping` |
//! | `deflection` | deflections of the supports of a body, for `elastic_damping` |
//! | `reaction` | the conditions of supports and their limits, for `elastic_damping` |
//! | `rolling` | rolling resistance, for `elastic_damping` |
//! | `coupling` | the common motion of bodies that press on each other, for `elastic_damping` |
//! | `damping` | region damping: moves velocities towards the mean rigid velocity of the regions |
//! | `integration` | acceleration towards the goal positions and advance of the positions |
//! | `energy` | the energy limiter of bodies without constraints and contacts |
//! | `rigid` | the motion of rigid bodies |
//! | `recovery` | the return of a tangled body to its rest shape |

mod constrained;
mod constraint;
mod constraint_error;
mod constraints;
mod coupling;
mod damping;
mod deflection;
mod elastic_damping;
mod elastic_law;
mod energy;
mod field;
mod follow;
mod force;
mod forces;
mod goal;
mod handle;
mod inflation;
mod integration;
mod keyed;
mod link;
mod lowest_mode;
mod material;
mod momentum;
mod plasticity;
mod reaction;
mod recovery;
mod rigid;
mod rolling;
mod selection;
mod stiffness_factors;
mod varied_damping;
mod zone;

pub use constraint::Constraint;
pub use constraint_error::ConstraintError;
pub use constraints::Constraints;
pub(crate) use coupling::{CoupledComponent, Coupling};
pub(crate) use damping::{MovingRegions, RegionDamper};
pub(crate) use elastic_damping::ElasticDamper;
pub use elastic_law::ElasticLaw;
pub(crate) use elastic_law::half_width_of;
pub(crate) use energy::EnergyLimiter;
pub use field::{Attraction, Field, FieldError, FieldLaw, Vortex, Wind};
pub(crate) use follow::BodyMesh;
pub use force::{Force, ForceDuration};
pub(crate) use force::{Lasting, distribute};
pub(crate) use forces::Forces;
pub use goal::Goal;
pub(crate) use goal::spring_shares;
pub use handle::{Handle, HandleMotion, Pin, TimeWindow};
pub(crate) use inflation::Inflation;
pub(crate) use integration::{Accelerate, Advance, add_rigid};
pub use keyed::KeyedMaterial;
pub use link::{Link, LinkError};
pub(crate) use lowest_mode::lowest_eigenvalue;
pub(crate) use material::effective_gravity;
pub use material::{Accuracy, Damping, Elasticity, Material, Preset, RegionDamping, RegionSize, Stiffness};
pub(crate) use momentum::MomentumTracker;
pub use plasticity::Plasticity;
pub(crate) use reaction::DampingStep;
pub(crate) use recovery::{is_tangled, most_steps, recover};
pub use rigid::RigidError;
pub(crate) use rigid::{HeldVertex, RigidBody, RigidMass, vertex_moments};
pub(crate) use rolling::rolling_resistance;
pub(crate) use selection::valid_weights;
pub use selection::{Map, Selection, SelectionError, SelectionPose};
pub(crate) use stiffness_factors::StiffnessFactors;
pub(crate) use varied_damping::{DampingRates, VariedDamping};
pub use zone::Zone;
pub(crate) use zone::{PartFactors, Quantity};
