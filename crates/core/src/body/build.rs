//! Builds a body from the settings of its builder.

use std::sync::OnceLock;

use super::builder::{BodyBuilder, Model};
use super::elasticity::{extent, initial_half_width, longest_side, size_of, slenderness_of};
use super::material::check_cell_mass;
use super::parts::{ContactData, DisplayData, Pipeline, Settings, Shape};
use super::rigid::rigid_settings;
use super::rigid_values::MassProperties;
use super::soft_body::{Body, MAX_CELLS};
use super::surface::Surface;
use crate::dynamics::{PartFactors, RigidError};
use crate::error::Error;
use crate::fracture::FractureOptions;
use crate::lattice::{Embedding, Lattice, LatticeError, Masses, Resolution, cell_shares};
use crate::mesh::{RefinedMesh, Scale};
use crate::skin::{Skin, SkinKind};
use crate::state::State;
use crate::volume::Correction;

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
        self.material.validate()?;
        self.keyed.validate()?;
        let (material, volume) = match self.rigid {
            true => rigid_settings(&self.material, self.volume)?,
            false => (self.material, self.volume),
        };
        self.check_rigid()?;
        self.mass_properties.iter().try_for_each(MassProperties::validate)?;
        let mut options = self.options;
        if self.rigid && !self.has_resolution {
            options.resolution = Resolution::Vertices(Self::RIGID_VERTICES);
        }
        self.placement.validate()?;
        self.touching.validate()?;
        self.fracture.iter().try_for_each(FractureOptions::validate)?;
        let mut refined = None;
        let (lattice, surface) = match self.shape {
            Model::Lattice(lattice) if !lattice.broken_joints().is_empty() => {
                return Err(LatticeError::Broken.into());
            }
            Model::Lattice(lattice) => {
                let Scale::Uniform(factor) = self.scale else {
                    return Err(LatticeError::Scale(self.scale).into());
                };
                (if factor == 1.0 { *lattice } else { lattice.scaled(factor)? }, None)
            }
            Model::Mesh(mesh) => {
                let mesh = mesh.scaled(self.scale)?;
                let lattice = Lattice::from_mesh(&mesh, &options)?;
                refined = self.refine.apply(&mesh, lattice.cell_size())?;
                if let Some(refined) = &refined {
                    let zones = self.zones.iter_mut().map(|zone| &mut zone.selection);
                    let pins = self.pins.iter_mut().map(|pin| &mut pin.selection);
                    let handles = self.handles.iter_mut().map(|handle| &mut handle.selection);
                    let all = zones.chain(pins).chain(handles);
                    all.for_each(|selection| selection.refine(refined));
                }
                let mesh = refined.as_ref().map_or(mesh, |refined| refined.mesh.clone());
                let embedding = Embedding::new(&lattice, mesh.vertices());
                let embedding = match self.skin {
                    SkinKind::Linear => embedding,
                    SkinKind::Smooth => embedding.smoothed(&lattice),
                };
                (lattice, Some(Surface { mesh, embedding, skin: Skin::default(), pieces: None }))
            }
        };
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
                size: size_of(&lattice, surface.as_ref(), &masses),
                slenderness: slenderness_of(&lattice, surface.as_ref(), &masses),
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
            contact: ContactData {
                contacts: None,
                body_contact: None,
                colliders_resist_rolling: false,
                leaving: Vec::new(),
            },
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
