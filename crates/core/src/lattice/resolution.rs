//! Finds the cell size for a requested number of lattice vertices.

use super::candidate::{Candidate, Request};
use super::{LatticeError, memory};
use crate::mesh::RelativeMeasure;

/// Maximum number of cell sizes that are tried.
const MAX_TRIALS: usize = 24;

/// Largest accepted |ln(vertices / requested)|. It is below ln 1.05, so the result is within 5 %.
const TOLERANCE: f64 = 0.045;

/// Smallest bracket of ln(cell size). In a smaller one the number of vertices jumps past the request.
const MIN_BRACKET: f64 = 1e-5;

/// A cell size that was tried.
#[derive(Clone, Copy)]
struct Trial {
    /// ln(cell size).
    size: f64,
    /// ln(vertices / requested).
    log_ratio: f64,
}

/// Tries cell sizes and returns the candidate whose number of lattice vertices is nearest to the request.
///
/// The number of vertices decreases with the cell size, mostly but not strictly, as a power between -1 (a
/// rod) and -3 (a solid). The first cell size is guessed from the volume and the area of the mesh. Later ones
/// are found by interpolation of ln(vertices) over ln(cell size) between the nearest trials on both sides.
pub(super) fn search(request: &Request<'_>, requested: usize) -> Result<Candidate, LatticeError> {
    if requested < 8 {
        return Err(LatticeError::TooFewVertices(requested));
    }
    let measure = RelativeMeasure::of(request.mesh);
    let mut size = guess(&measure, requested as f64);
    memory::check(memory::of_vertices(requested as u64), request.limit, size)?;
    let mut best: Option<(f64, Candidate)> = None;
    let mut last_error = None;
    let (mut fine, mut coarse): (Option<Trial>, Option<Trial>) = (None, None);
    for trials in 1..=MAX_TRIALS {
        let log_ratio = match request.candidate(size) {
            Ok(candidate) => {
                let log_ratio = (candidate.vertices as f64 / requested as f64).ln();
                if best.as_ref().is_none_or(|(least, _)| log_ratio.abs() < *least) {
                    best = Some((log_ratio.abs(), candidate));
                }
                log_ratio
            }
            // Too fine: treated as e times too many vertices.
            Err(error) => {
                last_error = Some(error);
                1.0
            }
        };
        // The first five trials aim at 1 %.
        let good_enough = if trials < 6 { 0.01 } else { TOLERANCE };
        if best.as_ref().is_some_and(|(least, _)| *least <= good_enough) {
            break;
        }
        let trial = Trial { size: size.ln(), log_ratio };
        if log_ratio > 0.0 {
            fine = Some(trial)
        } else {
            coarse = Some(trial)
        }
        size = match (fine, coarse) {
            (Some(fine), Some(coarse)) if coarse.size - fine.size < MIN_BRACKET => break,
            (Some(fine), Some(coarse)) => interpolate(&fine, &coarse, trials).exp(),
            // All trials are on one side of the request. The power 2.3 is between those of a sheet (2) and a
            // solid (3); with the extra 1 % the step is meant to overshoot, so that the request is bracketed.
            _ => size * (log_ratio / 2.3 + 0.01 * log_ratio.signum()).exp(),
        };
    }
    match (best, last_error) {
        (Some((_, candidate)), None) => Ok(candidate),
        (Some((least, candidate)), Some(_)) if least <= TOLERANCE => Ok(candidate),
        (_, Some(error)) => Err(error),
        (None, None) => Err(LatticeError::NoCells),
    }
}

/// Returns ln of the next cell size between two trials, by linear interpolation.
///
/// Every third trial bisects instead, because interpolation alone may stay near one end of the bracket.
fn interpolate(fine: &Trial, coarse: &Trial, trials: usize) -> f64 {
    let t = if trials.is_multiple_of(3) { 0.5 } else { fine.log_ratio / (fine.log_ratio - coarse.log_ratio) };
    fine.size + (coarse.size - fine.size) * t.clamp(0.02, 0.98)
}

/// Estimates the cell size for `requested` lattice vertices from the volume, area and extent of a body.
fn guess(measure: &RelativeMeasure, requested: f64) -> f64 {
    // With k = extent / h cells along the longest side: a surface of area A passes through about 1.5 A / h^2
    // cells, half of which lie in the volume, and their corners lie half a cell further out. The linear terms
    // are those of a line.
    let vertices = |k: f64| measure.volume * k.powi(3) + 1.5 * measure.area * k * k + 4.0 * k + 4.0;
    let (mut few, mut many) = (0.0, requested);
    for _ in 0..60 {
        let middle = 0.5 * (few + many);
        if vertices(middle) < requested { few = middle } else { many = middle }
    }
    measure.extent / many
}
