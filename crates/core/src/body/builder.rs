//! From what a user asks for to a body.

use std::sync::OnceLock;

use super::{Body, FARTHEST, Surface};
use crate::dynamics::{
    Handle, Material, MomentumTracker, Pin, RegionDamper, RegionDamping, RegionSize, Stiffness,
};
use crate::error::Error;
use crate::lattice::{Embedding, Lattice, LatticeOptions, Resolution};
use crate::matching::Matching;
use crate::mesh::Mesh;
use crate::skin::Skin;
use crate::state::{Placement, State, index_bounds};
use crate::volume::{Correction, VolumeOptions};

/// What a [`Body`] is built from. Every setting has the name, the unit, the range and the default that it has in a
/// scene file; [`build`](Self::build) checks them.
#[derive(Clone, Debug)]
#[must_use]
pub struct BodyBuilder {
    name: String,
    shape: Shape,
    options: LatticeOptions,
    scale: f64,
    material: Material,
    placement: Placement,
    volume: VolumeOptions,
    pins: Vec<Pin>,
    handles: Vec<Handle>,
}

#[derive(Clone, Debug)]
enum Shape {
    Mesh(Mesh),
    Lattice(Box<Lattice>),
}

impl BodyBuilder {
    pub(super) fn from_mesh(mesh: Mesh) -> Self {
        Self::from_shape(Shape::Mesh(mesh))
    }

    pub(super) fn from_lattice(lattice: Lattice) -> Self {
        Self::from_shape(Shape::Lattice(Box::new(lattice)))
    }

    fn from_shape(shape: Shape) -> Self {
        Self {
            name: "body".to_owned(),
            shape,
            options: LatticeOptions::default(),
            scale: 1.0,
            material: Material::default(),
            placement: Placement::default(),
            volume: VolumeOptions::default(),
            pins: Vec::new(),
            handles: Vec::new(),
        }
    }

    /// Name of the body; default "body".
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Half-width of the regions in cells, at least 1; default 2. Larger is stiffer; so is a coarser lattice.
    pub fn half_width(mut self, cells: usize) -> Self {
        self.material.region_size = RegionSize::Cells(cells);
        self
    }

    /// Half-width of the regions as a length, > 0: it stays when the resolution changes.
    pub fn stiffness_radius(mut self, radius: f64) -> Self {
        self.material.region_size = RegionSize::Radius(radius);
        self
    }

    /// alpha per step, in (0, 1]; default 1.
    pub fn stiffness(mut self, alpha: f64) -> Self {
        self.material.stiffness = Stiffness::PerStep(alpha);
        self
    }

    /// Stiffness as a frequency in Hz, > 0: it stays when the step changes.
    pub fn frequency(mut self, hertz: f64) -> Self {
        self.material.stiffness = Stiffness::Frequency(hertz);
        self
    }

    /// Region damping per step, in [0, 1]; default 0, which leaves the stage out.
    pub fn region_damping(mut self, share: f64) -> Self {
        self.material.region_damping = RegionDamping::PerStep(share);
        self
    }

    /// Region damping as a rate in 1/s, >= 0: it stays when the step changes.
    pub fn region_damping_rate(mut self, rate: f64) -> Self {
        self.material.region_damping = RegionDamping::Rate(rate);
        self
    }

    /// Mass per volume, > 0; default 1000.
    pub fn density(mut self, density: f64) -> Self {
        self.material.density = density;
        self
    }

    /// The whole material at once.
    pub fn material(mut self, material: Material) -> Self {
        self.material = material;
        self
    }

    /// Where and how the body starts; default: at rest where the model is.
    pub fn placement(mut self, placement: Placement) -> Self {
        self.placement = placement;
        self
    }

    /// How fine the lattice of a mesh is; default about 1,000 lattice vertices. A bare lattice is as it is.
    pub fn resolution(mut self, resolution: Resolution) -> Self {
        self.options.resolution = resolution;
        self
    }

    /// Wished number of lattice vertices, at least 8, met within 5 % where the shape allows.
    pub fn lattice_vertices(self, vertices: usize) -> Self {
        self.resolution(Resolution::Vertices(vertices))
    }

    /// Edge of a lattice cell, > 0, in the model's frame after `scale`.
    pub fn cell_size(self, cell_size: f64) -> Self {
        self.resolution(Resolution::CellSize(cell_size))
    }

    /// Whether parts of a mesh that float apart ride along; default true.
    pub fn join(mut self, join: bool) -> Self {
        self.options.join = join;
        self
    }

    /// Bytes that the body may take; default half of the machine's memory.
    pub fn memory_limit(mut self, bytes: u64) -> Self {
        self.options.memory_limit = Some(bytes);
        self
    }

    /// Factor on the mesh, or the bare lattice, > 0, before all else; default 1.
    pub fn scale(mut self, scale: f64) -> Self {
        self.scale = scale;
        self
    }

    /// Degrees about the fixed axes x, then y, then z; default 0.
    pub fn rotate(mut self, degrees: [f64; 3]) -> Self {
        self.placement.rotate = degrees;
        self
    }

    /// Shift in scene units, after the turn; default 0.
    pub fn translate(mut self, shift: [f64; 3]) -> Self {
        self.placement.translate = shift;
        self
    }

    /// Velocity at the start in scene units per second; default 0.
    pub fn velocity(mut self, velocity: [f64; 3]) -> Self {
        self.placement.velocity = velocity;
        self
    }

    /// Spin at the start in rad/s about the center of mass; default 0.
    pub fn spin(mut self, spin: [f64; 3]) -> Self {
        self.placement.spin = spin;
        self
    }

    /// Whether and how the volume is kept; default: by the best measure that the body has.
    pub fn volume(mut self, volume: impl Into<VolumeOptions>) -> Self {
        self.volume = volume.into();
        self
    }

    /// Adds a pin.
    pub fn pin(mut self, pin: Pin) -> Self {
        self.pins.push(pin);
        self
    }

    /// Adds a handle. Where holds overlap, later ones win, and handles win over pins.
    pub fn handle(mut self, handle: Handle) -> Self {
        self.handles.push(handle);
        self
    }

    /// The body.
    ///
    /// # Errors
    ///
    /// A number out of its range, a lattice that cannot be built or takes too much memory, a correction that the
    /// mesh cannot have, a pin or a handle that takes nothing.
    pub fn build(self) -> Result<Body, Error> {
        self.material.validate()?;
        self.placement.validate()?;
        let (lattice, surface) = match self.shape {
            Shape::Lattice(lattice) => {
                let scaled = if self.scale == 1.0 { *lattice } else { lattice.scaled(self.scale)? };
                (scaled, None)
            }
            Shape::Mesh(mesh) => {
                let mesh = if self.scale == 1.0 { mesh } else { mesh.scaled(self.scale)? };
                let lattice = Lattice::from_mesh(&mesh, &self.options)?;
                let embedding = Embedding::new(&lattice, mesh.vertices());
                (lattice, Some(Surface { mesh, embedding, skin: Skin::default() }))
            }
        };
        self.placement.within(FARTHEST * lattice.cell_size())?;
        let half_width = self.material.half_width(lattice.cell_size(), extent(&lattice));
        let matching = Matching::new(&lattice, half_width);
        let mut state = State::at_rest(&lattice, &matching.layout, &self.placement);
        state.set_in_motion(&lattice, &matching.layout, &self.placement);
        let borrowed = surface.as_ref().map(Surface::borrowed);
        let mut body = Body {
            name: self.name,
            material: self.material,
            volume: self.volume,
            correction: Correction::new(&lattice, borrowed, &self.volume)?,
            measures: OnceLock::new(),
            placed: self.placement.isometry(),
            state,
            workspace: matching.cascade.workspace(&matching.layout),
            momentum: MomentumTracker::new(&lattice, &matching.layout, matching.cascade.tasks()),
            energy: None,
            region_damping: self.material.is_damped().then(|| RegionDamper::new(&matching)),
            forces: None,
            contacts: None,
            constraints: None,
            unsettled: 0,
            lattice,
            surface,
            matching,
        };
        self.pins.iter().try_for_each(|pin| body.pin(pin))?;
        self.handles.iter().try_for_each(|handle| body.handle(handle))?;
        Ok(body)
    }
}

/// The largest extent of a lattice along an axis, in cells.
pub(super) fn extent(lattice: &Lattice) -> usize {
    let (low, high) = index_bounds(lattice.indices());
    (0..3).map(|c| high[c].abs_diff(low[c]) as usize).max().unwrap_or(1)
}
