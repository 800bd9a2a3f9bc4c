//! One file per command; each takes its arguments and gives the exit code of the contract.

mod attach;
pub(crate) mod calibrate;
mod card;
mod clock;
pub(crate) mod collect;
mod columns;
pub(crate) mod command;
pub(crate) mod csv;
pub(crate) mod demo;
pub(crate) mod doctor;
pub(crate) mod esc;
pub(crate) mod estimate;
pub(crate) mod eval;
pub(crate) mod export;
mod export_verify;
pub(crate) mod generate;
pub(crate) mod grasp;
mod hyper;
pub(crate) mod import;
pub(crate) mod label;
mod measure;
pub(crate) mod objects;
pub(crate) mod ports;
pub(crate) mod profile;
mod profile_plot;
pub(crate) mod recover;
pub(crate) mod replay;
mod replay_plot;
mod replay_tape;
pub(crate) mod score;
mod score_curve;
pub(crate) mod search;
pub(crate) mod sim;
mod source;
pub(crate) mod status;
pub(crate) mod study;
pub(crate) mod train;
mod train_beyond;

use crate::{
    cli::{self, CsvArgs},
    output,
};
use grip_record::{CsvOptions, Recording, TimeUnit, files, read_recording};
use grip_session::{
    HostConfig, HostConfigError, HostEstimator, ModelError, exit::WrongArgument, model,
};
use grip_sim::{Scene, scene};
use mlp::train::ModelFile;
use std::path::Path;

fn csv_options(args: &CsvArgs) -> anyhow::Result<CsvOptions> {
    let map = args.map.iter().map(|pair| {
        let (ours, theirs) = pair.split_once('=').ok_or_else(|| {
            WrongArgument(format!("--map {pair}: expected OURS=NAME, for example stylus=height_m"))
        })?;
        Ok((ours.to_owned(), theirs.to_owned()))
    });
    let time_unit = args.time_unit.map(|unit| match unit {
        cli::TimeUnit::S => TimeUnit::Seconds,
        cli::TimeUnit::Ms => TimeUnit::Millis,
        cli::TimeUnit::Us => TimeUnit::Micros,
        cli::TimeUnit::Ns => TimeUnit::Nanos,
    });
    let map = map.collect::<anyhow::Result<_>>()?;
    Ok(CsvOptions { rate_hz: args.rate, map, time_unit, finger: None })
}

fn host_config(file: Option<&Path>) -> Result<HostConfig, HostConfigError> {
    file.map_or_else(|| Ok(HostConfig::default()), HostConfig::read)
}

fn calibrated_config(
    file: Option<&Path>,
    calibration: Option<&Path>,
) -> Result<HostConfig, HostConfigError> {
    let config = host_config(file)?;
    calibration.map_or(Ok(config.clone()), |calibration| config.with_calibration(calibration))
}

fn estimator(model_file: Option<&Path>, config: &HostConfig) -> Result<HostEstimator, ModelError> {
    let file = model_file.or(config.model.as_deref());
    let estimator = file.map_or_else(model::default_estimator, model::read_estimator)?;
    if let Some((file, text)) = file.zip(model::weakness(&estimator)) {
        output::remark(format!("gripctl: model {}", file.display()), text);
    }
    Ok(estimator)
}

/// A scene, with another seed than its own where one is given.
fn scene(name: &str, seed: Option<u64>) -> anyhow::Result<Scene> {
    let scene = scene::open(name)?;
    Ok(match seed {
        Some(seed) => scene.reseeded(seed)?,
        None => scene,
    })
}

/// A number of the command line that must be positive and finite, or also zero if `zero`.
fn checked(flag: &str, value: f64, zero: bool) -> Result<f64, WrongArgument> {
    if value.is_finite() && (value > 0.0 || (zero && value == 0.0)) {
        return Ok(value);
    }
    let expected = if zero { "0 or more" } else { "more than 0" };
    Err(WrongArgument(format!("{flag} {value}: expected a number of {expected}")))
}

/// A recording as one: CSV, `.npz`, `.mcap` of ours, or a file of another program, as `gripctl replay` takes it.
fn recording(file: &Path, csv: &CsvArgs) -> anyhow::Result<Recording> {
    if replay::is_mcap(file) {
        return Ok(grip_session::recording::read_mcap(file)?);
    }
    let csv = csv_options(csv)?;
    if grip_import::is_foreign(file) {
        return import::shown(file, &csv);
    }
    let recording = read_recording(file, &csv)?;
    import::show_uses(file, &recording.notes.uses);
    recording.notes.remarks.iter().for_each(|remark| output::remark(file.display(), remark));
    Ok(recording)
}

/// An input that cannot be read.
fn unreadable(file: &Path) -> impl FnOnce(std::io::Error) -> WrongArgument {
    move |error| WrongArgument(format!("{}: cannot be read ({error})", file.display()))
}

fn read(file: &Path) -> Result<Vec<u8>, WrongArgument> {
    files::read(file, files::MOST_TABLE).map_err(unreadable(file))
}

/// A model file and its text.
fn model_file(file: &Path) -> Result<(ModelFile, String), ModelError> {
    let text = model::read_text(file)?;
    let content = ModelFile::from_json(&text)
        .map_err(|fault| ModelError::File { file: file.display().to_string(), fault })?;
    Ok((content, text.into_owned()))
}
