//! Moves mesh vertices onto the colliders that the body is pressed onto.

use nalgebra::{Point3, Vector3};

use super::approach::{Approach, REACH, approach, greatest_reach};
use super::displacements::{Displacements, Hold, MovedCell};
use super::table::FlattenTable;
use crate::contact::{PosedShape, SignedDistance};
use crate::lattice::{Embedding, PointMap, Slopes, monomials, polynomial};
use crate::simd::xyzx::{Xyzx, xyzx};

/// Distance of a mesh vertex from its cell, in cells, up to which its gap is computed by the polynomial of the cell.
const OUTSIDE: f32 = 0.01;

/// Gradient of the distance below which the effect fades out: where the lattice is crushed, the direction to the collider is not
/// certain.
const LEAST_GRADIENT: f32 = 0.25;

/// A cell with mesh vertices near a collider.
#[derive(Clone, Copy, Debug)]
struct NearCell {
    /// Index in [`Embedding::by_cell`].
    cell: u32,
    /// Corners of the cell.
    corners: [u32; 8],
    /// Ranks of the mesh vertices of the cell: first and end.
    ranks: [u32; 2],
    /// End of the mesh vertices near the collider in `Flattener::near`.
    end: u32,
}

/// A mesh vertex near a collider.
#[derive(Clone, Copy, Debug)]
struct Near {
    rank: u32,
    gap: f32,
    /// Normal of the collider.
    normal: [f32; 3],
}

/// The lattice around a collider.
#[derive(Debug, Default)]
struct Surroundings {
    /// Signed distance of each lattice vertex, or NaN if it is not known.
    distances: Vec<f32>,
    /// Derivatives of the distance along the axes of the rest shape at each lattice vertex, or NaN if they are not known.
    gradients: Vec<[f32; 3]>,
}

/// Finds the displacements of mesh vertices, and owns the buffers.
#[derive(Debug, Default)]
pub(crate) struct Flattener {
    displacements: Displacements,
    near: Vec<Near>,
    near_cells: Vec<NearCell>,
    /// Least gap of each component.
    gaps: Vec<f32>,
    surroundings: Surroundings,
    /// Number of colliders near each cell in [`Embedding::by_cell`].
    colliders: Vec<u8>,
    lattice: Vec<Xyzx>,
    slopes: Vec<[Xyzx; 3]>,
}

impl Flattener {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let near = size_of_val(&*self.near) + size_of_val(&*self.near_cells) + size_of_val(&*self.gaps);
        let Surroundings { distances, gradients } = &self.surroundings;
        let lattice =
            size_of_val(&*self.lattice) + size_of_val(&*self.slopes) + size_of_val(&*self.colliders);
        near + lattice + size_of_val(&**distances) + size_of_val(&**gradients) + self.displacements.bytes()
    }

    /// Returns false only if no collider is near a lattice.
    pub(crate) fn is_near<'a>(shapes: impl Iterator<Item = PosedShape<'a>>, positions: &[[f32; 3]]) -> bool {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for position in positions {
            low = std::array::from_fn(|k| low[k].min(position[k]));
            high = std::array::from_fn(|k| high[k].max(position[k]));
        }
        let (center, half) = center_and_half(low, high);
        shapes.into_iter().any(|shape| shape.may_touch(&center, &half, REACH.into()))
    }

    /// Returns the displacements.
    pub(crate) fn displacements(&self) -> &Displacements {
        &self.displacements
    }

    /// Returns the displacements.
    pub(crate) fn displacements_mut(&mut self) -> &mut Displacements {
        &mut self.displacements
    }

    /// Removes all displacements.
    pub(crate) fn clear(&mut self) {
        self.displacements.clear();
    }

    /// Finds the displacements.
    ///
    /// * `shapes`: the colliders, in the frame of the body.
    /// * `positions`: of the lattice vertices, in cells.
    /// * `trust`: in the slopes of the lattice, if the skin is smooth.
    pub(crate) fn flatten<'a>(
        &mut self,
        (table, embedding): (&FlattenTable, &Embedding),
        shapes: impl Iterator<Item = PosedShape<'a>> + Clone,
        positions: &[[f32; 3]],
        trust: &[f32],
    ) {
        self.displacements.begin(embedding);
        self.lattice.clear();
        self.lattice.extend(positions.iter().copied().map(xyzx));
        if let Some(smoothing) = embedding.smoothing() {
            smoothing.update_slopes(&self.lattice, &mut self.slopes);
        }
        self.colliders.clear();
        self.colliders.resize(embedding.by_cell().len(), 0);
        for shape in shapes.clone() {
            self.find_near((table, embedding), &shape, trust);
            self.displace(table, embedding, &shape);
        }
        if self.displacements.moved.iter().any(|moved| self.colliders[moved.cell as usize] > 1) {
            for shape in shapes {
                self.restrain((table, embedding), &shape, trust);
            }
        }
    }

    /// Lists the mesh vertices near a collider, by cell, and the least gap of each component.
    fn find_near(
        &mut self,
        (table, embedding): (&FlattenTable, &Embedding),
        shape: &PosedShape<'_>,
        trust: &[f32],
    ) {
        let Self { displacements, near, near_cells, gaps, surroundings, colliders, lattice, slopes } = self;
        let slopes = embedding.smoothing().map(|_| Slopes { slopes, trust });
        near.clear();
        near_cells.clear();
        gaps.clear();
        gaps.resize(table.component_count, f32::INFINITY);
        surroundings.begin(lattice, shape);
        // The distance from a plane is a linear function, so that it is trilinear in a cell if the positions are.
        let plane = shape.plane().map(|(normal, _)| <[f32; 3]>::from(normal.map(|x| x as f32)));
        let mut first = 0;
        for (cell, group) in (0..).zip(embedding.by_cell()) {
            let ranks = [first, first + group.points.len() as u32];
            first = ranks[1];
            if !surroundings.is_near(group.corners, lattice, shape) {
                continue;
            }
            let count = &mut colliders[cell as usize];
            *count = count.saturating_add(1);
            let least = &mut gaps[table.components[group.corners[0] as usize] as usize];
            let start = near.len();
            let mut push = |rank, gap: f32, normal| {
                *least = least.min(gap);
                near.push(Near { rank, gap, normal });
            };
            let distances = plane.filter(|_| slopes.is_none()).map(|normal| {
                (normal, polynomial(group.corners.map(|corner| surroundings.distances[corner as usize])))
            });
            let mut map = None;
            for (rank, &point) in (ranks[0]..).zip(group.points) {
                let local = embedding.local(point as usize);
                match &distances {
                    Some((normal, terms)) if local.iter().all(|x| (-OUTSIDE..=1.0 + OUTSIDE).contains(x)) => {
                        let weights = monomials(1.0, local);
                        let offset = displacements.get(rank);
                        let mut gap: f32 = (0..3).map(|k| normal[k] * offset[k]).sum();
                        for k in 0..8 {
                            gap += terms[k] * weights[k];
                        }
                        if gap < REACH {
                            push(rank, gap, *normal);
                        }
                    }
                    _ => {
                        let map = map.get_or_insert_with(|| PointMap::new(group.corners, lattice, slopes));
                        let position = displaced(map.at(local), displacements.get(rank));
                        let SignedDistance { distance, normal } = shape.signed_distance(&position);
                        if distance < f64::from(REACH) {
                            push(rank, distance as f32, normal.map(|x| x as f32).into());
                        }
                    }
                }
            }
            if near.len() > start {
                near_cells.push(NearCell { cell, corners: *group.corners, ranks, end: near.len() as u32 });
            }
        }
    }

    /// Moves the mesh vertices that were found towards the collider.
    fn displace(&mut self, table: &FlattenTable, embedding: &Embedding, shape: &PosedShape<'_>) {
        let Self { displacements, near, near_cells, gaps, surroundings, lattice, .. } = self;
        let mut start = 0;
        for &NearCell { cell, corners, ranks, end } in near_cells.iter() {
            let near = &near[start as usize..end as usize];
            start = end;
            let least = gaps[table.components[corners[0] as usize] as usize].max(0.0);
            let gradients =
                corners.map(|corner| Vector3::from(surroundings.gradient(corner, table, lattice, shape)));
            let range = least + greatest_reach(greatest_compression(&gradients));
            let terms = polynomial(gradients);
            let holds = displacements.holds.len();
            for &Near { rank, gap, normal } in near.iter().filter(|near| near.gap < range) {
                let local = embedding.local(table.vertices[rank as usize] as usize);
                let weights = monomials(1.0, local.map(|x| x.clamp(0.0, 1.0)));
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
            }
        }
    }

    /// Shortens displacements by which a mesh vertex enters a collider while it moves towards another one.
    fn restrain(
        &mut self,
        (table, embedding): (&FlattenTable, &Embedding),
        shape: &PosedShape<'_>,
        trust: &[f32],
    ) {
        let Self { displacements, colliders, lattice, slopes, .. } = self;
        let slopes = embedding.smoothing().map(|_| Slopes { slopes, trust });
        for index in 0..displacements.moved.len() {
            let MovedCell { cell, ranks: [first, end] } = displacements.moved[index];
            if colliders[cell as usize] < 2 {
                continue;
            }
            for rank in first..end {
                let offset = displacements.get(rank);
                if offset == [0.0; 3] {
                    continue;
                }
                let point = table.vertices[rank as usize] as usize;
                let position = to_xyz(embedding.position(point, lattice, slopes));
                let distance = |offset| shape.signed_distance(&displaced(position, offset)).distance;
                let (before, after) = (distance([0.0; 3]).max(0.0), distance(offset));
                if after < 0.0 && after < before {
                    let scale = (before / (before - after)) as f32;
                    displacements.add(rank, offset.map(|x| x * (scale - 1.0)));
                }
            }
        }
    }
}

/// Returns a bound of the compression in a cell, from the gradients of the distance at its corners: the length of a mean is at
/// least the least component along any direction.
fn greatest_compression(gradients: &[Vector3<f32>; 8]) -> f32 {
    let sum: Vector3<f32> = gradients.iter().sum();
    let direction = sum.try_normalize(0.0).unwrap_or_default();
    1.0 - gradients.iter().map(|gradient| gradient.dot(&direction)).fold(f32::INFINITY, f32::min)
}

impl Surroundings {
    /// Prepares for a lattice and a collider. Distances from a plane are computed at once.
    fn begin(&mut self, lattice: &[Xyzx], shape: &PosedShape<'_>) {
        self.distances.clear();
        match shape.plane() {
            Some((normal, offset)) => self.distances.extend(lattice.iter().map(|&[x, y, z, _]| {
                let [x, y, z] = [x, y, z].map(f64::from);
                (normal.x * x + normal.y * y + normal.z * z - offset) as f32
            })),
            None => self.distances.resize(lattice.len(), f32::NAN),
        }
        self.gradients.clear();
        self.gradients.resize(lattice.len(), [f32::NAN; 3]);
    }

    /// Returns false only if no point of a cell is near the collider. [`REACH`] is a margin for mesh vertices that a smooth skin
    /// moves out of their cell.
    fn is_near(&self, corners: &[u32; 8], lattice: &[Xyzx], shape: &PosedShape<'_>) -> bool {
        if shape.plane().is_some() {
            return corners.iter().any(|&corner| self.distances[corner as usize] < REACH);
        }
        let (center, half) = bounds(corners, lattice);
        shape.may_touch(&center, &half, REACH.into())
    }

    /// Returns the derivatives of the distance along the axes of the rest shape at a lattice vertex.
    fn gradient(
        &mut self,
        vertex: u32,
        table: &FlattenTable,
        lattice: &[Xyzx],
        shape: &PosedShape<'_>,
    ) -> [f32; 3] {
        let Self { distances, gradients } = self;
        let gradient = &mut gradients[vertex as usize];
        if gradient[0].is_nan() {
            let stencil = &table.stencils[vertex as usize];
            for neighbor in stencil.vertices() {
                let distance = &mut distances[neighbor as usize];
                if distance.is_nan() {
                    let position = displaced(to_xyz(lattice[neighbor as usize]), [0.0; 3]);
                    *distance = shape.signed_distance(&position).distance as f32;
                }
            }
            *gradient = stencil.slopes(|vertex| distances[vertex as usize]);
        }
        *gradient
    }
}

fn to_xyz([x, y, z, _]: Xyzx) -> [f32; 3] {
    [x, y, z]
}

/// Returns a position plus a displacement.
fn displaced(position: [f32; 3], offset: [f32; 3]) -> Point3<f64> {
    Point3::from(std::array::from_fn(|k| f64::from(position[k]) + f64::from(offset[k])))
}

/// Returns the center and half the size of the box around the corners of a cell.
fn bounds(corners: &[u32; 8], lattice: &[Xyzx]) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for &corner in corners {
        let position = to_xyz(lattice[corner as usize]);
        low = std::array::from_fn(|k| low[k].min(position[k]));
        high = std::array::from_fn(|k| high[k].max(position[k]));
    }
    center_and_half(low, high)
}

/// Returns the center of a box and half its size.
fn center_and_half(low: [f32; 3], high: [f32; 3]) -> (Point3<f64>, Vector3<f64>) {
    let [low, high] = [low, high].map(|corner| Vector3::from(corner.map(f64::from)));
    (Point3::from((low + high) / 2.0), (high - low) / 2.0)
}
