//! What a picture shows: the surfaces of bodies and colliders, and the planes, in the coordinates of the files.

use std::collections::HashMap;
use std::io;
use std::sync::Arc;

use nalgebra::Vector3;

/// Cosine of the largest angle between faces that are shaded smoothly: 40 degrees.
const SMOOTH: f32 = 0.766;

/// A color: red, green and blue, linear, in [0, 1].
pub(crate) type Color = [f32; 3];

/// Colors of the triangles of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Tint {
    /// That of the body in the palette.
    Palette,
    /// The inside of a broken body.
    Inside,
    /// That of a material.
    Material(Color),
}

/// Triangles whose vertices move.
#[derive(Debug)]
pub(crate) struct Surface {
    /// Corners of the triangles, as indices of `vertices`.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The mesh vertex of each shaded vertex. A mesh vertex on a crease has several, each with its own normal.
    pub(crate) vertices: Vec<u32>,
    /// Color of each triangle.
    pub(crate) tints: Vec<Tint>,
}

/// A surface in a frame.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pub(crate) surface: Arc<Surface>,
    /// Positions of the mesh vertices.
    pub(crate) positions: Vec<[f32; 3]>,
    /// Volume relative to that at rest, if it is known.
    pub(crate) volume: Option<f64>,
}

/// A plane in a frame: a point of it, and its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaneAt {
    pub(crate) point: [f64; 3],
    pub(crate) normal: [f64; 3],
}

/// A frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Moment {
    pub(crate) bodies: Vec<Solid>,
    pub(crate) colliders: Vec<Solid>,
    pub(crate) planes: Vec<PlaneAt>,
}

/// A motion that is shown, frame by frame. All positions are finite.
pub(crate) trait Footage {
    /// Returns the number of frames.
    fn frames(&self) -> usize;

    /// Returns the rate of the frames, in 1/s.
    fn fps(&self) -> f64;

    /// Returns the direction that points up, a unit vector.
    fn up(&self) -> [f64; 3];

    /// Returns a frame. Frames are read in their order, from the first one on, any number of times.
    fn read(&mut self, frame: usize) -> io::Result<Moment>;
}

impl Surface {
    /// Divides the vertices at creases.
    ///
    /// * `weld`: for each mesh vertex, the first one at the same place.
    /// * `tints`: one per triangle.
    pub(crate) fn new(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        weld: &[u32],
        tints: Vec<Tint>,
    ) -> Self {
        let at = |vertex: u32| Vector3::from(positions[vertex as usize]);
        let normal = |&[a, b, c]: &[u32; 3]| {
            let normal = (at(b) - at(a)).cross(&(at(c) - at(a)));
            normal.try_normalize(f32::MIN_POSITIVE).unwrap_or_default()
        };
        let normals: Vec<Vector3<f32>> = triangles.iter().map(normal).collect();
        let mut classes = Classes::new(3 * triangles.len());
        let mut edges: HashMap<[u32; 2], (usize, usize)> = HashMap::with_capacity(2 * triangles.len());
        for (triangle, corners) in triangles.iter().enumerate() {
            for corner in 0..3 {
                let next = (corner + 1) % 3;
                let [a, b] = [corner, next].map(|corner| weld[corners[corner] as usize]);
                let Some(&(other, first)) = edges.get(&[a.min(b), a.max(b)]) else {
                    edges.insert([a.min(b), a.max(b)], (triangle, corner));
                    continue;
                };
                if normals[triangle].dot(&normals[other]) < SMOOTH {
                    continue;
                }
                let second = (first + 1) % 3;
                let is_same = weld[triangles[other][first] as usize] == a;
                let [of_a, of_b] = if is_same { [first, second] } else { [second, first] };
                classes.join(3 * triangle + corner, 3 * other + of_a);
                classes.join(3 * triangle + next, 3 * other + of_b);
            }
        }
        let mut index = vec![u32::MAX; 3 * triangles.len()];
        let mut vertices = Vec::new();
        let mut shaded = |corner: usize, vertex: u32| {
            let root = classes.root(corner);
            if index[root] == u32::MAX {
                index[root] = vertices.len() as u32;
                vertices.push(vertex);
            }
            index[root]
        };
        let triangles = triangles.iter().enumerate().map(|(triangle, corners)| {
            [0, 1, 2].map(|corner| shaded(3 * triangle + corner, corners[corner]))
        });
        let triangles = triangles.collect();
        Self { triangles, vertices, tints }
    }
}

/// Classes of corners: union-find.
struct Classes(Vec<u32>);

impl Classes {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut item: usize) -> usize {
        while self.0[item] as usize != item {
            self.0[item] = self.0[self.0[item] as usize];
            item = self.0[item] as usize;
        }
        item
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        // The first corner is the root.
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_divided_at_creases_and_not_on_smooth_surfaces() {
        // Two triangles of a flat square, and one that stands on their common side.
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.5, 1.0]];
        let weld = [0, 1, 2, 3, 4];
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4]];
        let surface = Surface::new(&positions, &triangles, &weld, vec![Tint::Palette; 3]);
        assert_eq!(surface.vertices, [0, 1, 2, 3, 0, 3, 4]);
        assert_eq!(surface.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
        // A seam: the second triangle has its own copies of the vertices.
        let positions =
            [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let surface =
            Surface::new(&positions, &[[0, 1, 2], [3, 4, 5]], &[0, 1, 2, 0, 2, 5], vec![Tint::Palette; 2]);
        assert_eq!(surface.triangles, [[0, 1, 2], [0, 2, 3]]);
    }
}
