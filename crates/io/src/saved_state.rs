//! Converts the state of a simulation to bytes, and restores it in any simulation that was built alike.
//!
//! ```text
//! MAGIC | format version, u32 | checksum of the rest, u64 | identity and state, as postcard
//! ```

use serde::{Deserialize, Serialize};
use supple::{Body, Simulation, SimulationState};
use thiserror::Error;
use xxhash_rust::xxh3::{Xxh3Default, xxh3_64};

use crate::count::counted;
use crate::escape::Escaped;
use crate::run::CHECKPOINT_VERSION;

/// First bytes of every state.
const MAGIC: [u8; 8] = *b"SUPPLEST";
/// Size of the header, in bytes: magic, version and checksum.
const HEADER: usize = 8 + 4 + 8;

/// What a state shares with every simulation that it can be restored in.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Identity {
    fps: Option<f64>,
    colliders: usize,
    bodies: Vec<BodyIdentity>,
}

/// What the state of a body shares with the body.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct BodyIdentity {
    name: String,
    /// Number of lattice vertices of the whole body.
    lattice_vertices: usize,
    /// Number of mesh vertices of the whole body, zero for a bare lattice.
    mesh_vertices: usize,
    /// Hash of the cell size, the grid indices of the lattice vertices of the whole body, and the cells.
    lattice: u64,
}

/// Bytes that are no state of a simulation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SavedStateError {
    /// The bytes do not begin like a state.
    #[error("it is not a state of a simulation, or is incomplete; pass what save_state() returned")]
    NotAState,
    /// A state of another version.
    #[error(
        "its format is version {found}, and this is supple with version {CHECKPOINT_VERSION}; save it again"
    )]
    Version {
        /// Version of the state.
        found: u32,
    },
    /// The checksum does not match.
    #[error("it is damaged: its checksum does not match; save it again")]
    Damaged,
    /// A state of a simulation with other bodies, colliders or frames.
    #[error("it is of another simulation: {0}; build the simulation with the same bodies and colliders")]
    Other(String),
    /// The core refuses the state.
    #[error(transparent)]
    State(#[from] supple::Error),
}

/// Returns the state of a simulation as bytes: see [`Simulation::state`].
pub fn save(simulation: &Simulation) -> Vec<u8> {
    let mut bytes = [&MAGIC[..], &CHECKPOINT_VERSION.to_le_bytes(), &[0; 8]].concat();
    // A second copy of the positions, velocities, rotations, and less.
    bytes.reserve(simulation.bodies().iter().map(|body| 64 * body.lattice().len()).sum());
    let content = (Identity::of(simulation), simulation.state());
    let mut bytes = postcard::to_extend(&content, bytes).expect("a vector takes any number of bytes");
    let checksum = xxh3_64(&bytes[HEADER..]);
    bytes[HEADER - 8..HEADER].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// Restores a state that [`save`] returned, in the same simulation or in one that was built with the same bodies,
/// colliders and frames per second. The simulation continues bit-identically.
///
/// # Errors
///
/// Bytes that are damaged or of another version, and the state of another simulation. The simulation is then unchanged.
pub fn restore(simulation: &mut Simulation, bytes: &[u8]) -> Result<(), SavedStateError> {
    let (header, content) = bytes.split_at_checked(HEADER).ok_or(SavedStateError::NotAState)?;
    let (magic, rest) = header.split_first_chunk::<8>().ok_or(SavedStateError::NotAState)?;
    let (version, checksum) = rest.split_first_chunk::<4>().ok_or(SavedStateError::NotAState)?;
    if *magic != MAGIC {
        return Err(SavedStateError::NotAState);
    }
    match u32::from_le_bytes(*version) {
        CHECKPOINT_VERSION => {}
        found => return Err(SavedStateError::Version { found }),
    }
    if *checksum != xxh3_64(content).to_le_bytes() {
        return Err(SavedStateError::Damaged);
    }
    let (identity, content): (Identity, _) =
        postcard::take_from_bytes(content).map_err(|_| SavedStateError::Damaged)?;
    Identity::of(simulation).check(&identity)?;
    let state: SimulationState = postcard::from_bytes(content).map_err(|_| SavedStateError::Damaged)?;
    Ok(simulation.restore(&state)?)
}

impl Identity {
    fn of(simulation: &Simulation) -> Self {
        Self {
            fps: simulation.fps(),
            colliders: simulation.collider_count(),
            bodies: simulation.bodies().iter().map(BodyIdentity::of).collect(),
        }
    }

    /// Checks that a state with the identity `found` can be restored in this simulation.
    fn check(&self, found: &Self) -> Result<(), SavedStateError> {
        let other = |problem: String| Err(SavedStateError::Other(problem));
        let count = |what: &str, state: usize, own: usize| {
            format!("the state has {}, and this one {own}", counted(state, what))
        };
        if found.bodies.len() != self.bodies.len() {
            return other(count("body", found.bodies.len(), self.bodies.len()));
        }
        for (index, (own, found)) in self.bodies.iter().zip(&found.bodies).enumerate() {
            let name = Escaped(&own.name);
            if own.name != found.name {
                return other(format!(
                    "body {index} is {} in the state, and {name} in this one",
                    Escaped(&found.name)
                ));
            }
            let counts = [
                ("lattice vertex", found.lattice_vertices, own.lattice_vertices),
                ("mesh vertex", found.mesh_vertices, own.mesh_vertices),
            ];
            if let Some((what, state, own)) = counts.into_iter().find(|(_, state, own)| state != own) {
                return other(format!("body {name}: {}", count(what, state, own)));
            }
            if own.lattice != found.lattice {
                return other(format!("body {name} has another lattice in the state"));
            }
        }
        if found.colliders != self.colliders {
            return other(count("collider", found.colliders, self.colliders));
        }
        let fps = |fps: Option<f64>| fps.map_or_else(|| "no fps".to_owned(), |fps| format!("fps = {fps}"));
        if found.fps != self.fps {
            return other(format!("the state has {}, and this one {}", fps(found.fps), fps(self.fps)));
        }
        Ok(())
    }
}

impl BodyIdentity {
    fn of(body: &Body) -> Self {
        let lattice = body.lattice();
        let lattice_vertices = lattice.whole_len();
        let mut hash = Xxh3Default::new();
        hash.update(&lattice.cell_size().to_le_bytes());
        hash.update(bytemuck::cast_slice(&lattice.indices()[..lattice_vertices]));
        hash.update(bytemuck::cast_slice(lattice.cells()));
        Self {
            name: body.name().to_owned(),
            lattice_vertices,
            mesh_vertices: body.whole_mesh().map_or(0, |mesh| mesh.vertices().len()),
            lattice: hash.digest(),
        }
    }
}
