//! Formats the tables for the terminal, of at most 80 columns.

use std::fmt::Write as _;

use super::point::{Front, Point};
use super::report::Report;
use super::setting::Axis;
use crate::output::compact;
use supple_io::Escaped;

/// A column: heading, width, and the cell text of a point.
type Column = (&'static str, usize, fn(&Point) -> String);

const MAIN: [Column; 12] = [
    ("method", 16, |point| if point.axis == Axis::Sums { &point.sums } else { &point.method }.clone()),
    VERTICES,
    HALF_WIDTH,
    SUBSTEPS,
    ("step", 5, |point| milliseconds(point.timing.step.median)),
    ("corr", 5, |point| milliseconds(point.timing.correction.median)),
    ("mesh", 5, |point| milliseconds(point.timing.update.median)),
    ("surf", 6, |point| if point.finest { "=".to_owned() } else { compact(point.errors.surface_rms) }),
    ("volume", 6, |point| compact(Front::Volume.error(point))),
    ("cells", 6, |point| compact(Front::Cells.error(point))),
    ("path", 6, |point| compact(Front::Path.error(point))),
    ("best", 4, best),
];

const MOTION: [Column; 12] = [
    ("motion", 7, |point| if point.sums == "breadth-first" { "breadth" } else { &point.sums }.to_owned()),
    VERTICES,
    HALF_WIDTH,
    SUBSTEPS,
    ("goals", 6, |point| compact(point.errors.goals.map(|goals| goals.rms_cells))),
    ("most", 6, |point| compact(point.errors.goals.map(|goals| goals.max_cells))),
    ("path", 6, |point| compact(point.errors.path.map(|path| path.distances.rms_cells))),
    ("most", 6, |point| compact(point.errors.path.map(|path| path.distances.max_cells))),
    ("linear", 6, |point| compact(point.free.as_ref().map(|free| free.linear_momentum))),
    ("spin", 6, |point| compact(point.free.as_ref().map(|free| free.angular_momentum))),
    ("gain", 6, |point| compact(point.free.as_ref().and_then(|free| free.energy_gain))),
    ("loss", 6, |point| compact(point.free.as_ref().and_then(|free| free.energy_loss))),
];

const VERTICES: Column = ("n", 5, |point| point.lattice_vertices.to_string());
const HALF_WIDTH: Column = ("w", 3, |point| point.half_width.to_string());
const SUBSTEPS: Column = ("k", 2, |point| point.substeps.to_string());

/// Sections of the main table: the axes of their points, and their headings.
const SECTIONS: [(&[Axis], &str); 5] = [
    (&[Axis::Base, Axis::Resolution], "lattices and methods; the radius of the regions is constant"),
    (&[Axis::Substeps], "steps per frame; frequency and damping rate are constant"),
    (&[Axis::Regions], "half-width and steps of the same material"),
    (&[Axis::HalfWidth], "half-width on the lattice of the scene: another material"),
    (&[Axis::Sums], "naive sums in f64, on one thread"),
];

const MAIN_LEGEND: &str = "\
n lattice vertices, w half-width in cells, k steps per frame; step, correction,
mesh update in ms per frame. surf: rms distance from the surface of the finest
lattice (=), over the diagonal. volume: maximum relative error, of the mesh;
cells: rms, of single cells. path: rms distance from the naive sums, in cells.
best: no point is faster and better by s surface, v volume, c cells, p path.
~ steps too long: softer than specified. ! a correction reached its cap.
";

const MOTION_LEGEND: &str = "\
goals and path: rms and maximum distance from the naive sums, in cells. In free
flight, undamped: change of linear and angular momentum (spin), energy gained
and lost.";

const KEPT_WHOLE: &str = "\
note: the study leaves out [body.fracture], because the naive sums do not break.
It measures the motion of the whole body of";

impl Report {
    /// Formats tables of at most 80 columns.
    pub fn table(&self) -> String {
        let mut text = format!("{}\n{}\n", self.scene, self.machine.line());
        if !self.kept_whole.is_empty() {
            let _ = writeln!(text, "{KEPT_WHOLE}");
            for body in &self.kept_whole {
                let _ = writeln!(text, "  {}", Escaped(body));
            }
        }
        let _ = write!(text, "\n{}", headings(&MAIN));
        for (axes, heading) in SECTIONS {
            let points = sorted(self, |point| axes.contains(&point.axis));
            if !points.is_empty() {
                let _ = writeln!(text, "{heading}");
            }
            points.iter().for_each(|point| text += &row(&MAIN, point));
        }
        let _ = write!(text, "\n{MAIN_LEGEND}\n{}", headings(&MOTION));
        for point in sorted(self, |point| point.method == self.method) {
            text += &row(&MOTION, point);
        }
        text + "\n" + MOTION_LEGEND
    }
}

/// Returns the points that `is_selected` accepts, from coarse to fine.
fn sorted(report: &Report, is_selected: impl Fn(&&Point) -> bool) -> Vec<&Point> {
    let mut points: Vec<&Point> = report.points.iter().filter(is_selected).collect();
    points.sort_by(|a, b| {
        let widths = a.half_width.cells().total_cmp(&b.half_width.cells());
        a.lattice_vertices.cmp(&b.lattice_vertices).then(widths).then(a.substeps.cmp(&b.substeps))
    });
    points
}

/// Returns the letters of the fronts that contain a point, and its warning signs `~` and `!`.
fn best(point: &Point) -> String {
    let mut best: String = point.front.iter().map(|front| front.letter()).collect();
    best.extend(point.softened.then_some('~'));
    best.extend((point.errors.capped > 0).then_some('!'));
    best
}

/// Formats the line of headings.
fn headings(columns: &[Column]) -> String {
    line(columns, |(heading, ..)| (*heading).to_owned())
}

/// Formats the line of a point.
fn row(columns: &[Column], point: &Point) -> String {
    line(columns, |(.., cell)| cell(point))
}

/// Formats a line. The first column and the column `best` are left-aligned, the others right-aligned.
fn line(columns: &[Column], cell: impl Fn(&Column) -> String) -> String {
    let mut line = String::new();
    for (index, column @ (heading, width, _)) in columns.iter().enumerate() {
        let (gap, cell) = (if index == 0 { "" } else { " " }, cell(column));
        let _ = match index == 0 || *heading == "best" {
            true => write!(line, "{gap}{cell:<width$}"),
            false => write!(line, "{gap}{cell:>width$}"),
        };
    }
    line.trim_end().to_owned() + "\n"
}

/// Formats milliseconds with approximately three digits in at most five columns.
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
