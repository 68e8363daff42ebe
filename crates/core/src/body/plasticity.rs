//! Plasticity: the plastic shapes of the regions, which the steps change.

use nalgebra::Matrix3;

use super::soft_body::Body;
use crate::dynamics::{Inflation, Material, Plasticity};
use crate::matching::{HalfWidth, Matching, Shapes, bulk_of, symmetric};
use crate::range::RangeError;
use crate::simd::lanes::Lanes;

impl Body {
    /// Sets the plasticity, from the next step on. `None` removes it together with the plastic shapes: the body returns
    /// to its rest shape. Other parameters keep the plastic shapes.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_plastic(&mut self, plastic: Option<Plasticity>) -> Result<(), RangeError> {
        self.replace_material(Material { plastic, ..self.settings.material })?;
        self.update_shapes();
        Ok(())
    }

    /// Creates or removes the plastic shapes, and the constants for them, for the volume term and for breaking.
    pub(super) fn update_shapes(&mut self) {
        let is_plastic = self.settings.material.plastic.is_some();
        let bulk = bulk_of(self.settings.material.poisson_ratio()) as f32;
        if bulk != self.pipeline.matching.regions.bulk {
            self.pipeline.matching.set_bulk(bulk);
            self.state.energy_limit = None;
            self.pipeline.lowest_eigenvalue.take();
        }
        let is_inflated = self.inflation.as_ref().is_some_and(Inflation::is_acting);
        let needs_covariances = is_plastic || self.is_armed() || bulk != 0.0 || is_inflated;
        if needs_covariances != self.pipeline.matching.has_covariances() {
            self.pipeline.matching.set_covariances(needs_covariances);
        }
        if is_plastic != self.state.strains.is_some() {
            let strains = is_plastic.then(|| Lanes::zeros(self.pipeline.matching.layout.blocks()));
            // The first plastic shapes are the rest shapes, so that the fits stay the same.
            if std::mem::replace(&mut self.state.strains, strains).is_some() {
                self.forget_fits();
            }
        }
    }

    /// Returns the plastic strain of the region around each vertex, |S - 1| with the plastic shape S: 0 where the body
    /// has its rest shape, and everywhere without plasticity. |·| is the Frobenius norm. If the regions are cells, it
    /// is the mean of those around the vertex. See [`Plasticity`].
    pub fn plastic_strain(&self) -> Vec<f64> {
        let Some(strains) = &self.state.strains else { return vec![0.0; self.shape.lattice.len()] };
        let Matching { layout, regions, .. } = &self.pipeline.matching;
        let strain = |slot: u32| symmetric(strains.get(slot)).norm();
        self.by_vertex(|slot| match self.half_width().is_cell() {
            false => strain(slot),
            true => {
                let cells = regions.cells_around(layout, slot).map(|cell| (strain(cell), 1.0));
                let (sum, count) = cells.fold((0.0, 0.0), |sums, cell| (sums.0 + cell.0, sums.1 + cell.1));
                sum / f64::max(count, 1.0)
            }
        })
    }

    /// Returns the plastic shape S of each region, shape `(n, 3, 3)` for the vertices, or `(m, 3, 3)` for the cells
    /// if the regions are cells: a symmetric matrix of determinant 1, in the rest pose; the identity where the body
    /// has its rest shape, and everywhere without plasticity. See [`Plasticity`].
    pub fn plastic_shapes(&self) -> Vec<Matrix3<f64>> {
        let strain = |slot| {
            self.state.strains.as_ref().map_or_else(Matrix3::zeros, |strains| symmetric(strains.get(slot)))
        };
        let (lattice, slots) = (&self.shape.lattice, self.pipeline.matching.layout.slots());
        let shape = |slot: u32| Matrix3::identity() + strain(slot);
        match self.half_width().is_cell() {
            false => self.by_vertex(shape),
            true => (0..lattice.cells().len() as u32)
                .map(|cell| shape(slots[lattice.first_corner(cell) as usize]))
                .collect(),
        }
    }

    /// Resets the plastic shapes: from the next step on, the body returns to its rest shape. Without plasticity,
    /// nothing changes.
    pub fn reset_plastic(&mut self) {
        let Some(strains) = &mut self.state.strains else { return };
        *strains = Lanes::zeros(strains.blocks().len());
        self.forget_fits();
        self.wake();
    }

    /// Carries the plastic shapes over from the regions around vertices to cells, or back: the shape of a region is
    /// the mean over the corners, or over the cells around the vertex. The regions are not changed yet.
    pub(super) fn carry_shapes(&mut self, half_width: HalfWidth) {
        let to_cells = half_width.is_cell();
        let Some(before) = self.state.strains.as_ref().filter(|_| to_cells != self.half_width().is_cell())
        else {
            return;
        };
        let (lattice, slots) = (&self.shape.lattice, self.pipeline.matching.layout.slots());
        let slot_of_cell = |cell| slots[lattice.first_corner(cell) as usize];
        let (cells, vertices) = (lattice.cells().len() as u32, lattice.len() as u32);
        let mut sums = vec![(Matrix3::zeros(), 0.0); if to_cells { cells } else { vertices } as usize];
        for (cell, corner) in
            (0..cells).flat_map(|cell| lattice.cell_corners(cell).map(|corner| (cell, corner)))
        {
            let (from, to) = match to_cells {
                true => (slots[corner as usize], cell),
                false => (slot_of_cell(cell), corner),
            };
            let (sum, count) = &mut sums[to as usize];
            *sum += symmetric(before.get(from));
            *count += 1.0;
        }
        let mut strains = Lanes::zeros(before.blocks().len());
        for (region, (sum, count)) in (0..).zip(sums) {
            let slot = if to_cells { slot_of_cell(region) } else { slots[region as usize] };
            let shape = Matrix3::identity() + sum / f64::max(count, 1.0);
            // A mean of shapes of determinant 1 has a greater one.
            let strain = (shape / libm::cbrt(shape.determinant()) - Matrix3::identity()).map(|x| x as f32);
            strains.set(slot, [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|index| strain[index]));
        }
        self.state.strains = Some(strains);
    }

    /// Removes the results that depend on the plastic shapes.
    fn forget_fits(&mut self) {
        self.state.fitted = false;
        self.state.energy_limit = None;
    }

    /// Returns the shapes in which the regions are fitted.
    pub(crate) fn shapes(&self) -> Shapes<'_> {
        Shapes::of(self.state.strains.as_ref())
    }
}
