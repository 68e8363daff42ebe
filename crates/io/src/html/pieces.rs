//! The pieces of the broken bodies of a frame: their numbers of points, and their faces and links when these change.
//!
//! ```text
//! u32  number of broken bodies
//! for each of them
//!      u32  index of the body
//!      u64  hash of the faces and links: frames with the same hash have the same ones
//!      u32  number of vertices of the mesh, number of vertices of the lattice
//!      u32  number of faces, of caps, of corners, of triangles and of links; 0 if they are those of the frame before
//!      u8   the arrays of the faces and links, unless these numbers are 0
//! ```
//!
//! The first vertices of the mesh and of the lattice are those of the whole body, and the caps are the last faces. The
//! arrays are the number of corners of each face, for each face that is no cap the face of the whole body to which it
//! belongs, the corners of all faces, the first vertex at the position of each vertex, the triangles, which are
//! not listed if all are fans of their faces, and the pairs of lattice vertices that are linked. See `points::pack_words`.

use supple::mesh::Mesh;
use supple::{FaceSource, Lattice};

use super::points::{pack_words, unpack_words};

/// Number of words before the arrays of a body.
const WORDS: usize = 10;

/// The faces of the pieces of a body, and the links of its lattice.
#[derive(Debug)]
pub(crate) struct Topology {
    /// Numbers of faces, caps, corners, triangles and links.
    counts: [u32; 5],
    arrays: Vec<u8>,
}

impl Topology {
    /// `sources`: origin of each face.
    pub(crate) fn new(mesh: &Mesh, sources: &[FaceSource], lattice: &Lattice) -> Self {
        let links = links(lattice);
        let of_whole: Vec<u32> = sources
            .iter()
            .filter_map(|source| match *source {
                FaceSource::Whole(face) | FaceSource::Part(face) => Some(face),
                FaceSource::Cap { .. } => None,
            })
            .collect();
        let caps = &sources[of_whole.len()..];
        debug_assert!(
            caps.iter().all(|cap| matches!(cap, FaceSource::Cap { .. })),
            "caps are the last faces"
        );
        let corners: u32 = mesh.faces().map(|face| face.len() as u32).sum();
        let faces = mesh.face_count() as u32;
        let mut arrays = Vec::new();
        pack_words(mesh.faces().map(|face| face.len() as u32), &mut arrays);
        pack_words(of_whole.iter().copied(), &mut arrays);
        pack_words(mesh.faces().flatten().copied(), &mut arrays);
        pack_words(mesh.weld().iter().copied(), &mut arrays);
        let triangles = ears(mesh);
        pack_words(triangles.as_flattened().iter().copied(), &mut arrays);
        pack_words(links.as_flattened().iter().copied(), &mut arrays);
        let counts = [faces, caps.len() as u32, corners, triangles.len() as u32, links.len() as u32];
        Self { counts, arrays }
    }
}

/// Returns the triangles of a mesh, or none if the page finds them as fans of the faces.
pub(super) fn ears(mesh: &Mesh) -> &[[u32; 3]] {
    if mesh.is_fanned() { &[] } else { mesh.triangles() }
}

/// Returns the pairs of linked vertices of a lattice.
pub(super) fn links(lattice: &Lattice) -> Vec<[u32; 2]> {
    let of_vertex = |vertex: u32| {
        let [_, x, _, y, _, z] = lattice.neighbors(vertex);
        [x, y, z].into_iter().flatten().map(move |next| [vertex, next])
    };
    (0..lattice.len() as u32).flat_map(of_vertex).collect()
}

/// A broken body in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BrokenBody {
    /// Index of the body.
    pub(crate) body: usize,
    /// Hash of its faces and links.
    pub(crate) identity: u64,
    /// Numbers of vertices of its mesh and its lattice.
    pub(crate) points: [usize; 2],
}

impl BrokenBody {
    /// Appends the body to the pieces of a frame, with its topology if it is not that of the frame before.
    pub(super) fn write(&self, topology: Option<&Topology>, pieces: &mut Vec<u8>) {
        let [mesh, lattice] = self.points.map(|points| points as u32);
        pieces.extend((self.body as u32).to_le_bytes());
        pieces.extend(self.identity.to_le_bytes());
        let counts = topology.map_or([0; 5], |topology| topology.counts);
        pieces.extend([mesh, lattice].into_iter().chain(counts).flat_map(u32::to_le_bytes));
        pieces.extend(topology.iter().flat_map(|topology| &topology.arrays));
    }
}

/// The faces of the pieces of a body.
#[derive(Debug, PartialEq)]
pub(super) struct PieceArrays {
    /// Number of corners of each face.
    pub(super) corners: Vec<u32>,
    /// Face of the whole body, for each face before the caps.
    pub(super) of_whole: Vec<u32>,
    /// Corners of all faces.
    pub(super) indices: Vec<u32>,
    /// For each vertex, the first one at its place.
    pub(super) weld: Vec<u32>,
    /// The triangles, unless all are fans.
    pub(super) ears: Vec<[u32; 3]>,
}

/// A broken body, with the bytes of its arrays and the numbers of words of each.
type Entry<'a> = (BrokenBody, &'a [u8], [usize; 5]);

/// Reads the pieces at the start of `bytes`. Returns the broken bodies and the size of the pieces in bytes, or `None`
/// if they are incomplete or invalid.
pub(super) fn read(bytes: &[u8]) -> Option<(Vec<BrokenBody>, usize)> {
    let (entries, size) = entries(bytes)?;
    Some((entries.into_iter().map(|(body, ..)| body).collect(), size))
}

/// Reads the pieces at the start of `bytes`. Returns the broken bodies with their faces, unless these are those of the
/// frame before.
pub(super) fn read_arrays(bytes: &[u8]) -> Option<Vec<(BrokenBody, Option<PieceArrays>)>> {
    let arrays = |(body, mut bytes, counts): Entry<'_>| {
        let mut words = |count: usize| {
            let packed;
            (packed, bytes) = bytes.split_at(4 * count);
            unpack_words(packed)
        };
        let [corners, of_whole, indices, weld, ears] = counts.map(&mut words);
        let arrays = PieceArrays { corners, of_whole, indices, weld, ears: ears.as_chunks().0.to_vec() };
        (body, (counts[0] > 0).then_some(arrays))
    };
    Some(entries(bytes)?.0.into_iter().map(arrays).collect())
}

/// Returns the broken bodies at the start of `bytes`, and the size of the pieces in bytes.
fn entries(bytes: &[u8]) -> Option<(Vec<Entry<'_>>, usize)> {
    let (count, mut rest) = bytes.split_first_chunk::<4>()?;
    let mut bodies = Vec::new();
    for _ in 0..u32::from_le_bytes(*count) {
        let (words, after) = rest.split_at_checked(4 * WORDS)?;
        let word = |index: usize| u32::from_le_bytes(std::array::from_fn(|byte| words[4 * index + byte]));
        let [faces, caps, corners, triangles, links] = [5, 6, 7, 8, 9].map(|index| u64::from(word(index)));
        let counts = match faces {
            0 => [0; 5],
            _ => [faces, faces.checked_sub(caps)?, corners, u64::from(word(3)), 3 * triangles],
        };
        let links = if faces == 0 { 0 } else { 2 * links };
        let size = usize::try_from(4 * (counts.iter().sum::<u64>() + links)).ok()?;
        let arrays;
        (arrays, rest) = after.split_at_checked(size)?;
        let body = BrokenBody {
            body: word(0) as usize,
            identity: u64::from(word(1)) | u64::from(word(2)) << 32,
            points: [word(3) as usize, word(4) as usize],
        };
        bodies.push((body, arrays, counts.map(|count| count as usize)));
    }
    Some((bodies, bytes.len() - rest.len()))
}

#[cfg(test)]
mod tests {
    use supple::{Body, Origin};

    use super::*;

    /// The pieces of a frame with two broken bodies, the second one with the topology of the frame before.
    fn pieces() -> (Vec<u8>, [BrokenBody; 2]) {
        let vertices = vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        let mesh = Mesh::new(vertices, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
        let mut body = Body::builder(mesh).cell_size(1.0).build().unwrap();
        body.cut([1.0, 0.0, 0.0], [1.0, 0.1, 0.2]).unwrap();
        let (mesh, lattice, origin) = (body.mesh().unwrap(), body.lattice(), body.piece_mesh().unwrap());
        assert!(origin.origins().iter().any(|origin| matches!(origin, Origin::Cap { .. })));
        let topology = Topology::new(mesh, origin.face_sources(), lattice);
        let first = BrokenBody { body: 3, identity: 9, points: [mesh.vertices().len(), lattice.len()] };
        let second = BrokenBody { body: 5, identity: u64::MAX - 1, points: [7, 8] };
        let mut bytes = 2_u32.to_le_bytes().to_vec();
        first.write(Some(&topology), &mut bytes);
        second.write(None, &mut bytes);
        (bytes, [first, second])
    }

    #[test]
    fn pieces_read_back_with_their_size() {
        let (mut bytes, bodies) = pieces();
        let size = bytes.len();
        bytes.extend([1; 50]);
        assert_eq!(read(&bytes), Some((bodies.to_vec(), size)));
        assert_eq!(read(&[0; 9]), Some((Vec::new(), 4)));
        let arrays = read_arrays(&bytes).unwrap();
        let first = arrays[0].1.as_ref().unwrap();
        assert_eq!(first.indices.len(), first.corners.iter().sum::<u32>() as usize);
        assert!(first.of_whole.len() < first.corners.len() && arrays[1].1.is_none());
    }

    #[test]
    fn incomplete_and_changed_pieces_are_refused() {
        let (bytes, _) = pieces();
        for length in 0..bytes.len() {
            assert_eq!(read(&bytes[..length]), None, "{length} bytes");
        }
        // More caps than faces, and more elements than any file has.
        for word in [5, 6, 7, 8] {
            let mut changed = bytes.clone();
            changed[4 + 4 * word..8 + 4 * word].fill(0xff);
            assert_eq!(read(&changed), None, "word {word}");
        }
        let mut changed = bytes.clone();
        changed[..4].fill(0xff);
        assert_eq!(read(&changed), None);
    }
}
