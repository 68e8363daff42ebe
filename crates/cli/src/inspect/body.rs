//! What is known about one body: its file, its mesh, its lattice.

use supple::volume::Preservation;
use supple::{Body, Lattice};
use supple_io::frames::{Format, shared_normals};
use supple_io::run::{Input, Prepared};
use supple_io::scene::{BodyData, Scene};

use super::facts::{BodyFacts, FloatingFacts, LatticeFacts, MeshFacts};

/// The facts about a body, by its number in the scene.
pub(super) fn of(scene: &Scene, prepared: &Prepared, index: usize) -> BodyFacts {
    let (data, input) = (&scene.bodies[index], &prepared.inputs[index]);
    let body = prepared.simulation.body(index);
    let source = input.source();
    BodyFacts {
        name: data.name.clone(),
        mesh: mesh(scene, data, input, &body),
        lattice: lattice(body.lattice(), &body),
        half_width: body.half_width(),
        frame_bytes: source.frame_bytes(scene.output.format),
        pc2: pc2(source.points(), scene, input),
    }
}

fn mesh(scene: &Scene, data: &BodyData, input: &Input, body: &Body) -> MeshFacts {
    // As it lies in the lattice: after `scale`.
    let mesh = body.mesh().unwrap_or_else(|| input.part.mesh());
    let (topology, (low, high)) = (mesh.topology(), mesh.bounds());
    let document = &input.document;
    let libraries = document.libraries();
    let ignored = |statement: &supple_io::obj::IgnoredStatement| {
        let times =
            if statement.count == 1 { String::new() } else { format!(" ({} times)", statement.count) };
        format!("`{}` in line {}{times}", statement.keyword, statement.first_line)
    };
    MeshFacts {
        file: scene.resolve(&data.mesh).display().to_string(),
        object: data.object.clone(),
        vertices: mesh.vertices().len(),
        faces: mesh.face_count(),
        closed: mesh.is_closed(),
        flipped: topology.is_flipped(),
        components: topology.components.len(),
        volume: mesh.volume(),
        low: low.into(),
        high: high.into(),
        welded_seam_vertices: topology.seam_vertices,
        unused_vertices: topology.unused_vertices,
        boundary_edges: topology.boundary_edges,
        non_manifold_edges: topology.non_manifold_edges,
        misoriented_edges: topology.misoriented_edges,
        degenerate_faces: topology.degenerate_faces,
        duplicate_faces: topology.duplicate_faces,
        two_sided_faces: topology.two_sided_faces,
        shared_normals: shared_normals(document, &input.part),
        short_faces: document.short_faces().0,
        ignored_statements: document.ignored_statements().iter().map(ignored).collect(),
        missing_libraries: libraries.into_iter().filter(|l| !l.exists).map(|l| l.name).collect(),
        groups: document.groups().map(|group| group.name.clone()).collect(),
    }
}

fn lattice(lattice: &Lattice, body: &Body) -> LatticeFacts {
    let report = lattice.report();
    let volumes = body.alone().volume_report();
    let floating = |part: &supple::FloatingPart| FloatingFacts {
        cells: part.cells,
        mesh_components: part.mesh_components.clone(),
        joined: part.joined,
    };
    LatticeFacts {
        vertices: lattice.len(),
        cells: lattice.cells().len(),
        cell_size: lattice.cell_size(),
        components: lattice.components().count,
        shell: report.shell,
        surface_cells: report.surface_cells,
        filled_cells: report.filled_cells,
        bridge_cells: report.bridge_cells,
        floating: report.floating.iter().map(floating).collect(),
        glued: report.glued.clone(),
        bytes: lattice.memory(),
        volumes: volumes.volumes.iter().map(|(measure, v)| (measure.to_string(), v.rest)).collect(),
        measure: (body.volume_options().measure != Preservation::Off).then(|| volumes.measure.to_string()),
    }
}

/// What a reader of a point cache must know: the format holds neither faces nor names.
fn pc2(points: usize, scene: &Scene, input: &Input) -> Vec<String> {
    let mut facts = vec![
        format!(
            "{points} points, all `v` lines of {} in their order: load it without merging, splitting or \
             reordering vertices",
            input.document.path().display()
        ),
        "positions are in world space, in the axes of the scene; do not turn or place the mesh again"
            .to_owned(),
    ];
    if input.part.mesh().vertices().len() < points {
        facts.push("points of other objects of the file stay where they are".to_owned());
    }
    let samples = u64::from(scene.simulation.frames) + 1;
    facts.push(format!(
        "{samples} samples at {} a second, {} bytes",
        scene.simulation.fps,
        32 + samples * input.source().frame_bytes(Format::Pc2)
    ));
    facts
}
