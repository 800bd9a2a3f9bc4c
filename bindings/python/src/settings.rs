//! Settings of a pipeline, from the arguments `config`, `calibration` and `model`.

use crate::{
    calibrate::Calibration,
    input::{exists, refused},
    learn::Model,
    output::json_of,
};
use grip_record::{Recording, StylusKind};
use grip_session::{HostConfig, HostConfigError, HostEstimator, model, replay};
use pyo3::{prelude::*, types::PyDict};
use slip_core::{Pipeline, PipelineConfig};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// A file, or a dictionary with its keys.
#[derive(FromPyObject)]
pub(crate) enum Config<'py> {
    #[pyo3(transparent, annotation = "dict")]
    Table(Bound<'py, PyDict>),
    #[pyo3(transparent, annotation = "path")]
    File(PathBuf),
}

/// A file, or what `calibrate` gave.
#[derive(FromPyObject)]
pub(crate) enum CalibrationLike<'py> {
    #[pyo3(transparent)]
    Made(PyRef<'py, Calibration>),
    #[pyo3(transparent)]
    File(PathBuf),
}

/// A file or the name of a built-in model, or what `train` gave.
#[derive(FromPyObject)]
pub(crate) enum ModelLike<'py> {
    #[pyo3(transparent)]
    Made(PyRef<'py, Model>),
    #[pyo3(transparent)]
    File(PathBuf),
}

/// What a pipeline is built from.
#[derive(Clone)]
pub(crate) struct Settings {
    pub(crate) config: HostConfig,
    estimator: HostEstimator,
}

/// The configuration alone.
pub(crate) fn host_config(config: Option<Config<'_>>) -> PyResult<HostConfig> {
    match config {
        None => Ok(HostConfig::default()),
        Some(Config::File(file)) => {
            exists(&file)?;
            HostConfig::read(&file).map_err(refused)
        }
        Some(Config::Table(table)) => {
            let value: toml::Value = serde_json::from_str(&json_of(&table)?)
                .map_err(|error| refused(format!("config: {error}")))?;
            let text =
                toml::to_string(&value).map_err(|error| refused(format!("config: {error}")))?;
            HostConfig::parse(Path::new("config"), &text)
                .map_err(|error| refused(in_dictionary(&error, &text)))
        }
    }
}

/// What is wrong with a dictionary, by its keys: the user has never seen `text`, which was made of it.
fn in_dictionary(error: &HostConfigError, text: &str) -> String {
    let (place, message) = match error {
        HostConfigError::Parse { place, message, .. } => (place, message.clone()),
        HostConfigError::Value { place, source, .. } => (place, source.to_string()),
        other => return other.to_string(),
    };
    let lines = text.lines().take(place.at.map_or(0, |(line, _)| line));
    let (mut table, mut key) = ("", "");
    for line in lines {
        match line.strip_prefix('[') {
            Some(name) => (table, key) = (name.trim_end_matches(']'), ""),
            None => key = line.split_once(" = ").map_or("", |(key, _)| key),
        }
    }
    let keys = table.split('.').chain([key]).filter(|key| !key.is_empty());
    let path: String = keys.map(|key| format!("[\"{key}\"]")).collect();
    format!("config{path}: {message}")
}

impl Settings {
    pub(crate) fn new(
        config: Option<Config<'_>>,
        calibration: Option<CalibrationLike<'_>>,
        model: Option<ModelLike<'_>>,
    ) -> PyResult<Self> {
        let config = host_config(config)?;
        let config = match calibration {
            None => config,
            Some(CalibrationLike::Made(made)) => made.apply(config),
            Some(CalibrationLike::File(file)) => {
                exists(&file)?;
                config.with_calibration(&file).map_err(refused)?
            }
        };
        let file = config.model.clone();
        let estimator = match model {
            Some(ModelLike::Made(made)) => {
                return Ok(Self { estimator: made.estimator()?, config });
            }
            Some(ModelLike::File(file)) => model::read_estimator(&file),
            None => file.map_or_else(model::default_estimator, |file| model::read_estimator(&file)),
        };
        Ok(Self { config, estimator: estimator.map_err(refused)? })
    }

    /// The pipeline of `gripctl replay`, with its controller where `control`.
    pub(crate) fn pipeline(
        &self,
        about: &Recording,
        control: bool,
    ) -> PyResult<(PipelineConfig, Pipeline<Arc<[f32]>>)> {
        let config = replay::pipeline_config(about, &self.config, !control);
        let vibration = about.channels.stylus == StylusKind::Vibration;
        self.config.check_signal(config.sample_rate, vibration).map_err(refused)?;
        let pipeline = Pipeline::new(config, Some(self.estimator.clone())).map_err(refused)?;
        Ok((config, pipeline))
    }
}
