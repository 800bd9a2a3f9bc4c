//! The force estimator of a model file or of the name of a built-in model, or the reason against it.
//!
//! | built in | inputs | |
//! |---|---|---|
//! | `default` | slip acceleration and mean force over a stretch of sliding | determines the force |
//! | `paper` | slip speed and E_sc as printed, as in the source study | cannot: where the trial force varies, both state only how far it is from enough |
//!
//! A file holds one network or the members of an ensemble (`gripctl train --model ensemble`), of which at most
//! [`MAX_MEMBERS`](slip_core::estimate::MAX_MEMBERS) run in real time. What a model missed by on its test rows becomes part of the deviation of each
//! estimate ([`ModelFile::deviation`]); estimates that are too unsure are shown and never move the fingers ([`weakness`]).

use crate::signature::{self, MOST_SIGNATURE, SignatureError};
use grip_record::files;
use mlp_core::{
    ensemble_file::{EnsembleFile, is_ensemble},
    file::{self, Deviation, FileError, ModelFile},
    model::{MAX_IO, ScaleError},
    network::{MAX_WIDTH, ShapeError},
};
use sha2::{Digest as _, Sha256};
use slip_core::estimate::{Estimator, EstimatorError, Feature};
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
    sync::Arc,
};

/// An estimator whose weights are shared: a copy of it allocates nothing.
pub type HostEstimator = Estimator<Arc<[f32]>>;

/// The model that is used where no other is named.
const DEFAULT: &str = include_str!("../models/default.json");

/// Names and texts of the built-in models.
pub const BUILT_IN: [(&str, &str); 2] =
    [("default", DEFAULT), ("paper", include_str!("../models/paper.json"))];

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
    /// The signature beside it cannot be read.
    #[error("{}: the signature of the model cannot be read: {source}", file.display())]
    SignatureFile {
        /// The file of the signature.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not signed as it should be.
    #[error("{file}: {source}; {}", source.remedy(file))]
    Signature {
        /// The file.
        file: String,
        /// What is wrong.
        source: SignatureError,
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
            file::VERSION
        ),
        FileError::Format { found: Some(kind) } if kind == "ensemble-model" => {
            format!("this is of the kind {kind}; only one network (mlp-model) can be exported")
        }
        FileError::Format { found: Some(kind) } if kind.ends_with("-model") => {
            format!(
                "this is of the kind {kind}; only one network (mlp-model) or a few (ensemble-model) run in real time"
            )
        }
        FileError::Version { found: None } | FileError::Format { .. } => {
            "this is no model file; `gripctl train` writes one".to_owned()
        }
        FileError::Shape(ShapeError::Width { .. })
        | FileError::Scale { source: ScaleError::Columns { .. }, .. }
        | FileError::Classifier { .. } => format!(
            "{fault}; a model that runs in real time estimates a force from at most {MAX_IO} inputs, in layers of at most {MAX_WIDTH} neurons (`gripctl train`, `eval` and `export` take more)"
        ),
        other => other.to_string(),
    }
}

fn known_features() -> String {
    Feature::ALL.map(Feature::name).join(", ")
}

/// The text of the built-in model of that name. A file of the same name is meant by `./default` or `./paper`.
#[must_use]
pub fn built_in(name: &Path) -> Option<&'static str> {
    BUILT_IN.into_iter().find(|(known, _)| name == Path::new(known)).map(|(_, text)| text)
}

/// The text of a built-in model or a model file, without a signature.
///
/// # Errors
/// Where the file cannot be read.
pub fn read_text(file: &Path) -> Result<Cow<'static, str>, ModelError> {
    if let Some(text) = built_in(file) {
        return Ok(text.into());
    }
    let mut text = read(file, files::MOST_MODEL)?;
    text.truncate(signature::split(&text).0.len());
    Ok(text.into())
}

/// The text of a built-in model or a model file, with the signature behind it that stands there, or else in `FILE.minisig`.
///
/// # Errors
/// Where a file cannot be read, and where `FILE.minisig` holds no signature.
pub fn read_signed(file: &Path) -> Result<Cow<'static, str>, ModelError> {
    if let Some(text) = built_in(file) {
        return Ok(text.into());
    }
    let text = read(file, files::MOST_MODEL)?;
    if signature::split(&text).1.is_some() {
        return Ok(text.into());
    }
    Ok((text + &signature_beside(file)?.unwrap_or_default()).into())
}

/// The signature of a model file that lies in `FILE.minisig`, where that is there.
///
/// # Errors
/// Where it cannot be read, is empty, or is no signature.
pub fn signature_beside(file: &Path) -> Result<Option<String>, ModelError> {
    let beside = file.with_added_extension("minisig");
    if !beside.exists() {
        return Ok(None);
    }
    let most = u64::try_from(MOST_SIGNATURE).unwrap_or(u64::MAX);
    let signature = files::read_text(&beside, most)
        .map_err(|source| ModelError::SignatureFile { file: beside, source })?;
    signature::check_form(&signature).map_err(|source| {
        let file = file.display().to_string();
        ModelError::Signature { file, source }
    })?;
    Ok(Some(signature))
}

fn read(file: &Path, most: u64) -> Result<String, ModelError> {
    let read = files::read_text(file, most);
    read.map_err(|source| ModelError::Read { file: file.to_owned(), source })
}

/// Reads a built-in model or a model file.
///
/// # Errors
/// Where the file cannot be read, is no model, or does not estimate a force from features of a slip.
pub fn read_estimator(file: &Path) -> Result<HostEstimator, ModelError> {
    parse_estimator(&file.display().to_string(), &read_text(file)?)
}

/// SHA-256 of a model file.
#[must_use]
pub fn digest(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
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

/// The estimator from the text of a model file, signed or not; `file` is only named in errors. Who has signed it is asked elsewhere
/// ([`ModelKeys::check`](signature::ModelKeys::check)).
///
/// # Errors
/// As [`read_estimator`].
pub fn parse_estimator(file: &str, text: &str) -> Result<HostEstimator, ModelError> {
    let fault = |fault| ModelError::File { file: file.to_owned(), fault };
    let shape = |source| ModelError::Shape { file: file.to_owned(), source };
    let (text, _) = signature::split(text);
    let (deviation, interval, networks) = if is_ensemble(text) {
        let ensemble = EnsembleFile::from_json(text).map_err(fault)?;
        (mean_deviation(ensemble.members()), ensemble.interval.clone(), ensemble.aligned())
    } else {
        let network = ModelFile::from_json(text).map_err(fault)?;
        (mean_deviation(core::slice::from_ref(&network)), network.interval.clone(), vec![network])
    };
    let mut networks = networks.into_iter();
    let first = networks.next().ok_or_else(|| fault(FileError::NoMembers))?;
    let model = first.model_in().map_err(fault)?;
    let mut estimator = Estimator::new(model, &features(file, &first)?).map_err(shape)?;
    for member in networks {
        estimator = estimator.with_member(member.model_in().map_err(fault)?).map_err(shape)?;
    }
    let [relative, absolute_n] = deviation;
    let estimator = estimator.with_deviation(relative, absolute_n);
    Ok(match interval.as_ref().and_then(|i| Some((i.widths.first()?, i.level))) {
        Some((&width, level)) => estimator.with_interval(width, sigmas(level)),
        None => estimator,
    })
}

/// Deviations of a bell curve to both sides of its middle that hold this share of it.
fn sigmas(level: f64) -> f32 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let held = libm::erf(middle * core::f64::consts::FRAC_1_SQRT_2);
        (low, high) = if held < level { (middle, high) } else { (low, middle) };
    }
    file::rounded(low)
}

/// The features that the inputs of a network name; its target must be a force.
fn features(file: &str, network: &ModelFile) -> Result<Vec<Feature>, ModelError> {
    let mut features = Vec::new();
    for input in &network.inputs {
        let unknown = || ModelError::Input { file: file.to_owned(), input: input.name.clone() };
        features.push(Feature::from_name(&input.name).ok_or_else(unknown)?);
    }
    match network.targets.first() {
        Some(target) if target.unit != "N" => {
            let (target, unit) = (target.name.clone(), target.unit.clone());
            Err(ModelError::Target { file: file.to_owned(), target, unit })
        }
        _ => Ok(features),
    }
}

/// What the members missed by, as far as their files know: a share of the answer, and newtons.
fn mean_deviation(members: &[ModelFile]) -> [f32; 2] {
    let mut squares = [0.0_f32; 2];
    let mut known = 0.0_f32;
    for deviation in members.iter().filter_map(ModelFile::deviation) {
        match deviation {
            Deviation::Relative(share) => squares[0] += share * share,
            Deviation::Absolute(newtons) => squares[1] += newtons * newtons,
        }
        known += 1.0;
    }
    squares.map(|sum| (sum / known.max(1.0)).sqrt())
}

/// What a user should know of an estimator that knows too little to be trusted with the force.
#[must_use]
pub fn weakness<W: AsRef<[f32]>>(estimator: &Estimator<W>) -> Option<String> {
    let (share, _) = estimator.deviation();
    (!estimator.is_trustworthy()).then(|| {
        format!(
            "this model missed its test rows by {:.0} % (one standard deviation): its estimates are shown, but none moves the fingers, and slips are answered by the reflex alone",
            100.0 * share
        )
    })
}

#[cfg(test)]
mod tests {
    use super::{
        EnsembleFile, ModelError, ModelFile, built_in, default_estimator, default_text,
        parse_estimator, read_estimator, read_signed, read_text, weakness,
    };
    use slip_core::estimate::{Features, MAX_MEMBERS};
    use std::path::Path;

    #[test]
    fn what_is_too_large_or_tells_classes_apart_is_refused_with_the_limits() {
        let file = ModelFile::from_json(include_str!("../models/default.json")).unwrap();
        let refused = |file: &ModelFile, parts: &[&str]| {
            let error =
                parse_estimator("m.json", &file.to_json().unwrap()).unwrap_err().to_string();
            let limits = "at most 16 inputs, in layers of at most 64 neurons";
            assert!(parts.iter().chain([&limits]).all(|part| error.contains(part)), "{error}");
        };
        let mut wide = file.clone();
        for _ in wide.inputs.len()..17 {
            wide.inputs.push(wide.inputs[0].clone());
            wide.layers[0].weights.iter_mut().for_each(|row| row.push(0.0));
        }
        refused(&wide, &["m.json", "17 columns"]);
        let mut classifier = file;
        classifier.classes = Some("direction".to_owned());
        refused(&classifier, &["m.json", "1 classes apart"]);
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

    #[test]
    fn the_model_of_the_study_is_built_in_and_its_weakness_is_reported() {
        let paper = read_estimator(Path::new("paper")).unwrap();
        assert_eq!(weakness(&default_estimator().unwrap()), None);
        let reported = weakness(&paper).unwrap();
        assert!(
            reported.contains("54 %") && reported.contains("none moves the fingers"),
            "{reported}"
        );
        let inputs = ModelFile::from_json(built_in(Path::new("paper")).unwrap()).unwrap().inputs;
        assert_eq!(inputs[0].name, "slip_speed_m_s");
        assert_eq!(inputs[1].name, "esc_literal_w");
        let absent = read_estimator(Path::new("./paper")).unwrap_err();
        assert!(matches!(absent, ModelError::Read { .. }), "{absent}");
    }

    #[test]
    fn the_signature_beside_a_model_is_joined_to_it_and_read_only_where_it_is_one() {
        let (model, signature) = (
            include_str!("../tests/signed/model.json"),
            include_str!("../tests/signed/model.json.minisig"),
        );
        let folder = tempfile::tempdir().unwrap();
        let [file, beside] = ["m.json", "m.json.minisig"].map(|name| folder.path().join(name));
        std::fs::write(&file, model).unwrap();
        assert_eq!(read_signed(&file).unwrap(), model);
        std::fs::write(&beside, signature).unwrap();
        let joined = model.to_owned() + signature;
        assert_eq!(read_signed(&file).unwrap(), joined);
        std::fs::write(&file, &joined).unwrap();
        assert_eq!(
            (read_signed(&file).unwrap(), read_text(&file).unwrap()),
            (joined.into(), model.into())
        );
        read_estimator(&file).unwrap();
        std::fs::write(&file, model).unwrap();
        for (text, why) in [
            ("", "m.json: its signature cannot be read"),
            ("{}", "m.json: its signature cannot be read"),
            (
                &"x".repeat(5000),
                "m.json.minisig: the signature of the model cannot be read: it has 5000",
            ),
        ] {
            std::fs::write(&beside, text).unwrap();
            let error = read_signed(&file).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
            read_estimator(&file).unwrap();
        }
        assert_eq!(read_signed(Path::new("default")).unwrap(), default_text());
    }

    /// The answers are those of one network, and what they missed by in the test is their deviation.
    #[test]
    fn an_ensemble_runs_as_far_as_it_is_small() {
        let text = include_str!("../models/default.json");
        let ensemble = |members: usize| {
            let file = ModelFile::from_json(text).unwrap();
            EnsembleFile::new(vec![file; members]).unwrap().to_json().unwrap()
        };
        let one = default_estimator().unwrap();
        let four = parse_estimator("e.json", &ensemble(MAX_MEMBERS)).unwrap();
        assert_eq!((one.members(), four.members()), (1, MAX_MEMBERS));
        assert!((one.deviation().0 / four.deviation().0 - 1.0).abs() < 1e-5, "{one:?}");
        assert!((0.005..0.01).contains(&one.deviation().0) && one.deviation().1 == 0.0);
        let slip = Features {
            slip_speed_m_s: 0.05,
            contact_time_s: 0.02,
            slip_acceleration_m_s2: 2.0,
            slip_acceleration_sigma_m_s2: None,
            micro_displacement_m: 5e-4,
            trial_force_n: 5.0,
            irregularities: 0,
            mean_slope: None,
            esc: None,
            esc_chosen: None,
        };
        let [a, b] = [&one, &four].map(|model| model.estimate(&slip).unwrap());
        assert!((a.force_n / b.force_n - 1.0).abs() < 1e-4, "{a:?} {b:?}");
        assert!((a.sigma_n / a.force_n - one.deviation().0).abs() < 1e-4, "{a:?}");
        // What other physics add is stated, and no part of what the margin covers.
        let width = ModelFile::from_json(text).unwrap().interval.unwrap().widths[0];
        let [low_n, high_n] = a.limits_n.unwrap();
        assert!((a.force_n / low_n / width - 1.0).abs() < 1e-4 && a.is_trusted(), "{a:?}");
        assert!((high_n / a.force_n / width - 1.0).abs() < 1e-4, "{a:?}");
        assert_eq!(b.limits_n, None, "the file of the ensemble states none");
        let mut old = ModelFile::from_json(text).unwrap();
        old.interval = None;
        let old = old.to_json().unwrap().replacen('{', "{\n  \"discrepancy\": 0.25,", 1);
        let plain = parse_estimator("m.json", &old).unwrap().estimate(&slip).unwrap();
        assert_eq!((plain.force_n, plain.sigma_n, plain.limits_n), (a.force_n, a.sigma_n, None));
        assert!((super::sigmas(0.9) - 1.644_854).abs() < 1e-5, "{}", super::sigmas(0.9));
        let error = parse_estimator("e.json", &ensemble(MAX_MEMBERS + 1)).unwrap_err();
        assert!(error.to_string().contains("at most 4 networks"), "{error}");
        let error = parse_estimator("e.json", &ensemble(2).replace("ln", "log")).unwrap_err();
        assert!(matches!(error, ModelError::File { .. }), "{error}");
    }
}
