//! The mesh of a model file, and its place in the scene.

use std::path::Path;

use supple::{Body, BodyBuilder, Mesh};
use supple_io::model::{self, ModelError};

/// The direction that is up in a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Up {
    /// As in most OBJ and all glTF files.
    #[default]
    Y,
    /// As in most CAD programs.
    Z,
}

impl Up {
    /// All values with their names.
    pub(crate) const NAMED: [(&'static str, Self); 2] = [("y", Self::Y), ("z", Self::Z)];
}

/// A surface mesh. It is shown with a longest side of 1 m, whatever its own units are.
#[derive(Debug)]
pub(crate) struct Model {
    mesh: Mesh,
}

impl Model {
    /// Reads a model file from its bytes. Messages name the file `name`.
    pub(crate) fn read(name: &str, bytes: Vec<u8>) -> Result<Self, ModelError> {
        let mesh = model::from_bytes(Path::new(name), bytes)?.mesh(None)?;
        Ok(Self { mesh })
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Begins a body that stands in the center of the scene, its lowest point at `height` above the floor.
    pub(crate) fn body(&self, up: Up, height: f64) -> BodyBuilder {
        let (low, high) = self.mesh.bounds();
        let scale = 1.0 / (high - low).amax();
        let [low, high] = [low, high].map(|corner| corner * scale);
        let center = low + 0.5 * (high - low);
        // The rotation takes (x, y, z) to (x, z, -y).
        let (rotate, translate) = match up {
            Up::Y => ([0.0; 3], [-center.x, height - low.y, -center.z]),
            Up::Z => ([-90.0, 0.0, 0.0], [-center.x, height - low.z, center.y]),
        };
        Body::builder(self.mesh.clone()).scale(scale).rotate(rotate).translate(translate)
    }
}
