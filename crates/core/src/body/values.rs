//! Positions, velocities and other values of the vertices, which users read and set.

use nalgebra::{Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};

use super::soft_body::Body;
use super::surface::Surface;
use crate::matching::{Purpose, RegionFit, Workspace};
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::lanes::Lanes;
use crate::simd::vector::wide;
use crate::state::ArrayError;

impl Body {
    /// Returns the positions, shape `(n, 3)`.
    pub fn positions(&self) -> Vec<Point3<f64>> {
        self.by_vertex(|slot| self.state.frame.to_world(self.state.local(slot)))
    }

    /// Writes the positions to `out`, one row per vertex, `f32` or `f64`.
    ///
    /// # Panics
    ///
    /// Panics if the length of `out` is not the number of vertices.
    pub fn positions_into<T: Coordinate>(&self, out: &mut [[T; 3]]) {
        self.write_rows(out, |slot| self.state.frame.to_world(self.state.local(slot)).coords);
    }

    /// Sets all positions, one per vertex. Velocities, pins and all other state are unchanged.
    ///
    /// # Errors
    ///
    /// A wrong number of positions, or a coordinate that is not finite or exceeds 10^15 cells.
    pub fn set_positions(&mut self, positions: &[Point3<f64>]) -> Result<(), ArrayError> {
        self.check("positions", positions.len(), positions.iter().map(|p| p.coords))?;
        self.state.set_world(self.pipeline.matching.layout.slots(), positions);
        self.fit_pose();
        self.measure_contact_bounds();
        self.wake();
        Ok(())
    }

    /// Returns the corners of the bounding box of the positions, in world space.
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let (low, high) = self.local_bounds();
        (self.state.frame.to_world(low), self.state.frame.to_world(high))
    }

    /// Returns the corners of the bounding box of the positions, in cells from the origin of the body.
    pub(super) fn local_bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let far = Vector3::repeat(f64::INFINITY);
        let positions = self.pipeline.matching.layout.slots().iter().map(|&slot| self.state.local(slot));
        positions.fold((far, -far), |(low, high), position| (low.inf(&position), high.sup(&position)))
    }

    /// Returns the velocities in scene units per second, shape `(n, 3)`.
    pub fn velocities(&self) -> Vec<Vector3<f64>> {
        self.by_vertex(|slot| self.state.frame.velocity_to_world(self.state.velocities.get(slot)))
    }

    /// Writes the velocities in scene units per second to `out`, one row per vertex, `f32` or `f64`.
    ///
    /// # Panics
    ///
    /// Panics if the length of `out` is not the number of vertices.
    pub fn velocities_into<T: Coordinate>(&self, out: &mut [[T; 3]]) {
        self.write_rows(out, |slot| self.state.frame.velocity_to_world(self.state.velocities.get(slot)));
    }

    /// Sets all velocities, one per vertex. Positions, pins and all other state are unchanged.
    ///
    /// # Errors
    ///
    /// A wrong number of velocities, or a component that is not finite or exceeds 10^15 cells/s.
    pub fn set_velocities(&mut self, velocities: &[Vector3<f64>]) -> Result<(), ArrayError> {
        self.check("velocities", velocities.len(), velocities.iter().copied())?;
        self.state.set_world_velocities(self.pipeline.matching.layout.slots(), velocities);
        self.fit_motion();
        self.wake();
        Ok(())
    }

    /// Returns the velocities of the mesh vertices in scene units per second, shape `(k, 3)`; empty for a bare lattice.
    ///
    /// They are the velocities of the lattice by the weights of the skin. The motion of the volume correction relative to
    /// the lattice is not in them.
    pub fn surface_velocities(&self) -> Vec<Vector3<f64>> {
        let Some(Surface { embedding, .. }) = self.surface() else { return Vec::new() };
        let positions = self.by_vertex(|slot| self.state.positions.get(slot));
        let velocities = self.by_vertex(|slot| self.state.velocities.get(slot));
        let mut local = vec![[0.0; 3]; embedding.len()];
        embedding.interpolate_rates(&positions, &velocities, &mut local);
        local.into_iter().map(|velocity| self.state.frame.velocity_to_world(velocity)).collect()
    }

    /// Writes a vector per vertex, computed from the slot of the vertex, to the rows of `out`.
    fn write_rows<T: Coordinate>(&self, out: &mut [[T; 3]], value: impl Fn(u32) -> Vector3<f64>) {
        let slots = self.pipeline.matching.layout.slots();
        assert_eq!(out.len(), slots.len(), "one row per vertex");
        for (row, &slot) in out.iter_mut().zip(slots) {
            *row = value(slot).map(nalgebra::convert).into();
        }
    }

    /// Returns the rotation of the region around each vertex, from the rest pose, as of the last step, shape
    /// `(n, 3, 3)`. If the regions are cells, it is the mean of those around the vertex.
    pub fn rotations(&self) -> Vec<Matrix3<f64>> {
        let matrix = |quaternion: [f32; 4]| {
            let [x, y, z, w] = quaternion.map(f64::from);
            UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
        };
        let mut rotations = Vec::new();
        self.pipeline.matching.rotations_at_vertices(&self.state.rotations, &mut rotations);
        rotations.into_iter().map(matrix).collect()
    }

    /// Returns the masses, one per vertex: density x cell_size³ / 8 x the sum of the filled shares of the cells that
    /// share the vertex. The filled share of a cell is the part of it inside the mesh, at least 0.05. With an open mesh
    /// and for a bare lattice it is 1.
    pub fn masses(&self) -> Vec<f64> {
        (0..self.shape.lattice.len() as u32).map(|vertex| self.mass_of(vertex)).collect()
    }

    /// Returns the masses of the vertices in the fits of the regions, one per vertex, in units of a full cell's mass.
    /// While a vertex is constrained by a pin or handle, it weighs more in the fits, at least twice: nothing moves it,
    /// so the rigid motions of its regions follow it. Only the fits use these masses; [`Body::masses`] returns the
    /// others.
    pub fn fit_masses(&self) -> Vec<f64> {
        self.by_vertex(|slot| self.pipeline.matching.regions.weights.get(slot)[0].into())
    }

    /// Returns the filled share of each cell: see [`Body::masses`].
    pub fn cell_shares(&self) -> Vec<f64> {
        (0..self.shape.lattice.cells().len() as u32)
            .map(|cell| self.shape.masses.share(cell).into())
            .collect()
    }

    /// Returns the goal positions g at the current positions, shape `(n, 3)`, without advancing time.
    pub fn goals(&self) -> Vec<Point3<f64>> {
        let executor = Executor::sequential();
        let (workspace, _) = self.fit_now(&executor, Purpose::Vertices);
        let goals = self.pipeline.matching.goals(&workspace, &executor);
        self.by_vertex(|slot| self.state.frame.to_world(wide(goals.get(slot))))
    }

    /// Fits the regions to the current positions, and leaves the state as it is. Returns the sums and the rotations.
    pub(super) fn fit_now(&self, executor: &Executor, purpose: Purpose) -> (Workspace, Lanes<4>) {
        let (mut workspace, mut rotations) = (Workspace::default(), self.state.rotations.clone());
        let fitted =
            RegionFit { positions: &self.state.positions, rotations: &mut rotations, shapes: self.shapes() };
        self.pipeline.matching.fit(&mut workspace, executor, fitted, None, purpose);
        (workspace, rotations)
    }

    /// Checks the length of an array that a user passes.
    pub(super) fn check_length(&self, name: &'static str, count: usize) -> Result<(), ArrayError> {
        let expected = self.shape.lattice.len();
        if count == expected { Ok(()) } else { Err(ArrayError::Length { name, count, expected }) }
    }

    /// Checks the length and the values of an array that a user passes.
    pub(super) fn check(
        &self,
        name: &'static str,
        count: usize,
        values: impl Iterator<Item = Vector3<f64>>,
    ) -> Result<(), ArrayError> {
        self.check_length(name, count)?;
        for (index, value) in values.enumerate() {
            if !value.iter().all(|x| x.is_finite()) {
                return Err(ArrayError::NotFinite { name, index, value: value.into() });
            }
            let limit = self.coordinate_limit();
            if value.amax() > limit {
                return Err(ArrayError::TooFar { name, index, value: value.into(), limit });
            }
        }
        Ok(())
    }
}

/// Returns the factors of the masses of the vertices in the fits while the vertices with `true` are constrained.
#[cfg(feature = "internals")]
pub fn constraint_factors(body: &Body, constrained: &[bool]) -> Vec<f32> {
    body.pipeline.matching.regions.constraint_factors(&body.pipeline.matching.layout, constrained)
}
