//! The gripper of the example.

#[path = "../../examples/gripper.rs"]
mod scene;

use scene::{Gripper, LIFT};

/// Steps until the end of the lift and half a second after.
fn lifted(threads: usize) -> (Gripper, f64, f64) {
    let mut gripper = Gripper::new(threads).unwrap();
    (0..144).for_each(|_| gripper.step().unwrap());
    let (ball, fingers) = (gripper.ball_height(), gripper.finger_height());
    (144..528).for_each(|_| gripper.step().unwrap());
    (gripper, ball, fingers)
}

#[test]
fn the_gripper_lifts_and_holds_the_ball_with_the_same_bits_for_any_number_of_threads() {
    let (gripper, ball, fingers) = lifted(1);
    let rise = gripper.ball_height() - ball;
    let carried = gripper.finger_height() - fingers;
    // The weight of all moving parts, 72 N, lengthens the spring of the motor by less than 1 mm, at the start as at the
    // end; the weight of the ball, 20 N, by 0.2 mm.
    assert!((carried - f64::from(LIFT)).abs() < 1e-3, "{carried}");
    // The weight of the ball shears it. Each finger presses it with 40 N to a contact with the radius a = 36 mm
    // (Hertz), whose tangential stiffness 8 a G/(2 - ν) is 3200 N/m (Mindlin): 3 mm by half of the weight. On the
    // ground the ball was flattened so that its center was at 86 mm; its lower half falls back by less than a half of
    // these 14 mm.
    assert!((rise - carried).abs() < 1e-2, "{rise} {carried}");
    let (other, ..) = lifted(2);
    let positions = |gripper: &Gripper| gripper.soft.bodies()[0].positions();
    assert_eq!(positions(&gripper), positions(&other));
    let poses = |gripper: &Gripper| gripper.fingers.map(|finger| *gripper.world.bodies[finger].position());
    assert_eq!(poses(&gripper), poses(&other));
}
