//! Conversion of events and tables to Python dictionaries, with the keys of the JSON lines of gripctl.

use crate::input::refused;
use pyo3::{intern, prelude::*, sync::PyOnceLock, types::PyDict};
use serde::Serialize;

/// What `json.loads` makes of the JSON of `value`, so that a number is the one that a JSON line of gripctl shows.
pub(crate) fn dictionary<'py>(
    py: Python<'py>,
    value: &impl Serialize,
) -> PyResult<Bound<'py, PyDict>> {
    static LOADS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let text = serde_json::to_string(value).map_err(refused)?;
    let object = LOADS.import(py, "json", "loads")?.call1((text,))?;
    object.cast_into().map_err(Into::into)
}

/// The JSON of a dictionary.
pub(crate) fn json_of(value: &Bound<'_, PyDict>) -> PyResult<String> {
    let py = value.py();
    PyModule::import(py, "json")?.call_method1(intern!(py, "dumps"), (value,))?.extract()
}
