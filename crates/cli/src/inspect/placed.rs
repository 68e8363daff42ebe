//! Places the surface of a body in the world as at frame 0: its bounds, and the vertices that its pins, handles and
//! zones select.

use serde::Serialize;
use supple::{Body, Map, Selection, Zone};
use supple_io::scene::{BodyData, HandleData, Scene};

/// Surface of a body in world space at frame 0.
pub(super) struct Placed<'a> {
    body: &'a Body,
    /// Positions of the mesh vertices.
    vertices: Vec<[f64; 3]>,
}

/// Facts about a pin or handle.
#[derive(Debug, Serialize)]
pub(super) struct SelectionFacts {
    /// Number of mesh vertices inside the shape; `None` for a list of lattice vertices.
    pub(super) mesh_vertices: Option<usize>,
    /// Number of lattice vertices that are held.
    pub(super) lattice_vertices: usize,
    /// Smallest coordinates of the selected mesh vertices, or of the listed lattice vertices.
    pub(super) low: [f64; 3],
    /// Largest coordinates of the selected mesh vertices, or of the listed lattice vertices.
    pub(super) high: [f64; 3],
    /// The animation that a handle follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) follow: Option<FollowFacts>,
}

/// Facts about the animation that a handle follows.
#[derive(Debug, Serialize)]
pub(super) struct FollowFacts {
    /// PC2 file.
    pub(super) file: String,
    pub(super) samples: usize,
    /// Time of the first sample in seconds.
    pub(super) first: f64,
    /// Time of the last sample in seconds.
    pub(super) last: f64,
    /// Greatest distance of a mesh vertex from its rest position when the handle becomes active.
    pub(super) distance_at_start: f64,
}

/// Facts about a zone.
#[derive(Debug, Serialize)]
pub(super) struct ZoneFacts {
    /// Factor of Young's modulus.
    pub(super) factor: f64,
    /// Number of lattice vertices inside the shape, or in the list.
    pub(super) lattice_vertices: usize,
    /// Number of lattice vertices around the shape, where the factor decreases to 1.
    pub(super) border_vertices: usize,
    /// Smallest coordinates of all these vertices.
    pub(super) low: [f64; 3],
    /// Largest coordinates of all these vertices.
    pub(super) high: [f64; 3],
}

impl<'a> Placed<'a> {
    /// Places the mesh of `body`, which is scaled, by `rotate` and `translate` of `data`.
    pub(super) fn new(data: &BodyData, body: &'a Body) -> Self {
        let to_world = data.placement.isometry();
        let vertices = body.mesh().map_or(&[][..], |mesh| mesh.vertices());
        Self { body, vertices: vertices.iter().map(|vertex| (to_world * vertex).into()).collect() }
    }

    /// Returns the body.
    pub(super) fn body(&self) -> &'a Body {
        self.body
    }

    /// Returns the smallest and the largest coordinates of the vertices that the faces use.
    pub(super) fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let faces = self.body.mesh().into_iter().flat_map(|mesh| mesh.faces());
        bounds(faces.flatten().map(|&vertex| self.vertices[vertex as usize]))
    }

    /// Returns the vertices that the faces use, and the centers of the faces. A vertex is repeated for each of
    /// its faces.
    pub(super) fn surface_points(&self) -> impl Iterator<Item = [f64; 3]> {
        let faces = self.body.mesh().into_iter().flat_map(|mesh| mesh.faces());
        faces.flat_map(|face| {
            let corners = face.iter().map(|&vertex| self.vertices[vertex as usize]);
            let sum = corners.clone().fold([0.0; 3], |[x, y, z], [a, b, c]| [x + a, y + b, z + c]);
            corners.chain([sum.map(|coordinate| coordinate / face.len() as f64)])
        })
    }

    /// Returns facts about the pin or handle with the given index, counted over the pins and then the
    /// handles.
    pub(super) fn selection(&self, index: usize, selection: &Selection) -> SelectionFacts {
        let held = self.body.constraint(index).map_or(&[][..], |constraint| constraint.vertices());
        let is_list = matches!(selection, Selection::Vertices(_));
        let vertices = |list: &[u32]| list.iter().map(|&vertex| self.vertices[vertex as usize]).collect();
        let selected: Vec<[f64; 3]> = match selection {
            Selection::Vertices(_) => {
                let positions = self.body.positions();
                held.iter().map(|&vertex| positions[vertex as usize].into()).collect()
            }
            Selection::MeshVertices(list) => vertices(list),
            Selection::Group(name) => {
                vertices(self.body.mesh().and_then(|mesh| mesh.group(name)).unwrap_or_default())
            }
            Selection::Map(Map::Weights(weights)) => self.weighted(weights),
            Selection::Map(Map::Name(name)) => {
                self.weighted(self.body.mesh().and_then(|mesh| mesh.map(name)).unwrap_or_default())
            }
            shape => {
                let inside = |point: &&[f64; 3]| shape.distance(&(**point).into()) <= 0.0;
                self.vertices.iter().filter(inside).copied().collect()
            }
        };
        let (low, high) = bounds(selected.iter().copied());
        let mesh_vertices = (!is_list).then_some(selected.len());
        SelectionFacts { mesh_vertices, lattice_vertices: held.len(), low, high, follow: None }
    }

    /// Returns the mesh vertices with a weight above 0.
    fn weighted(&self, weights: &[f32]) -> Vec<[f64; 3]> {
        self.vertices
            .iter()
            .zip(weights)
            .filter(|(_, weight)| **weight > 0.0)
            .map(|(point, _)| *point)
            .collect()
    }

    /// Returns facts about a handle: see [`selection`](Self::selection).
    pub(super) fn handle(
        &self,
        index: usize,
        scene: &Scene,
        (data, handle): (&BodyData, &HandleData),
    ) -> SelectionFacts {
        let facts = self.selection(index, &handle.selection);
        let followed = self.body.constraint(index).ok().and_then(|constraint| constraint.followed());
        let (Some(file), Some((animation, _)), Some(mesh)) = (&handle.follow, followed, self.body.mesh())
        else {
            return facts;
        };
        let mut positions = Vec::new();
        animation.positions_at_time(handle.window.start, &mut positions);
        let pairs = positions.iter().zip(mesh.vertices());
        let distances = pairs.map(|(position, rest)| (data.scale.apply(position) - rest).norm());
        let (first, last) = (animation.start(), animation.samples() - 1);
        let follow = FollowFacts {
            file: scene.resolve(file).display().to_string(),
            samples: animation.samples(),
            first,
            last: first + last as f64 * animation.interval(),
            distance_at_start: distances.fold(0.0, f64::max),
        };
        SelectionFacts { follow: Some(follow), ..facts }
    }

    /// Returns facts about a zone, whose shape or map selects lattice vertices.
    pub(super) fn zone(&self, zone: &Zone) -> ZoneFacts {
        let cell_size = self.body.lattice().cell_size();
        let positions = self.body.positions();
        let selected: Vec<(f64, [f64; 3])> = match &zone.selection {
            map if map.is_map() => {
                let weights = self.body.weights(map).ok().flatten().unwrap_or_default();
                let rest = |weight: f64| if weight > 1.0 - 1e-6 { 0.0 } else { (1.0 - weight) * cell_size };
                let points = positions.iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
                points.map(|(position, weight)| (rest(weight), (*position).into())).collect()
            }
            Selection::Vertices(_) | Selection::MeshVertices(_) | Selection::Group(_) => {
                let list = self.body.select(&zone.selection).unwrap_or_default();
                list.iter().map(|&vertex| (0.0, positions[vertex as usize].into())).collect()
            }
            shape => {
                let points = positions.iter().map(|position| (shape.distance(position), (*position).into()));
                points.filter(|(distance, _)| *distance < cell_size).collect()
            }
        };
        let inside = selected.iter().filter(|(distance, _)| *distance <= 0.0).count();
        let (low, high) = bounds(selected.iter().map(|&(_, position)| position));
        let border_vertices = selected.len() - inside;
        ZoneFacts { factor: zone.factor, lattice_vertices: inside, border_vertices, low, high }
    }
}

/// Returns the smallest and the largest coordinates of points; zeros without points.
fn bounds(points: impl Iterator<Item = [f64; 3]>) -> ([f64; 3], [f64; 3]) {
    let each = |a: [f64; 3], b: [f64; 3], choose: fn(f64, f64) -> f64| {
        [choose(a[0], b[0]), choose(a[1], b[1]), choose(a[2], b[2])]
    };
    let mut pairs = points.map(|point| (point, point));
    let first = pairs.next().unwrap_or_default();
    pairs.fold(first, |(low, high), (point, _)| (each(low, point, f64::min), each(high, point, f64::max)))
}
