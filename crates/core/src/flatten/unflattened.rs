//! The surface before it is flattened: positions of its mesh vertices, and their gaps to a plane.

use nalgebra::Vector3;

use super::surroundings::{Surroundings, displaced, to_xyz};
use super::table::FlattenTable;
use crate::lattice::{Embedding, PointMap, Slopes, monomials, polynomial};
use crate::simd::moving::Moving;
use crate::simd::xyzx::Xyzx;
use crate::skin::{ComponentMotion, SurfaceMotion};

/// Distance of a mesh vertex from its cell, in cells, up to which its gap is computed by the polynomial of the cell.
const OUTSIDE: f32 = 0.01;

/// Distance in cells by which a smooth surface may leave the box of its cell: along each axis, at most 4/27 of the
/// differences between both slopes and the chord, which are at most 1 where the slopes are trusted.
pub(super) const SMOOTH_MARGIN: f32 = 1.0;

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

impl<'a> Unflattened<'a> {
    /// Returns the distance in cells by which mesh vertices may be outside the boxes of their cells.
    pub(super) fn margin(&self) -> f32 {
        let smooth = if self.embedding.smoothing().is_some() { SMOOTH_MARGIN } else { 0.0 };
        smooth + self.table.outside
    }

    /// Returns the slopes, if the skin is smooth.
    fn slopes(&self, slopes: &'a [[Xyzx; 3]]) -> Option<Slopes<'a>> {
        self.embedding.smoothing().map(|_| Slopes { slopes, trust: self.trust })
    }

    /// Returns the position of the mesh vertex of a rank.
    pub(super) fn position(&self, (lattice, slopes): (&'a [Xyzx], &'a [[Xyzx; 3]]), rank: u32) -> [f32; 3] {
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
pub(super) struct CellGaps<'a> {
    /// Local coordinates of the mesh vertex of each rank.
    local: &'a [[f32; 3]],
    /// Normal and offset of the plane.
    plane: (Vector3<f64>, f64),
    points: GapPoints<'a>,
}

/// What determines the gaps in a cell.
#[expect(clippy::large_enum_variant, reason = "a value is short-lived and stays on the stack")]
enum GapPoints<'a> {
    /// The distance from a plane, which is trilinear in the cell; and the corners and the lattice, for mesh vertices
    /// outside the cell.
    Distance { terms: [f32; 8], normal: [f32; 3], corners: &'a [u32; 8], lattice: &'a [Xyzx] },
    /// The positions in the cell.
    Map(PointMap),
    /// The motions of the mesh vertices.
    Motion(&'a [Moving], ComponentMotion),
}

impl<'a> CellGaps<'a> {
    pub(super) fn new(
        surface: Unflattened<'a>,
        (lattice, slopes): (&'a [Xyzx], &'a [[Xyzx; 3]]),
        plane: (Vector3<f64>, f64),
        surroundings: &Surroundings,
        corners: &'a [u32; 8],
    ) -> Self {
        let points = match surface.motion {
            Some(motion) => GapPoints::Motion(motion.points, motion.of_vertex(corners[0])),
            None if surface.embedding.smoothing().is_none() => GapPoints::Distance {
                terms: polynomial(corners.map(|corner| surroundings.distances[corner as usize])),
                normal: plane.0.map(|x| x as f32).into(),
                corners,
                lattice,
            },
            None => GapPoints::Map(PointMap::new(corners, lattice, surface.slopes(slopes))),
        };
        Self { local: &surface.table.local, plane, points }
    }

    /// Returns the gap of a displaced mesh vertex, and the normal of the plane.
    #[inline]
    pub(super) fn gap(&self, rank: u32, offset: [f32; 3]) -> (f32, [f32; 3]) {
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
        let (normal, offset) = self.plane;
        let distance = normal.dot(&position.coords) - offset;
        (distance as f32, normal.map(|x| x as f32).into())
    }
}
