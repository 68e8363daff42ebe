//! The cell size for a wished number of lattice vertices.

use super::candidate::{Candidate, Request};
use super::{LatticeError, memory};
use crate::mesh::RelativeMeasure;

/// Lattices that are tried before the best of them is taken.
const TRIES: usize = 24;

/// How far from the wish, as a logarithm, a number of vertices may be.
const MET: f64 = 0.045;

/// A bracket of cell sizes, as a logarithm, in which the number of vertices jumps.
const JUMP: f64 = 1e-5;

/// A cell size and how far its number of vertices is from the wish, as logarithms.
#[derive(Clone, Copy)]
struct Tried {
    size: f64,
    miss: f64,
}

/// The cells whose number of lattice vertices is nearest to the wish, among those tried.
///
/// The number falls with the cell size, on the whole but not strictly, by a power between 1 (a rod) and 3 (a solid). The first guess
/// is from the volume and the area; each next one is on the line through the two nearest tries on either side, in logarithms.
pub(super) fn search(request: &Request<'_>, wished: usize) -> Result<Candidate, LatticeError> {
    if wished < 8 {
        return Err(LatticeError::TooFewVertices(wished));
    }
    let measure = RelativeMeasure::of(request.mesh);
    let mut size = guess(&measure, wished as f64);
    memory::check(memory::of_vertices(wished as u64), request.limit, size)?;
    let mut best: Option<(f64, Candidate)> = None;
    let mut refused = None;
    let (mut fine, mut coarse): (Option<Tried>, Option<Tried>) = (None, None);
    for tries in 1..=TRIES {
        let miss = match request.candidate(size) {
            Ok(candidate) => {
                let miss = (candidate.vertices as f64 / wished as f64).ln();
                if best.as_ref().is_none_or(|(least, _)| miss.abs() < *least) {
                    best = Some((miss.abs(), candidate));
                }
                miss
            }
            Err(error) => {
                refused = Some(error);
                1.0
            }
        };
        let good_enough = if tries < 6 { 0.01 } else { MET };
        if best.as_ref().is_some_and(|(least, _)| *least <= good_enough) {
            break;
        }
        let tried = Tried { size: size.ln(), miss };
        if miss > 0.0 {
            fine = Some(tried)
        } else {
            coarse = Some(tried)
        }
        size = match (fine, coarse) {
            (Some(fine), Some(coarse)) if coarse.size - fine.size < JUMP => break,
            (Some(fine), Some(coarse)) => between(&fine, &coarse, tries).exp(),
            // Somewhat further than a shape between a sheet and a solid asks for, to have the wish between two tries.
            _ => size * (miss / 2.3 + 0.01 * miss.signum()).exp(),
        };
    }
    match (best, refused) {
        (Some((_, candidate)), None) => Ok(candidate),
        (Some((miss, candidate)), Some(_)) if miss <= MET => Ok(candidate),
        (_, Some(error)) => Err(error),
        (None, None) => Err(LatticeError::NoCells),
    }
}

/// The logarithm of the next cell size between two tries: on the line through them, but in every third turn, where that may get
/// stuck at one end, in the middle.
fn between(fine: &Tried, coarse: &Tried, tries: usize) -> f64 {
    let along = if tries.is_multiple_of(3) { 0.5 } else { fine.miss / (fine.miss - coarse.miss) };
    fine.size + (coarse.size - fine.size) * along.clamp(0.02, 0.98)
}

/// The cell size at which a body of the given volume and area, or a bare line, has about `wished` lattice vertices.
fn guess(measure: &RelativeMeasure, wished: f64) -> f64 {
    // A surface of area A passes through about 1.5 A / h^2 cells, half of which lie within the volume; their corners reach half a
    // cell further out.
    let vertices = |k: f64| measure.volume * k.powi(3) + 1.5 * measure.area * k * k + 4.0 * k + 4.0;
    let (mut few, mut many) = (0.0, wished);
    for _ in 0..60 {
        let middle = 0.5 * (few + many);
        if vertices(middle) < wished { few = middle } else { many = middle }
    }
    measure.extent / many
}
