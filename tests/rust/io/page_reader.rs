//! Reads pages independently of the crate that writes them: from the description of the format in its comments.

use std::io::Read;
use std::rc::Rc;

use base64::prelude::{BASE64_STANDARD, Engine};
use flate2::read::GzDecoder;
use serde_json::Value;

/// A run of a page.
pub(crate) struct PageRun {
    /// The description of the run.
    pub(crate) header: Value,
    /// For each frame, the volumes of each body: at rest, before and after the correction.
    pub(crate) volumes: Vec<Vec<[f64; 3]>>,
    /// For each frame, the pose of each collider: displacement, then angles.
    pub(crate) poses: Vec<Vec<[f64; 6]>>,
    /// For each frame, the point sets.
    pub(crate) sets: Vec<Vec<PointSet>>,
    /// For each frame, the pieces of each body; `None` if it is whole.
    pub(crate) pieces: Vec<Vec<Option<Rc<PagePieces>>>>,
    /// Size of the compressed data, in bytes.
    pub(crate) compressed: usize,
}

/// The pieces of a body.
#[derive(Debug, PartialEq)]
pub(crate) struct PagePieces {
    /// The corners of each face.
    pub(crate) faces: Vec<Vec<u32>>,
    /// For each face that is no cap, the face of the whole body. Caps follow.
    pub(crate) sources: Vec<u32>,
    /// For each vertex, the first one at its position.
    pub(crate) weld: Vec<u32>,
    /// Numbers of vertices of the mesh and of the lattice.
    pub(crate) points: [usize; 2],
    /// Pairs of linked vertices of the lattice.
    pub(crate) links: Vec<[u32; 2]>,
}

/// A point set in a frame.
pub(crate) struct PointSet {
    pub(crate) positions: Vec<[f64; 3]>,
    /// Distance between the values of a coordinate.
    pub(crate) step: [f64; 3],
}

/// Returns the contents of all data elements of a page, by run. The last one is the program.
pub(crate) fn data(page: &str) -> Vec<Vec<u8>> {
    let mut runs: Vec<Vec<u8>> = Vec::new();
    for element in page.split("<script type=\"text/plain\" data-run=\"").skip(1) {
        let (run, text) = element.split_once("\">").unwrap();
        let text = text.split("</script>").next().unwrap();
        let run: usize = run.parse().unwrap();
        runs.resize_with(runs.len().max(run + 1), Vec::new);
        runs[run].extend(BASE64_STANDARD.decode(text).unwrap());
    }
    runs
}

/// Reads the runs of a page.
pub(crate) fn runs(page: &str) -> Vec<PageRun> {
    let mut data = data(page);
    data.pop();
    data.iter().map(|compressed| run(compressed)).collect()
}

fn run(compressed: &[u8]) -> PageRun {
    let mut bytes = Vec::new();
    GzDecoder::new(compressed).read_to_end(&mut bytes).unwrap();
    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let list = |key: &str| header[key].as_array().unwrap().clone();
    let (bodies, colliders) = (list("bodies"), list("colliders"));
    let vertices = |of: &Value| number(&header["surfaces"][number(&of["surface"])]["vertices"]);
    let mut sizes = Vec::new();
    for body in &bodies {
        sizes.extend([(vertices(body), 65535.0), (number(&body["lattice"]), 4095.0)]);
    }
    let animated = colliders.iter().filter(|collider| collider["is_animated"] == true);
    sizes.extend(animated.map(|collider| (vertices(collider), 65535.0)));
    let mut rest = &bytes[4 + length + number(&header["arrays"])..];
    let mut take = |count: usize| {
        let taken;
        (taken, rest) = rest.split_at(count);
        taken
    };
    let mut run = PageRun {
        header: header.clone(),
        volumes: Vec::new(),
        poses: Vec::new(),
        sets: Vec::new(),
        pieces: Vec::new(),
        compressed: compressed.len(),
    };
    for frame in 0..number(&header["frames"]) {
        let mut sizes = sizes.clone();
        let mut double = || f64::from_le_bytes(take(8).try_into().unwrap());
        run.volumes.push(bodies.iter().map(|_| [double(), double(), double()]).collect());
        run.poses.push(colliders.iter().map(|_| std::array::from_fn(|_| double())).collect());
        let bounds: Vec<[f64; 6]> = sizes
            .iter()
            .map(|_| std::array::from_fn(|_| f32::from_le_bytes(take(4).try_into().unwrap()).into()))
            .collect();
        let mut of_frame = vec![None; bodies.len()];
        let broken = if number(&header["version"]) == 1 { 0 } else { word(&mut take) };
        for _ in 0..broken {
            let [body, _, _, mesh, lattice, faces, caps, corners, triangles, links] =
                std::array::from_fn(|_| word(&mut take));
            let last = frame.checked_sub(1).and_then(|last: usize| run.pieces[last][body].clone());
            let pieces = if faces == 0 {
                last.expect("the frame before has the faces")
            } else {
                let mut list = |count: usize| words(take(4 * count));
                let sizes = list(faces);
                let sources = list(faces - caps);
                let mut corners = list(corners).into_iter();
                let faces =
                    sizes.iter().map(|&size| corners.by_ref().take(size as usize).collect()).collect();
                let weld = list(mesh);
                list(3 * triangles);
                let links = list(2 * links).as_chunks().0.to_vec();
                Rc::new(PagePieces { faces, sources, weld, points: [mesh, lattice], links })
            };
            assert_eq!(pieces.points, [mesh, lattice]);
            (sizes[2 * body].0, sizes[2 * body + 1].0) = (mesh, lattice);
            of_frame[body] = Some(pieces);
        }
        run.pieces.push(of_frame);
        let mut sets = Vec::new();
        for (index, (&(points, largest), bounds)) in sizes.iter().zip(bounds).enumerate() {
            let before =
                |ago: usize| run.sets.get(frame.wrapping_sub(ago)).map(|sets: &Vec<PointSet>| &sets[index]);
            sets.push(unpack(take(6 * points), bounds, largest, [before(1), before(2)]));
        }
        run.sets.push(sets);
    }
    assert!(rest.is_empty());
    run
}

fn word<'a>(take: &mut impl FnMut(usize) -> &'a [u8]) -> usize {
    u32::from_le_bytes(take(4).try_into().unwrap()) as usize
}

/// Unpacks words: differences, zigzag-encoded, the lowest bytes of all words first.
fn words(packed: &[u8]) -> Vec<u32> {
    let count = packed.len() / 4;
    let mut sum = 0_i64;
    let word = |index: usize| {
        let byte = |k: usize| i64::from(packed[k * count + index]) << (8 * k);
        let word: i64 = (0..4).map(byte).sum();
        sum += if word % 2 == 0 { word / 2 } else { -(word + 1) / 2 };
        sum.rem_euclid(1 << 32) as u32
    };
    (0..count).map(word).collect()
}

/// Unpacks a point set: differences from the prediction `2 x(t-1) - x(t-2)`, less that of the point before.
fn unpack(packed: &[u8], bounds: [f64; 6], largest: f64, before: [Option<&PointSet>; 2]) -> PointSet {
    let points = packed.len() / 6;
    let step: [f64; 3] = std::array::from_fn(|axis| (bounds[axis + 3] - bounds[axis]) / largest);
    let mut positions = vec![[0.0; 3]; points];
    for axis in 0..3 {
        let mut error = 0_i64;
        for point in 0..points {
            let at = axis * points + point;
            let word = i64::from(packed[at]) + 256 * i64::from(packed[3 * points + at]);
            error += if word % 2 == 0 { word / 2 } else { -(word + 1) / 2 };
            let at = |set: Option<&PointSet>| set?.positions.get(point).map(|position| position[axis]);
            let predicted = match before.map(at) {
                [Some(last), Some(second_last)] => Some(last + (last - second_last)),
                [Some(last), None] => Some(last),
                _ => None,
            };
            let predicted = predicted.filter(|_| step[axis] > 0.0).map_or(0.0, |coordinate| {
                ((coordinate - bounds[axis]) / step[axis] + 0.5).floor().clamp(0.0, largest)
            });
            let value = (predicted as i64 + error).rem_euclid(65536);
            positions[point][axis] = bounds[axis] + value as f64 * step[axis];
        }
    }
    PointSet { positions, step }
}
