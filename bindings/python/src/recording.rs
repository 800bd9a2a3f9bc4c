//! Recordings as arrays, from files.

use crate::{
    input::{Block, Names, exists, rate, refused, times},
    output::dictionary,
};
use grip_record::{
    CsvOptions, Rows, TimeUnit, Use,
    outputs::{OutputKind, OutputPath},
    read_recording,
};
use grip_session::tape::{Played, Tape, TapeOptions};
use numpy::{PyArray1, PyArray2, ToPyArray as _};
use pyo3::{
    exceptions::{PyKeyError, PyOSError},
    prelude::*,
    types::PyDict,
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// Rows of readings with their times, from a file (`read`) or from arrays.
///
/// data: (rows, channels); rate_hz: samples per second (Hz); channels: the name of each column;
/// times: (rows,) in s, never decreasing, otherwise row i is at i / rate_hz.
#[pyclass(frozen, module = "slipgrip")]
pub(crate) struct Recording {
    pub(crate) inner: grip_record::Recording,
    /// What is odd in it, and what was taken for which channel.
    #[pyo3(get)]
    notes: Vec<String>,
}

impl Recording {
    fn new(inner: grip_record::Recording, mut notes: Vec<String>) -> Self {
        notes.extend(Some(inner.notes.to_string()).filter(|text| !text.is_empty()));
        Self { inner, notes }
    }
}

#[pymethods]
impl Recording {
    #[new]
    #[pyo3(signature = (data, rate_hz, channels, *, times=None, name="array"))]
    fn py_new(
        py: Python<'_>,
        data: &Bound<'_, PyAny>,
        rate_hz: f64,
        channels: Names,
        times: Option<&Bound<'_, PyAny>>,
        name: &str,
    ) -> PyResult<Self> {
        let inner = of_arrays(py, data, rate_hz, channels, times, name)?;
        Ok(Self::new(inner, Vec::new()))
    }

    /// The name: that of the file without its ending.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Samples per second (Hz), given or measured from the times.
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.inner.rate_hz.into()
    }

    /// The names of the columns of `data`.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.inner.columns()
    }

    /// Times of the rows (s), float64 of shape (rows,), a copy.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        py.detach(|| self.inner.times_s()).to_pyarray(py)
    }

    /// All readings, float32 of shape (rows, channels), a copy; NaN where a channel has none.
    #[getter]
    fn data<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        py.detach(|| self.inner.readings()).to_pyarray(py)
    }

    fn __len__(&self) -> usize {
        self.inner.samples.len()
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        channel: &str,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let columns = self.inner.columns();
        let Some(at) = columns.iter().position(|name| name == channel) else {
            return Err(PyKeyError::new_err(format!(
                "no channel {channel:?}; there are {columns:?}"
            )));
        };
        let readings = py.detach(|| self.inner.readings());
        Ok(readings.column(at).to_pyarray(py))
    }

    fn __repr__(&self) -> String {
        format!(
            "Recording({:?}, {} rows at {} Hz, channels={:?})",
            self.inner.name,
            self.inner.samples.len(),
            self.inner.rate_hz,
            self.inner.columns()
        )
    }

    /// Writes an .npz with an array for each channel, which `read` and gripctl read.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        if !grip_record::is_npz(&path) {
            return Err(refused(format!("{}: a recording is saved as .npz", path.display())));
        }
        let write = || -> Result<(), Box<dyn core::error::Error + Send + Sync>> {
            let mut out = OutputPath::new(&path, OutputKind::ANY, [], Some(true))?.create()?;
            self.inner.write_npz(&mut out)?;
            Ok(out.finish()?)
        };
        py.detach(write).map_err(|error| {
            PyOSError::new_err(format!("{}: cannot be written: {error}", path.display()))
        })
    }
}

/// The recording of these arrays.
pub(crate) fn of_arrays(
    py: Python<'_>,
    data: &Bound<'_, PyAny>,
    rate_hz: f64,
    channels: Names,
    times_s: Option<&Bound<'_, PyAny>>,
    name: &str,
) -> PyResult<grip_record::Recording> {
    let Names(channels) = channels;
    let mut rows = rows(name, &channels, rate_hz)?;
    let block = Block::new(data, &channels)?;
    if block.rows() == 0 {
        return Err(refused("data: it has no rows"));
    }
    let times = times_s.map(|t| times(t, block.rows(), None)).transpose()?;
    let values = block.values()?;
    py.detach(|| {
        for (at, row) in values.chunks_exact(channels.len()).enumerate() {
            rows.keep(times.as_ref().and_then(|times| times.get(at).copied()), row)?;
        }
        rows.finish()
    })
    .map_err(refused)
}

/// Rows of these channels, all of them known.
pub(crate) fn rows(name: &str, channels: &[String], rate_hz: f64) -> PyResult<Rows> {
    if channels.iter().any(|channel| channel == "t_s") {
        return Err(refused("channels: t_s is no channel; give the times as times="));
    }
    for (at, channel) in channels.iter().enumerate() {
        if !channel.is_empty() && channels[..at].contains(channel) {
            return Err(refused(format!("channels: {channel:?} is named twice")));
        }
    }
    let rows = Rows::new(name, channels, rate(rate_hz)?).map_err(refused)?;
    let unknown = rows.about().notes.ignored_columns;
    if unknown.is_empty() {
        return Ok(rows);
    }
    let known = grip_record::COLUMN_NAMES.into_iter().filter(|name| *name != "t_s");
    let known = known.collect::<Vec<_>>().join(", ");
    Err(refused(format!(
        "channels: {unknown:?} is not known; known are {known}, vibration_x .. _z, reference_x .. _z and pressure_0, pressure_1, .."
    )))
}

/// A recording from a file: .csv, .npz, .mcap of gripd; .wav, .w64, .npy, .npz, .mcap with JSON or ROS 2 messages, .db3 or the
/// folder of a bag. `channels` maps names of channels to names in the file, as --map of gripctl does:
/// {"vibration": "acceleration"}. `rate_hz` (Hz) is needed where the file has no times, `time_unit` ("s", "ms", "us", "ns") where
/// neither their name nor their rate shows it.
#[pyfunction]
#[pyo3(signature = (path, *, rate_hz=None, channels=None, time_unit=None))]
pub(crate) fn read(
    py: Python<'_>,
    path: PathBuf,
    rate_hz: Option<f64>,
    channels: Option<BTreeMap<String, String>>,
    time_unit: Option<&str>,
) -> PyResult<Recording> {
    exists(&path)?;
    let rate_hz = rate_hz.map(rate).transpose()?;
    let map = channels.unwrap_or_default().into_iter().collect();
    let unit = |name: &str| TimeUnit::ALL.into_iter().find(|unit| unit.name() == name);
    let time_unit = time_unit.map(|name| {
        unit(name).ok_or_else(|| refused(format!("time_unit={name:?}: it is one of s, ms, us, ns")))
    });
    let options =
        CsvOptions { rate_hz, map, time_unit: time_unit.transpose()?, ..CsvOptions::default() };
    py.detach(|| open(&path, &options)).map_err(refused)
}

/// A recording of ours, or of another program.
fn open(path: &Path, options: &CsvOptions) -> Result<Recording, String> {
    let text = |error: &dyn core::fmt::Display| error.to_string();
    let mcap = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    let given = options.rate_hz.is_some() || !options.map.is_empty();
    let own = if mcap && !given { Some(grip_session::recording::read_mcap(path)) } else { None };
    match own {
        Some(Ok(recording)) => return Ok(Recording::new(recording, Vec::new())),
        Some(Err(own)) => {
            // One of another program, where that reader finds a sensor in it.
            return import(path, options).map_err(|_| text(&own));
        }
        None if mcap || grip_import::is_foreign(path) => {
            return import(path, options).map_err(|error| text(&error));
        }
        None => {}
    }
    let read = read_recording(path, options).map_err(|error| text(&error))?;
    let uses = taken(&read.notes.uses);
    Ok(Recording::new(read, uses))
}

fn import(path: &Path, options: &CsvOptions) -> Result<Recording, grip_import::ImportError> {
    let options = grip_import::ImportOptions {
        rate_hz: options.rate_hz,
        map: options.map.clone(),
        time_unit: options.time_unit,
        ..grip_import::ImportOptions::default()
    };
    let imported = grip_import::import(path, &options)?;
    let notes = taken(&imported.uses).into_iter().chain(imported.notes).collect();
    Ok(Recording::new(imported.recording, notes))
}

/// What was taken for what, where the file has names or units of its own.
fn taken(uses: &[Use]) -> Vec<String> {
    let own = |used: &&Use| used.ours != used.theirs;
    let line = |used: &Use| format!("{} -> {} ({})", used.theirs, used.ours, used.unit);
    uses.iter().filter(own).map(line).collect()
}

/// The events of an .mcap of gripd, replayed with the settings and the model that are recorded in it, as
/// `gripctl replay FILE.mcap --json` prints them.
#[pyfunction]
pub(crate) fn replay<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Vec<Bound<'py, PyDict>>> {
    exists(&path)?;
    let events = py.detach(|| {
        let mut tape = Tape::new(TapeOptions::default());
        let mut events = Vec::new();
        tape.play(&path, &mut |played| {
            if let Played::Line(event) = played {
                events.push(*event);
            }
        })?;
        Ok::<_, grip_session::tape::TapeError>(events)
    });
    events.map_err(refused)?.iter().map(|event| dictionary(py, event)).collect()
}
