//! Every file of `good` and of the examples is accepted without a warning but those it names; every file of `bad` is refused
//! with the message in the `.txt` beside it.

use grip_session::config::{Layers, advice};
use std::{
    fs,
    path::{Path, PathBuf},
};

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|file| file.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    files
}

/// The warnings of a file, one a line.
fn accepted(file: &Path) -> String {
    let layers = Layers::file(file).unwrap();
    let config = layers.resolve().unwrap_or_else(|error| panic!("{error}"));
    let warnings = advice::warnings(&config, &layers.settings().unwrap());
    warnings.iter().map(|warning| format!("{warning}\n")).collect()
}

#[test]
fn good_files_are_accepted_and_warn_of_what_they_say() {
    let files = files("tests/config/good");
    assert!(files.len() >= 8, "{}", files.len());
    for file in files {
        let expected = fs::read_to_string(file.with_extension("txt")).unwrap_or_default();
        assert_eq!(accepted(&file), expected, "{}", file.display());
    }
}

#[test]
fn examples_are_accepted_without_a_warning() {
    let files = files("../../docs/examples");
    assert!(files.len() >= 6, "{}", files.len());
    for file in files.iter().filter(|file| !file.ends_with("fragile-cal.toml")) {
        assert_eq!(accepted(file), "", "{}", file.display());
    }
}

#[test]
fn bad_files_are_refused_with_their_message() {
    let files = files("tests/config/bad");
    assert!(files.len() >= 24, "{}", files.len());
    for file in files {
        let reported =
            Layers::file(&file).and_then(|layers| layers.resolve()).unwrap_err().to_string();
        let folder = format!("{}/", file.parent().unwrap().display());
        let reported = format!("{}\n", reported.replace(&folder, ""));
        let expected = fs::read_to_string(file.with_extension("txt")).unwrap_or_default();
        assert_eq!(reported, expected, "{}", file.display());
    }
}
