//! States of simulations as bytes: `supple_io::saved_state`.

use supple::{Body, Collider, Field, FieldLaw, Simulation, Touched};
use supple_io::saved_state::{SavedStateError, restore, save};

use supple_tests::half_cells;

/// Returns blocks that fall on each other and on the ground.
fn pile(count: u32, threads: usize) -> Simulation {
    let ground = Collider::plane([0.0, 1.95, 0.0], [0.0, 1.0, 0.0]);
    let builder = Simulation::builder().fps(60.0).threads(threads).collider(ground);
    let blocks = (0..count).map(|index| {
        let body = Body::from_lattice(half_cells()).name(format!("block{index}"));
        body.translate([0.0, 1.6 * f64::from(index), 0.0]).build().unwrap()
    });
    blocks.fold(builder, |builder, body| builder.body(body)).build().unwrap()
}

#[test]
fn a_restored_simulation_has_the_same_bytes_and_continues_with_the_same_bits() {
    let (mut simulation, mut fork) = (pile(3, 1), pile(3, 2));
    simulation.advance(20);
    assert!(simulation.contacts().iter().any(|contact| contact.body == 0));
    let bytes = save(&simulation);
    simulation.advance(10);
    let later = save(&simulation);
    assert_ne!(later, bytes);
    for restored in [&mut simulation, &mut fork] {
        restore(restored, &bytes).unwrap();
        assert_eq!(save(restored), bytes);
        restored.advance(10);
        assert_eq!(save(restored), later);
    }
}

/// Contacts are those of the last step, also of bodies that sleep on, and fields those of the state.
#[test]
fn a_restored_simulation_has_its_contacts_and_fields() {
    let mut simulation = pile(3, 1);
    simulation.set_fields(vec![Field::new(FieldLaw::Drag(0.5))]).unwrap();
    simulation.advance(20);
    let (contacts, bytes) = (simulation.contacts(), save(&simulation));
    let fields = simulation.fields().to_vec();
    assert!(contacts.len() > 3);
    simulation.set_fields(Vec::new()).unwrap();
    simulation.advance(5);
    restore(&mut simulation, &bytes).unwrap();
    assert_eq!((simulation.contacts(), simulation.fields()), (contacts.clone(), &fields[..]));
    simulation.step();
    assert_ne!(simulation.contacts(), contacts);
    while !simulation.bodies().iter().all(|body| body.is_asleep()) {
        simulation.advance(1);
        assert!(simulation.time() < 60.0, "the pile falls asleep");
    }
    let (contacts, bytes) = (simulation.contacts(), save(&simulation));
    restore(&mut simulation, &bytes).unwrap();
    simulation.steps(3);
    assert_eq!(simulation.contacts(), contacts);
}

/// Restored contacts, fields and the choice of steps follow the removal of a body.
#[test]
fn a_removed_body_leaves_neither_contacts_nor_fields() {
    let mut simulation = pile(3, 1);
    let of_all = Field::new(FieldLaw::Drag(0.1));
    let of_one = Field { bodies: vec!["block1".to_owned()], ..Field::new(FieldLaw::Drag(0.5)) };
    simulation.set_fields(vec![of_one, of_all.clone()]).unwrap();
    let touches = |simulation: &Simulation| {
        simulation.contacts().iter().any(|contact| contact.body == 2 || contact.other == Touched::Body(2))
    };
    while !touches(&simulation) {
        simulation.advance(1);
        assert!(simulation.time() < 5.0, "the third block touches the second");
    }
    let state = simulation.state();
    simulation.restore(&state).unwrap();
    assert!(touches(&simulation));
    assert_eq!(simulation.remove_body(1).unwrap().name(), "block1");
    for contact in simulation.contacts() {
        assert!(contact.body < 2 && !matches!(contact.other, Touched::Body(2..)), "{contact:?}");
    }
    assert_eq!(simulation.fields(), [of_all]);
    simulation.step();
    let state = simulation.state();
    simulation.restore(&state).unwrap();
    simulation.reset();
    assert_eq!(simulation.time(), 0.0);
    assert!(simulation.chosen_substeps().is_none_or(|chosen| chosen.body < 2));
}

#[test]
fn damaged_bytes_and_states_of_other_simulations_change_nothing() {
    let (mut simulation, other) = (pile(2, 1), pile(3, 1));
    simulation.advance(3);
    let bytes = save(&simulation);
    let error = restore(&mut simulation, &save(&other)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "it is of another simulation: the state has 3 bodies, and this one 2; build the simulation with the same \
         bodies and colliders"
    );
    for length in (0..bytes.len()).step_by(97) {
        assert!(restore(&mut simulation, &bytes[..length]).is_err(), "{length}");
    }
    for at in (0..bytes.len()).step_by(89) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        let error = restore(&mut simulation, &damaged).unwrap_err();
        let is_expected = match at {
            0..8 => matches!(error, SavedStateError::NotAState),
            8..12 => matches!(error, SavedStateError::Version { .. }),
            _ => matches!(error, SavedStateError::Damaged),
        };
        assert!(is_expected, "{at}: {error}");
    }
    assert_eq!(save(&simulation), bytes);
}
