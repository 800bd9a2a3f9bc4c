//! Model cards on disk: where they lie, how they are read and written.

use crate::{cli::ForceArgs, output};
use grip_record::{
    files,
    outputs::{OutputError, OutputPath},
};
use mlp::export::card::Card;
use mlp::train::{DataSet, Fit, FitConfig};
use std::path::{Path, PathBuf};

/// The card that lies beside the file `path`: `force.json` and `force.c` have `force.card.json`.
pub(super) fn path_beside(path: &Path) -> PathBuf {
    path.with_extension("card.json")
}

/// `--card`, or the place beside `path`; never that of a file in `inputs` or `outputs`.
pub(super) fn output(
    given: Option<&Path>,
    path: &Path,
    force: &ForceArgs,
    inputs: &[Option<&Path>],
    outputs: &[&Path],
) -> Result<OutputPath, OutputError> {
    let card = given.map_or_else(|| path_beside(path), Path::to_owned);
    let card = output::path(&card, output::CARD, force, inputs)?;
    outputs.iter().try_fold(card, |card, other| card.apart_from(other))
}

/// The first of `paths` that holds the card of the model with the contents `text`.
pub(super) fn known(paths: &[&Path], text: &str) -> Option<Card> {
    let read = |path: &&Path| Card::from_json(&files::read_text(path, files::MOST_MODEL).ok()?);
    paths.iter().filter_map(read).find(|card| card.is_of(text))
}

/// The card of a model that has just been trained: `name` and `text` are its file.
pub(super) fn trained(
    name: &str,
    text: &str,
    fit: &Fit,
    config: &FitConfig,
    train: &DataSet,
    test: Option<&DataSet>,
) -> Card {
    let test = test.zip(fit.test.as_ref());
    Card::new(&fit.file, name, text)
        .with_settings(concat!("gripctl ", env!("CARGO_PKG_VERSION")), config)
        .with_rows((train, &fit.train), test, &split(fit, test.is_some()))
}

/// How rows were kept away from the training, in words.
fn split(fit: &Fit, tested: bool) -> String {
    let Some(note) = fit.file.training.as_ref().and_then(|training| training.split.as_ref()) else {
        let words =
            if tested { "a file of its own for the test rows" } else { "none: no test rows" };
        return words.to_owned();
    };
    let share = |share: Option<f64>, name: &str| {
        share.map(|share| format!("{share} of the rows for {name}"))
    };
    let parts = [share(note.holdout, "the test"), share(note.validation, "validation")];
    let by =
        note.by.as_ref().map_or_else(|| "row".to_owned(), |column| format!("group of {column}"));
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!("{}, by {by}, seed {}", parts.join(", "), note.seed)
}
