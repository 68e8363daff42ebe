//! Builds a body from the settings of its builder.

use std::sync::OnceLock;

use super::builder::{BodyBuilder, Model};
use super::elasticity::initial_half_width;
use super::material::check_cell_mass;
use super::parts::{ContactData, DisplayData, Pipeline, Settings, Shape};
use super::proportions::{Proportions, extent, longest_side};
use super::rigid_values::MassProperties;
use super::soft_body::{Body, MAX_CELLS};
use super::surface::Surface;
use crate::dynamics::{
    Elasticity, Handle, Material, PartFactors, Pin, RegionSize, RigidError, Stiffness, Zone,
};
use crate::error::Error;
use crate::fracture::FractureOptions;
use crate::lattice::{Embedding, Lattice, LatticeError, LatticeOptions, Masses, Resolution, cell_shares};
use crate::matching::HalfWidth;
use crate::mesh::{Refine, RefinedMesh, Scale};
use crate::skin::SkinKind;
use crate::state::State;
use crate::volume::{Correction, Preservation, VolumeOptions};

impl BodyBuilder {
    /// Builds the body.
    ///
    /// # Errors
    ///
    /// A number out of range, a lattice that cannot be built or exceeds the memory limit, a volume measure
    /// that the mesh does not allow, or a zone, pin or handle with an empty selection.
    pub fn build(self) -> Result<Body, Error> {
        self.build_refined().map(|(body, _)| body)
    }

    /// Builds the body. Also returns the refined mesh of the body, if its mesh is refined: see [`BodyBuilder::refine`].
    ///
    /// # Errors
    ///
    /// As [`BodyBuilder::build`].
    pub fn build_refined(mut self) -> Result<(Body, Option<RefinedMesh>), Error> {
        let (material, volume) = self.checked()?;
        if self.rigid && !self.has_resolution {
            self.options.resolution = Resolution::Vertices(Self::RIGID_VERTICES);
        }
        let (lattice, surface, refined) =
            self.shape.build(self.scale, &self.options, (self.refine, self.skin))?;
        if let Some(refined) = &refined {
            refine_selections(refined, &mut self.zones, &mut self.pins, &mut self.handles);
        }
        self.touching.check_size(longest_side(&lattice, surface.as_ref()))?;
        self.placement.check_limit(MAX_CELLS * lattice.cell_size())?;
        check_cell_mass(&material, &lattice)?;
        let extent = extent(&lattice);
        let half_width = initial_half_width(&material, &lattice, extent);
        let mesh = surface.as_ref().map(|surface| &surface.mesh);
        let shares = self.fracture.is_some().then(|| cell_shares(&lattice, mesh));
        let masses = match &shares {
            None => Masses::new(&lattice, mesh),
            Some(shares) => Masses::of_shares(&lattice, shares),
        };
        let pipeline = Pipeline::new(&lattice, &masses, half_width);
        let layout = &pipeline.matching.layout;
        let mut state = State::at_rest(&lattice, layout, &self.placement);
        state.set_initial_velocities(&masses, layout, &self.placement);
        let volume_surface = surface.as_ref().map(Surface::volume_surface);
        let correction = Correction::new(&lattice, volume_surface, &volume)?.into();
        let mut body = Body {
            name: self.name,
            settings: Settings {
                material,
                skin: if surface.is_some() { self.skin } else { SkinKind::Linear },
                volume,
                touching: self.touching,
                has_self_contact: false,
                parts: PartFactors::default(),
                modulus_share: 1.0,
                youngs_modulus: None,
            },
            shape: Shape {
                proportions: Proportions::of(&lattice, surface.as_ref(), &masses),
                lattice,
                masses,
                surface: surface.map(OnceLock::from),
                scale: self.scale,
                model_to_world: self.placement.isometry(),
                placement: self.placement,
                extent,
            },
            state,
            pipeline,
            contact: ContactData::default(),
            constraints: None,
            forces: None,
            inflation: None,
            keyed: None,
            stiffness_factors: None,
            breaking: None,
            rigid: None,
            display: DisplayData { correction, measures: OnceLock::new() },
        };
        if self.rigid {
            let mass = body.rigid_mass(self.mass_properties.as_ref());
            body.make_rigid(mass, self.placement.velocity.into(), self.placement.spin.into());
        }
        body.update_shapes();
        body.rebuild_stages();
        if let (Some(options), Some(shares)) = (self.fracture, shares) {
            body.arm(options, shares);
        }
        body.set_inflate(self.inflate)?;
        body.set_keyed(self.keyed)?;
        self.zones.iter().try_for_each(|zone| body.zone(zone))?;
        self.pins.iter().try_for_each(|pin| body.pin(pin))?;
        self.handles.iter().try_for_each(|handle| body.handle(handle))?;
        Ok((body, refined))
    }

    /// Checks the settings without the lattice. Returns the material and the volume correction of the body.
    fn checked(&self) -> Result<(Material, VolumeOptions), Error> {
        self.material.validate()?;
        self.keyed.validate()?;
        let checked = match self.rigid {
            true => rigid_settings(&self.material, self.volume)?,
            false => (self.material, self.volume),
        };
        self.check_rigid()?;
        self.mass_properties.iter().try_for_each(MassProperties::validate)?;
        self.placement.validate()?;
        self.touching.validate()?;
        self.fracture.iter().try_for_each(FractureOptions::validate)?;
        Ok(checked)
    }

    /// Checks that a rigid body has no settings of bodies that deform, beside those of its material.
    fn check_rigid(&self) -> Result<(), RigidError> {
        if self.mass_properties.is_some() && !self.rigid {
            return Err(RigidError::NotRigid { change: "a mass with an inertia" });
        }
        let given = [
            ("fracture", self.fracture.is_some()),
            ("inflate", self.inflate != 1.0.into()),
            ("zone", !self.zones.is_empty()),
            ("keyframes", self.keyed.names().any(|name| name != "friction")),
        ];
        match given.into_iter().find(|(_, is_given)| self.rigid && *is_given) {
            Some((key, _)) => Err(RigidError::Setting { key }),
            None => Ok(()),
        }
    }
}

/// Makes the selections of zones, pins and handles those of a refined mesh.
fn refine_selections(refined: &RefinedMesh, zones: &mut [Zone], pins: &mut [Pin], handles: &mut [Handle]) {
    let zones = zones.iter_mut().map(|zone| &mut zone.selection);
    let pins = pins.iter_mut().map(|pin| &mut pin.selection);
    let handles = handles.iter_mut().map(|handle| &mut handle.selection);
    zones.chain(pins).chain(handles).for_each(|selection| selection.refine(refined));
}

impl Model {
    /// Builds the lattice, and of a mesh the surface, which is that of the refined mesh if there is one.
    fn build(
        self,
        scale: Scale,
        options: &LatticeOptions,
        (refine, skin): (Refine, SkinKind),
    ) -> Result<(Lattice, Option<Surface>, Option<RefinedMesh>), Error> {
        match self {
            Self::Lattice(lattice) if !lattice.broken_joints().is_empty() => Err(LatticeError::Broken.into()),
            Self::Lattice(lattice) => {
                let Scale::Uniform(factor) = scale else { return Err(LatticeError::Scale(scale).into()) };
                let lattice = if factor == 1.0 { *lattice } else { lattice.scaled(factor)? };
                Ok((lattice, None, None))
            }
            Self::Mesh(mesh) => {
                let mesh = mesh.scaled(scale)?;
                let lattice = Lattice::from_mesh(&mesh, options)?;
                let refined = refine.apply(&mesh, lattice.cell_size())?;
                let mesh = refined.as_ref().map_or(mesh, |refined| refined.mesh.clone());
                let embedding = Embedding::new(&lattice, mesh.vertices());
                let surface = Surface::new(mesh, embedding, (&lattice, skin), None);
                Ok((lattice, Some(surface), refined))
            }
        }
    }
}

/// Checks that the settings of a rigid body are those of a body that does not deform. Returns its material and its volume
/// correction.
fn rigid_settings(
    material: &Material,
    volume: VolumeOptions,
) -> Result<(Material, VolumeOptions), RigidError> {
    let default = Material::default();
    let elasticity = match material.elasticity {
        Elasticity::Preset(_) => "material",
        Elasticity::YoungsModulus(_) => "youngs_modulus",
        Elasticity::Regions { .. } => "half_width or stiffness",
    };
    let given = [
        (elasticity, material.elasticity != default.elasticity),
        ("poisson_ratio", material.poisson_ratio.is_some()),
        ("accuracy", material.accuracy != default.accuracy),
        ("damping_ratio or damping_rate", material.damping.is_some()),
        ("region_damping", material.region_damping != default.region_damping),
        ("plastic", material.plastic.is_some()),
        ("volume", matches!(volume.measure, Preservation::By(_))),
    ];
    if let Some((key, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
        return Err(RigidError::Setting { key });
    }
    // Of the regions, only the layout is used.
    let (size, stiffness) = (RegionSize::Cells(HalfWidth::whole(1)), Stiffness::PerStep(1.0));
    let material = Material { elasticity: Elasticity::Regions { size, stiffness }, ..*material };
    Ok((material, VolumeOptions { measure: Preservation::Off, ..volume }))
}
