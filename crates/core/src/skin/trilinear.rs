//! Points carried along by their cells, cell after cell: trilinear interpolation.

use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f32x4, f32x8};

use super::rings::TileLayout;
use crate::lattice::{Embedding, extrapolate, polynomial};
use crate::simd::level;
use crate::simd::xyzx::{Pair, Xyzx, spread};

/// How far outside its cell, along two axes at once, a point may lie for the polynomial of the cell to be used as it
/// is: the product of the two ways, whose share in the point is below the rounding of `f32`.
const OUTSIDE: f32 = 1e-8;

/// Points in the order in which they are carried: chunk by chunk, within a chunk cell by cell, an even number in each.
#[derive(Clone, Debug, Default)]
pub(super) struct EmbeddedPoints {
    /// The lattice vertices at the corners of each cell that is named below.
    corners: Vec<[u32; 8]>,
    ends: Vec<Ends>,
    runs: Vec<CellRun>,
    /// Where in their cell two points each lie: `(u, v, w, 0)`.
    places: Vec<Pair>,
    /// Points well outside their cells: rows in the chunk, and the cells.
    strays: Vec<(u32, u32)>,
}

/// Where what belongs to a chunk ends.
#[derive(Clone, Copy, Debug, Default)]
struct Ends {
    runs: usize,
    places: usize,
    strays: usize,
}

/// Points of one cell.
#[derive(Clone, Debug)]
struct CellRun {
    cell: u32,
    pairs: u32,
}

/// [`EmbeddedPoints`], and what is needed to add chunks to it.
pub(super) struct EmbeddedPointsBuilder {
    /// Of each point, the index of its cell among those that hold any, and its place there.
    points: Vec<(u32, [f32; 3])>,
    embedded: EmbeddedPoints,
}

impl EmbeddedPointsBuilder {
    /// No chunk yet. Point `k` of the chunks to come is `points[k]` of the embedding.
    pub(super) fn new(embedding: &Embedding, points: &[u32]) -> Self {
        let mut cell_of = vec![0; embedding.len()];
        let mut embedded = EmbeddedPoints::default();
        for (cell, held) in (0..).zip(embedding.by_cell()) {
            embedded.corners.push(*held.corners);
            held.points.iter().for_each(|&point| cell_of[point as usize] = cell);
        }
        let place = |&point: &u32| (cell_of[point as usize], embedding.local(point as usize));
        Self { points: points.iter().map(place).collect(), embedded }
    }

    /// The chunks that were added.
    pub(super) fn finish(self) -> EmbeddedPoints {
        self.embedded
    }

    /// Points sorted by cell, as indices in `points`.
    fn by_cell(&self, points: &[u32]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by_key(|&k| self.points[points[k] as usize].0);
        order
    }
}

impl TileLayout for EmbeddedPointsBuilder {
    fn rows(&self, points: &[u32]) -> Vec<usize> {
        let cell = |&k: &usize| self.points[points[k] as usize].0;
        let mut rows = vec![0; points.len()];
        let mut first = 0;
        for run in self.by_cell(points).chunk_by(|a, b| cell(a) == cell(b)) {
            (first..).zip(run).for_each(|(row, &k)| rows[k] = row);
            first += run.len().next_multiple_of(2);
        }
        rows
    }

    /// If the points of a cell are odd in number, the last one is there twice.
    fn add(&mut self, points: &[u32]) {
        let order = self.by_cell(points);
        let point = |&k: &usize| self.points[points[k] as usize];
        let EmbeddedPoints { ends, runs, places, strays, .. } = &mut self.embedded;
        let begin = places.len();
        for run in order.chunk_by(|a, b| point(a).0 == point(b).0) {
            let cell = point(&run[0]).0;
            let first = 2 * (places.len() - begin) as u32;
            let outside = (first..).zip(run).filter(|(_, k)| is_outside(point(k).1));
            strays.extend(outside.map(|(row, _)| (row, cell)));
            places.extend(run.chunks(2).map(|two| {
                let ([a, b, c], [d, e, f]) = (point(&two[0]).1, point(&two[two.len() - 1]).1);
                [a, b, c, 0.0, d, e, f, 0.0]
            }));
            runs.push(CellRun { cell, pairs: run.len().div_ceil(2) as u32 });
        }
        ends.push(Ends { runs: runs.len(), places: places.len(), strays: strays.len() });
    }
}

impl EmbeddedPoints {
    /// How many points are carried.
    pub(super) fn len(&self) -> usize {
        2 * self.places.len()
    }

    /// Memory that they take.
    pub(super) fn bytes(&self) -> usize {
        let Self { corners, ends, runs, places, strays } = self;
        let tables = size_of_val(&**corners) + size_of_val(&**ends) + size_of_val(&**runs);
        tables + size_of_val(&**places) + size_of_val(&**strays)
    }

    /// Where the points of a chunk are, given where the lattice vertices are.
    pub(super) fn interpolate(&self, chunk: usize, lattice: &[Xyzx], pairs: &mut [Pair]) {
        let begin = if chunk == 0 { Ends::default() } else { self.ends[chunk - 1] };
        let end = self.ends[chunk];
        let places = &self.places[begin.places..end.places];
        dispatch!(level(), simd => {
            let mut rest = (places, &mut *pairs);
            for run in &self.runs[begin.runs..end.runs] {
                let (places, later) = rest.0.split_at(run.pairs as usize);
                let (pairs, later_pairs) = rest.1.split_at_mut(run.pairs as usize);
                interpolate_cell(simd, &self.corners[run.cell as usize], lattice, places, pairs);
                rest = (later, later_pairs);
            }
        });
        for &(at, cell) in &self.strays[begin.strays..end.strays] {
            let (pair, half) = (at as usize / 2, at as usize % 2 * 4);
            let place = [0, 1, 2].map(|axis| places[pair][half + axis]);
            let stray = extrapolate(&self.corners[cell as usize], lattice, place);
            pairs[pair][half..half + 4].copy_from_slice(&stray);
        }
    }
}

/// Whether the polynomial of a cell and its linear continuation differ at a place.
fn is_outside(place: [f32; 3]) -> bool {
    let [u, v, w] = place.map(|x| (x - x.clamp(0.0, 1.0)).abs());
    // Not finite is outside as well.
    let fine = u * v <= OUTSIDE && v * w <= OUTSIDE && w * u <= OUTSIDE;
    !fine
}

/// The points of one cell: its trilinear map as a polynomial about corner 0, at each place.
#[inline(always)]
fn interpolate_cell<S: Simd>(
    simd: S,
    corners: &[u32; 8],
    lattice: &[Xyzx],
    places: &[Pair],
    pairs: &mut [Pair],
) {
    let mut terms = [f32x4::splat(simd, 0.0); 8];
    for k in 0..8 {
        terms[k] = f32x4::load_array_ref(simd, &lattice[corners[k] as usize]);
    }
    let terms = polynomial(terms);
    let mut both = [f32x8::splat(simd, 0.0); 8];
    for k in 0..8 {
        both[k] = simd.combine_f32x4(terms[k], terms[k]);
    }
    let [one, x, y, xy, z, xz, yz, xyz] = both;
    for (place, pair) in places.iter().zip(pairs) {
        let [u, v, w, _] = spread(simd, f32x8::load_array_ref(simd, place));
        // The offset from corner 0 first: small numbers, of which little is lost to rounding.
        let upper = u.mul_add(xyz, yz).mul_add(v, u.mul_add(xz, z));
        let offset = upper.mul_add(w, u.mul_add(xy, y).mul_add(v, u * x));
        (one + offset).store_array(pair);
    }
}
