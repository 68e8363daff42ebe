//! Moves mesh vertices onto the planes that the body is pressed onto.

use nalgebra::Vector3;

use super::approach::{
    Approach, FACING, FADED, GREATEST_LENGTH, TOUCHING, approach, greatest_reach, least_gap,
};
use super::displacements::{Displacements, Hold, MovedCell};
use super::surroundings::{Surroundings, bounds, center_and_half, displaced};
use super::unflattened::{CellGaps, SMOOTH_MARGIN, Unflattened};
use crate::contact::PosedShape;
use crate::lattice::{monomials, polynomial};
use crate::simd::xyzx::{Xyzx, xyzx};

/// Gradient of the distance below which the effect fades out: where the lattice is crushed, the direction to the
/// collider is not certain.
const LEAST_GRADIENT: f32 = 0.25;

/// Marks cells whose mesh vertices move towards several planes.
const SEVERAL: u32 = u32::MAX;

/// Finds the displacements of mesh vertices, and owns the buffers.
#[derive(Debug, Default)]
pub(crate) struct Flattener {
    displacements: Displacements,
    /// Least gap of each component, from which gaps are measured.
    gaps: Vec<f32>,
    surroundings: Surroundings,
    /// Number of the plane, from 1 on, towards which mesh vertices of each cell of
    /// [`by_cell`](crate::lattice::Embedding::by_cell) move; 0 if they do not move, and [`SEVERAL`].
    colliders: Vec<u32>,
    lattice: Vec<Xyzx>,
    slopes: Vec<[Xyzx; 3]>,
}

impl Flattener {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let lattice = size_of_val(&*self.lattice) + size_of_val(&*self.slopes);
        let cells = size_of_val(&*self.gaps) + size_of_val(&*self.colliders);
        lattice + self.surroundings.bytes() + cells + self.displacements.bytes()
    }

    /// Returns false only if no plane is near a lattice.
    pub(crate) fn is_near<'a>(shapes: impl Iterator<Item = PosedShape<'a>>, positions: &[[f32; 3]]) -> bool {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for position in positions {
            low = std::array::from_fn(|k| low[k].min(position[k]));
            high = std::array::from_fn(|k| high[k].max(position[k]));
        }
        let (center, half) = center_and_half(low, high);
        let reach = f64::from(FADED + TOUCHING + SMOOTH_MARGIN);
        let is_near =
            |shape: PosedShape<'_>| shape.plane().is_some() && shape.may_touch(&center, &half, reach);
        shapes.into_iter().any(is_near)
    }

    /// Returns the displacements.
    pub(crate) fn displacements(&self) -> &Displacements {
        &self.displacements
    }

    /// Returns the displacements, to change them.
    pub(crate) fn displacements_mut(&mut self) -> &mut Displacements {
        &mut self.displacements
    }

    /// Removes all displacements.
    pub(crate) fn clear(&mut self) {
        self.displacements.clear();
    }

    /// Finds the displacements at planes. `shapes`: the shapes of all colliders in the frame of the body.
    ///
    /// Only the distance from a plane is linear, so that its derivatives are those of the lattice: those of other
    /// distances change within a cell at edges, at the back, and where the shape is curved, also where the lattice is
    /// not compressed.
    pub(crate) fn flatten<'a>(
        &mut self,
        surface: Unflattened<'_>,
        shapes: impl Iterator<Item = PosedShape<'a>> + Clone,
    ) {
        self.displacements.begin(surface.embedding);
        self.lattice.clear();
        self.lattice.extend(surface.positions.iter().copied().map(xyzx));
        if let Some(smoothing) = surface.embedding.smoothing().filter(|_| surface.motion.is_none()) {
            smoothing.update_slopes(&self.lattice, &mut self.slopes);
        }
        self.colliders.clear();
        self.colliders.resize(surface.embedding.by_cell().len(), 0);
        let (mut count, mut planes) = (0, 0_u32);
        for shape in shapes.clone() {
            count += 1;
            let Some(plane) = shape.plane() else { continue };
            self.surroundings.begin(&self.lattice, plane);
            if self.find_least_gaps(surface, plane) {
                self.displace(surface, plane, count);
                planes += 1;
            }
        }
        if count > 1 && !self.displacements.is_empty() {
            self.restrain(surface, shapes, planes as f32 * GREATEST_LENGTH);
        }
    }

    /// Finds the least gap of each component. Returns whether any is small enough for an effect.
    fn find_least_gaps(&mut self, surface: Unflattened<'_>, plane: (Vector3<f64>, f64)) -> bool {
        let Self { displacements, gaps, surroundings, lattice, slopes, .. } = self;
        let margin = surface.margin();
        gaps.clear();
        gaps.resize(surface.table.component_count, FADED + TOUCHING);
        let mut first = 0;
        for group in surface.embedding.by_cell() {
            let ranks = first..first + group.points.len() as u32;
            first = ranks.end;
            let least = &mut gaps[surface.table.components[group.corners[0] as usize] as usize];
            if *least <= TOUCHING || !surroundings.is_near(group.corners, *least + margin) {
                continue;
            }
            let measure = CellGaps::new(surface, (lattice, slopes), plane, surroundings, group.corners);
            for rank in ranks {
                let (gap, _) = measure.gap(rank, displacements.get(rank));
                *least = least.min(gap);
            }
        }
        gaps.iter_mut().for_each(|gap| *gap = least_gap(*gap));
        gaps.iter().any(|gap| *gap < FADED)
    }

    /// Moves mesh vertices towards the plane with a number. Must be called after [`Flattener::find_least_gaps`].
    fn displace(&mut self, surface: Unflattened<'_>, plane: (Vector3<f64>, f64), number: u32) {
        let Self { displacements, gaps, surroundings, colliders, lattice, slopes } = self;
        let Unflattened { table, embedding, .. } = surface;
        let margin = surface.margin();
        let mut first = 0;
        for (cell, group) in (0..).zip(embedding.by_cell()) {
            let ranks = [first, first + group.points.len() as u32];
            first = ranks[1];
            let least = gaps[table.components[group.corners[0] as usize] as usize];
            let greatest = least + greatest_reach(f32::INFINITY, least);
            if least >= FADED || !surroundings.is_near(group.corners, greatest + margin) {
                continue;
            }
            let gradients = group.corners.map(|corner| Vector3::from(surroundings.gradient(corner, table)));
            let reach = least + greatest_reach(greatest_compression(&gradients), least);
            if reach <= least || !faces(&gradients, &table.normal_ranges[cell as usize]) {
                continue;
            }
            if !surroundings.is_near(group.corners, reach + margin) {
                continue;
            }
            let terms = polynomial(gradients);
            let measure = CellGaps::new(surface, (lattice, slopes), plane, surroundings, group.corners);
            let holds = displacements.holds.len();
            for rank in ranks[0]..ranks[1] {
                let (gap, normal) = measure.gap(rank, displacements.get(rank));
                if gap >= reach {
                    continue;
                }
                let weights = monomials(1.0, table.local[rank as usize].map(|x| x.clamp(0.0, 1.0)));
                let mut gradient = terms[0];
                for k in 1..8 {
                    gradient += terms[k] * weights[k];
                }
                let length = gradient.norm();
                let outward = Vector3::from(table.normals[rank as usize]);
                let cosine = -gradient.dot(&outward) / length.max(LEAST_GRADIENT);
                let Approach { length, hold } = approach(gap, least, 1.0 - length, cosine);
                if length > 0.0 || hold > 0.0 {
                    displacements.add(rank, normal.map(|x| -x * length));
                    displacements.holds.push(Hold { rank, hold, normal });
                }
            }
            if displacements.holds.len() > holds {
                displacements.mark(cell, ranks);
                let collider = &mut colliders[cell as usize];
                *collider = if *collider == 0 { number } else { SEVERAL };
            }
        }
    }

    /// Shortens displacements by which a mesh vertex would enter a collider by more than [`TOUCHING`] while it moves
    /// towards a plane. The tolerance makes them continuous where a vertex moves along a collider. `greatest`: greatest
    /// length of a displacement.
    fn restrain<'a>(
        &mut self,
        surface: Unflattened<'_>,
        shapes: impl Iterator<Item = PosedShape<'a>>,
        greatest: f32,
    ) {
        let Self { displacements, colliders, lattice, slopes, .. } = self;
        let Unflattened { table, embedding, .. } = surface;
        let reach = f64::from(greatest + surface.margin());
        for (number, shape) in (1..=SEVERAL).zip(shapes) {
            for index in 0..displacements.moved.len() {
                let MovedCell { cell, ranks: [first, end] } = displacements.moved[index];
                // Displacements towards one plane alone do not enter it.
                if colliders[cell as usize] == number {
                    continue;
                }
                let corners = embedding.corners(table.vertices[first as usize] as usize);
                let (center, half) = bounds(&corners, lattice);
                if !shape.may_touch(&center, &half, reach) {
                    continue;
                }
                for rank in first..end {
                    let offset = displacements.get(rank);
                    if offset == [0.0; 3] {
                        continue;
                    }
                    let position = surface.position((lattice, slopes), rank);
                    let distance = |offset| shape.signed_distance(&displaced(position, offset)).distance;
                    let (before, after) = (distance([0.0; 3]), distance(offset));
                    let (way, room) = (before - after, before.max(0.0) + f64::from(TOUCHING));
                    if way > room {
                        displacements.add(rank, offset.map(|x| x * ((room / way) as f32 - 1.0)));
                    }
                }
            }
        }
    }
}

/// Returns false only if no surface in a cell faces the collider. `normals`: least and greatest components of the
/// normals in the cell.
fn faces(gradients: &[Vector3<f32>; 8], normals: &[[f32; 3]; 2]) -> bool {
    let [least, greatest] = normals;
    // The greatest product with a normal is a convex function of the gradient, so that it is greatest at a corner.
    let greatest_product = |gradient: &Vector3<f32>| -> f32 {
        (0..3).map(|k| (-gradient[k] * least[k]).max(-gradient[k] * greatest[k])).sum()
    };
    gradients.iter().any(|gradient| greatest_product(gradient) > FACING[0] * LEAST_GRADIENT)
}

/// Returns a bound of the compression in a cell, from the gradients of the distance at its corners: the length of a
/// mean is at least the least component along any direction.
fn greatest_compression(gradients: &[Vector3<f32>; 8]) -> f32 {
    let sum: Vector3<f32> = gradients.iter().sum();
    let direction = sum.try_normalize(0.0).unwrap_or_default();
    1.0 - gradients.iter().map(|gradient| gradient.dot(&direction)).fold(f32::INFINITY, f32::min)
}
