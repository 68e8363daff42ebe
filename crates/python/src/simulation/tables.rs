//! Reads lists of dicts with the keys of a list of tables in a scene, such as `[[field]]`.

use std::mem;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde::de::DeserializeOwned;
use supple_io::scene::{Data, Place, Table, Value};

use crate::keys;

/// The shapes of selections, with the names of their parts, which may also be given as pairs.
const SHAPES: [(&str, [&str; 2]); 3] =
    [("box", ["min", "max"]), ("sphere", ["center", "radius"]), ("plane", ["point", "normal"])];

/// Reads the argument `name`, a list of dicts, or one. `T` has a list with this name. In place of the tables of a scene,
/// shapes may be pairs, and keyframes of the numbers `curves` tuples (time, value).
pub(super) fn read<T: DeserializeOwned>(list: &Bound<'_, PyAny>, name: &str, curves: &[&str]) -> PyResult<T> {
    let py = list.py();
    let list = if list.cast::<PyDict>().is_ok() { PyList::new(py, [list])?.into_any() } else { list.clone() };
    keys::read([(name.to_owned(), list)], |key, list| {
        let mut value = keys::value(list, key)?;
        let tables = if let Data::Array(tables) = &mut value.data { &mut tables[..] } else { &mut [] };
        for (index, (item, table)) in list.try_iter()?.zip(tables).enumerate() {
            let Ok(dict) = item?.cast_into::<PyDict>() else { continue };
            let Data::Table(table) = &mut table.data else { continue };
            for curve in curves {
                if let Some(given) = dict.get_item(curve)?.filter(|given| !given.is_none()) {
                    let name = format!("{key}[{index}].{curve}");
                    table.insert((*curve).to_owned(), keys::curve(&given, &name)?);
                }
            }
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
