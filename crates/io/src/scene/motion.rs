//! Pins, handles and colliders: selections, shapes and keys over time.

use super::error::SceneError;
use super::fields::{Field, Fields};
use super::range::Range;
use supple::dynamics::{Handle, Key, Pin, Selection, Window};
use supple::{Collider, Shape};

const SELECTIONS: [&str; 4] = ["box", "sphere", "plane", "vertices"];
const SHAPES: [&str; 4] = ["plane", "sphere", "box", "capsule"];

/// Reads one `[[body.pin]]`.
pub(super) fn read_pin(field: &Field<'_>) -> Result<Pin, SceneError> {
    let fields = Fields::new(field, &["box", "sphere", "plane", "vertices", "from", "until"])?;
    let selection = read_selection(&fields)?;
    Ok(Pin { selection, window: read_window(&fields)? })
}

/// Reads one `[[body.handle]]`.
pub(super) fn read_handle(field: &Field<'_>) -> Result<Handle, SceneError> {
    let fields = Fields::new(field, &["box", "sphere", "plane", "vertices", "keys", "from", "until"])?;
    let selection = read_selection(&fields)?;
    let window = read_window(&fields)?;
    let keys =
        read_keys(&fields.require("keys", "a list of poses, as [{ time = 1, translate = [0, 1, 0] }]")?)?;
    Ok(Handle { selection, keys, window })
}

/// Reads one `[[collider]]`.
pub(super) fn read_collider(field: &Field<'_>) -> Result<Collider, SceneError> {
    let known = ["plane", "sphere", "box", "capsule", "friction", "restitution", "keys"];
    let fields = Fields::new(field, &known)?;
    Ok(Collider {
        shape: read_shape(&fields)?,
        friction: fields.read_or("friction", 0.5, |field| field.number(Range::NotNegative))?,
        restitution: fields.read_or("restitution", 0.0, |field| field.number(Range::Unit))?,
        keys: fields.get("keys").map_or(Ok(Vec::new()), |field| read_keys(&field))?,
    })
}

fn read_selection(fields: &Fields<'_>) -> Result<Selection, SceneError> {
    let Some((kind, field)) = fields.one_of(&SELECTIONS)? else {
        return Err(fields.missing("box", "say what it takes by one of `box`, `sphere`, `plane`"));
    };
    match kind {
        0 => {
            let fields = Fields::new(&field, &["min", "max"])?;
            let min = fields.require("min", "the least corner, three numbers")?.vector()?;
            let corner = fields.require("max", "the greatest corner, three numbers")?;
            let max = corner.vector()?;
            if (0..3).any(|axis| min[axis] > max[axis]) {
                return Err(corner.out_of_range("at least `min` on every axis"));
            }
            Ok(Selection::Box { min, max })
        }
        1 => {
            let (center, radius) = read_sphere(&field)?;
            Ok(Selection::Sphere { center, radius })
        }
        2 => {
            let (point, normal) = read_plane(&field)?;
            Ok(Selection::Plane { point, normal })
        }
        _ => {
            let vertices = field.list("a list of lattice vertices, as [0, 5]")?;
            let vertices =
                vertices.iter().map(|vertex| vertex.count(0, u32::MAX)).collect::<Result<_, _>>()?;
            Ok(Selection::Vertices(vertices))
        }
    }
}

fn read_shape(fields: &Fields<'_>) -> Result<Shape, SceneError> {
    let Some((kind, field)) = fields.one_of(&SHAPES)? else {
        let hint = "give it a shape by one of `plane`, `sphere`, `box`, `capsule`";
        return Err(fields.missing("plane", hint));
    };
    match kind {
        0 => {
            let (point, normal) = read_plane(&field)?;
            Ok(Shape::Plane { point, normal })
        }
        1 => {
            let (center, radius) = read_sphere(&field)?;
            Ok(Shape::Sphere { center, radius })
        }
        2 => {
            let fields = Fields::new(&field, &["center", "half_extents", "rotate"])?;
            let extents = fields.require("half_extents", "half of each edge, three lengths")?;
            let half_extents = extents.vector()?;
            if half_extents.iter().any(|&half| half <= 0.0) {
                return Err(extents.out_of_range("three numbers above 0"));
            }
            let center = fields.require("center", "three numbers")?.vector()?;
            let rotate = fields.read_or("rotate", [0.0; 3], Field::vector)?;
            Ok(Shape::Box { center, half_extents, rotate })
        }
        _ => {
            let fields = Fields::new(&field, &["a", "b", "radius"])?;
            Ok(Shape::Capsule {
                a: fields.require("a", "one end of the axis, three numbers")?.vector()?,
                b: fields.require("b", "the other end of the axis, three numbers")?.vector()?,
                radius: fields.require("radius", "a length")?.number(Range::Positive)?,
            })
        }
    }
}

fn read_plane(field: &Field<'_>) -> Result<([f64; 3], [f64; 3]), SceneError> {
    let fields = Fields::new(field, &["point", "normal"])?;
    let point = fields.require("point", "a point of the plane, three numbers")?.vector()?;
    let normal = fields.require("normal", "a direction, three numbers")?.direction()?;
    Ok((point, normal))
}

fn read_sphere(field: &Field<'_>) -> Result<([f64; 3], f64), SceneError> {
    let fields = Fields::new(field, &["center", "radius"])?;
    let center = fields.require("center", "three numbers")?.vector()?;
    let radius = fields.require("radius", "a length")?.number(Range::Positive)?;
    Ok((center, radius))
}

/// `from` and `until`, in order.
fn read_window(fields: &Fields<'_>) -> Result<Window, SceneError> {
    let default = Window::default();
    let from = fields.read_or("from", default.from, |field| field.number(Range::NotNegative))?;
    let until = fields.read_or("until", default.until, |field| field.number(Range::Above(from)))?;
    Ok(Window { from, until })
}

fn read_keys(field: &Field<'_>) -> Result<Vec<Key>, SceneError> {
    let tables = field.list("a list of poses, as [{ time = 1, translate = [0, 1, 0] }]")?;
    if tables.is_empty() {
        return Err(field.out_of_range("at least one pose, as { time = 1, translate = [0, 1, 0] }"));
    }
    let mut keys: Vec<Key> = Vec::with_capacity(tables.len());
    for table in &tables {
        let fields = Fields::new(table, &["time", "translate", "rotate"])?;
        // Two poses at one time would be a jump, which no speed can follow.
        let range = keys.last().map_or(Range::Finite, |last| Range::Above(last.time));
        keys.push(Key {
            time: fields.require("time", "seconds")?.number(range)?,
            translate: fields.read_or("translate", [0.0; 3], Field::vector)?,
            rotate: fields.read_or("rotate", [0.0; 3], Field::vector)?,
        });
    }
    Ok(keys)
}
