//! Reads the fields and links of a simulation: lists of dicts with the keys of tables in a scene.

use std::mem;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use supple::{Field, Link};
use supple_io::scene::{Data, FieldTable, LinkTable, Place, Table, Value, nearest};

use crate::{error, keys};

/// The shapes of selections, with the names of their parts, which may also be given as pairs.
const SHAPES: [(&str, [&str; 2]); 3] =
    [("box", ["min", "max"]), ("sphere", ["center", "radius"]), ("plane", ["point", "normal"])];

/// Reads the argument `name`, a list of dicts, or one. `T` has a list with this name. In place of the tables of a scene,
/// shapes may be pairs, and keyframes of the numbers `curves` tuples (time, value). The keys `results`, which tables of the
/// simulation have beside those of the argument, are left out.
fn read<T: DeserializeOwned>(
    list: &Bound<'_, PyAny>,
    name: &str,
    curves: &[&str],
    results: &[&str],
) -> PyResult<T> {
    let py = list.py();
    let list = if list.cast::<PyDict>().is_ok() { PyList::new(py, [list])?.into_any() } else { list.clone() };
    keys::read([(name.to_owned(), list)], |key, list| {
        let mut value = keys::value(list, key)?;
        let tables = if let Data::Array(tables) = &mut value.data { &mut tables[..] } else { &mut [] };
        // The reader refuses an object that is no list.
        let Ok(items) = list.try_iter() else { return Ok(Some(value)) };
        for (index, (item, table)) in items.zip(tables).enumerate() {
            let Ok(dict) = item?.cast_into::<PyDict>() else { continue };
            let Data::Table(table) = &mut table.data else { continue };
            for curve in curves {
                if let Some(given) = dict.get_item(curve)?.filter(|given| !given.is_none()) {
                    let name = format!("{key}[{index}].{curve}");
                    table.insert((*curve).to_owned(), keys::curve(&given, &name)?);
                }
            }
            table.retain(|key, _| !results.contains(&key.as_str()));
            SHAPES.iter().for_each(|(shape, names)| name_parts(table, shape, names));
        }
        Ok(Some(value))
    })
}

/// Makes a table of a shape that is a pair.
fn name_parts(table: &mut Table, shape: &str, names: &[&str; 2]) {
    let Some(value) = table.get_mut(shape) else { return };
    let Data::Array(parts) = &mut value.data else { return };
    if let Ok(parts) = <[Value; 2]>::try_from(mem::take(parts)) {
        value.data = Data::Table(names.map(str::to_owned).into_iter().zip(parts).collect());
        value.place = Place::Argument("dict".to_owned());
    }
}

/// The argument `fields`.
#[derive(Deserialize)]
struct FieldList {
    fields: Vec<FieldTable>,
}

/// Reads the argument `fields`: a list of dicts, or one.
pub(super) fn read_fields(fields: &Bound<'_, PyAny>) -> PyResult<Vec<Field>> {
    let FieldList { fields } = read(fields, "fields", &["strength"], &[])?;
    Ok(fields.into_iter().map(|FieldTable(field)| field).collect())
}

/// Checks that the bodies on which fields act are bodies with these names.
pub(super) fn check_fields(fields: &[Field], names: &[&str]) -> PyResult<()> {
    for (index, field) in fields.iter().enumerate() {
        field.validate().map_err(error::from_core)?;
        for name in &field.bodies {
            check_name(name, names, |name| format!("fields[{index}].bodies names {name:?}"))?;
        }
    }
    Ok(())
}

/// The argument `links`.
#[derive(Deserialize)]
struct LinkList {
    links: Vec<LinkTable>,
}

/// Reads the argument `links`: a list of dicts, or one.
pub(super) fn read_links(links: &Bound<'_, PyAny>) -> PyResult<Vec<Link>> {
    let LinkList { links } = read(links, "links", &[], &["force", "broken"])?;
    Ok(links.into_iter().map(|LinkTable(link)| link).collect())
}

/// Checks that the bodies that links join are bodies with these names.
pub(super) fn check_links(links: &[Link], names: &[&str]) -> PyResult<()> {
    for (index, link) in links.iter().enumerate() {
        link.validate().map_err(error::from_core)?;
        check_name(&link.body, names, |name| format!("links[{index}].body is {name:?}"))?;
        if let Some(other) = &link.other {
            check_name(other, names, |name| format!("links[{index}].other is {name:?}"))?;
        }
    }
    Ok(())
}

/// Checks that a body of a simulation has a name. `what`: which argument has the name.
fn check_name(name: &str, names: &[&str], what: impl FnOnce(&str) -> String) -> PyResult<()> {
    if names.contains(&name) {
        return Ok(());
    }
    let way_out = nearest(name, names).map(|name| format!("; the nearest name is {name:?}"));
    let message = format!("{}, and no body of the simulation has this name", what(name));
    Err(PyValueError::new_err(message + &way_out.unwrap_or_default()))
}
