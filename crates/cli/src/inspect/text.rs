//! Formats the facts about a scene as text.

use std::fmt::Write;

use super::facts::{BodyFacts, Facts, LatticeFacts, MeshFacts};
use crate::terminal;

/// Formats the facts as lines with two columns, a key and a value. If `plan` is set, adds the stages of the
/// simulation and the memory of each.
pub(super) fn format(facts: &Facts, plan: bool) -> String {
    let mut page = Page(String::new());
    let auto = if facts.substeps_auto { " (auto)" } else { "" };
    let frames = terminal::counted(facts.frames as usize, "frame");
    page.line(&facts.input);
    page.entry("duration", &format!("{frames} at {} frames/s = {:.2} s", facts.fps, facts.seconds));
    page.entry("steps", &format!("{} per frame{auto}", facts.substeps));
    page.entry("output", &format!("{} files in {}", facts.format, facts.directory));
    page.entry("on disk", &format!("approximately {}", terminal::bytes(facts.bytes_on_disk)));
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

/// Text in lines.
struct Page(String);

impl Page {
    fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    /// Adds a line with a key and a value. An empty key continues the entry above.
    fn entry(&mut self, key: &str, value: &str) {
        // Writing to a string does not fail.
        let _ = writeln!(self.0, "  {key:12}{value}");
    }

    /// Adds the line `text: count` unless `count` is 0.
    fn count(&mut self, count: usize, text: &str) {
        if count > 0 {
            self.entry("", &format!("{text}: {count}"));
        }
    }

    fn body(&mut self, body: &BodyFacts) {
        self.line("");
        self.line(&format!("body {}", body.name));
        self.mesh(&body.mesh);
        self.lattice(&body.lattice);
        self.entry("half-width", &terminal::counted(body.half_width, "cell"));
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
            &format!(
                "{}{object}: {} vertices, {}, {closed}",
                mesh.file,
                mesh.vertices,
                terminal::counted(mesh.faces, "face")
            ),
        );
        self.entry(
            "",
            &format!(
                "from {} to {}, volume {}, {}",
                point(mesh.low),
                point(mesh.high),
                number(mesh.volume),
                terminal::counted(mesh.components, "component")
            ),
        );
        if mesh.flipped {
            self.entry("", "the faces point inwards; the volume is printed as a positive number");
        }
        self.count(
            mesh.welded_seam_vertices,
            "seam vertices that coincide with another vertex and move with it",
        );
        self.count(mesh.unused_vertices, "vertices that no face uses");
        self.count(mesh.boundary_edges, "edges that belong to only one face");
        self.count(mesh.non_manifold_edges, "edges that belong to more than two faces");
        self.count(mesh.misoriented_edges, "edges that join faces of opposite orientation");
        self.count(mesh.degenerate_faces, "faces with fewer than three distinct corners");
        self.count(mesh.duplicate_faces, "faces that duplicate another face");
        self.count(mesh.two_sided_faces, "faces that coincide with a face of opposite orientation");
        self.count(
            mesh.shared_normals,
            "`vn` lines shared by corners at different positions; frames contain the mean of their normals",
        );
        self.count(mesh.short_faces, "omitted `f` lines, which have fewer than three corners");
        for statement in &mesh.ignored_statements {
            self.entry("", &format!("ignored statement: {statement}"));
        }
        for library in &mesh.missing_libraries {
            self.entry("", &format!("material library not found: {library}"));
        }
    }

    fn lattice(&mut self, lattice: &LatticeFacts) {
        self.entry(
            "lattice",
            &format!(
                "{} vertices, {} of size {}, {}, {}",
                lattice.vertices,
                terminal::counted(lattice.cells, "cell"),
                number(lattice.cell_size),
                terminal::counted(lattice.components, "component"),
                terminal::bytes(lattice.bytes as u64)
            ),
        );
        if lattice.shell {
            self.entry(
                "",
                "the mesh has openings wider than a cell; only the cells on its surface are occupied, \
                 not its interior",
            );
        }
        for part in &lattice.floating {
            let state = if part.joined {
                "joined to another part by a bridge of cells"
            } else {
                "not joined: `join` is false"
            };
            self.entry(
                "",
                &format!(
                    "{}: a part of {}, separate from the largest part; {state}",
                    components(&part.mesh_components),
                    terminal::counted(part.cells, "cell")
                ),
            );
        }
        for group in &lattice.glued {
            self.entry(
                "",
                &format!(
                    "{} are connected in the lattice: they share cells, their cells touch, or one encloses \
                     another",
                    components(group)
                ),
            );
        }
        let volume = |(measure, volume): &(String, f64)| {
            let preserved = if lattice.measure.as_ref() == Some(measure) { " (preserved)" } else { "" };
            format!("{measure} {}{preserved}", number(*volume))
        };
        self.entry("volume", &lattice.volumes.iter().map(volume).collect::<Vec<_>>().join(", "));
    }
}

/// Formats a number with at least four significant digits: in scientific notation from 1e5 and below 1e-3,
/// otherwise with up to six decimals and all digits before the decimal point.
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

/// Formats the indices of mesh components: `mesh component 3`, `mesh components 1, 2`.
fn components(indices: &[u32]) -> String {
    let noun = if indices.len() == 1 { "component" } else { "components" };
    let list = indices.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
    format!("mesh {noun} {list}")
}
