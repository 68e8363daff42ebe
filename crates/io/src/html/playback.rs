//! Reads the frames of a run as surfaces, as the player does.

use std::io;
use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use supple::{Mesh, Shape, euler_degrees};

use super::frame::Layout;
use super::header::{ColliderShape, Header};
use super::pieces::{self, PieceArrays};
use super::points::{BOUNDS, MESH_VALUES, POINT, positions, unpack_words};
use super::run::Run;
use super::text::invalid;
use crate::collider::{self, Divisions};
use crate::film::{Footage, Moment, PlaneAt, Solid, Surface, Tint};

/// How finely colliders are divided: the light of films is evaluated at their vertices.
const DIVISIONS: Divisions = Divisions { around: 64, quarter: 16, edge: 12 };

/// Faces as triangles.
#[derive(Clone, Debug, Default)]
struct Faces {
    triangles: Vec<[u32; 3]>,
    /// The face of each triangle.
    faces: Vec<u32>,
    /// For each vertex, the first one at its place.
    weld: Vec<u32>,
}

/// A body in the present frame.
struct BodyPlayback {
    faces: Faces,
    /// Color of each face.
    tints: Vec<Tint>,
    whole: Option<Arc<Surface>>,
    /// The pieces with an identity.
    pieces: Option<(u64, Arc<Surface>)>,
}

/// A collider before it moves.
struct ColliderPlayback {
    center: Vector3<f64>,
    kind: ColliderKind,
}

enum ColliderKind {
    Plane(PlaneAt),
    Fixed(Solid),
    Animated(Faces, Option<Arc<Surface>>),
}

/// A run that is played, frame by frame.
pub(crate) struct Playback<'a> {
    run: Run<'a>,
    layout: Layout,
    bodies: Vec<BodyPlayback>,
    colliders: Vec<ColliderPlayback>,
    frame: Vec<u8>,
}

impl<'a> Playback<'a> {
    /// Reads the surfaces of a run.
    pub(crate) fn new(run: Run<'a>) -> io::Result<Self> {
        let incomplete = || invalid("the data of a run are incomplete, or were changed");
        let mut arrays = Arrays { rest: &run.arrays, header: &run.header, surfaces: Vec::new() };
        let mut bodies = Vec::new();
        for (index, body) in run.header.bodies.iter().enumerate() {
            let faces = arrays.surface(body.surface).ok_or_else(incomplete)?;
            arrays.words(2 * body.links as usize).ok_or_else(incomplete)?;
            let tints = run.header.tints(index);
            bodies.push(BodyPlayback { faces, tints, whole: None, pieces: None });
        }
        let mut colliders = Vec::new();
        for collider in &run.header.colliders {
            let kind = arrays.collider(collider.center, &collider.shape).ok_or_else(incomplete)?;
            colliders.push(ColliderPlayback { center: collider.center.into(), kind });
        }
        Ok(Self { layout: Layout::new(&run.header), run, bodies, colliders, frame: Vec::new() })
    }

    fn moment(&mut self) -> Option<Moment> {
        let Self { layout, bodies, colliders, frame, .. } = self;
        let head = frame.get(..layout.head())?;
        let (points, size) = layout.points(&frame[layout.head()..])?;
        let broken = pieces::read_arrays(&frame[layout.head()..])?;
        let mut rest = &frame[layout.head() + size..];
        let mut sets = points.iter().enumerate().map(|(set, &points)| {
            let values;
            (values, rest) = rest.split_at_checked(POINT * points)?;
            let bounds = &head[layout.bounds(set)..][..BOUNDS];
            // The lattices are not needed.
            let largest = MESH_VALUES;
            Some(positions(bounds, largest, values))
        });
        let mut moment = Moment::default();
        for (index, body) in bodies.iter_mut().enumerate() {
            let positions: Vec<[f32; 3]> =
                sets.next()??.into_iter().map(|point| point.map(|number| number as f32)).collect();
            sets.next()??;
            let pieces = broken.iter().find(|(broken, _)| broken.body == index);
            let surface = body.surface(&positions, pieces)?;
            let [at_rest, _, volume] = layout.volumes(head, index);
            let volume = (at_rest != 0.0).then(|| volume / at_rest);
            moment.bodies.push(Solid { surface, positions, volume });
        }
        for (index, collider) in colliders.iter_mut().enumerate() {
            let points = match collider.kind {
                ColliderKind::Animated(..) => sets.next()??,
                _ => Vec::new(),
            };
            let Some(pose) = layout.pose(head, index) else { continue };
            match &mut collider.kind {
                ColliderKind::Animated(faces, surface) => {
                    let positions: Vec<[f32; 3]> =
                        points.into_iter().map(|point| point.map(|number| number as f32)).collect();
                    let surface = surface.get_or_insert_with(|| faces.surface(&positions, &[])).clone();
                    let solid = Solid { surface, positions, volume: None };
                    moment.colliders.push(moved(&solid, collider.center, pose));
                }
                ColliderKind::Fixed(solid) => moment.colliders.push(moved(solid, collider.center, pose)),
                ColliderKind::Plane(plane) => {
                    let rotation = euler_degrees(pose[1]);
                    let point = rotation * (Vector3::from(plane.point) - collider.center) + collider.center;
                    let point = (point + Vector3::from(pose[0])).into();
                    moment
                        .planes
                        .push(PlaneAt { point, normal: (rotation * Vector3::from(plane.normal)).into() });
                }
            }
        }
        Some(moment)
    }
}

impl Footage for Playback<'_> {
    fn frames(&self) -> usize {
        self.run.header.frames
    }

    fn fps(&self) -> f64 {
        self.run.header.fps / self.run.header.every as f64
    }

    fn up(&self) -> [f64; 3] {
        self.run.header.up
    }

    fn read(&mut self, frame: usize) -> io::Result<Moment> {
        self.run.frames.read_frame(frame, &mut self.frame)?;
        self.moment().ok_or_else(|| invalid("a frame is incomplete, or was changed"))
    }
}

impl BodyPlayback {
    /// Returns the surface of a frame, whole or of its pieces.
    fn surface(
        &mut self,
        positions: &[[f32; 3]],
        pieces: Option<&(pieces::BrokenBody, Option<PieceArrays>)>,
    ) -> Option<Arc<Surface>> {
        let Some((broken, arrays)) = pieces else {
            self.pieces = None;
            if positions.len() != self.faces.weld.len() {
                return None;
            }
            let Self { faces, tints, whole, .. } = self;
            return Some(whole.get_or_insert_with(|| faces.surface(positions, tints)).clone());
        };
        if let Some((identity, surface)) = &self.pieces
            && *identity == broken.identity
        {
            return Some(surface.clone());
        }
        let PieceArrays { corners, of_whole, indices, weld, ears } = arrays.as_ref()?;
        let faces = Faces::new(corners, indices, weld.clone(), ears, positions.len())?;
        let of_face = |face: usize| match of_whole.get(face) {
            Some(&face) => self.tints.get(face as usize).copied().unwrap_or(Tint::Palette),
            None => Tint::Inside,
        };
        let tints: Vec<Tint> = (0..corners.len()).map(of_face).collect();
        let surface = faces.surface(positions, &tints);
        self.pieces = Some((broken.identity, surface.clone()));
        Some(surface)
    }
}

impl Faces {
    /// Triangulates faces; `None` if an index is out of range. `ears`: the triangles, or none if all faces are fans.
    fn new(
        corners: &[u32],
        indices: &[u32],
        weld: Vec<u32>,
        ears: &[[u32; 3]],
        vertices: usize,
    ) -> Option<Self> {
        let is_valid = |index: &u32| (*index as usize) < vertices;
        if weld.len() != vertices || !indices.iter().chain(&weld).chain(ears.as_flattened()).all(is_valid) {
            return None;
        }
        let (mut triangles, mut faces) = (Vec::new(), Vec::new());
        let mut rest = indices;
        for (face, &count) in (0..).zip(corners) {
            let of_face;
            (of_face, rest) = rest.split_at_checked(count as usize)?;
            for k in 2..of_face.len() {
                triangles.push([of_face[0], of_face[k - 1], of_face[k]]);
                faces.push(face);
            }
        }
        if !ears.is_empty() {
            // A face of n corners has n - 2 triangles in either case.
            if ears.len() != triangles.len() {
                return None;
            }
            triangles = ears.to_vec();
        }
        Some(Self { triangles, faces, weld })
    }

    /// `tints`: colors of the faces, or none.
    fn surface(&self, positions: &[[f32; 3]], tints: &[Tint]) -> Arc<Surface> {
        let tint = |&face: &u32| tints.get(face as usize).copied().unwrap_or(Tint::Palette);
        let tints = self.faces.iter().map(tint).collect();
        Arc::new(Surface::new(positions, &self.triangles, &self.weld, tints))
    }
}

/// The arrays after a description, while they are read.
struct Arrays<'a> {
    rest: &'a [u8],
    header: &'a Header,
    surfaces: Vec<Faces>,
}

impl Arrays<'_> {
    fn words(&mut self, count: usize) -> Option<Vec<u32>> {
        let packed;
        (packed, self.rest) = self.rest.split_at_checked(4 * count)?;
        Some(unpack_words(packed))
    }

    /// Returns a surface, which is read the first time.
    fn surface(&mut self, index: usize) -> Option<Faces> {
        if index == self.surfaces.len() {
            let [vertices, faces, corners, triangles] = self.header.surfaces.get(index)?.counts();
            let (corners_of, indices) = (self.words(faces)?, self.words(corners)?);
            let (weld, ears) = (self.words(vertices)?, self.words(3 * triangles)?);
            let surface = Faces::new(&corners_of, &indices, weld, ears.as_chunks().0, vertices)?;
            self.surfaces.push(surface);
        }
        self.surfaces.get(index).cloned()
    }

    fn collider(&mut self, center: [f64; 3], shape: &ColliderShape) -> Option<ColliderKind> {
        Some(match *shape {
            ColliderShape::Plane { point, normal } => ColliderKind::Plane(PlaneAt { point, normal }),
            ColliderShape::Sphere { radius } => fixed(&Shape::Sphere { center, radius })?,
            ColliderShape::Capsule { a, b, radius } => fixed(&Shape::Capsule { a, b, radius })?,
            ColliderShape::Box { half_extents, rotate } => {
                fixed(&Shape::Box { center, half_extents, rotate })?
            }
            ColliderShape::Mesh { surface, is_animated, .. } => {
                let faces = self.surface(surface)?;
                if is_animated {
                    return Some(ColliderKind::Animated(faces, None));
                }
                let numbers = self.words(3 * faces.weld.len())?;
                let positions: Vec<[f32; 3]> =
                    numbers.as_chunks().0.iter().map(|point| point.map(f32::from_bits)).collect();
                let surface = faces.surface(&positions, &[]);
                ColliderKind::Fixed(Solid { surface, positions, volume: None })
            }
        })
    }
}

/// Returns a collider that is no mesh, without colors, where it stands.
fn fixed(shape: &Shape) -> Option<ColliderKind> {
    let (vertices, faces) = collider::faces(shape, DIVISIONS)?;
    let mesh = Mesh::new(vertices, &faces).ok()?;
    let place = collider::local(shape);
    let place = |vertex: &Point3<f64>| collider::finite(place.transform_point(vertex));
    let positions: Vec<[f32; 3]> = mesh.vertices().iter().map(place).collect();
    let tints = vec![Tint::Palette; mesh.triangles().len()];
    let surface = Arc::new(Surface::new(&positions, mesh.triangles(), mesh.weld(), tints));
    Some(ColliderKind::Fixed(Solid { surface, positions, volume: None }))
}

/// Returns a collider that is turned about a center and then displaced.
fn moved(solid: &Solid, center: Vector3<f64>, [translate, rotate]: [[f64; 3]; 2]) -> Solid {
    if translate == [0.0; 3] && rotate == [0.0; 3] {
        return solid.clone();
    }
    let (rotation, to) = (euler_degrees(rotate), center + Vector3::from(translate));
    let place = |point: &[f32; 3]| {
        let place = rotation * (Vector3::from(point.map(f64::from)) - center) + to;
        collider::finite(place.into())
    };
    Solid { positions: solid.positions.iter().map(place).collect(), ..solid.clone() }
}
