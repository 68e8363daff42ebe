//! Tests of the coupling of soft bodies with a Rapier world.

mod colliders;
mod contact;
mod gripper;
mod momentum;
mod step;
mod support;
