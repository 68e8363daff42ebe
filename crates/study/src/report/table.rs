//! The table for the terminal: at most 80 columns.

use std::fmt::Write as _;

use super::Report;
use crate::front::Front;
use crate::point::Point;
use crate::setting::Axis;

/// Columns: heading and width.
const COLUMNS: [(&str, usize); 12] = [
    ("method", 15),
    ("n", 6),
    ("w", 2),
    ("k", 2),
    ("step", 6),
    ("corr", 5),
    ("mesh", 5),
    ("surface", 7),
    ("volume", 6),
    ("cells", 5),
    ("path", 6),
    ("best", 4),
];

/// The parts of the table.
const PARTS: [(&[Axis], &str); 4] = [
    (&[Axis::Base, Axis::Resolution], "lattices and methods; the radius of the regions stays"),
    (&[Axis::Substeps], "steps a frame; frequency and damping rate stay"),
    (&[Axis::HalfWidth], "half-width on the lattice of the scene: another material"),
    (&[Axis::Sums], "naive sums in f64, on one thread"),
];

const LEGEND: &str = "\
n lattice vertices, w half-width in cells, k steps a frame; step, correction and
mesh update in ms a frame. surface: rms distance from the finest lattice (=) over
the diagonal. volume: of the mesh, greatest; cells: of single cells, rms. path:
rms distance from the naive sums, in cells. best: nothing is both faster and
better by s, v, c, p: surface, volume, cells, path. ~ softer than asked: steps
too long.";

/// The table of a report.
pub(super) fn of(report: &Report) -> String {
    let mut text = format!("{}\n{}\n", report.scene, report.machine.line());
    let headings: Vec<String> = COLUMNS.iter().map(|(heading, _)| (*heading).to_owned()).collect();
    line(&mut text, &headings);
    for (axes, heading) in PARTS {
        let mut points: Vec<&Point> =
            report.points.iter().filter(|point| axes.contains(&point.axis)).collect();
        if points.is_empty() {
            continue;
        }
        points.sort_by(|a, b| a.lattice_vertices.cmp(&b.lattice_vertices).then(a.substeps.cmp(&b.substeps)));
        let _ = writeln!(text, "{heading}");
        points.iter().for_each(|point| line(&mut text, &row(point)));
    }
    text + LEGEND
}

fn row(point: &Point) -> Vec<String> {
    let timing = &point.timing;
    let name = if point.sums == "fast" { &point.method } else { &point.sums };
    let surface = if point.finest { "=".to_owned() } else { small(point.errors.surface_rms) };
    let softened = if point.softened { "~" } else { "" };
    vec![
        format!("{name}{softened}"),
        point.lattice_vertices.to_string(),
        point.half_width.to_string(),
        point.substeps.to_string(),
        milliseconds(timing.step.median),
        milliseconds(timing.correction.median),
        milliseconds(timing.update.median),
        surface,
        small(Front::Volume.error(point)),
        small(Front::Cells.error(point)),
        small(Front::Path.error(point)),
        point.front.iter().map(|front| front.letter()).collect(),
    ]
}

/// The first and the last column to the left, the others to the right.
fn line(text: &mut String, cells: &[String]) {
    let mut out = String::new();
    for (index, (cell, (_, width))) in cells.iter().zip(COLUMNS).enumerate() {
        let gap = if index == 0 { "" } else { " " };
        let left = index == 0 || index + 1 == COLUMNS.len();
        let _ = match left {
            true => write!(out, "{gap}{cell:<width$}"),
            false => write!(out, "{gap}{cell:>width$}"),
        };
    }
    let _ = writeln!(text, "{}", out.trim_end());
}

/// Three digits in at most six columns.
fn milliseconds(value: f64) -> String {
    match value {
        _ if !value.is_finite() => "-".to_owned(),
        _ if value >= 100.0 => format!("{value:.0}"),
        _ if value >= 10.0 => format!("{value:.1}"),
        _ if value >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// Two digits and an exponent: `3.1e-7`.
fn small(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) if (0.01..10.0).contains(&value) => format!("{value:.3}"),
        Some(value) => format!("{value:.1e}"),
    }
}
