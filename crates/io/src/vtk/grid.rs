//! The text and the arrays of a grid.

use super::Cells;

/// The values of points or of cells.
#[derive(Clone, Copy)]
pub(crate) enum Data<'a> {
    Numbers(&'a [f32]),
    Vectors(&'a [[f32; 3]]),
}

/// A grid.
pub(crate) struct Grid<'a> {
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) cells: &'a Cells,
    /// Names and values of the points.
    pub(crate) of_points: &'a [(&'a str, Data<'a>)],
    /// Names and values of the cells.
    pub(crate) of_cells: &'a [(&'a str, Data<'a>)],
}

impl Data<'_> {
    fn numbers(&self) -> &[f32] {
        match self {
            Self::Numbers(numbers) => numbers,
            Self::Vectors(vectors) => vectors.as_flattened(),
        }
    }

    fn components(&self) -> usize {
        match self {
            Self::Numbers(_) => 1,
            Self::Vectors(_) => 3,
        }
    }
}

/// A file that is built.
#[derive(Default)]
struct Builder {
    text: String,
    arrays: Vec<u8>,
}

impl Builder {
    /// Adds an array to the file.
    fn array(&mut self, kind: &str, name: &str, components: usize, bytes: impl ExactSizeIterator<Item = u8>) {
        let offset = self.arrays.len();
        self.text += &format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{offset}\"/>\n"
        );
        self.arrays.extend((bytes.len() as u64).to_le_bytes());
        self.arrays.extend(bytes);
    }

    /// Adds arrays within an element.
    fn data(&mut self, element: &str, all: &[(&str, Data<'_>)]) {
        self.text += &format!("<{element}>\n");
        for (name, data) in all {
            let bytes: Vec<u8> = data.numbers().iter().flat_map(|number| number.to_le_bytes()).collect();
            self.array("Float32", name, data.components(), bytes.into_iter());
        }
        self.text += &format!("</{element}>\n");
    }
}

impl Grid<'_> {
    /// Returns the file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let Cells { corners, ends, types } = self.cells;
        let mut builder = Builder::default();
        builder.data("Points", &[("Points", Data::Vectors(self.points))]);
        builder.text += "<Cells>\n";
        builder.array("Int64", "connectivity", 1, corners.iter().copied());
        builder.array("Int64", "offsets", 1, ends.iter().copied());
        builder.array("UInt8", "types", 1, types.iter().copied());
        builder.text += "</Cells>\n";
        builder.data("PointData", self.of_points);
        builder.data("CellData", self.of_cells);
        let Builder { text, arrays } = builder;
        let start = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n{text}\
             </Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
            self.points.len(),
            types.len(),
        );
        [start.as_bytes(), &arrays, b"\n</AppendedData>\n</VTKFile>\n"].concat()
    }
}
