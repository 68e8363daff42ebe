//! A closed, smooth surface of any resolution: a cube mapped to a ball and then deformed.

use std::fmt::Write;

use nalgebra::Vector3;
use supple::{Mesh, vertex_normals};

/// A standing figure without limbs, about 2.4 high and 1 wide.
#[derive(Clone, Debug)]
pub struct Statue {
    vertices: Vec<[f64; 3]>,
    faces: Vec<Vec<u32>>,
}

/// Axes of the sides of a cube: along a row, across rows, and outward. Each entry is used for two opposite
/// sides.
const SIDES: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];

impl Statue {
    /// Creates a statue of `6 n^2 + 2` vertices and `6 n^2` quads.
    pub fn of_quads(n: usize) -> Self {
        let grid = Grid::new(n);
        Self { vertices: grid.vertices.into_iter().map(shape).collect(), faces: grid.quads }
    }

    /// Creates a statue of `6 n^2 + 2` vertices and `12 n^2` triangles.
    pub fn of_triangles(n: usize) -> Self {
        let mut statue = Self::of_quads(n);
        let halves = |quad: Vec<u32>| [vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]];
        statue.faces = statue.faces.into_iter().flat_map(halves).collect();
        statue
    }

    /// Returns the mesh.
    ///
    /// # Panics
    ///
    /// If it has no faces.
    pub fn mesh(&self) -> Mesh {
        Mesh::new(self.vertices.clone(), &self.faces).expect("a closed surface")
    }

    /// Returns the mesh as an OBJ file in the usual form: positions, texture coordinates and normals with six
    /// decimals.
    ///
    /// # Panics
    ///
    /// If it has no faces.
    pub fn obj(&self) -> String {
        let mesh = self.mesh();
        let positions: Vec<_> = self.vertices.iter().map(|vertex| vertex.map(|x| x as f32)).collect();
        let mut normals = vec![[0.0; 3]; positions.len()];
        vertex_normals(mesh.triangles(), &positions, mesh.weld(), &mut normals);
        let mut text = String::from("o statue\n");
        let mut line = |word: &str, numbers: &[f64]| {
            text.push_str(word);
            for number in numbers {
                write!(text, " {number:.6}").expect("room for text");
            }
            text.push('\n');
        };
        self.vertices.iter().for_each(|vertex| line("v", vertex));
        self.vertices
            .iter()
            .for_each(|[x, y, z]| line("vt", &[0.5 + z.atan2(*x) / std::f64::consts::TAU, 0.4 * y]));
        normals.iter().for_each(|normal| line("vn", &normal.map(f64::from)));
        text.push_str("s 1\n");
        for face in &self.faces {
            text.push('f');
            for corner in face.iter().map(|corner| corner + 1) {
                write!(text, " {corner}/{corner}/{corner}").expect("room for text");
            }
            text.push('\n');
        }
        text
    }
}

/// Maps a point of the cube of edge 2 about the origin to the surface of the statue.
fn shape(cube: [f64; 3]) -> [f64; 3] {
    // Equal angles: otherwise the faces at the center of a side would be much larger than at its corners.
    let ball = Vector3::from(cube.map(|x| (x * std::f64::consts::FRAC_PI_4).tan())).normalize();
    let waist = 1.0 + 0.25 * (5.0 * ball.y).cos() + 0.06 * (9.0 * ball.x).sin() * (7.0 * ball.z).cos();
    [0.45 * waist * ball.x, 1.2 * ball.y + 1.2, 0.4 * waist * ball.z]
}

/// A cube of edge 2 about the origin with `n` x `n` quads per side. Sides share the vertices on their edges.
struct Grid {
    n: usize,
    vertices: Vec<[f64; 3]>,
    /// Vertex index of each grid point `(x, y, z)`, 0 to `n` along each axis; [`UNASSIGNED`] if it has none.
    numbers: Vec<u32>,
    quads: Vec<Vec<u32>>,
}

const UNASSIGNED: u32 = u32::MAX;

impl Grid {
    fn new(n: usize) -> Self {
        let points = (n + 1).pow(3);
        let mut grid = Self { n, vertices: Vec::new(), numbers: vec![UNASSIGNED; points], quads: Vec::new() };
        for axes in SIDES {
            for outer in [0, n] {
                for row in 0..n {
                    for column in 0..n {
                        grid.quad(axes, outer, [column, row]);
                    }
                }
            }
        }
        grid
    }

    /// Adds the quad at `column` and `row` of a side.
    fn quad(&mut self, [along, across, outward]: [usize; 3], outer: usize, [column, row]: [usize; 2]) {
        let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[right, up]| {
            let mut place = [0; 3];
            place[along] = column + right;
            place[across] = row + up;
            place[outward] = outer;
            self.vertex(place)
        });
        // Counter-clockwise seen from outside.
        if outer == 0 {
            quad.reverse();
        }
        self.quads.push(quad.to_vec());
    }

    /// Returns the vertex of a grid point, and creates it if necessary.
    fn vertex(&mut self, place: [usize; 3]) -> u32 {
        let [x, y, z] = place;
        let number = &mut self.numbers[(z * (self.n + 1) + y) * (self.n + 1) + x];
        if *number == UNASSIGNED {
            *number = self.vertices.len() as u32;
            self.vertices.push(place.map(|k| 2.0 * k as f64 / self.n as f64 - 1.0));
        }
        *number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statue_is_closed_and_its_obj_file_is_read_correctly() {
        for (statue, faces) in [(Statue::of_quads(10), 600), (Statue::of_triangles(10), 1200)] {
            let mesh = statue.mesh();
            assert_eq!((mesh.vertices().len(), mesh.face_count()), (602, faces));
            assert!(mesh.is_closed() && mesh.signed_volume() > 0.0);
            let read = supple_io::obj::Document::from_bytes("statue.obj", statue.obj().into_bytes()).unwrap();
            assert_eq!((read.vertex_count(), read.normal_count(), read.face_count()), (602, 602, faces));
            let ratio = read.mesh(None).unwrap().volume() / mesh.volume();
            assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
        }
    }
}
