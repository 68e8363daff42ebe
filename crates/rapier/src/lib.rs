//! Soft bodies of supple in a world of [Rapier](https://rapier.rs), coupled both ways.
//!
//! A [`SoftWorld`] has the soft bodies, a `PhysicsWorld` of Rapier the rigid ones. [`SoftWorld::step`] makes one step
//! of each: the soft bodies touch the colliders of Rapier, and the dynamic bodies of Rapier get the opposite impulses.
//!
//! `docs/rapier.md` in the repository has a program, and describes the coupling.
//!
//! | file | contents |
//! |---|---|
//! | `convert` | vectors, poses and masses of Rapier in f64 |
//! | `error` | errors |
//! | `shapes` | shapes of Rapier as colliders and as meshes |
//! | `entries` | the colliders of a Rapier world, and whether they changed |
//! | `obstacles` | fixed and kinematic colliders |
//! | `coupled_body` | a dynamic body: its motion before the step, its impulse after it |
//! | `coupled_bodies` | the dynamic bodies that are near soft bodies |
//! | `soft_world` | [`SoftWorld`] |

mod convert;
mod coupled_bodies;
mod coupled_body;
mod entries;
mod error;
mod obstacles;
mod shapes;
mod soft_world;

pub use error::Error;
pub use rapier3d;
pub use soft_world::SoftWorld;

/// The program of the page of the bridge.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/rapier.md")]
struct Page;
