//! Moves mesh vertices onto the colliders that the body is pressed onto.

use nalgebra::{Point3, Vector3};

use super::approach::{
    Approach, FACING, FADED, GREATEST_LENGTH, TOUCHING, approach, greatest_reach, least_gap,
};
use super::displacements::{Displacements, Hold, MovedCell};
use super::table::FlattenTable;
use crate::contact::{PosedShape, SignedDistance};
use crate::lattice::{Embedding, PointMap, Slopes, monomials, polynomial};
use crate::simd::moving::Moving;
use crate::simd::xyzx::{Xyzx, xyzx};
use crate::skin::{ComponentMotion, SurfaceMotion};

/// Distance of a mesh vertex from its cell, in cells, up to which its gap is computed by the polynomial of the cell.
const OUTSIDE: f32 = 0.01;

/// Gradient of the distance below which the effect fades out: where the lattice is crushed, the direction to the collider is not
/// certain.
const LEAST_GRADIENT: f32 = 0.25;

/// Distance in cells by which a smooth surface may leave the box of its cell: along each axis, at most 4/27 of the differences
/// between both slopes and the chord, which are at most 1 where the slopes are trusted.
const SMOOTH_MARGIN: f32 = 1.0;

/// The surface of a body before it is flattened.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unflattened<'a> {
    pub(crate) table: &'a FlattenTable,
    pub(crate) embedding: &'a Embedding,
    /// Positions of the lattice vertices, in cells.
    pub(crate) positions: &'a [[f32; 3]],
    /// Trust in the slopes of the lattice, if the skin is smooth.
    pub(crate) trust: &'a [f32],
    /// The motions of the mesh vertices to their positions, if they are known.
    pub(crate) motion: Option<SurfaceMotion<'a>>,
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
    /// Least gap of each component, from which gaps are measured.
    gaps: Vec<f32>,
    surroundings: Surroundings,
    /// Number of colliders that displaced mesh vertices of a cell may enter, for each moved cell.
    colliders: Vec<u8>,
    lattice: Vec<Xyzx>,
    slopes: Vec<[Xyzx; 3]>,
}

impl Flattener {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Surroundings { distances, gradients } = &self.surroundings;
        let lattice = size_of_val(&*self.lattice) + size_of_val(&*self.slopes);
        let surroundings = size_of_val(&**distances) + size_of_val(&**gradients);
        let cells = size_of_val(&*self.gaps) + size_of_val(&*self.colliders);
        lattice + surroundings + cells + self.displacements.bytes()
    }

    /// Returns false only if no collider is near a lattice.
    pub(crate) fn is_near<'a>(shapes: impl Iterator<Item = PosedShape<'a>>, positions: &[[f32; 3]]) -> bool {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for position in positions {
            low = std::array::from_fn(|k| low[k].min(position[k]));
            high = std::array::from_fn(|k| high[k].max(position[k]));
        }
        let (center, half) = center_and_half(low, high);
        shapes
            .into_iter()
            .any(|shape| shape.may_touch(&center, &half, f64::from(FADED + TOUCHING + SMOOTH_MARGIN)))
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

    /// Finds the displacements at colliders, whose shapes are in the frame of the body.
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
        let mut count = 0_u16;
        for shape in shapes.clone() {
            self.surroundings.begin(&self.lattice, &shape);
            if self.find_least_gaps(surface, &shape) {
                self.displace(surface, &shape);
            }
            count = count.saturating_add(1);
        }
        if count > 1 && !self.displacements.is_empty() {
            self.restrain(surface, shapes, f32::from(count) * GREATEST_LENGTH);
        }
    }

    /// Finds the least gap of each component. Returns whether any is small enough for an effect.
    fn find_least_gaps(&mut self, surface: Unflattened<'_>, shape: &PosedShape<'_>) -> bool {
        let Self { displacements, gaps, surroundings, lattice, slopes, .. } = self;
        let margin = surface.margin();
        gaps.clear();
        gaps.resize(surface.table.component_count, FADED + TOUCHING);
        let mut first = 0;
        for group in surface.embedding.by_cell() {
            let ranks = first..first + group.points.len() as u32;
            first = ranks.end;
            let least = &mut gaps[surface.table.components[group.corners[0] as usize] as usize];
            if *least <= TOUCHING || !surroundings.is_near(group.corners, lattice, shape, *least + margin) {
                continue;
            }
            let measure = CellGaps::new(surface, (lattice, slopes), shape, surroundings, group.corners);
            for rank in ranks {
                let (gap, _) = measure.gap(rank, displacements.get(rank));
                *least = least.min(gap);
            }
        }
        gaps.iter_mut().for_each(|gap| *gap = least_gap(*gap));
        gaps.iter().any(|gap| *gap < FADED)
    }

    /// Moves mesh vertices towards the collider. Must be called after [`Flattener::find_least_gaps`].
    fn displace(&mut self, surface: Unflattened<'_>, shape: &PosedShape<'_>) {
        let Self { displacements, gaps, surroundings, lattice, slopes, .. } = self;
        let Unflattened { table, embedding, .. } = surface;
        let margin = surface.margin();
        let mut first = 0;
        for (cell, group) in (0..).zip(embedding.by_cell()) {
            let ranks = [first, first + group.points.len() as u32];
            first = ranks[1];
            let least = gaps[table.components[group.corners[0] as usize] as usize];
            let greatest = least + greatest_reach(f32::INFINITY, least);
            if least >= FADED || !surroundings.is_near(group.corners, lattice, shape, greatest + margin) {
                continue;
            }
            let gradients = group
                .corners
                .map(|corner| Vector3::from(surroundings.gradient(corner, table, lattice, shape)));
            let reach = least + greatest_reach(greatest_compression(&gradients), least);
            if reach <= least || !faces(&gradients, &table.normal_ranges[cell as usize]) {
                continue;
            }
            if !surroundings.is_near(group.corners, lattice, shape, reach + margin) {
                continue;
            }
            let terms = polynomial(gradients);
            let measure = CellGaps::new(surface, (lattice, slopes), shape, surroundings, group.corners);
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
            }
        }
    }

    /// Shortens displacements by which a mesh vertex enters a collider while it moves towards another one. `greatest`: greatest length
    /// of a displacement.
    fn restrain<'a>(
        &mut self,
        surface: Unflattened<'_>,
        shapes: impl Iterator<Item = PosedShape<'a>> + Clone,
        greatest: f32,
    ) {
        let Self { displacements, colliders, lattice, slopes, .. } = self;
        let Unflattened { table, embedding, .. } = surface;
        let reach = f64::from(greatest + surface.margin());
        colliders.clear();
        colliders.resize(displacements.moved.len(), 0);
        for shape in shapes.clone() {
            for (moved, count) in displacements.moved.iter().zip(&mut *colliders) {
                let corners = embedding.corners(table.vertices[moved.ranks[0] as usize] as usize);
                let (center, half) = bounds(&corners, lattice);
                *count = count.saturating_add(shape.may_touch(&center, &half, reach).into());
            }
        }
        for shape in shapes {
            for index in (0..colliders.len()).filter(|&index| colliders[index] > 1) {
                let MovedCell { ranks: [first, end], .. } = displacements.moved[index];
                for rank in first..end {
                    let offset = displacements.get(rank);
                    if offset == [0.0; 3] {
                        continue;
                    }
                    let position = surface.position((lattice, slopes), rank);
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
}

impl<'a> Unflattened<'a> {
    /// Returns the distance in cells by which mesh vertices may be outside the boxes of their cells.
    fn margin(&self) -> f32 {
        let smooth = if self.embedding.smoothing().is_some() { SMOOTH_MARGIN } else { 0.0 };
        smooth + self.table.outside
    }

    /// Returns the slopes, if the skin is smooth.
    fn slopes(&self, slopes: &'a [[Xyzx; 3]]) -> Option<Slopes<'a>> {
        self.embedding.smoothing().map(|_| Slopes { slopes, trust: self.trust })
    }

    /// Returns the position of the mesh vertex of a rank.
    fn position(&self, (lattice, slopes): (&'a [Xyzx], &'a [[Xyzx; 3]]), rank: u32) -> [f32; 3] {
        let point = self.table.vertices[rank as usize] as usize;
        match self.motion {
            None => to_xyz(self.embedding.position(point, lattice, self.slopes(slopes))),
            Some(motion) => {
                let corner = self.embedding.corners(point)[0];
                moved(&motion.points[rank as usize], motion.of_vertex(corner))
            }
        }
    }
}

/// Returns the end of the motion of a point.
fn moved(point: &Moving, ComponentMotion { lambda, center }: ComponentMotion) -> [f32; 3] {
    let (p, v) = (point.position(), point.direction());
    std::array::from_fn(|k| center[k] + (p[k] + lambda * v[k]))
}

/// Measures the gaps of the mesh vertices in a cell.
struct CellGaps<'a> {
    /// Local coordinates of the mesh vertex of each rank.
    local: &'a [[f32; 3]],
    shape: &'a PosedShape<'a>,
    /// Normal and offset of the collider, if it is a plane.
    plane: Option<(Vector3<f64>, f64)>,
    points: GapPoints<'a>,
}

/// What determines the gaps in a cell.
enum GapPoints<'a> {
    /// The distance from a plane, which is trilinear in the cell; and the corners and the lattice, for mesh vertices outside the
    /// cell.
    Distance { terms: [f32; 8], normal: [f32; 3], corners: &'a [u32; 8], lattice: &'a [Xyzx] },
    /// The positions in the cell.
    Map(PointMap),
    /// The motions of the mesh vertices.
    Motion(&'a [Moving], ComponentMotion),
}

impl<'a> CellGaps<'a> {
    fn new(
        surface: Unflattened<'a>,
        (lattice, slopes): (&'a [Xyzx], &'a [[Xyzx; 3]]),
        shape: &'a PosedShape<'a>,
        surroundings: &Surroundings,
        corners: &'a [u32; 8],
    ) -> Self {
        let plane = shape.plane();
        let points = match (surface.motion, plane) {
            (Some(motion), _) => GapPoints::Motion(motion.points, motion.of_vertex(corners[0])),
            (None, Some((normal, _))) if surface.embedding.smoothing().is_none() => GapPoints::Distance {
                terms: polynomial(corners.map(|corner| surroundings.distances[corner as usize])),
                normal: normal.map(|x| x as f32).into(),
                corners,
                lattice,
            },
            (None, _) => GapPoints::Map(PointMap::new(corners, lattice, surface.slopes(slopes))),
        };
        Self { local: &surface.table.local, shape, plane, points }
    }

    /// Returns the gap of a displaced mesh vertex, and the normal of the collider.
    #[inline]
    fn gap(&self, rank: u32, offset: [f32; 3]) -> (f32, [f32; 3]) {
        let local = self.local[rank as usize];
        let position = match &self.points {
            GapPoints::Distance { terms, normal, corners, lattice } => {
                if local.iter().all(|x| (-OUTSIDE..=1.0 + OUTSIDE).contains(x)) {
                    let weights = monomials(1.0, local);
                    let along: f32 = (0..3).map(|k| normal[k] * offset[k]).sum();
                    return ((0..8).fold(along, |gap, k| gap + terms[k] * weights[k]), *normal);
                }
                PointMap::new(corners, lattice, None).at(local)
            }
            GapPoints::Map(map) => map.at(local),
            GapPoints::Motion(points, motion) => moved(&points[rank as usize], *motion),
        };
        let position = displaced(position, offset);
        let (distance, normal) = match self.plane {
            Some((normal, offset)) => (normal.dot(&position.coords) - offset, normal),
            None => {
                let SignedDistance { distance, normal } = self.shape.signed_distance(&position);
                (distance, normal)
            }
        };
        (distance as f32, normal.map(|x| x as f32).into())
    }
}

/// Returns false only if no surface in a cell faces the collider. `normals`: least and greatest components of the normals in the
/// cell.
fn faces(gradients: &[Vector3<f32>; 8], normals: &[[f32; 3]; 2]) -> bool {
    let [least, greatest] = normals;
    // The greatest product with a normal is a convex function of the gradient, so that it is greatest at a corner.
    let greatest_product = |gradient: &Vector3<f32>| -> f32 {
        (0..3).map(|k| (-gradient[k] * least[k]).max(-gradient[k] * greatest[k])).sum()
    };
    gradients.iter().any(|gradient| greatest_product(gradient) > FACING[0] * LEAST_GRADIENT)
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

    /// Returns false only if no point of the box of a cell is within a distance of the collider.
    fn is_near(&self, corners: &[u32; 8], lattice: &[Xyzx], shape: &PosedShape<'_>, distance: f32) -> bool {
        if shape.plane().is_some() {
            return corners.iter().any(|&corner| self.distances[corner as usize] < distance);
        }
        let (center, half) = bounds(corners, lattice);
        shape.may_touch(&center, &half, distance.into())
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
