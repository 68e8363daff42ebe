//! `study.csv`: a row a point. What is not known is empty.

use std::path::Path;

use super::Report;
use crate::error::StudyError;
use crate::front::Front;
use crate::output::write_csv;
use crate::point::Point;

/// Writes the file.
pub(super) fn write(report: &Report, path: &Path) -> Result<(), StudyError> {
    let mut records = Vec::new();
    for (index, point) in report.points.iter().enumerate() {
        let (names, values): (Vec<_>, Vec<_>) = fields(point).into_iter().unzip();
        if index == 0 {
            records.push(names.into_iter().map(str::to_owned).collect());
        }
        records.push(values);
    }
    write_csv(path, &records)
}

/// The columns of a point: names and values.
fn fields(point: &Point) -> Vec<(&'static str, String)> {
    let Point { timing, errors, free, .. } = point;
    // The shortest text that reads back.
    let number = |value: f64| format!("{value:?}");
    let known = |value: Option<f64>| value.map_or_else(String::new, number);
    let goals = |part: fn(&crate::Distances) -> f64| known(errors.goals.as_ref().map(part));
    let path = |part: fn(&crate::Path) -> f64| known(errors.path.as_ref().map(part));
    let free = |part: fn(&crate::Free) -> Option<f64>| known(free.as_ref().and_then(part));
    let front: Vec<String> = Front::ALL.iter().map(|front| point.front.contains(front).to_string()).collect();
    vec![
        ("axis", point.axis.name().to_owned()),
        ("method", point.method.clone()),
        ("sums", point.sums.clone()),
        ("lattice_vertices", point.lattice_vertices.to_string()),
        ("cell_size", number(point.cell_size)),
        ("half_width", point.half_width.to_string()),
        ("reach", number(point.reach)),
        ("substeps", point.substeps.to_string()),
        ("alpha", number(point.alpha)),
        ("softened", point.softened.to_string()),
        ("finest", point.finest.to_string()),
        ("ms_step", number(timing.step.median)),
        ("ms_correction", number(timing.correction.median)),
        ("ms_update", number(timing.update.median)),
        ("ms_total", number(timing.total.median)),
        ("ms_total_low", number(timing.total.low)),
        ("ms_total_high", number(timing.total.high)),
        ("repeats", timing.samples.len().to_string()),
        ("goals_rms_cells", goals(|goals| goals.rms_cells)),
        ("goals_max_cells", goals(|goals| goals.max_cells)),
        ("goals_rms", goals(|goals| goals.rms)),
        ("goals_max", goals(|goals| goals.max)),
        ("path_frames", errors.path.map_or_else(String::new, |path| path.frames.to_string())),
        ("path_rms_cells", path(|path| path.distances.rms_cells)),
        ("path_max_cells", path(|path| path.distances.max_cells)),
        ("path_rms", path(|path| path.distances.rms)),
        ("path_max", path(|path| path.distances.max)),
        ("mesh_volume", known(errors.mesh_volume)),
        ("cells_volume", known(errors.cells_volume)),
        ("cell_volumes", known(errors.cell_volumes)),
        ("surface_rms", known(errors.surface_rms)),
        ("surface_hausdorff", known(errors.surface_hausdorff)),
        ("capped_frames", errors.capped.to_string()),
        ("linear_momentum", free(|free| Some(free.linear_momentum))),
        ("angular_momentum", free(|free| Some(free.angular_momentum))),
        ("energy_gain", free(|free| free.energy_gain)),
        ("energy_loss", free(|free| free.energy_loss)),
        ("front_surface", front[0].clone()),
        ("front_volume", front[1].clone()),
        ("front_cells", front[2].clone()),
        ("front_path", front[3].clone()),
    ]
}
