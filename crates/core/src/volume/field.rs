//! The deformation field: which way, and how far, each lattice vertex moves per unit of `lambda`.

use nalgebra::Vector3;

use super::adjacency::Adjacency;
use super::normals::{boundary_normals, unit};

/// How the deformation field is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FieldKind {
    /// As in Takamatsu & Kanai (2009): unit normals at boundary vertices, from the neighbours that exist; inwards,
    /// layer by layer, the mean direction of the layer before, at a length that falls from 1 to 0 at the centre.
    #[default]
    Paper,
}

/// The field at rest, in the model's frame; the rotations of the matching turn it with the body.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// One vector a vertex, in vertex order, of length 0 to 1.
    pub(super) directions: Vec<[f32; 3]>,
    /// Of each component: the greatest depth below the boundary in cells, half a cell where all is boundary.
    pub(super) thickness: Vec<f64>,
}

impl Field {
    pub(super) fn new(kind: FieldKind, adjacency: &Adjacency, indices: &[[i32; 3]], octants: &[u8]) -> Self {
        match kind {
            FieldKind::Paper => Self::paper(adjacency, indices, octants),
        }
    }

    fn paper(adjacency: &Adjacency, indices: &[[i32; 3]], octants: &[u8]) -> Self {
        let mut directions = boundary_normals(adjacency, indices, octants);
        let depth = adjacency.distances((0..adjacency.len()).filter(|&i| octants[i] != u8::MAX));
        let mut greatest = vec![0_u32; adjacency.components()];
        for (i, &depth) in depth.iter().enumerate() {
            let greatest = &mut greatest[adjacency.component(i)];
            *greatest = depth.max(*greatest);
        }
        let mut inwards: Vec<usize> = (0..adjacency.len()).filter(|&i| depth[i] > 0).collect();
        inwards.sort_by_key(|&i| depth[i]);
        for i in inwards {
            let before = adjacency.linked(i).filter(|&j| depth[j] < depth[i]);
            // Opposite walls can cancel: such a vertex stays where it is.
            directions[i] = unit(before.map(|j| directions[j]).sum()).unwrap_or_else(Vector3::zeros);
        }
        let scaled = |i: usize| {
            let greatest = f64::from(greatest[adjacency.component(i)].max(1));
            let length = 1.0 - f64::from(depth[i]) / greatest;
            <[f32; 3]>::from((directions[i] * length).map(|x| x as f32))
        };
        Self {
            directions: (0..adjacency.len()).map(scaled).collect(),
            thickness: greatest.into_iter().map(|depth| f64::from(depth).max(0.5)).collect(),
        }
    }
}

/// `v` turned by the unit quaternion `q = (x, y, z, w)`.
#[inline]
pub(super) fn turned(q: &[f32; 4], v: &[f32; 3]) -> [f32; 3] {
    let [x, y, z, w] = *q;
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    // v + 2 u x (u x v + w v), u the vector part.
    let inner = cross([x, y, z], *v);
    let inner = std::array::from_fn(|k| inner[k] + w * v[k]);
    let outer = cross([x, y, z], inner);
    std::array::from_fn(|k| v[k] + 2.0 * outer[k])
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::lattice::Lattice;
    use crate::volume::measure::{adjacency, octants};

    fn field(cells: &[[i32; 3]]) -> (Lattice, Field) {
        let lattice = Lattice::from_cells(cells, 1.0, Point3::origin(), false).unwrap();
        let field = Field::new(FieldKind::Paper, &adjacency(&lattice), lattice.indices(), &octants(&lattice));
        (lattice, field)
    }

    fn block(n: i32) -> Vec<[i32; 3]> {
        (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n]).collect()
    }

    fn length(v: [f32; 3]) -> f32 {
        v.iter().map(|x| x * x).sum::<f32>().sqrt()
    }

    #[test]
    fn from_one_at_the_boundary_to_nothing_at_the_centre() {
        let (lattice, field) = field(&block(6));
        for (index, &v) in lattice.indices().iter().zip(&field.directions) {
            let depth = index.iter().map(|&i| i.min(6 - i)).min().unwrap();
            assert!((length(v) - (1.0 - depth as f32 / 3.0)).abs() < 1e-6, "{index:?}: {v:?}");
        }
        assert_eq!(field.thickness, [3.0]);
        let at = |index| field.directions[lattice.vertex_at(index).unwrap() as usize];
        assert_eq!(at([3, 3, 0]), [0.0, 0.0, -1.0]);
        assert_eq!(at([6, 3, 2]), [1.0, 0.0, 0.0]);
        let edge = 0.5_f32.sqrt();
        assert_eq!(at([0, 6, 3]), [-edge, edge, 0.0]);
    }

    #[test]
    fn concave_edges_look_into_the_gap() {
        let mut cells = block(2);
        cells.retain(|&[x, y, _]| [x, y] != [1, 1]);
        let (lattice, field) = field(&cells);
        let v = field.directions[lattice.vertex_at([1, 1, 1]).unwrap() as usize];
        assert_eq!(v, [0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0]);
    }

    #[test]
    fn no_boundary_vertex_is_without_a_direction() {
        // Cells that touch along edges and in corners, where the missing directions cancel.
        let checkered: Vec<[i32; 3]> =
            block(4).into_iter().filter(|c| c.iter().sum::<i32>() % 2 == 0).collect();
        for cells in [checkered, vec![[0, 0, 0], [1, 1, 1]], vec![[0, 0, 0], [1, 1, 0]]] {
            let (_, field) = field(&cells);
            assert!(field.directions.iter().all(|&v| (length(v) - 1.0).abs() < 1e-6), "{cells:?}");
            assert_eq!(field.thickness, [0.5]);
        }
    }

    #[test]
    fn turning() {
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.3, -1.2, 2.5);
        let v = nalgebra::Vector3::new(0.2, -0.7, 0.4);
        let expected: [f64; 3] = (turn * v).into();
        let q = turn.coords.map(|x| x as f32).into();
        let v = turned(&q, &[0.2, -0.7, 0.4]);
        assert!(v.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6), "{v:?} {expected:?}");
    }
}
