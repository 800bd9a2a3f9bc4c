//! A model file in, the force estimator or the reason against it out.

use mlp::train::{FileError, ModelFile};
use slip_core::{
    estimate::{Estimator, EstimatorError},
    features::Feature,
};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// An estimator whose weights are shared: a copy of it allocates nothing.
pub type HostEstimator = Estimator<Arc<[f32]>>;

/// The model that is used where no other is named.
const DEFAULT: &str = include_str!("../models/default.json");

/// Why a model file cannot serve.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The file cannot be read.
    #[error("{}: the model cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no usable model.
    #[error("{file}: {}", explain(fault))]
    File {
        /// The file.
        file: String,
        /// What is wrong, with line and column where the text is at fault.
        fault: FileError,
    },
    /// An input that a slip does not show.
    #[error(
        "{file}: input `{input}` is no feature of a slip; a model may use {}",
        known_features()
    )]
    Input {
        /// The file.
        file: String,
        /// The input.
        input: String,
    },
    /// The target is not a force in newtons.
    #[error("{file}: the target is `{target}` in `{unit}`, not a force in N")]
    Target {
        /// The file.
        file: String,
        /// Its name.
        target: String,
        /// Its unit.
        unit: String,
    },
    /// The network has the wrong shape.
    #[error("{file}: {source}")]
    Shape {
        /// The file.
        file: String,
        /// What does not fit.
        source: EstimatorError,
    },
}

fn explain(fault: &FileError) -> String {
    match fault {
        FileError::Version { found: Some(found) } => format!(
            "the model file has version {found}, this program reads version {}; train the model again with `gripctl train`",
            mlp::train::file::VERSION
        ),
        FileError::Format { found: Some(kind) } if kind.ends_with("-model") => {
            format!(
                "this is of the kind {kind}; only a single network (mlp-model) runs in real time"
            )
        }
        FileError::Version { found: None } | FileError::Format { .. } => {
            "this is no model file; `gripctl train` writes one".to_owned()
        }
        other => other.to_string(),
    }
}

fn known_features() -> String {
    Feature::ALL.map(Feature::name).join(", ")
}

/// Reads a model file.
///
/// # Errors
/// Where the file cannot be read, is no model, or does not estimate a force from features of a slip.
pub fn read_estimator(file: &Path) -> Result<HostEstimator, ModelError> {
    let text = std::fs::read_to_string(file)
        .map_err(|source| ModelError::Read { file: file.to_owned(), source })?;
    parse_estimator(&file.display().to_string(), &text)
}

/// The text of the embedded model.
#[must_use]
pub const fn default_text() -> &'static str {
    DEFAULT
}

/// The embedded model.
///
/// # Errors
/// Never, as long as the tests pass that load it.
pub fn default_estimator() -> Result<HostEstimator, ModelError> {
    parse_estimator("embedded model", DEFAULT)
}

/// The estimator from the text of a model file; `file` is only named in errors.
///
/// # Errors
/// As [`read_estimator`].
pub fn parse_estimator(file: &str, text: &str) -> Result<HostEstimator, ModelError> {
    let file = file.to_owned();
    let fault = |fault| ModelError::File { file: file.clone(), fault };
    let content = ModelFile::from_json(text).map_err(fault)?;
    let mut features = Vec::new();
    for input in &content.inputs {
        let feature = Feature::from_name(&input.name)
            .ok_or_else(|| ModelError::Input { file: file.clone(), input: input.name.clone() })?;
        features.push(feature);
    }
    if let Some(target) = content.targets.first()
        && target.unit != "N"
    {
        let (target, unit) = (target.name.clone(), target.unit.clone());
        return Err(ModelError::Target { file, target, unit });
    }
    let model = content.model_in().map_err(fault)?;
    Estimator::new(model, &features).map_err(|source| ModelError::Shape { file, source })
}

#[cfg(test)]
mod tests {
    use super::{ModelError, default_estimator, parse_estimator};
    use grip_sim::generator::{GeneratorConfig, Source, rows};
    use slip_core::features::Features;

    #[expect(clippy::cast_possible_truncation, reason = "features are f32")]
    fn features(row: &grip_sim::Row) -> Features {
        Features {
            slip_speed_m_s: row.slip_speed_m_s as f32,
            contact_time_s: row.contact_time_s as f32,
            slip_acceleration_m_s2: row.slip_acceleration_m_s2 as f32,
            slip_acceleration_sigma_m_s2: None,
            micro_displacement_m: row.micro_displacement_m as f32,
            trial_force_n: row.trial_force_n as f32,
            irregularities: row.irregularities,
            mean_slope: None,
            esc: None,
            esc_chosen: None,
        }
    }

    /// Objects the training never saw (it used seed 1), in the ranges it covers.
    #[test]
    fn the_embedded_model_is_within_ten_percent_on_new_objects() {
        let estimator = default_estimator().unwrap();
        let config = GeneratorConfig { source: Source::Stretch, ..GeneratorConfig::default() };
        let (mut answered, mut within) = (0, 0);
        for row in rows(config, 77, 5000).unwrap() {
            let estimate = estimator.estimate(&features(&row)).unwrap();
            if estimate.extrapolated {
                continue;
            }
            answered += 1;
            let ratio = f64::from(estimate.force_n) / row.adequate_force_n;
            within += u32::from((0.9..=1.1).contains(&ratio));
        }
        assert!(answered > 4900, "{answered} of 5000 inside the training range");
        assert!(f64::from(within) >= 0.99 * f64::from(answered), "{within} of {answered}");
    }

    #[test]
    fn a_model_that_answers_something_else_is_refused() {
        let text = include_str!("../models/default.json");
        let renamed = text.replace("slip_acceleration_m_s2", "temperature_k");
        let error = parse_estimator("m.json", &renamed).unwrap_err();
        assert!(matches!(error, ModelError::Input { .. }), "{error}");
        assert!(
            error.to_string().contains("temperature_k")
                && error.to_string().contains("trial_force_n")
        );
        let other =
            text.replace("adequate_force_n", "adequate_speed_m_s").replacen("\"N\"", "\"m/s\"", 9);
        let error = parse_estimator("m.json", &other).unwrap_err();
        assert!(matches!(error, ModelError::Target { .. }), "{error}");
    }
}
