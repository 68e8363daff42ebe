//! Finds the cell size for a requested number of lattice vertices.

use super::candidate::{Candidate, Request};
use super::{LatticeError, memory};
use crate::mesh::RelativeMeasure;

/// Maximum number of cell sizes that are tried.
const MAX_TRIALS: usize = 24;

/// Largest accepted |ln(vertices / requested)|. It is less than ln 1.05, so the result is within 5 %.
const TOLERANCE: f64 = 0.045;

/// Smallest interval of ln(cell size) in which the search continues. In a smaller interval the number of
/// vertices jumps from one side of the request to the other.
const MIN_BRACKET: f64 = 1e-5;

/// A trial ends without a result when its memory is this many times the memory for the requested vertices, unless it
/// is less than [`MIN_TRIAL_BYTES`]. The surface of a mesh with degenerate faces can have far more cells at the
/// estimated cell size.
const MAX_TRIAL_RATIO: u64 = 8;

/// Memory in bytes up to which each trial gives a number of vertices: a lattice with four million vertices.
const MIN_TRIAL_BYTES: u64 = 1_000_000_000;

/// Largest ln(vertices / requested) that is assumed for a trial without a result.
const MAX_ASSUMED_RATIO: f64 = 5.0;

/// A cell size that was tried.
#[derive(Clone, Copy)]
struct Trial {
    /// ln(cell size).
    log_size: f64,
    /// ln(vertices / requested).
    log_ratio: f64,
}

/// Tries cell sizes and returns the candidate whose number of lattice vertices is nearest to the request.
///
/// The number of vertices decreases with the cell size, mostly but not strictly. It is nearly proportional to
/// the cell size to a power between -1 (for a rod) and -3 (for a solid). The first cell size is estimated
/// from the volume and the area of the mesh. Later cell sizes are found by linear interpolation of
/// ln(vertices) over ln(cell size), between the last trial with too many vertices and the last trial with too
/// few vertices.
pub(super) fn search(request: &Request<'_>, requested: usize) -> Result<Candidate, LatticeError> {
    if requested < 8 {
        return Err(LatticeError::TooFewVertices(requested));
    }
    let measure = RelativeMeasure::new(request.mesh);
    let mut size = estimate_size(&measure, requested as f64);
    let needed_bytes = memory::needed_bytes(requested as u64);
    memory::check(needed_bytes, request.limit, size)?;
    let trial_limit = needed_bytes.saturating_mul(MAX_TRIAL_RATIO).max(MIN_TRIAL_BYTES).min(request.limit);
    let trial_request = Request { limit: trial_limit, ..*request };
    let mut best: Option<(f64, Candidate)> = None;
    let mut last_error = None;
    let (mut too_many, mut too_few): (Option<Trial>, Option<Trial>) = (None, None);
    for trials in 1..=MAX_TRIALS {
        let log_ratio = match trial_request.candidate(size) {
            Ok(candidate) => {
                let log_ratio = libm::log(candidate.vertices as f64 / requested as f64);
                if best.as_ref().is_none_or(|(best, _)| log_ratio.abs() < *best) {
                    best = Some((log_ratio.abs(), candidate));
                }
                log_ratio
            }
            // The cells are too small. The lower bound of the memory stands for the number of vertices, which is
            // treated as at least e times too many.
            Err(error) => {
                let LatticeError::TooMuchMemory { needed, limit, .. } = error else { return Err(error) };
                if limit == request.limit {
                    last_error = Some(error);
                }
                libm::log(needed as f64 / needed_bytes as f64).clamp(1.0, MAX_ASSUMED_RATIO)
            }
        };
        // The first five trials must be within 1 %.
        let accepted = if trials < 6 { 0.01 } else { TOLERANCE };
        if best.as_ref().is_some_and(|(best, _)| *best <= accepted) {
            break;
        }
        let trial = Trial { log_size: libm::log(size), log_ratio };
        if log_ratio > 0.0 {
            too_many = Some(trial)
        } else {
            too_few = Some(trial)
        }
        size = match (too_many, too_few) {
            (Some(many), Some(few)) if few.log_size - many.log_size < MIN_BRACKET => break,
            (Some(many), Some(few)) => libm::exp(interpolate(&many, &few, trials)),
            // All trials are on one side of the request. Assumes that the number of vertices is proportional
            // to the cell size to the power -2.3, between -2 (for a shell) and -3 (for a solid). The extra
            // 1 % makes it likely that the next trial is on the other side.
            _ => size * libm::exp(log_ratio / 2.3 + 0.01 * log_ratio.signum()),
        };
    }
    match (best, last_error) {
        (Some((_, candidate)), None) => Ok(fill_box(&trial_request, candidate)),
        (Some((best, candidate)), Some(_)) if best <= TOLERANCE => Ok(fill_box(&trial_request, candidate)),
        (_, Some(error)) => Err(error),
        (None, None) => Err(LatticeError::NoCells),
    }
}

/// Returns the cells of a box with the least cell size that gives as many. Those along one axis at least are then full, and
/// contact and bending of the box are those of full cells. Other shapes are unchanged.
fn fill_box(request: &Request<'_>, candidate: Candidate) -> Candidate {
    let least = candidate.least_size_of_box(request.mesh);
    let filled = least.and_then(|size| request.candidate(size).ok());
    filled.filter(|filled| filled.vertices == candidate.vertices).unwrap_or(candidate)
}

/// Returns ln of the next cell size, between a trial with too many vertices and a trial with too few
/// vertices.
///
/// Interpolates linearly. Every third trial bisects instead, because interpolation alone may stay near one
/// end of the interval.
fn interpolate(many: &Trial, few: &Trial, trials: usize) -> f64 {
    let t = if trials.is_multiple_of(3) { 0.5 } else { many.log_ratio / (many.log_ratio - few.log_ratio) };
    many.log_size + (few.log_size - many.log_size) * t.clamp(0.02, 0.98)
}

/// Estimates the cell size for `requested` lattice vertices from the volume, area and extent of a mesh.
fn estimate_size(measure: &RelativeMeasure, requested: f64) -> f64 {
    // Let h be the cell size, and k = extent / h the number of cells along the longest side. The volume V has
    // V / h^3 cells. A surface of area A passes through approximately 1.5 A / h^2 cells. Half of these cells
    // lie outside the volume, and the corners lie half a cell further out, which adds as many again. The
    // linear terms are the number of corners of a line of k cells.
    let vertices = |k: f64| measure.volume * k.powi(3) + 1.5 * measure.area * k * k + 4.0 * k + 4.0;
    let (mut few, mut many) = (0.0, requested);
    for _ in 0..60 {
        let middle = 0.5 * (few + many);
        if vertices(middle) < requested { few = middle } else { many = middle }
    }
    measure.extent / many
}
