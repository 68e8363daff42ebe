//! Formats the facts about a scene as text.

use std::fmt::Write;

use supple_io::counted;

use super::contact::{ContactFacts, OverlapFacts, TouchingFacts};
use super::facts::{BodyFacts, ColliderMeshFacts, Facts, LatticeFacts};
use super::material::MaterialFacts;
use super::mesh::{MapFacts, MeshFacts};
use super::placed::{FollowFacts, SelectionFacts, ZoneFacts};
use crate::terminal::{self, number};

/// Formats the facts as lines with two columns, a key and a value. If `plan` is set, adds the stages of the
/// simulation and the memory of each.
pub(super) fn format(facts: &Facts, plan: bool) -> String {
    let mut page = Page(String::new());
    let reason = facts.substeps_reason.as_ref();
    let auto = reason.map_or_else(String::new, |reason| format!(" (auto: {reason})"));
    let frames = counted(facts.frames as usize, "frame");
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
    for ColliderMeshFacts { collider, file, triangles, closed } in &facts.collider_meshes {
        let kind = if *closed { "closed, a solid" } else { "open, a shell" };
        page.entry("", &format!("collider.{collider}: {file}, {}, {kind}", counted(*triangles, "triangle")));
    }
    page.contact(facts);
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
    for warning in &facts.warnings {
        page.line("");
        page.line(&format!("warning: {warning}"));
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

    /// Adds the settings of contact between bodies, and the bodies that do not touch each other.
    fn contact(&mut self, facts: &Facts) {
        let ContactFacts { between_bodies, self_contact, ignored, overlapping } = &facts.contact;
        let own = facts.bodies.iter().filter(|body| body.touching.as_ref().is_some_and(|t| t.self_contact));
        let own: Vec<&str> = own.map(|body| body.name.as_str()).collect();
        let between = match (facts.bodies.len(), *between_bodies) {
            (1, _) => "none, the scene has one body",
            (_, true) => "on",
            (_, false) => "off (`contact = false`)",
        };
        let own = match own.len() {
            0 => "off".to_owned(),
            count if count == facts.bodies.len() && *self_contact => "on".to_owned(),
            _ => format!("on for {}", own.join(", ")),
        };
        self.entry("contact", &format!("between bodies: {between}; of a body with itself: {own}"));
        for [a, b] in ignored {
            self.entry("", &format!("{a} and {b} pass through each other (`ignore`)"));
        }
        for OverlapFacts { bodies: [a, b], depth } in overlapping {
            self.entry("", &format!("{a} and {b} overlap at the start, up to {} deep", number(*depth)));
        }
    }

    fn body(&mut self, body: &BodyFacts) {
        self.line("");
        self.line(&format!("body {}", body.name));
        self.mesh(&body.mesh);
        self.lattice(&body.lattice);
        for (index, zone) in body.zones.iter().enumerate() {
            self.zone(index, zone);
        }
        for (kind, selections) in [("pin", &body.pins), ("handle", &body.handles)] {
            for (index, selection) in selections.iter().enumerate() {
                self.selection(&format!("{kind} {index}"), selection);
            }
        }
        if let Some(material) = &body.material {
            for (line, name) in material.lines().iter().zip(["material", "", ""]) {
                self.entry(name, line);
            }
            if let Some(plastic) = &material.plastic {
                self.entry("plastic", &plastic.line());
            }
            if let Some(fracture) = &material.fracture {
                self.entry("fracture", &fracture.line());
            }
        }
        if let Some(touching) = &body.touching {
            let TouchingFacts { friction, restitution, thickness, samples, bytes, .. } = touching;
            let (samples, bytes) = (counted(*samples, "surface sample"), terminal::bytes(*bytes as u64));
            let thickness = if *thickness > 0.0 { format!("thickness {thickness}, ") } else { String::new() };
            self.entry(
                "contact",
                &format!("friction {friction}, restitution {restitution}, {thickness}{samples}, {bytes}"),
            );
        }
        if let Some(half_width) = body.half_width {
            let text = match half_width.whole_cells() {
                Some(cells) => counted(cells, "cell"),
                None => format!("{half_width} cells, so that each region is a cell"),
            };
            let text = match body.material.as_ref().and_then(MaterialFacts::regions) {
                Some(why) => format!("{text}; {why}"),
                None => text,
            };
            self.entry("half-width", &text);
        }
        if body.rigid {
            self.entry("rigid", "six degrees of freedom");
        }
        self.entry("memory", &terminal::bytes(body.memory_bytes as u64));
        self.entry("frame size", &terminal::bytes(body.frame_bytes));
        for (index, fact) in body.pc2.iter().enumerate() {
            self.entry(if index == 0 { "PC2" } else { "" }, fact);
        }
    }

    fn zone(&mut self, index: usize, zone: &ZoneFacts) {
        let ZoneFacts { factor, border_vertices, .. } = zone;
        let (low, high) = (point(zone.low), point(zone.high));
        let inside = counted(zone.lattice_vertices, "lattice vertex");
        let text =
            format!("factor {factor} on {inside}, {border_vertices} at its border, from {low} to {high}");
        self.entry(&format!("zone {index}"), &text);
    }

    fn selection(&mut self, key: &str, selection: &SelectionFacts) {
        let lattice_vertices = counted(selection.lattice_vertices, "lattice vertex");
        let (low, high) = (point(selection.low), point(selection.high));
        let text = match selection.mesh_vertices {
            Some(count) => {
                let mesh_vertices = counted(count, "mesh vertex");
                format!("{mesh_vertices} from {low} to {high}, {lattice_vertices}")
            }
            None => format!("{lattice_vertices} from {low} to {high}"),
        };
        self.entry(key, &text);
        if let Some(FollowFacts { file, samples, first, last, distance_at_start }) = &selection.follow {
            let (first, last, distance) = (number(*first), number(*last), number(*distance_at_start));
            let samples = counted(*samples, "sample");
            self.entry("", &format!("follows {file}: {samples} from {first} to {last} s"));
            self.entry(
                "",
                &format!("the mesh is up to {distance} from its rest pose when the handle begins"),
            );
        }
    }

    fn mesh(&mut self, mesh: &MeshFacts) {
        let object = mesh.object.as_ref().map_or(String::new(), |object| format!(", object {object}"));
        let closed = if mesh.closed { "closed" } else { "not closed" };
        self.entry(
            "mesh",
            &format!(
                "{}{object}: {}, {}, {closed}",
                mesh.file,
                counted(mesh.vertices, "vertex"),
                counted(mesh.faces, "face")
            ),
        );
        self.entry(
            "",
            &format!(
                "in the world from {} to {}, volume {}, mass {}, {}",
                point(mesh.world_low),
                point(mesh.world_high),
                number(mesh.volume),
                number(mesh.mass),
                counted(mesh.components, "component")
            ),
        );
        match mesh.interior {
            "winding_number" => {
                self.entry(
                    "",
                    "the surface is not closed; points with a winding number above 1/2 are inside",
                );
            }
            "sheet" => self.entry("", "the surface is a sheet; the cells that it enters are full"),
            _ => {}
        }
        if mesh.weld_distance > 0.0 {
            let distance = number(mesh.weld_distance);
            self.entry(
                "",
                &format!("vertices up to {distance} apart count as one, because the distance is rounding"),
            );
        }
        if mesh.near_misses > 0 {
            let (count, distance) = (counted(mesh.near_misses, "vertex"), number(mesh.near_miss_distance));
            let hint = "merge vertices by this distance where the mesh was made to close it";
            self.entry("", &format!("{count} at open edges up to {distance} from another one: {hint}"));
        }
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
        for part in &mesh.ignored_parts {
            self.entry("", &format!("not read: {part}"));
        }
        for MapFacts { name, least, greatest } in &mesh.maps {
            let (least, greatest) = (number((*least).into()), number((*greatest).into()));
            self.entry("", &format!("map {name}: {least} to {greatest}"));
        }
        for library in &mesh.missing_libraries {
            self.entry("", &format!("material library not found: {library}"));
        }
    }

    fn lattice(&mut self, lattice: &LatticeFacts) {
        self.entry(
            "lattice",
            &format!(
                "{}, {} of size {}, {}, {}",
                counted(lattice.vertices, "vertex"),
                counted(lattice.cells, "cell"),
                number(lattice.cell_size),
                counted(lattice.components, "component"),
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
        for (count, state) in [
            (lattice.joined_parts, "joined to another part by a bridge of cells"),
            (lattice.separate_parts, "not joined: `join` is false"),
        ] {
            if count > 0 {
                let parts = counted(count, "floating part");
                self.entry("", &format!("{parts}, separate from the largest part; {state}"));
            }
        }
        if !lattice.glued.is_empty() {
            self.entry(
                "",
                &format!(
                    "{} in {} are connected in the lattice: they share cells, their cells touch, or one encloses \
                     another",
                    counted(lattice.glued_components, "mesh component"),
                    counted(lattice.glued.len(), "group")
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

fn point(value: [f64; 3]) -> String {
    let [x, y, z] = value.map(number);
    format!("({x}, {y}, {z})")
}
