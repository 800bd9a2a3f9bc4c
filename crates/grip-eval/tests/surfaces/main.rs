//! Real surfaces: profilometer traces against the instrument's own evaluation and played as a stylus signal, and
//! a finger over ridged boards. The recordings are no part of the project.
#![expect(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "test code")]

mod boards;
mod traces;

use std::path::{Path, PathBuf};

/// The files of the folder `name` of the real recordings whose name ends in `ending`.
fn recordings(name: &str, ending: &str) -> Vec<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("GRIP_DATA").map_or_else(beside, PathBuf::from).join(name);
    assert!(folder.is_dir(), "no folder {}: set GRIP_DATA", folder.display());
    let entries = std::fs::read_dir(&folder).unwrap();
    let files = entries.map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files.filter(|f| f.to_string_lossy().ends_with(ending)).collect();
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    files
}

fn name(file: &Path) -> String {
    file.file_stem().unwrap().to_string_lossy().into_owned()
}
