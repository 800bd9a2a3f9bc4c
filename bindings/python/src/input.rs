//! Conversion of Python objects to checked numbers, names and times. What is wrong becomes a Python exception with a sentence.

use core::fmt::Display;
use numpy::{
    Element, PyArrayDyn, PyArrayMethods as _, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods as _,
};
use pyo3::{
    exceptions::{PyOSError, PyTypeError, PyValueError},
    intern,
    prelude::*,
    sync::PyOnceLock,
    types::IntoPyDict as _,
};
use slip_core::units::Micros;
use std::{
    io,
    path::{Path, PathBuf},
};

/// Times beyond are no times of a recording (s): half a million years.
const MOST_S: f64 = 1.8e13;

/// A `ValueError` with this sentence, in words of Python.
pub(crate) fn refused(what: impl Display) -> PyErr {
    PyValueError::new_err(words(&what.to_string()))
}

/// A message with arguments of Python in the place of flags.
fn words(text: &str) -> String {
    let mut text = text
        .replace("--rate HZ", "rate_hz=HZ")
        .replace("--rate ", "rate_hz=")
        .replace("--time-unit ms (or s)", "time_unit=\"ms\" (or \"s\")")
        .replace("--time-unit", "time_unit=");
    while let Some((before, after)) = text.split_once("--map ") {
        let (pair, rest) = match after.strip_prefix('\'') {
            Some(quoted) => quoted.split_once('\'').unwrap_or((quoted, "")),
            None => after.split_at(after.find([' ', ';', ':', ',']).unwrap_or(after.len())),
        };
        text = match pair.split_once('=') {
            Some((ours, theirs)) => format!("{before}channels={{{ours:?}: {theirs:?}}}{rest}"),
            None => format!("{before}channels {pair}{rest}"),
        };
    }
    text
}

/// Whether there is such a file; where there is none, the exception of Python that names it.
pub(crate) fn exists(path: &Path) -> PyResult<()> {
    std::fs::metadata(path).map(|_| ()).map_err(|error| unreadable(path, &error))
}

/// The `OSError` of a file that cannot be written.
pub(crate) fn unwritable(path: &Path, error: &io::Error) -> PyErr {
    PyOSError::new_err(format!("{}: cannot be written: {error}", path.display()))
}

/// The `OSError` of a file that cannot be opened, with its path.
pub(crate) fn unreadable(path: &Path, error: &io::Error) -> PyErr {
    let (text, path) = (error.to_string(), path.display().to_string());
    let Some(code) = error.raw_os_error() else {
        return PyOSError::new_err(format!("{path}: {text}"));
    };
    let reason = text.split(" (os error").next().unwrap_or_default().to_owned();
    PyOSError::new_err((code, reason, path))
}

/// A number that NumPy knows by a name.
pub(crate) trait Number: Element {
    const NAME: &'static str;
}

impl Number for f32 {
    const NAME: &'static str = "float32";
}

impl Number for f64 {
    const NAME: &'static str = "float64";
}

/// Anything that NumPy makes an array of numbers of, as a contiguous one. Such an array of `T` is not copied.
pub(crate) fn numbers<'py, T: Number>(
    what: &str,
    data: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = data.py();
    if !data.is_exact_instance_of::<PyUntypedArray>() && is_masked(data)? {
        return Err(refused(format!(
            "{what}: some of it is masked, and a mask is not used; take `x.astype(float).filled(numpy.nan)`, whose NaN are no readings, or leave these rows out"
        )));
    }
    if let Some(array) = plain(data) {
        return Ok(array);
    }
    let array = numpy(py)?.call_method1(intern!(py, "asarray"), (data,))?;
    let dtype = array.getattr(intern!(py, "dtype"))?;
    let kind: String = dtype.getattr(intern!(py, "kind"))?.extract()?;
    if !matches!(kind.as_str(), "f" | "i" | "u" | "b") {
        return Err(PyTypeError::new_err(format!(
            "{what}: an array of real numbers is needed, not one of dtype {dtype}"
        )));
    }
    let options = [("dtype", T::NAME), ("order", "C")].into_py_dict(py)?;
    let copied = numpy(py)?.call_method(intern!(py, "array"), (array,), Some(&options))?;
    plain(&copied).ok_or_else(|| refused(format!("{what}: NumPy made no {} of it", T::NAME)))
}

/// Whether NumPy has masked readings in it.
fn is_masked(data: &Bound<'_, PyAny>) -> PyResult<bool> {
    let py = data.py();
    let masked = numpy(py)?.getattr(intern!(py, "ma"))?;
    masked.call_method1(intern!(py, "is_masked"), (data,))?.extract()
}

/// The array itself, where it can be read as it is.
fn plain<'py, T: Number>(data: &Bound<'py, PyAny>) -> Option<PyReadonlyArrayDyn<'py, T>> {
    let array = data.cast::<PyArrayDyn<T>>().ok()?;
    let aligned = (array.data() as usize).is_multiple_of(align_of::<T>());
    if !(array.is_c_contiguous() && aligned) {
        return None;
    }
    array.try_readonly().ok()
}

fn numpy(py: Python<'_>) -> PyResult<&Bound<'_, PyModule>> {
    static NUMPY: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let module = NUMPY.get_or_try_init(py, || PyModule::import(py, "numpy").map(Bound::unbind));
    module.map(|module| module.bind(py))
}

/// A vector of doubles.
pub(crate) fn vector(what: &str, data: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = numbers::<f64>(what, data)?;
    if array.ndim() != 1 {
        return Err(shape(what, "one dimension", array.shape()));
    }
    array.as_slice().map(<[f64]>::to_vec).map_err(refused)
}

/// The sentence on a wrong shape.
pub(crate) fn shape(what: &str, wanted: &str, got: &[usize]) -> PyErr {
    refused(format!("{what}: an array of {wanted} is needed, not one of shape {got:?}"))
}

/// One name or several.
#[derive(Debug)]
pub(crate) struct Names(pub(crate) Vec<String>);

impl Names {
    /// That of the channel of an array whose channels are not named.
    pub(crate) fn vibration() -> Self {
        Self(vec!["vibration".to_owned()])
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Names {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(name) = given.extract() {
            return Ok(Self(vec![name]));
        }
        given.extract().map(Self).map_err(|_| {
            let class = given.get_type();
            PyTypeError::new_err(format!(
                "a name, or a list of one for each column, is needed, not {class}"
            ))
        })
    }
}

/// Why an array without its rate is refused, and a file as well.
pub(crate) fn no_rate(data: &Bound<'_, PyAny>) -> PyErr {
    match data.extract::<PathBuf>() {
        Ok(file) => PyTypeError::new_err(format!(
            "data: an array or a recording is needed; slipgrip.read({file:?}) reads a file"
        )),
        Err(_) => refused("rate_hz is needed for an array: its samples per second"),
    }
}

/// Readings as rows: contiguous, with their width.
pub(crate) struct Block<'py> {
    array: PyReadonlyArrayDyn<'py, f32>,
    rows: usize,
}

impl<'py> Block<'py> {
    /// `data` of shape (rows, channels), or (rows,) where there is one channel.
    pub(crate) fn new(data: &Bound<'py, PyAny>, channels: &[String]) -> PyResult<Self> {
        let array = numbers::<f32>("data", data)?;
        let width = channels.len();
        let rows = match *array.shape() {
            [rows] if width == 1 => rows,
            [rows, columns] if width == columns => rows,
            ref other => {
                let wanted = if width == 1 {
                    "(rows,) or (rows, 1)".to_owned()
                } else {
                    format!("(rows, {width})")
                };
                return Err(refused(format!(
                    "data: shape {other:?} does not fit the channels {channels:?}, which need {wanted}; name one channel for each column"
                )));
            }
        };
        Ok(Self { array, rows })
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn values(&self) -> PyResult<&[f32]> {
        self.array.as_slice().map_err(refused)
    }
}

/// Times of rows (s), finite and never decreasing from `after` on.
pub(crate) fn times(
    data: &Bound<'_, PyAny>,
    rows: usize,
    after: Option<Micros>,
) -> PyResult<Vec<Micros>> {
    let seconds = vector("times", data)?;
    if seconds.len() != rows {
        return Err(refused(format!("times: {} of them for {rows} rows of data", seconds.len())));
    }
    let mut last = after;
    let mut micros = Vec::with_capacity(rows);
    for (row, &t) in seconds.iter().enumerate() {
        if !(0.0..=MOST_S).contains(&t) {
            return Err(refused(format!(
                "times: {t} s in row {row} is not within 0 to {MOST_S:e} s"
            )));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked before"
        )]
        let now = Micros((t * 1e6).round() as u64);
        if let Some(before) = last.filter(|before| *before > now) {
            return Err(refused(format!(
                "times: row {row} goes backwards from {:.6} s to {:.6} s",
                before.as_seconds(),
                now.as_seconds()
            )));
        }
        last = Some(now);
        micros.push(now);
    }
    Ok(micros)
}

/// A finite number above 0, or also 0 where `zero`.
pub(crate) fn positive(name: &str, value: f64, zero: bool) -> PyResult<f64> {
    if value.is_finite() && (value > 0.0 || (zero && value == 0.0)) {
        return Ok(value);
    }
    let wanted = if zero { "0 or more" } else { "more than 0" };
    Err(refused(format!("{name} = {value}: a finite number of {wanted} is needed")))
}

/// A sample rate (Hz), with the bits of a float32.
pub(crate) fn rate(rate_hz: f64) -> PyResult<f32> {
    #[expect(clippy::cast_possible_truncation, reason = "a rate has 24 bits")]
    Ok(positive("rate_hz", rate_hz, false)? as f32)
}
