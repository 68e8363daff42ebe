//! The cells of a grid.

use supple::Lattice;
use supple::mesh::Mesh;

/// A cell with three, four, or any number of corners, and one with eight corners.
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;
const QUAD: u8 = 9;
const HEXAHEDRON: u8 = 12;

/// The corners of a hexahedron of VTK as those of a cell of a lattice: around the face below, then around that above.
const AROUND: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// Cells: the bytes of their corners, of the end of each among all corners, and their types.
#[derive(Debug)]
pub(crate) struct Cells {
    pub(super) corners: Vec<u8>,
    pub(super) ends: Vec<u8>,
    pub(super) types: Vec<u8>,
}

impl Cells {
    /// The faces of a mesh. Faces with fewer than three corners are left out. Concave faces are their triangles, because
    /// other programs take polygons for convex ones.
    pub(crate) fn of_mesh(mesh: &Mesh) -> Self {
        if mesh.is_fanned() {
            Self::new(mesh.faces().filter(|face| face.len() > 2), |corners| match corners {
                3 => TRIANGLE,
                4 => QUAD,
                _ => POLYGON,
            })
        } else {
            Self::new(mesh.triangles().iter().map(<[u32; 3]>::as_slice), |_| TRIANGLE)
        }
    }

    /// The cells of a lattice.
    pub(crate) fn of_lattice(lattice: &Lattice) -> Self {
        let cells: Vec<[u32; 8]> = (0..lattice.cells().len() as u32)
            .map(|cell| {
                let corners = lattice.cell_corners(cell);
                AROUND.map(|corner| corners[corner])
            })
            .collect();
        Self::new(cells.iter().map(<[u32; 8]>::as_slice), |_| HEXAHEDRON)
    }

    fn new<'a>(cells: impl Iterator<Item = &'a [u32]>, kind: impl Fn(usize) -> u8) -> Self {
        let mut made = Self { corners: Vec::new(), ends: Vec::new(), types: Vec::new() };
        let mut end = 0_i64;
        for cell in cells {
            made.corners.extend(cell.iter().flat_map(|&corner| i64::from(corner).to_le_bytes()));
            end += cell.len() as i64;
            made.ends.extend(end.to_le_bytes());
            made.types.push(kind(cell.len()));
        }
        made
    }
}
