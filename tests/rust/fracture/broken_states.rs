//! Saved states of bodies that broke: they restore any settings, and states that do not fit change nothing.

use supple::{
    Body, BodySnapshot, Material, Plasticity, Preservation, Simulation, VolumeMeasure, VolumeOptions,
};

use crate::cut::sides_box;
use supple_tests::{block, lattice};

/// Returns the JSON of the snapshot of a body.
fn json(body: &Body) -> serde_json::Value {
    serde_json::to_value(body.snapshot()).unwrap()
}

fn snapshot(json: serde_json::Value) -> BodySnapshot {
    serde_json::from_value(json).unwrap()
}

fn plastic_block() -> Body {
    let material = Material { plastic: Some(Plasticity::default()), ..Material::fast_lsm() };
    Body::from_lattice(lattice(&block([4, 4, 4]))).material(material).half_width(1).build().unwrap()
}

fn cut_block() -> Body {
    let mut body = plastic_block();
    body.cut([2.0; 3], [1.0, 0.1, 0.0]).unwrap();
    body
}

#[test]
fn plastic_shapes_without_plasticity_are_named_as_the_reason() {
    let mut state = json(&cut_block());
    state["material"]["plastic"] = serde_json::Value::Null;
    let mut body = plastic_block();
    let before = body.snapshot();
    let error = body.restore(&snapshot(state)).unwrap_err();
    assert!(
        error.to_string().ends_with("the plastic shapes of the state do not match its material"),
        "{error}"
    );
    assert!(body.snapshot() == before);
}

#[test]
fn broken_joints_without_an_event_are_refused() {
    let mut state = json(&cut_block());
    state["cracks"]["events"] = 0.into();
    let mut body = plastic_block();
    let before = body.snapshot();
    assert!(body.restore(&snapshot(state)).is_err());
    assert!(body.snapshot() == before);
}

#[test]
fn the_greatest_number_of_events_does_not_overflow() {
    let mut state = json(&cut_block());
    state["cracks"]["events"] = u64::MAX.into();
    let mut body = plastic_block();
    body.restore(&snapshot(state)).unwrap();
    assert!(body.cut([2.0; 3], [0.0, 1.0, 0.0]).unwrap() > 0);
    assert_eq!((body.pieces(), body.topology_version()), (4, u64::MAX));
}

/// The shells of a closed mesh follow one piece each, also those of slivers, so that the measure stays `mesh`; and after a
/// restore in a body with other options.
#[test]
fn pieces_of_closed_meshes_keep_the_measure_also_when_they_are_restored() {
    let build = |volume: VolumeOptions| {
        Body::builder(sides_box([2.0, 1.0, 1.0], 5)).lattice_vertices(150).volume(volume).build().unwrap()
    };
    let report = |body: Body| {
        let simulation = Simulation::builder().body(body).build().unwrap();
        let measure = simulation.body(0).volume_report().measure;
        (measure, simulation.body(0).surface().positions.to_vec())
    };
    let mesh = VolumeMeasure::Mesh.into();
    let mut body = build(mesh);
    let mut random = fastrand::Rng::with_seed(5);
    for _ in 0..3 {
        let point = [0.6 + 0.8 * random.f64(), 0.3 + 0.4 * random.f64(), 0.3 + 0.4 * random.f64()];
        body.cut(point, std::array::from_fn(|_| 2.0 * random.f64() - 1.0)).unwrap();
    }
    let (whole, broken) = (build(mesh).snapshot(), body.snapshot());
    assert_eq!(report(build(mesh)).0, VolumeMeasure::Mesh);
    let expected = report(body);
    assert_eq!(expected.0, VolumeMeasure::Mesh);
    for options in [VolumeOptions::off(), mesh, VolumeMeasure::Lattice.into()] {
        let mut body = build(options);
        body.restore(&broken).unwrap();
        assert_eq!(body.volume_options(), mesh);
        // And back again.
        body.set_volume(Preservation::Off).unwrap();
        body.restore(&whole).unwrap();
        assert_eq!((body.pieces(), body.volume_options()), (1, mesh));
        body.set_volume(Preservation::Off).unwrap();
        body.restore(&broken).unwrap();
        assert_eq!(report(body), expected);
    }
}
