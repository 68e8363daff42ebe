//! The functions that the page calls.

use supple::{Display, Elasticity, Simulation, Substeps};
#[cfg(target_family = "wasm")]
use wasm_bindgen::prelude::wasm_bindgen;

use crate::error::PlaygroundError;
use crate::grab::{Base, Grab};
use crate::model::Model;
use crate::settings::Settings;

/// A soft body on a floor, which pointers drag.
///
/// Lengths are in m, times in seconds. The body stands at the origin, its longest side is 1 m, and +y is up. Arrays of
/// positions and normals are in linear memory, three 32-bit floats for each vertex. Their addresses are valid until the
/// next call of [`Playground::reset`] or [`Playground::apply`].
#[cfg_attr(target_family = "wasm", wasm_bindgen)]
#[derive(Debug)]
pub struct Playground {
    model: Model,
    settings: Settings,
    simulation: Simulation,
    /// Positions of the lattice vertices in the start pose.
    start: Vec<[f64; 3]>,
    base: Base,
    grabs: Vec<Grab>,
    display: Display,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    lattice_positions: Vec<[f32; 3]>,
    /// Rest volume in the start pose, before the body is inflated.
    start_volume: f64,
    /// Volume at rest, before the correction and after it.
    volumes: [f64; 3],
}

#[cfg_attr(target_family = "wasm", wasm_bindgen)]
impl Playground {
    /// Reads a model file from its bytes, and builds the body. Messages name the file `name`.
    ///
    /// # Errors
    ///
    /// A file that is not a valid model, with the line or element; or a body that cannot be built.
    pub fn new(name: &str, bytes: Vec<u8>, settings: &Settings) -> Result<Playground, PlaygroundError> {
        show_panics();
        let (model, settings) = (Model::read(name, bytes)?, *settings);
        let (simulation, start, base) = prepare(&model, &settings)?;
        let vertices = model.mesh().vertices().len();
        let mut playground = Self {
            lattice_positions: vec![[0.0; 3]; start.len()],
            positions: vec![[0.0; 3]; vertices],
            normals: vec![[0.0; 3]; vertices],
            start_volume: 0.0,
            volumes: [0.0; 3],
            display: Display::new(),
            grabs: Vec::new(),
            model,
            settings,
            simulation,
            start,
            base,
        };
        playground.evaluate_start();
        Ok(playground)
    }

    /// Puts the body back to its start, at rest, and evaluates the surface. Pointers let go.
    ///
    /// # Errors
    ///
    /// A body that cannot be built. The old one then goes on.
    pub fn reset(&mut self) -> Result<(), PlaygroundError> {
        self.rebuild(self.settings)
    }

    /// Changes the settings. Another number of lattice vertices, or another axis, resets the body.
    ///
    /// # Errors
    ///
    /// A number out of range, or a body that cannot be built.
    pub fn apply(&mut self, settings: &Settings) -> Result<(), PlaygroundError> {
        let (old, new) = (self.settings, *settings);
        if (new.lattice_vertices, new.up) != (old.lattice_vertices, old.up) {
            return self.rebuild(new);
        }
        let body = self.simulation.body_mut(0);
        if new.poisson_ratio != old.poisson_ratio {
            body.set_poisson_ratio(Some(new.poisson_ratio)).map_err(supple::Error::from)?;
        }
        if new.inflate != old.inflate {
            body.set_inflate(new.inflate).map_err(supple::Error::from)?;
        }
        if new.material != old.material {
            body.set_elasticity(Elasticity::Preset(new.material)).map_err(supple::Error::from)?;
        }
        if new.volume != old.volume {
            body.set_volume(new.preservation()).map_err(supple::Error::from)?;
        }
        self.base.set_held(body, new.base)?;
        if new.floor != old.floor {
            self.simulation.set_colliders(&new.colliders())?;
        }
        if new.wind != old.wind {
            self.simulation.set_fields(new.fields())?;
        }
        if new.gravity != old.gravity {
            self.simulation.set_gravity(new.acceleration())?;
        }
        self.simulation.set_substeps(Substeps::Auto)?;
        self.settings = new;
        Ok(())
    }

    /// Lets a pointer grab the part of the body around a point of the start pose.
    ///
    /// # Errors
    ///
    /// Fails if the handle cannot be built, as with a `grip` out of range.
    pub fn grab(&mut self, pointer: u32, x: f64, y: f64, z: f64) -> Result<(), PlaygroundError> {
        self.release(pointer)?;
        let goal = self.settings.goal();
        self.grabs.push(Grab::new(pointer, &mut self.simulation, (&self.start, [x, y, z]), goal)?);
        Ok(())
    }

    /// Sets the displacement of the part that a pointer grabs from the place where it was grabbed.
    ///
    /// # Errors
    ///
    /// A pointer that grabs nothing.
    pub fn drag(&mut self, pointer: u32, x: f64, y: f64, z: f64) -> Result<(), PlaygroundError> {
        let grab = self.grabs.iter_mut().find(|grab| grab.pointer == pointer);
        grab.ok_or(PlaygroundError::NotGrabbed(pointer))?.target = [x, y, z];
        Ok(())
    }

    /// Lets a pointer let go. Has no effect if it grabs nothing.
    ///
    /// # Errors
    ///
    /// Fails if the handle cannot be removed.
    pub fn release(&mut self, pointer: u32) -> Result<(), PlaygroundError> {
        if let Some(place) = self.grabs.iter().position(|grab| grab.pointer == pointer) {
            self.grabs.swap_remove(place).release(&mut self.simulation)?;
        }
        Ok(())
    }

    /// Advances by frames of 1/60 s. The grabbed parts are at the places of their pointers at the end.
    ///
    /// # Errors
    ///
    /// A pointer that is too far away.
    pub fn advance(&mut self, frames: u32) -> Result<(), PlaygroundError> {
        for frame in 0..frames {
            let share = 1.0 / f64::from(frames - frame);
            for grab in &mut self.grabs {
                grab.follow(&mut self.simulation, share)?;
            }
            self.simulation.advance(1);
        }
        Ok(())
    }

    /// Evaluates the displayed surface: corrects the volume, and writes positions and normals.
    pub fn evaluate(&mut self) {
        let mut displayed = self.display.evaluate(self.simulation.body(0));
        displayed.surface_into(&mut self.positions, Some(&mut self.normals));
        for (row, position) in self.lattice_positions.iter_mut().zip(displayed.positions()) {
            *row = [position.x as f32, position.y as f32, position.z as f32];
        }
        let corrections = displayed.corrections();
        self.volumes = if corrections.is_empty() {
            let report = displayed.volume_report();
            [report.rest, report.before, report.after]
        } else {
            corrections.iter().fold([0.0; 3], |[rest, before, after], component| {
                [rest + component.rest, before + component.before, after + component.after]
            })
        };
    }

    /// Returns whether the body is at rest, so that steps change nothing.
    pub fn is_at_rest(&self) -> bool {
        self.simulation.body(0).is_asleep()
    }

    /// Returns the relative error of the volume of the displayed surface.
    pub fn volume_error(&self) -> f64 {
        let [rest, _, after] = self.volumes;
        after / rest - 1.0
    }

    /// Returns the relative error of the volume before the correction.
    pub fn volume_error_before(&self) -> f64 {
        let [rest, before, _] = self.volumes;
        before / rest - 1.0
    }

    /// Returns the ratio of the rest volume to that of the model, as of the last step: 1 before the first one.
    pub fn rest_volume_ratio(&self) -> f64 {
        self.volumes[0] / self.start_volume
    }

    /// Returns whether the mesh is closed. The volume of an open one is that of the lattice cells.
    pub fn is_closed(&self) -> bool {
        self.model.mesh().is_closed()
    }

    /// Returns the number of steps per frame.
    pub fn steps_per_frame(&self) -> u32 {
        self.simulation.substeps() as u32
    }

    /// Returns the number of lattice vertices.
    pub fn lattice_vertices(&self) -> u32 {
        self.start.len() as u32
    }

    /// Returns the number of mesh vertices.
    pub fn mesh_vertices(&self) -> u32 {
        self.positions.len() as u32
    }

    /// Returns the address of the positions of the mesh vertices.
    pub fn positions(&self) -> *const f32 {
        self.positions.as_ptr().cast()
    }

    /// Returns the address of the unit normals of the mesh vertices.
    pub fn normals(&self) -> *const f32 {
        self.normals.as_ptr().cast()
    }

    /// Returns the address of the positions of the lattice vertices, after the volume correction.
    pub fn lattice_positions(&self) -> *const f32 {
        self.lattice_positions.as_ptr().cast()
    }

    /// Returns the numbers of corners of the faces.
    pub fn face_sizes(&self) -> Vec<u32> {
        self.model.mesh().faces().map(|face| face.len() as u32).collect()
    }

    /// Returns the vertices at the corners of all faces.
    pub fn face_corners(&self) -> Vec<u32> {
        self.model.mesh().faces().flatten().copied().collect()
    }

    /// Returns the corners of the triangles of all faces.
    pub fn triangles(&self) -> Vec<u32> {
        self.model.mesh().triangles().as_flattened().to_vec()
    }

    /// Returns for each mesh vertex the first one at the same position.
    pub fn weld(&self) -> Vec<u32> {
        self.model.mesh().weld().to_vec()
    }

    /// Returns the ends of the links of the lattice.
    pub fn links(&self) -> Vec<u32> {
        let body = self.simulation.body(0);
        let lattice = body.lattice();
        let ends = |vertex: u32| {
            let neighbors = lattice.neighbors(vertex).into_iter().flatten();
            neighbors.filter(move |&other| other > vertex).flat_map(move |other| [vertex, other])
        };
        (0..lattice.len() as u32).flat_map(ends).collect()
    }
}

impl Playground {
    /// Returns the positions of the mesh vertices, for programs in Rust.
    pub fn surface(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Builds the body anew.
    fn rebuild(&mut self, settings: Settings) -> Result<(), PlaygroundError> {
        (self.simulation, self.start, self.base) = prepare(&self.model, &settings)?;
        self.settings = settings;
        self.display = Display::new();
        self.grabs.clear();
        self.lattice_positions = vec![[0.0; 3]; self.start.len()];
        self.evaluate_start();
        Ok(())
    }

    /// Evaluates the surface before the first step.
    fn evaluate_start(&mut self) {
        self.evaluate();
        self.start_volume = self.volumes[0];
    }
}

/// Builds the simulation of a model. Returns it with the positions of its lattice vertices, and with its base.
fn prepare(model: &Model, settings: &Settings) -> Result<(Simulation, Vec<[f64; 3]>, Base), PlaygroundError> {
    let mut simulation = settings.simulation(model)?;
    let body = simulation.body_mut(0);
    let start: Vec<[f64; 3]> = body.positions().into_iter().map(Into::into).collect();
    let base = Base::new(body, &start, settings.base)?;
    // A body that is held may need more steps.
    simulation.set_substeps(Substeps::Auto)?;
    Ok((simulation, start, base))
}

/// Gives JavaScript the message of a panic. Without it an `Error` says `unreachable`.
fn show_panics() {
    #[cfg(target_family = "wasm")]
    std::panic::set_hook(Box::new(|panic| wasm_bindgen::throw_str(&panic.to_string())));
}
