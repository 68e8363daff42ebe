//! The tables for the terminal: at most 80 columns.

use std::fmt::Write as _;

use super::Report;
use crate::front::Front;
use crate::output::small;
use crate::point::Point;
use crate::setting::Axis;

/// Columns: heading and width.
type Columns<'a> = &'a [(&'a str, usize)];

const MAIN: Columns<'_> = &[
    ("method", 16),
    ("n", 6),
    ("w", 2),
    ("k", 2),
    ("step", 5),
    ("corr", 5),
    ("mesh", 5),
    ("surf", 6),
    ("volume", 6),
    ("cells", 6),
    ("path", 6),
    ("best", 4),
];

const MOTION: Columns<'_> = &[
    ("motion", 7),
    ("n", 6),
    ("w", 2),
    ("k", 2),
    ("goals", 6),
    ("most", 6),
    ("path", 6),
    ("most", 6),
    ("linear", 6),
    ("spin", 6),
    ("gain", 6),
    ("loss", 6),
];

/// The parts of the main table.
const PARTS: [(&[Axis], &str); 4] = [
    (&[Axis::Base, Axis::Resolution], "lattices and methods; the radius of the regions stays"),
    (&[Axis::Substeps], "steps a frame; frequency and damping rate stay"),
    (&[Axis::HalfWidth], "half-width on the lattice of the scene: another material"),
    (&[Axis::Sums], "naive sums in f64, on one thread"),
];

const MAIN_LEGEND: &str = "\
n lattice vertices, w half-width in cells, k steps a frame; step, correction and
mesh update in ms a frame. surf: rms distance from the surface of the finest
lattice (=), over the diagonal. volume: greatest relative error, of the mesh;
cells: rms, of single cells. path: rms distance from the naive sums, in cells.
best: nothing is both faster and better by s surface, v volume, c cells, p path.
~ steps too long: softer than asked. ! a correction met its cap in some frame.
";

const MOTION_LEGEND: &str = "\
goals and path: rms and greatest distance from the naive sums, in cells. In free
flight, undamped: change of linear and angular momentum (spin), energy gained
and lost.";

/// The tables of a report.
pub(super) fn of(report: &Report) -> String {
    let mut text = format!("{}\n{}\n\n{}", report.scene, report.machine.line(), headings(MAIN));
    for (axes, heading) in PARTS {
        let points = sorted(report, |point| axes.contains(&point.axis));
        if !points.is_empty() {
            let _ = writeln!(text, "{heading}");
        }
        points.iter().for_each(|point| text += &line(MAIN, &main(point)));
    }
    let _ = write!(text, "\n{MAIN_LEGEND}\n{}", headings(MOTION));
    for point in sorted(report, |point| point.method == report.method) {
        text += &line(MOTION, &motion(point));
    }
    text + "\n" + MOTION_LEGEND
}

/// Some points, from coarse to fine.
fn sorted(report: &Report, which: impl Fn(&&Point) -> bool) -> Vec<&Point> {
    let mut points: Vec<&Point> = report.points.iter().filter(which).collect();
    points.sort_by_key(|point| (point.lattice_vertices, point.half_width, point.substeps));
    points
}

fn main(point: &Point) -> Vec<String> {
    let timing = &point.timing;
    let surface = if point.finest { "=".to_owned() } else { small(point.errors.surface_rms) };
    let name = if point.axis == Axis::Sums { &point.sums } else { &point.method };
    let mut best: String = point.front.iter().map(|front| front.letter()).collect();
    best.extend(point.softened.then_some('~'));
    best.extend((point.errors.capped > 0).then_some('!'));
    let mut cells = vec![name.clone()];
    cells.extend([point.lattice_vertices, point.half_width].map(|count| count.to_string()));
    cells.push(point.substeps.to_string());
    cells.extend([timing.step, timing.correction, timing.update].map(|time| milliseconds(time.median)));
    cells.push(surface);
    cells.extend([Front::Volume, Front::Cells, Front::Path].map(|front| small(front.error(point))));
    cells.push(best);
    cells
}

fn motion(point: &Point) -> Vec<String> {
    let (errors, free) = (&point.errors, point.free.as_ref());
    let mut cells =
        vec![if point.sums == "breadth-first" { "breadth".to_owned() } else { point.sums.clone() }];
    cells.extend([point.lattice_vertices, point.half_width].map(|count| count.to_string()));
    cells.push(point.substeps.to_string());
    for distances in [errors.goals, errors.path.map(|path| path.distances)] {
        cells.push(small(distances.map(|distances| distances.rms_cells)));
        cells.push(small(distances.map(|distances| distances.max_cells)));
    }
    cells.push(small(free.map(|free| free.linear_momentum)));
    cells.push(small(free.map(|free| free.angular_momentum)));
    cells.push(small(free.and_then(|free| free.energy_gain)));
    cells.push(small(free.and_then(|free| free.energy_loss)));
    cells
}

fn headings(columns: Columns<'_>) -> String {
    let headings: Vec<String> = columns.iter().map(|(heading, _)| (*heading).to_owned()).collect();
    line(columns, &headings)
}

/// The first column and the last of the main table to the left, the others to the right.
fn line(columns: Columns<'_>, cells: &[String]) -> String {
    let mut line = String::new();
    for (index, (cell, (heading, width))) in cells.iter().zip(columns).enumerate() {
        let gap = if index == 0 { "" } else { " " };
        let _ = match index == 0 || *heading == "best" {
            true => write!(line, "{gap}{cell:<width$}"),
            false => write!(line, "{gap}{cell:>width$}"),
        };
    }
    line.trim_end().to_owned() + "\n"
}

/// About three digits in at most five columns.
fn milliseconds(value: f64) -> String {
    let decimals = match value {
        _ if !value.is_finite() => return "-".to_owned(),
        _ if value >= 100.0 => 0,
        _ if value >= 10.0 => 1,
        _ if value >= 1.0 => 2,
        _ => 3,
    };
    format!("{value:.decimals$}")
}
