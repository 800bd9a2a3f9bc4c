//! Calibration with rows without slip: a noise floor, slack and what they stand on.

use crate::{
    input::{Names, no_rate, refused, unreadable, unwritable},
    output::dictionary,
    recording::{Recording, of_arrays},
    settings::{Config, host_config},
};
use grip_session::{HostConfig, calibration};
use numpy::{PyArray1, ToPyArray as _};
use pyo3::{prelude::*, types::PyDict};
use std::path::PathBuf;

/// What `gripctl calibrate` writes: a noise floor, a motion gate and slack, with what they stand on.
#[pyclass(frozen, module = "slipgrip")]
pub(crate) struct Calibration {
    inner: calibration::Calibration,
    /// Why no slip will be certified; None where it will.
    #[pyo3(get)]
    not_certified: Option<String>,
}

impl Calibration {
    pub(crate) fn apply(&self, config: HostConfig) -> HostConfig {
        HostConfig { calibrated: Some(self.inner), ..config }
    }
}

#[pymethods]
impl Calibration {
    /// From the file that `save` or `gripctl calibrate` wrote (.toml).
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let text = std::fs::read_to_string(&path).map_err(|error| unreadable(&path, &error))?;
        let named = |error| refused(format!("{}: {error}", path.display()));
        // Checked as the flag --calibration checks it.
        HostConfig::default().with_calibration(&path).map_err(refused)?;
        let inner =
            calibration::Calibration::parse(&text).map_err(|error| named(error.to_string()))?;
        let certified = inner.stylus().is_some_and(|stylus| stylus.certificate.is_some());
        let not_certified = (!certified).then(|| "the file has no certificate".to_owned());
        Ok(Self { inner, not_certified })
    }

    /// Writes the file that --calibration of gripd and gripctl reads (.toml).
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let text = toml::to_string(&self.inner).map_err(refused)?;
        std::fs::write(&path, text).map_err(|error| unwritable(&path, &error))
    }

    fn __repr__(&self) -> String {
        let certified = if self.not_certified.is_none() { "" } else { ", not certified" };
        format!("Calibration({} Hz{certified})", self.rate_hz())
    }

    /// All of it, with the keys of the file.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        dictionary(py, &self.inner)
    }

    /// Samples per second it holds for (Hz).
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.inner.sample_rate().0.into()
    }

    /// Energy of each band at rest (signal unit squared), (6,); None of a taxel array alone.
    #[getter]
    fn floor<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        self.inner.stylus().map(|stylus| stylus.floor.to_pyarray(py))
    }

    /// Times that shear, vibration, the octaves and these together may rise over the floor, robot still, (7,); None of a taxel array alone.
    #[getter]
    fn slack<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        self.inner.stylus().map(|stylus| stylus.slack_still.to_pyarray(py))
    }

    /// The smallest vibration (signal unit, rms, 100 to 400 Hz) that is a slip at rest.
    #[getter]
    fn smallest(&self) -> Option<f64> {
        self.inner.stylus()?.evidence.smallest_rest.map(Into::into)
    }
}

/// Floor, gate and slack from rows without any slip: at least 5 s at rest, and with a reference also in motion.
///
/// Arguments as for `detect`; interval_s: wanted mean time between two false alarms (s).
#[pyfunction]
#[pyo3(signature = (data, rate_hz=None, channels=None, *, times=None, interval_s=600.0, config=None))]
pub(crate) fn calibrate(
    py: Python<'_>,
    data: &Bound<'_, PyAny>,
    rate_hz: Option<f64>,
    channels: Option<Names>,
    times: Option<&Bound<'_, PyAny>>,
    interval_s: f64,
    config: Option<Config<'_>>,
) -> PyResult<Calibration> {
    let config = host_config(config)?;
    if !(1.0..=1e9).contains(&interval_s) {
        return Err(refused(format!("interval_s = {interval_s}: 1 to 1e9 seconds are expected")));
    }
    let made = if let Ok(recording) = data.cast::<Recording>() {
        if rate_hz.is_some() || channels.is_some() || times.is_some() {
            return Err(refused(
                "a recording has its own rate, channels and times: leave them out",
            ));
        }
        let recording = &recording.get().inner;
        py.detach(|| grip_eval::calibrate::calibrate(recording, &config, interval_s))
    } else {
        let Some(rate_hz) = rate_hz else {
            return Err(no_rate(data));
        };
        let channels = channels.unwrap_or_else(Names::vibration);
        let recording = of_arrays(py, data, rate_hz, channels, times, "array")?;
        py.detach(|| grip_eval::calibrate::calibrate(&recording, &config, interval_s))
    };
    let made = made.map_err(refused)?;
    let not_certified = made.certified.err().map(|why| why.to_string());
    Ok(Calibration { inner: made.calibration, not_certified })
}
