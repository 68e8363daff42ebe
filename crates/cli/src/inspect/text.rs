//! Facts about a scene as text.

use std::fmt::Write;

use super::facts::{BodyFacts, Facts, LatticeFacts, MeshFacts};
use crate::terminal;

/// Formats all facts in lines of two columns; with the plan of the simulation if `plan` is set.
pub(super) fn format(facts: &Facts, plan: bool) -> String {
    let mut page = Page(String::new());
    let auto = if facts.substeps_auto { " (auto)" } else { "" };
    page.line(&facts.input);
    page.entry(
        "duration",
        &format!("{} frames at {} frames/s = {:.2} s", facts.frames, facts.fps, facts.seconds),
    );
    page.entry("steps", &format!("{} per frame{auto}", facts.substeps));
    page.entry("output", &format!("{} files in {}", facts.format, facts.directory));
    page.entry("on disk", &format!("about {}", terminal::bytes(facts.bytes_on_disk)));
    let memory: usize = facts.bodies.iter().map(|body| body.memory_bytes).sum();
    page.entry("memory", &terminal::bytes(memory as u64));
    page.entry("threads", &facts.threads.to_string());
    page.entry("SIMD level", &facts.simd);
    page.entry("colliders", &facts.colliders.to_string());
    for body in &facts.bodies {
        page.body(body);
    }
    if plan {
        page.line("");
        page.line("plan");
        for line in facts.plan.lines() {
            page.line(&format!("  {line}"));
        }
    }
    for note in &facts.notes {
        page.line("");
        page.line(&format!("note: {note}"));
    }
    page.0
}

/// Text with labelled lines.
struct Page(String);

impl Page {
    fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    fn entry(&mut self, key: &str, value: &str) {
        // Writing to a string does not fail.
        let _ = writeln!(self.0, "  {key:12}{value}");
    }

    /// Adds an entry unless `count` is 0.
    fn count(&mut self, count: usize, text: &str) {
        if count > 0 {
            self.entry("", &format!("{count} {text}"));
        }
    }

    fn body(&mut self, body: &BodyFacts) {
        self.line("");
        self.line(&format!("body {}", body.name));
        self.mesh(&body.mesh);
        self.lattice(&body.lattice);
        self.entry("half-width", &format!("{} cells", body.half_width));
        self.entry("memory", &terminal::bytes(body.memory_bytes as u64));
        self.entry("frame size", &terminal::bytes(body.frame_bytes));
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
            self.entry("", "its faces point inwards; its volume is counted as positive");
        }
        self.count(mesh.welded_seam_vertices, "seam vertices coincide with another vertex and move with it");
        self.count(mesh.unused_vertices, "vertices are not used by any face");
        self.count(mesh.boundary_edges, "edges belong to only one face");
        self.count(mesh.non_manifold_edges, "edges belong to more than two faces");
        self.count(mesh.misoriented_edges, "edges join faces of opposite orientation");
        self.count(mesh.degenerate_faces, "faces have fewer than three distinct corners");
        self.count(mesh.duplicate_faces, "faces duplicate another face");
        self.count(mesh.two_sided_faces, "faces duplicate another face with the opposite orientation");
        self.count(
            mesh.count_shared_normals,
            "`vn` lines are shared by corners with different normals; the mean is written",
        );
        self.count(mesh.short_faces, "`f` lines with fewer than three corners are omitted");
        for statement in &mesh.ignored_statements {
            self.entry("", &format!("ignored: {statement}"));
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
                terminal::bytes(lattice.bytes as u64)
            ),
        );
        if lattice.shell {
            self.entry("", "the mesh has openings wider than a cell; only cells on its surface are filled");
        }
        for part in &lattice.floating {
            let state = if part.joined { "joined by a bridge of cells" } else { "not joined" };
            self.entry(
                "",
                &format!(
                    "mesh components {} are a separate part of {} cells, {state}",
                    list(&part.mesh_components),
                    part.cells
                ),
            );
        }
        for group in &lattice.glued {
            self.entry("", &format!("mesh components {} are glued: their cells touch", list(group)));
        }
        let volume = |(measure, volume): &(String, f64)| {
            let preserved = if lattice.measure.as_ref() == Some(measure) { " (preserved)" } else { "" };
            format!("{measure} {}{preserved}", number(*volume))
        };
        self.entry("volume", &lattice.volumes.iter().map(volume).collect::<Vec<_>>().join(", "));
    }
}

/// Formats a number with four significant digits.
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
