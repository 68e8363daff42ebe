//! Reads the animations of a scene. Bodies and colliders of one file share its positions.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use super::error::RunError;
use crate::frames::read_pc2;
use crate::obj::{Document, Part};
use crate::scene::{BodyData, HandleData, Scene};
use supple::{AnimationError, CollisionMesh, MeshAnimation};

/// The animations of a scene that were read so far.
pub(super) struct Animations<'a> {
    scene: &'a Scene,
    /// By their paths.
    files: HashMap<PathBuf, MeshAnimation>,
    /// Those of objects of a file, by the paths of the animation and the mesh, and the name of the object.
    parts: HashMap<(PathBuf, PathBuf, String), MeshAnimation>,
}

/// Why an animation cannot be used.
enum Fault {
    File(io::Error),
    Invalid(AnimationError),
}

impl<'a> Animations<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self { scene, files: HashMap::new(), parts: HashMap::new() }
    }

    /// Returns the animation of a file. Its frames are those of the scene.
    fn read(&mut self, path: &Path) -> Result<MeshAnimation, Fault> {
        if let Some(animation) = self.files.get(path) {
            return Ok(animation.clone());
        }
        let cache = read_pc2(path).map_err(Fault::File)?;
        let seconds = |frames: f64| frames / self.scene.simulation.fps;
        let (start, interval) = (seconds(cache.first_frame), seconds(cache.frames_per_sample));
        let animation = MeshAnimation::new(cache.positions, cache.points, start, interval);
        let animation = animation.map_err(Fault::Invalid)?;
        self.files.insert(path.to_owned(), animation.clone());
        Ok(animation)
    }

    /// Returns the mesh of a collider with the animation of a file. `key` is the key of the file.
    pub(super) fn collider(
        &mut self,
        mesh: &CollisionMesh,
        path: &Path,
        key: String,
    ) -> Result<CollisionMesh, RunError> {
        let path = self.scene.resolve(path);
        let animated = match self.read(&path) {
            Ok(animation) => CollisionMesh::animated(mesh.mesh().clone(), animation),
            Err(Fault::Invalid(fault)) => Err(fault.into()),
            Err(Fault::File(source)) => return Err(RunError::Animation { key, path, source }),
        };
        animated.map_err(|source| RunError::ColliderMesh { key, path, source })
    }

    /// Returns the animation that a handle follows. `key` is the key of the file.
    pub(super) fn handle(
        &mut self,
        (body, handle): (&BodyData, &HandleData),
        input: (&Document, &Part),
        (path, key): (&Path, String),
    ) -> Result<MeshAnimation, RunError> {
        let path = self.scene.resolve(path);
        let timed = self.part(body, input, &path).and_then(|animation| {
            let fps = handle.follow_fps.unwrap_or(self.scene.simulation.fps);
            let (start, interval) = (animation.start(), animation.interval());
            let interval = interval * self.scene.simulation.fps / fps;
            let start = handle.follow_start.unwrap_or(start * self.scene.simulation.fps / fps);
            animation.timed(start, interval).map_err(Fault::Invalid)
        });
        timed.map_err(|fault| match fault {
            Fault::File(source) => RunError::Animation { key, path, source },
            Fault::Invalid(source) => RunError::HandleAnimation { key, path, source },
        })
    }

    /// Returns the animation of a body. If the body is an object of a file, the animation may have all vertices of the
    /// file.
    fn part(
        &mut self,
        body: &BodyData,
        (document, part): (&Document, &Part),
        path: &Path,
    ) -> Result<MeshAnimation, Fault> {
        let whole = self.read(path)?;
        let (found, vertices) = (whole.vertices(), part.mesh().vertices().len());
        match &body.object {
            _ if found == vertices => Ok(whole),
            Some(object) if found == document.vertex_count() => {
                let key = (path.to_owned(), self.scene.resolve(&body.mesh), object.clone());
                if let Some(animation) = self.parts.get(&key) {
                    return Ok(animation.clone());
                }
                let samples = whole.positions().chunks_exact(found);
                let of_part = |sample: &[[f32; 3]]| -> Vec<[f32; 3]> {
                    part.vertices().map(|vertex| sample[vertex as usize]).collect()
                };
                let positions = samples.flat_map(of_part).collect();
                let animation = MeshAnimation::new(positions, vertices, whole.start(), whole.interval());
                let animation = animation.map_err(Fault::Invalid)?;
                self.parts.insert(key, animation.clone());
                Ok(animation)
            }
            _ => Err(Fault::Invalid(AnimationError::Vertices { found, vertices })),
        }
    }
}
