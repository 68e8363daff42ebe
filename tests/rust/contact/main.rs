//! Colliders, contact between bodies and of a body with itself, friction and swept collisions.

mod automatic_steps;
mod block_body;
mod blocks;
mod bodies;
mod collider;
mod driven_collider;
mod enabled;
mod energy;
mod friction;
mod inside_colliders;
mod mesh_colliders;
mod near_bodies;
mod pressed;
mod reaction;
mod samples;
mod swept;
mod thickness;
