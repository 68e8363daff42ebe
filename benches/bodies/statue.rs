//! Generates a closed, smooth surface of any resolution: a cube is mapped to a ball, and the ball is
//! deformed.

use std::fmt::Write;

use nalgebra::Vector3;
use supple::{Mesh, vertex_normals};

/// A standing figure without limbs, 2.4 units high and approximately 1 unit wide.
#[derive(Clone, Debug)]
pub struct Statue {
    vertices: Vec<[f64; 3]>,
    faces: Vec<Vec<u32>>,
}

/// Three axes for each pair of opposite sides of a cube: the axis along the rows of quads, the axis across
/// the rows, and the axis of the outward normals.
const SIDES: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];

impl Statue {
    /// Creates a statue of quads from a cube with `n` x `n` quads per side. The statue has `6 n^2 + 2`
    /// vertices and `6 n^2` quads.
    pub fn of_quads(n: usize) -> Self {
        let grid = Grid::new(n);
        Self { vertices: grid.vertices.into_iter().map(shape).collect(), faces: grid.quads }
    }

    /// Creates the statue [`Statue::of_quads`] with each quad divided into two triangles. The statue has
    /// `6 n^2 + 2` vertices and `12 n^2` triangles.
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
    /// Panics if the statue has no faces.
    pub fn mesh(&self) -> Mesh {
        Mesh::new(self.vertices.clone(), &self.faces).expect("the mesh is valid")
    }

    /// Returns the text of an OBJ file with positions, texture coordinates and normals, each with six
    /// decimals.
    ///
    /// # Panics
    ///
    /// Panics if the statue has no faces.
    pub fn obj(&self) -> String {
        let mesh = self.mesh();
        let positions: Vec<_> = self.vertices.iter().map(|vertex| vertex.map(|x| x as f32)).collect();
        let mut normals = vec![[0.0; 3]; positions.len()];
        vertex_normals(mesh.triangles(), &positions, mesh.weld(), &mut normals);
        let mut text = String::from("o statue\n");
        let mut line = |keyword: &str, values: &[f64]| {
            text.push_str(keyword);
            for value in values {
                write!(text, " {value:.6}").expect("writing to a string succeeds");
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
                write!(text, " {corner}/{corner}/{corner}").expect("writing to a string succeeds");
            }
            text.push('\n');
        }
        text
    }
}

/// Maps a point on the surface of the cube of edge 2 centered at the origin to the surface of the statue.
fn shape(cube: [f64; 3]) -> [f64; 3] {
    // `tan` places the grid lines of a side at equal angles, seen from the origin. Without `tan`, the quads
    // at the center of a side would be much larger than the quads at its corners.
    let ball = Vector3::from(cube.map(|x| (x * std::f64::consts::FRAC_PI_4).tan())).normalize();
    let radius_factor =
        1.0 + 0.25 * (5.0 * ball.y).cos() + 0.06 * (9.0 * ball.x).sin() * (7.0 * ball.z).cos();
    [0.45 * radius_factor * ball.x, 1.2 * ball.y + 1.2, 0.4 * radius_factor * ball.z]
}

/// The surface of the cube of edge 2 centered at the origin, with `n` x `n` quads per side. Sides share the
/// vertices on their common edges.
struct Grid {
    n: usize,
    vertices: Vec<[f64; 3]>,
    /// Vertex index of each grid point `(x, y, z)`, whose coordinates are 0 to `n`; [`UNASSIGNED`] for grid
    /// points without a vertex.
    vertex_indices: Vec<u32>,
    quads: Vec<Vec<u32>>,
}

/// Vertex index of grid points without a vertex.
const UNASSIGNED: u32 = u32::MAX;

impl Grid {
    fn new(n: usize) -> Self {
        let points = (n + 1).pow(3);
        let vertex_indices = vec![UNASSIGNED; points];
        let mut grid = Self { n, vertices: Vec::new(), vertex_indices, quads: Vec::new() };
        for axes in SIDES {
            for outer in [0, n] {
                for row in 0..n {
                    for column in 0..n {
                        grid.add_quad(axes, outer, [column, row]);
                    }
                }
            }
        }
        grid
    }

    /// Adds the quad at `column` and `row` of a side. The grid points of the side have the coordinate `outer`
    /// (0 or `n`) along the axis `outward`.
    fn add_quad(&mut self, [along, across, outward]: [usize; 3], outer: usize, [column, row]: [usize; 2]) {
        let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[right, up]| {
            let mut point = [0; 3];
            point[along] = column + right;
            point[across] = row + up;
            point[outward] = outer;
            self.vertex(point)
        });
        // The corners must be counter-clockwise, seen from outside.
        if outer == 0 {
            quad.reverse();
        }
        self.quads.push(quad.to_vec());
    }

    /// Returns the vertex index of a grid point. Creates the vertex if it does not exist.
    fn vertex(&mut self, point: [usize; 3]) -> u32 {
        let [x, y, z] = point;
        let index = &mut self.vertex_indices[(z * (self.n + 1) + y) * (self.n + 1) + x];
        if *index == UNASSIGNED {
            *index = self.vertices.len() as u32;
            self.vertices.push(point.map(|k| 2.0 * k as f64 / self.n as f64 - 1.0));
        }
        *index
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
