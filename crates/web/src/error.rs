//! Errors, with the message that the page shows.

use supple_io::model::ModelError;
#[cfg(target_family = "wasm")]
use wasm_bindgen::{JsError, JsValue};

/// Error of the playground. JavaScript gets an `Error` with the message.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlaygroundError {
    /// A file that is not a valid model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A body that cannot be built, or a number out of range.
    #[error(transparent)]
    Body(#[from] supple::Error),
    /// An unknown name of a setting.
    #[error("{setting} `{name}` is not known; use {known}")]
    Name {
        /// The setting.
        setting: &'static str,
        /// The unknown name.
        name: String,
        /// Known names.
        known: String,
    },
    /// A pointer that grabs no part.
    #[error("pointer {0} grabs no part of the body")]
    NotGrabbed(u32),
}

#[cfg(target_family = "wasm")]
impl From<PlaygroundError> for JsValue {
    fn from(error: PlaygroundError) -> Self {
        JsError::new(&error.to_string()).into()
    }
}
