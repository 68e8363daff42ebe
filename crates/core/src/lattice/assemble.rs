//! From a set of cells to a lattice.

use nalgebra::Point3;

use super::components::{self, Components, RunLabels};
use super::join::{self, Bridge};
use super::report::{FloatingPart, LatticeReport};
use super::runs::Runs;
use super::{Lattice, LatticeError, corners, memory};

/// The parts of a set of cells, and the cells once these are joined.
pub(crate) struct Joined {
    /// The cells, bridges among them.
    pub(crate) cells: Runs,
    /// The cells that bridges added.
    pub(crate) bridge_cells: usize,
    /// The parts before joining, of each run of the cells before joining.
    pub(crate) parts: RunLabels,
    bridges: Vec<Bridge>,
}

/// Joins the parts of a set of cells, if wished, unless the bridges take too much memory.
pub(crate) fn join(cells: Runs, join: bool, cell_size: f64, limit: u64) -> Result<Joined, LatticeError> {
    let parts = components::label(&cells);
    let bridges = if join { join::bridges(&cells, &parts) } else { Vec::new() };
    if bridges.is_empty() {
        return Ok(Joined { cells, bridge_cells: 0, parts, bridges });
    }
    // Each further cell of a bridge shares a face with the one before and so adds four vertices.
    let length = bridges.iter().fold(0u64, |sum, bridge| sum.saturating_add(bridge.len()));
    memory::check(memory::of_vertices(length.saturating_mul(4)), limit, cell_size)?;
    let (cells, bridge_cells) = join::with_bridges(&cells, &bridges);
    Ok(Joined { cells, bridge_cells, parts, bridges })
}

/// The parts but the largest, as the report lists them.
pub(crate) fn floating_parts(before: &Runs, joined: &Joined) -> Vec<FloatingPart> {
    let mut floating = vec![FloatingPart::default(); joined.parts.count];
    for (run, part) in joined.parts.of_run.iter().enumerate() {
        floating[*part as usize].cells += before.span(run).len();
    }
    for bridge in &joined.bridges {
        floating[bridge.part as usize].bridge_cells += bridge.len() as usize;
    }
    for part in &mut floating {
        part.joined = !joined.bridges.is_empty();
    }
    floating.remove(join::largest(before, &joined.parts) as usize);
    floating
}

/// The lattice of a set of cells, which must not be empty.
pub(crate) fn lattice(
    cells: Runs,
    cell_size: f64,
    origin: Point3<f64>,
    report: LatticeReport,
    limit: u64,
) -> Result<Lattice, LatticeError> {
    let count = corners::count(&cells);
    memory::check(memory::of_vertices(count as u64), limit, cell_size)?;
    let labels = components::label(&cells);
    let mut vertex_runs = Runs::default();
    let mut indices = Vec::with_capacity(count);
    let mut links = Vec::with_capacity(count);
    let mut occupied_cells = Vec::with_capacity(count);
    let mut of_vertex = Vec::with_capacity(count);
    corners::visit(&cells, |corner| {
        vertex_runs.push(corner.index, 1);
        indices.push(corner.index);
        links.push(corner.links);
        occupied_cells.push(corner.cells);
        of_vertex.push(labels.of_run[corner.cell_run]);
    });
    let components = Components { count: labels.count, of_vertex };
    let positions = cells.positions();
    Ok(Lattice {
        cell_size,
        origin,
        indices,
        vertex_runs,
        links,
        occupied_cells,
        cells: positions,
        cell_runs: cells,
        components,
        report,
    })
}
