//! The stage of a run: its bodies, materials and colliders.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

use nalgebra::Matrix4;
use supple::Simulation;

use super::collider::{ColliderPrim, Transforms};
use super::kind::{FRAMES, FrameTable};
use super::layer::write_layer;
use super::layout::{ARRAY_HEAD, Layout, MATRIX, push_bounds, push_matrix, push_vectors};
use super::material::{Images, Materials};
use super::name::Names;
use super::package::Packed;
use super::pieces::Places;
use super::prim::{Prim, Stored, Value, token};
use super::surface::{BodyInput, Surface};
use super::surface_pieces::SurfacePieces;
use crate::space::{FileSpace, Up};

/// The prim that contains all others.
const ROOT: &str = "World";

/// The data of a stage that are the same in all frames, and the places of the others in a frame.
#[derive(Debug)]
pub(crate) struct Stage {
    description: StageDescription,
    bodies: Vec<Surface>,
    colliders: Vec<ColliderPrim>,
    layout: Layout,
}

/// What a stage says about itself.
#[derive(Clone, Debug)]
pub(crate) struct StageDescription {
    /// Directory of the file; images are found from it.
    pub(crate) directory: PathBuf,
    /// Coordinates of the file.
    pub(crate) space: FileSpace,
    /// Meters per unit of length of the file.
    pub(crate) meters_per_unit: f64,
    /// Frames per second.
    pub(crate) fps: f64,
    /// Number of the first frame.
    pub(crate) first: u64,
    /// Interval between frames, at least 1.
    pub(crate) every: u64,
    /// Whether the images are in a package with the stage.
    pub(crate) is_packed: bool,
    /// Whether the bodies have velocities.
    pub(crate) has_velocities: bool,
}

impl Stage {
    /// Describes a simulation. `inputs` has one entry per body.
    pub(crate) fn new(
        simulation: &Simulation,
        inputs: impl Iterator<Item = BodyInput>,
        description: StageDescription,
    ) -> Self {
        let mut layout = Layout::default();
        let has_velocities = description.has_velocities;
        let bodies = simulation.bodies().iter().zip(inputs);
        let bodies = bodies
            .map(|(body, input)| Surface::new(body.name(), input, has_velocities, &mut layout))
            .collect();
        let shapes =
            (0..simulation.collider_count()).map(|index| &simulation.collider(index).description().shape);
        let colliders = shapes.map(|shape| ColliderPrim::new(shape, &mut layout)).collect();
        Self { description, bodies, colliders, layout }
    }

    /// Returns the size of a frame, in bytes.
    pub(crate) fn frame_bytes(&self) -> u64 {
        self.layout.bytes()
    }

    /// Returns the bodies.
    pub(crate) fn bodies(&self) -> &[Surface] {
        &self.bodies
    }

    /// Appends the next body to a frame: its positions in the coordinates of the file, and its velocities and normals if it
    /// has any. `bounded`: the positions within its bounds.
    pub(crate) fn push_body(
        &self,
        frame: &mut Vec<u8>,
        positions: &[[f32; 3]],
        bounded: &[[f32; 3]],
        velocities: Option<&[[f32; 3]]>,
        normals: Option<impl ExactSizeIterator<Item = [f32; 3]>>,
    ) {
        push_vectors(frame, positions.iter().copied());
        push_bounds(frame, bounded);
        if let Some(velocities) = velocities {
            push_vectors(frame, velocities.iter().copied());
        }
        if let Some(normals) = normals {
            push_vectors(frame, normals);
        }
    }

    /// Appends the colliders to a frame, after all bodies.
    pub(crate) fn push_colliders(&self, frame: &mut Vec<u8>, simulation: &Simulation) {
        for (index, collider) in self.colliders.iter().enumerate() {
            push_matrix(frame, &collider.matrix(simulation, index, self.description.space));
            if let Some((count, ..)) = collider.animated {
                let mut positions = collider.positions(simulation.time());
                positions.resize(count, [0.0; 3]);
                push_vectors(frame, positions.iter().copied());
                push_bounds(frame, &positions);
            }
        }
    }

    /// Completes a file that has the beginning and `count` frames. Returns the images of its package.
    pub(crate) fn complete(&self, file: &mut (impl Read + Write + Seek), count: u64) -> io::Result<Packed> {
        let StageDescription { first, every, .. } = self.description;
        let times: Vec<f64> = (0..count).map(|frame| (first + frame * every) as f64).collect();
        let places =
            Places::find(file, self.frame_bytes(), count)?.map_err(|_| io::ErrorKind::InvalidData)?;
        let (root, packed) = self.root(file, &times, &places)?;
        let frames = FrameTable { starts: &places.starts, end: places.end, times: &times };
        write_layer(&mut io::BufWriter::new(file), &root, frames)?;
        Ok(packed)
    }

    /// Returns the stage with the metadata of the file, and the images of its package.
    fn root(
        &self,
        file: &mut (impl Read + Seek),
        times: &[f64],
        places: &Places,
    ) -> io::Result<(Prim, Packed)> {
        let StageDescription { space, meters_per_unit, fps, directory, is_packed, .. } = &self.description;
        let mut names = Names::default();
        let world = names.unique(ROOT);
        let mut inside = Names::default();
        // Bodies keep their names; the other prims get different ones.
        let materials_name = self.scope_name("Materials");
        let materials_path = format!("/{world}/{materials_name}");
        let images = if *is_packed { Images::Packed(Packed::default()) } else { Images::Beside(directory) };
        let mut materials = Materials::new(&materials_path, images);
        let mut children: Vec<Prim> = self
            .bodies
            .iter()
            .enumerate()
            .map(|(index, body)| {
                let pieces = SurfacePieces::new(places, index);
                body.prim(&mut inside, &mut materials, pieces.as_ref())
            })
            .collect();
        let packed = materials.images.into_packed();
        if !materials.prims.is_empty() {
            let mut scope = Prim::new("Scope", &materials_name, &mut inside);
            scope.children = materials.prims;
            children.push(scope);
        }
        let colliders = self.collider_prims(file, &places.starts)?;
        if !colliders.is_empty() {
            let mut scope = Prim::new("Scope", "Colliders", &mut inside);
            scope.children = colliders;
            children.push(scope);
        }
        let up = match space.up() {
            Up::Y => "Y",
            Up::Z => "Z",
        };
        let time = |time: Option<&f64>| Value::Double(time.copied().unwrap_or_default());
        let mut root =
            Prim { name: String::new(), metadata: Vec::new(), properties: Vec::new(), children: Vec::new() }
                .with("defaultPrim", token(&world))
                .with("upAxis", token(up))
                .with("metersPerUnit", Value::Double(*meters_per_unit))
                .with("startTimeCode", time(times.first()))
                .with("endTimeCode", time(times.last()))
                .with("timeCodesPerSecond", Value::Double(*fps))
                .with("framesPerSecond", Value::Double(*fps));
        let mut world = Prim::new("Xform", &world, &mut Names::default()).with("kind", token("component"));
        world.children = children;
        root.children.push(world);
        Ok((root, packed))
    }

    /// Returns a name that no body has.
    fn scope_name(&self, name: &str) -> String {
        let mut names = Names::default();
        self.bodies.iter().for_each(|body| drop(names.unique(body.name())));
        names.unique(name)
    }

    fn collider_prims(&self, file: &mut (impl Read + Seek), starts: &[u64]) -> io::Result<Vec<Prim>> {
        let mut names = Names::default();
        let bounds = if starts.is_empty() { None } else { self.first_bounds(file)? };
        let mut prims = Vec::new();
        for collider in &self.colliders {
            let matrices = starts.iter().map(|&start| read_matrix(file, start, collider.matrix));
            let transforms = Transforms::new(&matrices.collect::<io::Result<Vec<_>>>()?, starts);
            prims.extend(transforms.map(|transforms| collider.prim(&mut names, &transforms, bounds)));
        }
        Ok(prims)
    }

    /// Returns the bounds of all bodies in the first frame.
    fn first_bounds(&self, file: &mut (impl Read + Seek)) -> io::Result<Option<[[f32; 3]; 2]>> {
        let mut union: Option<[[f32; 3]; 2]> = None;
        for body in &self.bodies {
            let mut bytes = [0; 24];
            file.seek(SeekFrom::Start(FRAMES + body.bounds.at + ARRAY_HEAD))?;
            file.read_exact(&mut bytes)?;
            let (numbers, _) = bytes.as_chunks::<4>();
            let corner = |k: usize| std::array::from_fn(|axis| f32::from_le_bytes(numbers[3 * k + axis]));
            let [low, high]: [[f32; 3]; 2] = [corner(0), corner(1)];
            union = Some(union.map_or([low, high], |[least, most]| {
                [
                    std::array::from_fn(|axis| least[axis].min(low[axis])),
                    std::array::from_fn(|axis| most[axis].max(high[axis])),
                ]
            }));
        }
        Ok(union)
    }
}

fn read_matrix(file: &mut (impl Read + Seek), start: u64, stored: Stored) -> io::Result<Matrix4<f64>> {
    let mut bytes = [0; MATRIX as usize];
    file.seek(SeekFrom::Start(start + stored.at))?;
    file.read_exact(&mut bytes)?;
    Ok(Matrix4::from_iterator(bytes.as_chunks::<8>().0.iter().map(|number| f64::from_le_bytes(*number))))
}
