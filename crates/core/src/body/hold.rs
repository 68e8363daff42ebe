//! What holds, pushes and touches a body.

use nalgebra::Point3;

use super::Body;
use crate::contact::SampleCells;
use crate::dynamics::{
    Handle, Hold, Key, Kinematics, KinematicsError, Pin, Selection, SelectionError, Window,
};
use crate::error::Error;

impl Body {
    /// Holds a part of the body as it is when the pin begins. Shapes are tested at frame 0, where the body is placed.
    ///
    /// # Errors
    ///
    /// A selection that takes nothing or makes no sense, or an empty window of time.
    pub fn pin(&mut self, pin: &Pin) -> Result<(), Error> {
        self.add_hold(&pin.selection, pin.window, None)
    }

    /// Moves a part of the body along keys, from the pose that it has when the handle begins.
    ///
    /// # Errors
    ///
    /// As for [`Body::pin`], or keys that are no motion or lead further than 10^15 cells.
    pub fn handle(&mut self, handle: &Handle) -> Result<(), Error> {
        self.add_hold(&handle.selection, handle.window, Some(&handle.keys))
    }

    fn add_hold(&mut self, selection: &Selection, window: Window, keys: Option<&[Key]>) -> Result<(), Error> {
        let hold = Hold::new(self.select(selection)?, window, keys)?;
        hold.within(self.farthest()).map_err(KinematicsError::from)?;
        let vertices = self.lattice.len();
        self.kinematics.get_or_insert_with(|| Kinematics::new(vertices, Vec::new())).add(hold);
        Ok(())
    }

    /// Shuts the books of the components that pins and handles hold now, whose momenta are not their own.
    pub(super) fn book_holds(&mut self) {
        let Self { kinematics, matching, bookkeeper, state, .. } = self;
        match kinematics {
            Some(kinematics) => {
                bookkeeper.pull(matching.layout.slots(), kinematics.held(), &mut state.books);
            }
            None => bookkeeper.free(),
        }
    }

    /// The lattice vertices that a selection takes, in increasing order: those of the cells of the mesh vertices
    /// inside; of a bare lattice the vertices inside. Tested where the body is placed at frame 0.
    ///
    /// # Errors
    ///
    /// A selection that takes nothing, with the nearest distance, or that makes no sense.
    pub fn select(&self, selection: &Selection) -> Result<Vec<u32>, SelectionError> {
        let (count, placed) = (self.lattice.len(), |p: Point3<f64>| self.placed * p);
        match &self.surface {
            Some(surface) => {
                let points = surface.mesh.vertices().iter().copied().map(placed);
                let owned = |point: u32| surface.embedding.corners(point as usize);
                selection.lattice_vertices(points, count, owned)
            }
            None => {
                let points = (0..count as u32).map(|vertex| placed(self.lattice.rest_position(vertex)));
                selection.lattice_vertices(points, count, |vertex| [vertex])
            }
        }
    }

    /// Where contacts act: on the visible surface, or on the boundary of a bare lattice.
    pub(super) fn samples(&self) -> SampleCells {
        let slots = self.matching.layout.slots();
        match &self.surface {
            Some(surface) => SampleCells::of_mesh(&surface.mesh, &self.lattice, slots),
            None => SampleCells::of_lattice(&self.lattice, slots),
        }
    }
}
