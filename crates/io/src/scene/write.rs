//! A scene as TOML: what [`Scene::parse`] reads back as the same scene.

use std::fmt::{Display, Write};
use std::path::Path;

use super::data::{BodyData, Scene, Substeps};
use supple::dynamics::{Key, Selection, Window};
use supple::volume::VolumeOptions;
use supple::{Damping, RegionSize, Resolution, Shape, Stiffness};

impl Scene {
    /// The scene as TOML, with every key that has a value, defaults too. [`Scene::base`] is not in it.
    pub fn to_toml(&self) -> String {
        let mut out = Writer(String::new());
        let simulation = &self.simulation;
        out.header("[simulation]");
        out.key("frames", simulation.frames);
        out.key("fps", number(simulation.fps));
        match simulation.substeps {
            Substeps::Fixed(steps) => out.key("substeps", steps),
            Substeps::Auto => out.key("substeps", "\"auto\""),
        }
        out.key("gravity", vector(simulation.gravity));
        out.key("threads", simulation.threads);
        out.header("[output]");
        out.key("directory", path(&self.output.directory));
        out.key("format", text(self.output.format.name()));
        for body in &self.bodies {
            out.body(body);
        }
        for collider in &self.colliders {
            out.header("[[collider]]");
            let (name, shape) = shape(&collider.shape);
            out.key(name, shape);
            out.key("friction", number(collider.friction));
            out.key("restitution", number(collider.restitution));
            if !collider.keys.is_empty() {
                out.key("keys", keys(&collider.keys));
            }
        }
        out.0
    }
}

struct Writer(String);

impl Writer {
    fn header(&mut self, header: &str) {
        if !self.0.is_empty() {
            self.0.push('\n');
        }
        self.0.push_str(header);
        self.0.push('\n');
    }

    fn key(&mut self, key: &str, value: impl Display) {
        // Writing to a string does not fail.
        let _ = writeln!(self.0, "{key} = {value}");
    }

    fn body(&mut self, body: &BodyData) {
        self.header("[[body]]");
        self.key("name", text(&body.name));
        self.key("mesh", path(&body.mesh));
        if let Some(object) = &body.object {
            self.key("object", text(object));
        }
        self.key("scale", number(body.scale));
        self.key("rotate", vector(body.placement.rotate));
        self.key("translate", vector(body.placement.translate));
        match body.resolution {
            Resolution::Vertices(count) => self.key("lattice_vertices", count),
            Resolution::CellSize(size) => self.key("cell_size", number(size)),
        }
        self.key("join", body.join);
        match body.material.region_size {
            RegionSize::Cells(cells) => self.key("half_width", cells),
            RegionSize::Radius(length) => self.key("stiffness_radius", number(length)),
        }
        match body.material.stiffness {
            Stiffness::PerStep(alpha) => self.key("stiffness", number(alpha)),
            Stiffness::Frequency(frequency) => self.key("frequency", number(frequency)),
        }
        match body.material.damping {
            Damping::PerStep(share) => self.key("damping", number(share)),
            Damping::Rate(rate) => self.key("damping_rate", number(rate)),
        }
        self.key("density", number(body.material.density));
        let VolumeOptions { measure, scope, field, max_correction } = body.volume;
        let (measure, scope, field) = (text(measure.name()), text(scope.name()), text(field.name()));
        let cap = number(max_correction);
        self.key(
            "volume",
            format_args!(
                "{{ measure = {measure}, scope = {scope}, field = {field}, max_correction = {cap} }}"
            ),
        );
        self.key("velocity", vector(body.placement.velocity));
        self.key("spin", vector(body.placement.spin));
        for pin in &body.pins {
            self.header("[[body.pin]]");
            self.held(&pin.selection, pin.window);
        }
        for handle in &body.handles {
            self.header("[[body.handle]]");
            self.held(&handle.selection, handle.window);
            self.key("keys", keys(&handle.keys));
        }
    }

    fn held(&mut self, selection: &Selection, window: Window) {
        match *selection {
            Selection::Box { min, max } => {
                let (min, max) = (vector(min), vector(max));
                self.key("box", format_args!("{{ min = {min}, max = {max} }}"));
            }
            Selection::Sphere { center, radius } => self.key("sphere", sphere(center, radius)),
            Selection::Plane { point, normal } => self.key("plane", plane(point, normal)),
            Selection::Vertices(ref vertices) => self.key("vertices", format_args!("{vertices:?}")),
        }
        self.key("from", number(window.from));
        if window.until.is_finite() {
            self.key("until", number(window.until));
        }
    }
}

/// The key and the value of a collider's shape.
fn shape(shape: &Shape) -> (&'static str, String) {
    match *shape {
        Shape::Plane { point, normal } => ("plane", plane(point, normal)),
        Shape::Sphere { center, radius } => ("sphere", sphere(center, radius)),
        Shape::Box { center, half_extents, rotate } => {
            let (center, half, rotate) = (vector(center), vector(half_extents), vector(rotate));
            ("box", format!("{{ center = {center}, half_extents = {half}, rotate = {rotate} }}"))
        }
        Shape::Capsule { a, b, radius } => {
            let (a, b, radius) = (vector(a), vector(b), number(radius));
            ("capsule", format!("{{ a = {a}, b = {b}, radius = {radius} }}"))
        }
    }
}

fn plane(point: [f64; 3], normal: [f64; 3]) -> String {
    format!("{{ point = {}, normal = {} }}", vector(point), vector(normal))
}

fn sphere(center: [f64; 3], radius: f64) -> String {
    format!("{{ center = {}, radius = {} }}", vector(center), number(radius))
}

fn keys(keys: &[Key]) -> String {
    let key = |key: &Key| {
        let (time, translate, rotate) = (number(key.time), vector(key.translate), vector(key.rotate));
        format!("    {{ time = {time}, translate = {translate}, rotate = {rotate} }},\n")
    };
    format!("[\n{}]", keys.iter().map(key).collect::<String>())
}

/// The shortest text that reads back as the same number; TOML's floats are Rust's.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn vector(value: [f64; 3]) -> String {
    let [x, y, z] = value.map(number);
    format!("[{x}, {y}, {z}]")
}

fn path(value: &Path) -> String {
    text(&value.to_string_lossy())
}

fn text(value: &str) -> String {
    toml::Value::String(value.to_owned()).to_string()
}
