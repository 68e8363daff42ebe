//! The facts as people read them.

use std::fmt::Write;

use super::facts::{BodyFacts, Facts, LatticeFacts, MeshFacts};
use crate::say;

/// All facts, in lines of two columns.
pub(super) fn of(facts: &Facts) -> String {
    let mut page = Page(String::new());
    let auto = if facts.substeps_auto { " (auto)" } else { "" };
    page.line(&format!(
        "{}: {} frames at {} a second = {:.2} s, {} steps a frame{auto}",
        facts.input, facts.frames, facts.fps, facts.seconds, facts.substeps
    ));
    page.entry("machine", &format!("{} threads, SIMD level {}", facts.threads, facts.simd));
    page.entry(
        "frames",
        &format!(
            "{} in {}, about {} on disk",
            facts.format,
            facts.directory,
            say::bytes(facts.bytes_on_disk)
        ),
    );
    page.entry("colliders", &facts.colliders.to_string());
    for body in &facts.bodies {
        page.body(body);
    }
    page.line("");
    page.line("plan");
    for line in facts.plan.lines() {
        page.line(&format!("  {line}"));
    }
    for note in &facts.notes {
        page.line("");
        page.line(&format!("note: {note}"));
    }
    page.0
}

struct Page(String);

impl Page {
    fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    fn entry(&mut self, key: &str, value: &str) {
        // Writing to a string does not fail.
        let _ = writeln!(self.0, "  {key:10}{value}");
    }

    /// An entry for something that is seldom there.
    fn count(&mut self, count: usize, what: &str) {
        if count > 0 {
            self.entry("", &format!("{count} {what}"));
        }
    }

    fn body(&mut self, body: &BodyFacts) {
        self.line("");
        self.line(&format!("body {}", body.name));
        self.mesh(&body.mesh);
        self.lattice(&body.lattice);
        self.entry("regions", &format!("half-width {} cells", body.half_width));
        self.entry("frame", &say::bytes(body.frame_bytes));
        for (index, fact) in body.pc2.iter().enumerate() {
            self.entry(if index == 0 { "PC2" } else { "" }, fact);
        }
    }

    fn mesh(&mut self, mesh: &MeshFacts) {
        let object = mesh.object.as_ref().map_or(String::new(), |object| format!(", object {object}"));
        let closed = if mesh.closed { "closed" } else { "not closed" };
        self.entry(
            "mesh",
            &format!("{}{object}: {} vertices, {} faces, {closed}", mesh.file, mesh.vertices, mesh.faces),
        );
        self.entry(
            "",
            &format!(
                "from {} to {}, volume {}, {}",
                point(mesh.low),
                point(mesh.high),
                number(mesh.volume),
                components(mesh.components)
            ),
        );
        if mesh.flipped {
            self.entry("", "its faces look inwards; its volume is taken as positive all the same");
        }
        self.count(
            mesh.welded_seam_vertices,
            "seam vertices lie where another vertex lies, and move with it",
        );
        self.count(mesh.unused_vertices, "vertices are used by no face");
        self.count(mesh.boundary_edges, "edges belong to one face alone");
        self.count(mesh.non_manifold_edges, "edges belong to more than two faces");
        self.count(mesh.misoriented_edges, "edges join faces that look opposite ways");
        self.count(mesh.degenerate_faces, "faces have fewer than three different corners");
        self.count(mesh.duplicate_faces, "faces repeat another");
        self.count(mesh.two_sided_faces, "faces repeat another, turned over");
        self.count(mesh.shared_normals, "`vn` lines are shared by different normals, and get their mean");
        self.count(mesh.short_faces, "`f` lines with fewer than three corners are left out");
        for statement in &mesh.ignored_statements {
            self.entry("", &format!("not used: {statement}"));
        }
        for library in &mesh.missing_libraries {
            self.entry("", &format!("material library not found: {library}"));
        }
    }

    fn lattice(&mut self, lattice: &LatticeFacts) {
        self.entry(
            "lattice",
            &format!(
                "{} vertices, {} cells of size {}, {}, {}",
                lattice.vertices,
                lattice.cells,
                number(lattice.cell_size),
                components(lattice.components),
                say::bytes(lattice.bytes as u64)
            ),
        );
        if lattice.shell {
            self.entry("", "the mesh has openings wider than a cell: a shell along its surface, not a solid");
        }
        for part in &lattice.floating {
            let fate = if part.joined { "rides along on a bridge" } else { "is on its own" };
            self.entry(
                "",
                &format!(
                    "mesh parts {} float apart in {} cells: {fate}",
                    list(&part.mesh_components),
                    part.cells
                ),
            );
        }
        for group in &lattice.glued {
            self.entry("", &format!("mesh parts {} are glued: their cells touch", list(group)));
        }
        let volume = |(measure, volume): &(String, f64)| {
            let kept = if lattice.measure.as_ref() == Some(measure) { " (kept)" } else { "" };
            format!("{measure} {}{kept}", number(*volume))
        };
        self.entry("volume", &lattice.volumes.iter().map(volume).collect::<Vec<_>>().join(", "));
    }
}

/// Four digits: enough to recognise a number.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = (3 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

fn point(value: [f64; 3]) -> String {
    let [x, y, z] = value.map(number);
    format!("({x}, {y}, {z})")
}

fn components(count: usize) -> String {
    if count == 1 { "1 component".to_owned() } else { format!("{count} components") }
}

fn list(numbers: &[u32]) -> String {
    numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")
}
