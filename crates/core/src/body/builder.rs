//! The builder of a body.

use super::soft_body::Body;
use super::{rigid_values::MassProperties, touching::TouchingOptions};
use crate::dynamics::{
    Accuracy, Damping, Elasticity, Handle, KeyedMaterial, Material, Pin, Plasticity, Preset, RegionDamping,
    RegionSize, Stiffness, Zone,
};
use crate::fracture::FractureOptions;
use crate::lattice::{Lattice, LatticeOptions, Resolution};
use crate::matching::HalfWidth;
use crate::mesh::{Mesh, Refine, Scale};
use crate::motion::Curve;
use crate::skin::SkinKind;
use crate::state::Placement;
use crate::volume::VolumeOptions;

/// Builds a [`Body`] from a mesh or a lattice, and settings. The settings have the names, units, ranges and
/// defaults of the keys in a scene file. [`build`](Self::build) checks the settings.
#[derive(Clone, Debug)]
#[must_use]
pub struct BodyBuilder {
    pub(super) name: String,
    pub(super) shape: Model,
    pub(super) options: LatticeOptions,
    pub(super) scale: Scale,
    pub(super) refine: Refine,
    pub(super) material: Material,
    pub(super) placement: Placement,
    pub(super) volume: VolumeOptions,
    pub(super) skin: SkinKind,
    pub(super) touching: TouchingOptions,
    pub(super) fracture: Option<FractureOptions>,
    pub(super) inflate: Curve,
    pub(super) keyed: KeyedMaterial,
    pub(super) zones: Vec<Zone>,
    pub(super) pins: Vec<Pin>,
    pub(super) handles: Vec<Handle>,
    pub(super) rigid: bool,
    pub(super) mass_properties: Option<MassProperties>,
    /// Whether the resolution was set.
    pub(super) has_resolution: bool,
}

#[derive(Clone, Debug)]
pub(super) enum Model {
    Mesh(Mesh),
    Lattice(Box<Lattice>),
}

impl Body {
    /// Returns a builder of a body from a mesh.
    pub fn builder(mesh: Mesh) -> BodyBuilder {
        BodyBuilder::from_mesh(mesh)
    }

    /// Returns a builder of a body from a bare lattice, without a mesh to display.
    pub fn from_lattice(lattice: Lattice) -> BodyBuilder {
        BodyBuilder::from_lattice(lattice)
    }
}

impl BodyBuilder {
    /// Default number of lattice vertices of a rigid body: enough for its contacts.
    pub const RIGID_VERTICES: usize = 300;

    pub(super) fn from_mesh(mesh: Mesh) -> Self {
        Self::from_shape(Model::Mesh(mesh))
    }

    pub(super) fn from_lattice(lattice: Lattice) -> Self {
        Self::from_shape(Model::Lattice(Box::new(lattice)))
    }

    fn from_shape(shape: Model) -> Self {
        Self {
            name: "body".to_owned(),
            shape,
            options: LatticeOptions::default(),
            scale: Scale::default(),
            refine: Refine::default(),
            material: Material::default(),
            placement: Placement::default(),
            volume: VolumeOptions::default(),
            skin: SkinKind::default(),
            touching: TouchingOptions::default(),
            fracture: None,
            inflate: 1.0.into(),
            keyed: KeyedMaterial::default(),
            zones: Vec::new(),
            pins: Vec::new(),
            handles: Vec::new(),
            rigid: false,
            mass_properties: None,
            has_resolution: false,
        }
    }

    /// Sets the name of the body; default "body".
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Sets a named material. Replaces any other elasticity.
    pub fn preset(self, preset: Preset) -> Self {
        self.elasticity(Elasticity::Preset(preset))
    }

    /// Sets Young's modulus, > 0, a number or keyframes: force per area in scene units. Replaces any other elasticity.
    pub fn youngs_modulus(self, modulus: impl Into<Curve>) -> Self {
        let (greatest, keys) = keyed(modulus);
        let mut builder = self.elasticity(Elasticity::YoungsModulus(greatest));
        builder.keyed.youngs_modulus = keys;
        builder
    }

    /// Sets the elasticity.
    pub fn elasticity(mut self, elasticity: Elasticity) -> Self {
        self.material.elasticity = elasticity;
        self.keyed.youngs_modulus = None;
        self
    }

    /// Sets the half-width of the regions in cells: 0.5, so that each region is a cell, or a whole number of at least 1.
    /// Larger regions make the body stiffer, and so does a coarser lattice with the same half-width. Replaces a
    /// preset or Young's modulus; the default of the stiffness is then alpha = 1.
    pub fn half_width(self, cells: impl Into<HalfWidth>) -> Self {
        let elasticity = self.material.elasticity.with_region_size(RegionSize::Cells(cells.into()));
        self.elasticity(elasticity)
    }

    /// Sets the half-width of the regions as a length, > 0, independent of the resolution of the lattice.
    /// Replaces [`half_width`](Self::half_width).
    pub fn stiffness_radius(self, radius: f64) -> Self {
        let elasticity = self.material.elasticity.with_region_size(RegionSize::Radius(radius));
        self.elasticity(elasticity)
    }

    /// Sets the stiffness alpha per step, in (0, 1]. Replaces a preset or Young's modulus; the default of the
    /// half-width is then 2 cells.
    pub fn stiffness(self, alpha: f64) -> Self {
        let elasticity = self.material.elasticity.with_stiffness(Stiffness::PerStep(alpha));
        self.elasticity(elasticity)
    }

    /// Sets the stiffness as a frequency in Hz, > 0, independent of the step length. Replaces
    /// [`stiffness`](Self::stiffness).
    pub fn frequency(self, hertz: f64) -> Self {
        let elasticity = self.material.elasticity.with_stiffness(Stiffness::Frequency(hertz));
        self.elasticity(elasticity)
    }

    /// Sets how the half-width of the regions is chosen for a material or Young's modulus.
    pub fn accuracy(mut self, accuracy: Accuracy) -> Self {
        self.material.accuracy = accuracy;
        self
    }

    /// Sets Poisson's ratio, in [0, 0.47], a number or keyframes: see [`Material::poisson_ratio`].
    pub fn poisson_ratio(mut self, ratio: impl Into<Curve>) -> Self {
        let (greatest, keys) = keyed(ratio);
        (self.material.poisson_ratio, self.keyed.poisson_ratio) = (Some(greatest), keys);
        self
    }

    /// Sets the ratio of the rest volume to that of the mesh, in [0.1, 10], a number or keyframes; default 1. See
    /// [`Body::set_inflate`].
    pub fn inflate(mut self, ratio: impl Into<Curve>) -> Self {
        self.inflate = ratio.into();
        self
    }

    /// Sets the damping ratio of the lowest elastic mode, in [0, 1], a number or keyframes: see [`Damping`].
    pub fn damping_ratio(mut self, ratio: impl Into<Curve>) -> Self {
        let (greatest, keys) = keyed(ratio);
        (self.material.damping, self.keyed.damping_ratio) = (Some(Damping::Ratio(greatest)), keys);
        self
    }

    /// Sets the decay rate of the elastic modes in 1/s, >= 0: see [`Damping`]. Replaces
    /// [`damping_ratio`](Self::damping_ratio).
    pub fn damping_rate(mut self, rate: f64) -> Self {
        (self.material.damping, self.keyed.damping_ratio) = (Some(Damping::Rate(rate)), None);
        self
    }

    /// Sets the region damping per step, in [0, 1]: the fraction of the non-rigid velocity within regions
    /// that a step removes. Default 0, which omits the stage.
    pub fn region_damping(mut self, fraction: f64) -> Self {
        self.material.region_damping = RegionDamping::PerStep(fraction);
        self
    }

    /// Sets the region damping as a rate in 1/s, >= 0, independent of the step length. Replaces
    /// [`region_damping`](Self::region_damping).
    pub fn region_damping_rate(mut self, rate: f64) -> Self {
        self.material.region_damping = RegionDamping::Rate(rate);
        self
    }

    /// Sets the mass per volume, > 0; default 1000.
    pub fn density(mut self, density: f64) -> Self {
        self.material.density = density;
        self
    }

    /// Makes the body plastic: parts that are strained beyond a limit keep a part of their deformation. By default it
    /// is elastic.
    pub fn plastic(mut self, plastic: Plasticity) -> Self {
        self.material.plastic = Some(plastic);
        self
    }

    /// Lets the body break where it is stretched beyond a limit. By default it does not break.
    pub fn fracture(mut self, fracture: FractureOptions) -> Self {
        self.fracture = Some(fracture);
        self
    }

    /// Sets the complete material, without keyframes.
    pub fn material(mut self, material: Material) -> Self {
        self.material = material;
        let friction = self.keyed.friction.take();
        self.keyed = KeyedMaterial { friction, ..KeyedMaterial::default() };
        self
    }

    /// Sets the keyframes of numbers of the material, whose greatest values replace the numbers.
    pub fn keyed(mut self, keyed: KeyedMaterial) -> Self {
        self.keyed = keyed;
        self
    }

    /// Sets position, orientation, velocity and spin at the start. By default the body is at rest in the
    /// model's frame.
    pub fn placement(mut self, placement: Placement) -> Self {
        self.placement = placement;
        self
    }

    /// Sets the resolution of the lattice of a mesh; default approximately 1,000 lattice vertices. It has no
    /// effect on a bare lattice.
    pub fn resolution(mut self, resolution: Resolution) -> Self {
        self.options.resolution = resolution;
        self.has_resolution = true;
        self
    }

    /// Sets the target number of lattice vertices, at least 8. The actual number is within 5 % of it where
    /// the shape allows.
    pub fn lattice_vertices(self, vertices: usize) -> Self {
        self.resolution(Resolution::Vertices(vertices))
    }

    /// Sets the edge of a lattice cell, > 0, in the model's frame after `scale`.
    pub fn cell_size(self, cell_size: f64) -> Self {
        self.resolution(Resolution::CellSize(cell_size))
    }

    /// Sets whether bridges of cells join each separate part of a mesh to the nearest other part; default
    /// true.
    pub fn join(mut self, join: bool) -> Self {
        self.options.join = join;
        self
    }

    /// Sets the memory limit of the body in bytes; default 4 GiB. See [`LatticeOptions::memory_limit`].
    pub fn memory_limit(mut self, bytes: u64) -> Self {
        self.options.memory_limit = Some(bytes);
        self
    }

    /// Sets whether faces that are larger than cells are divided, so that the surface bends between the vertices of the
    /// mesh; default [`Refine::Off`]. The mesh of the body then has more vertices, after the given ones: see
    /// [`Mesh::refined`]. It has no effect on a bare lattice.
    pub fn refine(mut self, refine: Refine) -> Self {
        self.refine = refine;
        self
    }

    /// Sets the scale of the mesh or bare lattice, applied before the placement: a factor > 0, or for a mesh one for
    /// each axis, not 0, of which negative ones mirror it; default 1.
    pub fn scale(mut self, scale: impl Into<Scale>) -> Self {
        self.scale = scale.into();
        self
    }

    /// Sets the rotation in degrees about the fixed axes x, then y, then z; default 0.
    pub fn rotate(mut self, degrees: [f64; 3]) -> Self {
        self.placement.rotate = degrees;
        self
    }

    /// Sets the translation in scene units, applied after the rotation; default 0.
    pub fn translate(mut self, offset: [f64; 3]) -> Self {
        self.placement.translate = offset;
        self
    }

    /// Sets the initial velocity in scene units per second; default 0.
    pub fn velocity(mut self, velocity: [f64; 3]) -> Self {
        self.placement.velocity = velocity;
        self
    }

    /// Sets the initial spin in rad/s about the center of mass; default 0.
    pub fn spin(mut self, spin: [f64; 3]) -> Self {
        self.placement.spin = spin;
        self
    }

    /// Sets the volume correction. By default it preserves the measure `mesh` if the surface encloses a
    /// volume, otherwise the measure `cells`.
    pub fn volume(mut self, volume: impl Into<VolumeOptions>) -> Self {
        self.volume = volume.into();
        self
    }

    /// Sets how the mesh follows the lattice; default [`SkinKind::Linear`]. It has no effect on a bare lattice.
    pub fn skin(mut self, skin: SkinKind) -> Self {
        self.skin = skin;
        self
    }

    /// Adds a part with another stiffness or rest volume. The factors of overlapping zones multiply.
    pub fn zone(mut self, zone: Zone) -> Self {
        self.zones.push(zone);
        self
    }

    /// Sets whether the body is rigid; default false. A rigid body has six degrees of freedom, with the exact mass and
    /// inertia of a closed mesh, or those of the lattice of an open mesh and of a bare lattice. Its lattice has about 300
    /// vertices by default; it is the geometry of the contacts. Settings of bodies that deform exclude it: elasticity,
    /// damping, plasticity, fracture, inflation, zones and a volume measure. Pins and handles that hold single lattice
    /// vertices are joints: see [`Body::pin`].
    pub fn rigid(mut self, rigid: bool) -> Self {
        self.rigid = rigid;
        self
    }

    /// Sets the mass, the center of mass and the inertia of a rigid body. By default they are those of its mesh at the
    /// density. They are no part of a saved state. Soft bodies do not have them: [`build`](Self::build) is then an
    /// error.
    pub fn mass_properties(mut self, properties: MassProperties) -> Self {
        self.mass_properties = Some(properties);
        self
    }

    /// Adds a pin. Where pins overlap, a later pin overrides an earlier pin.
    pub fn pin(mut self, pin: Pin) -> Self {
        self.pins.push(pin);
        self
    }

    /// Adds a handle. Where pins and handles overlap, handles override pins, and a later handle overrides an
    /// earlier handle.
    pub fn handle(mut self, handle: Handle) -> Self {
        self.handles.push(handle);
        self
    }
}

/// Returns the greatest value of a number, and its keyframes if it changes.
pub(super) fn keyed(number: impl Into<Curve>) -> (f64, Option<Curve>) {
    let curve = number.into();
    (curve.greatest(), curve.constant().is_none().then_some(curve))
}
