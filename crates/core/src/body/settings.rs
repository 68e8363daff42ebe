//! Changes settings between steps: volume correction, pins, handles, forces.

use super::parts::Shape;
use super::soft_body::Body;
use super::surface::Surface;
use crate::dynamics::{
    BodyMesh, Constraint, ConstraintError, Constraints, Handle, HandleMotion, Pin, Selection, SelectionPose,
    TimeWindow,
};
use crate::error::Error;
use crate::mesh::MeshAnimation;
use crate::motion::{Interpolation, Key, Motion};
use crate::volume::{Correction, VolumeError, VolumeOptions};

impl Body {
    /// Sets the options of the volume correction, from the next evaluation of the displayed surface on, and
    /// rebuilds the correction.
    ///
    /// # Errors
    ///
    /// A number out of range, or a volume measure that the mesh does not allow. The options are then
    /// unchanged.
    pub fn set_volume(&mut self, volume: impl Into<VolumeOptions>) -> Result<(), VolumeError> {
        let options = volume.into();
        let surface = self.surface().map(Surface::volume_surface);
        self.display.correction = Correction::new(&self.shape.lattice, surface, &options)?.into();
        self.settings.volume = options;
        Ok(())
    }

    /// Releases a pin or handle permanently, from the next step on. `index` is its position, from 0, among
    /// all pins and handles in the order in which they were added, including released ones. So a release
    /// changes no index. Releasing a released pin or handle has no effect.
    ///
    /// A released pin or handle takes no memory and no time. One whose time window has ended does, until it
    /// is released, because it becomes active again if the time is set back.
    ///
    /// # Errors
    ///
    /// An index out of range.
    pub fn release(&mut self, index: usize) -> Result<(), ConstraintError> {
        self.wake();
        self.constraints_mut(index)?.release(index)
    }

    /// Replaces the keyframes of a handle, from the next step on. Keyframes are relative to the pose that the
    /// selected part had when the handle became active. A pin that gets keyframes becomes a handle. A handle that
    /// followed an animation moves along the keyframes from the pose that the part has before the next step.
    ///
    /// * `interpolation`: `None` keeps the interpolation of the keyframes before; linear if there were none.
    /// * `index`: as for [`Body::release`].
    ///
    /// # Errors
    ///
    /// An index out of range, a released handle, invalid keyframes, or a displacement of more than 10^15
    /// cells.
    pub fn set_keys(
        &mut self,
        index: usize,
        keys: &[Key],
        interpolation: Option<Interpolation>,
    ) -> Result<(), ConstraintError> {
        self.wake();
        let limit = self.coordinate_limit();
        let constraints = self.constraints_mut(index)?;
        let motion = Motion::new(keys.to_vec())?;
        motion.check_limit(limit)?;
        let before = constraints.get(index)?.interpolation();
        constraints.set_motion(index, motion.interpolated(interpolation.or(before).unwrap_or_default()))
    }

    /// Returns the number of pins and handles added so far, including released ones.
    pub fn constraint_count(&self) -> usize {
        self.constraints.as_ref().map_or(0, Constraints::count)
    }

    /// Returns the pins and handles that are not released, in the order in which they were added: the pins
    /// of the builder first, then its handles.
    pub fn constraints(&self) -> impl Iterator<Item = &Constraint> {
        let list = self.constraints.iter().flat_map(Constraints::list);
        list.filter(|constraint| !constraint.is_released())
    }

    /// Returns the lattice vertices that pins and handles constrained in the last step.
    pub(crate) fn constrained_vertices(&self) -> impl Iterator<Item = u32> + Clone {
        let constrained = Constraints::constrained_by(self.constraints.as_ref());
        (0..).zip(constrained).filter(|(_, constrained)| **constrained).map(|(vertex, _)| vertex)
    }

    /// Returns a pin or handle.
    ///
    /// * `index`: as for [`Body::release`].
    ///
    /// # Errors
    ///
    /// An index out of range, or a released pin or handle.
    pub fn constraint(&self, index: usize) -> Result<&Constraint, ConstraintError> {
        let missing = ConstraintError::NoSuchConstraint { index, count: 0 };
        self.constraints.as_ref().ok_or(missing)?.get(index)
    }

    fn constraints_mut(&mut self, index: usize) -> Result<&mut Constraints, ConstraintError> {
        self.constraints.as_mut().ok_or(ConstraintError::NoSuchConstraint { index, count: 0 })
    }

    /// Adds a pin, which fixes the selected part of the body in the pose that the part has when the time
    /// window of the pin begins. For selections see [`Body::select`]; a map gives each vertex a weight of its own, see
    /// [`Pin::goal`]. The part may overlap with the parts of
    /// other pins and handles: of the active ones, the one that was added last moves the common vertices.
    ///
    /// In a rigid body, all vertices that pins and handles hold at a time are one joint. A single vertex is a ball joint,
    /// vertices on a line are a hinge, and all others prescribe the pose. Boxes and other shapes select whole cells.
    ///
    /// # Errors
    ///
    /// An empty or invalid selection, or an empty time window.
    pub fn pin(&mut self, pin: &Pin) -> Result<(), Error> {
        let (vertices, weights) = self.held_part(&pin.selection)?;
        self.add(Constraint::new(vertices, pin.window, None)?.softened(pin.goal.as_ref(), weights)?)
    }

    /// Adds a handle, which moves the selected part of the body: along keyframes, relative to the pose that the part
    /// has when the time window of the handle begins, or with an animated mesh. For selections see [`Body::select`].
    ///
    /// # Errors
    ///
    /// The errors of [`Body::pin`], invalid keyframes, a displacement of more than 10^15 cells, an animation that has
    /// another number of vertices than the mesh of the body, or a body without a mesh.
    pub fn handle(&mut self, handle: &Handle) -> Result<(), Error> {
        let Handle { selection, motion, window, goal } = handle;
        let (vertices, weights) = self.held_part(selection)?;
        let constraint = match motion {
            HandleMotion::Keys(keys, interpolation) => {
                Constraint::new(vertices, *window, Some(keys))?.interpolated(*interpolation)
            }
            HandleMotion::Follow(animation) => self.following(selection, vertices, *window, animation)?,
        };
        constraint.check_limit(self.coordinate_limit()).map_err(ConstraintError::from)?;
        self.add(constraint.softened(goal.as_ref(), weights)?)
    }

    /// Adds a pin or a handle.
    fn add(&mut self, constraint: Constraint) -> Result<(), Error> {
        self.wake();
        let vertices = self.shape.lattice.len();
        self.constraints.get_or_insert_with(|| Constraints::new(vertices, Vec::new())).add(constraint);
        Ok(())
    }

    /// Returns a handle on `vertices`, those of the selection, that follows an animated mesh.
    fn following(
        &self,
        selection: &Selection,
        vertices: Vec<u32>,
        window: TimeWindow,
        animation: &MeshAnimation,
    ) -> Result<Constraint, Error> {
        let Some(surface) = self.surface() else { return Err(ConstraintError::NoMesh.into()) };
        let Surface { mesh, embedding, .. } = surface;
        let (value, limit) =
            (animation.greatest_coordinate() * self.shape.scale.greatest(), self.coordinate_limit());
        if value > limit {
            return Err(ConstraintError::AnimationTooFar { value, limit }.into());
        }
        let part = match self.mesh_part(selection)? {
            Some(part) => part,
            None if selection.is_shape() => {
                selection.points_inside(self.mesh_at(surface, SelectionPose::Start))?
            }
            None => (0..mesh.vertices().len() as u32).collect(),
        };
        let &Self { shape: Shape { ref lattice, scale, model_to_world, .. }, .. } = self;
        let body = BodyMesh { lattice, mesh, embedding, scale, model_to_world };
        Ok(Constraint::following(&body, animation, selection, &part, vertices, window)?)
    }
}
