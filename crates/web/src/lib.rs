//! The part of the page to play with that runs as WebAssembly: one soft body that is dragged.
//!
//! [`Playground`] has the functions that the page calls. It converts between the browser and [`supple`], and contains
//! no part of the method. The page itself is in the folder `page`; `scripts/web` builds both.
//!
//! * `model`: the mesh of a model file, and its place in the scene.
//! * `settings`: the choices that the page offers, and the simulation that they give.
//! * `grab`: a part of the body that follows a pointer.
//! * `playground`: the functions for the page.
//! * `error`: errors, with the message that the page shows.

mod error;
mod grab;
mod model;
mod playground;
mod settings;

pub use error::PlaygroundError;
pub use playground::Playground;
pub use settings::Settings;
