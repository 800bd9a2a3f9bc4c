//! Search for recordings in folders and files, in the order in which they go on.

use grip_record::{
    CsvError, LabelError,
    mcap::{Entry, McapReader},
};
use grip_session::{
    recording::{ABOUT, PART, RUN},
    tape::TapeError,
};
use slip_core::ConfigError;
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Names of what lies beside CSV recordings.
const BESIDE: [&str; 3] = ["_pose", "_taxels", "_electrodes"];
/// Folders within folders, at most.
const DEEPEST: usize = 16;

/// Why rows cannot be collected.
#[derive(Debug, thiserror::Error)]
pub enum CollectError {
    /// A place that is not there, or cannot be read.
    #[error("{}: cannot be read: {source}", place.display())]
    Place {
        /// The place.
        place: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Nothing to read.
    #[error("{}: no recording in it; .mcap and .csv are looked for, also in the folders inside", place.display())]
    Nothing {
        /// The folder.
        place: PathBuf,
    },
    /// A file of another kind.
    #[error("{}: is no recording; they end with .mcap, .csv or .npz", file.display())]
    Kind {
        /// The file.
        file: PathBuf,
    },
    /// An MCAP recording.
    #[error(transparent)]
    Tape(#[from] TapeError),
    /// A CSV recording.
    #[error(transparent)]
    Csv(#[from] CsvError),
    /// The labels beside one.
    #[error(transparent)]
    Labels(#[from] LabelError),
    /// Settings that do not fit a CSV recording.
    #[error("{}: {source}", file.display())]
    Settings {
        /// The file.
        file: PathBuf,
        /// What does not fit.
        source: ConfigError,
    },
}

/// One recording: the files of a run that go on in each other, or one CSV file or `.npz`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Recorded {
    pub(super) files: Vec<PathBuf>,
    /// Whether it was named, not found: then it must be one.
    pub(super) named: bool,
}

impl Recorded {
    pub(super) fn is_mcap(&self) -> bool {
        self.files.iter().any(|file| ends(file, "mcap"))
    }
}

fn ends(file: &Path, ending: &str) -> bool {
    file.extension().is_some_and(|known| known.eq_ignore_ascii_case(ending))
}

/// All recordings in `places`, each file once, but not those of `without`.
pub(super) fn find(places: &[PathBuf], without: &[PathBuf]) -> Result<Vec<Recorded>, CollectError> {
    // What is not there yet is not found either.
    let without: Vec<PathBuf> =
        without.iter().filter_map(|file| file.canonicalize().ok()).collect();
    let is_wanted = |file: &Path| file.canonicalize().map_or(true, |file| !without.contains(&file));
    let mut files: Vec<(PathBuf, bool)> = Vec::new();
    for place in places {
        let unreadable = |source| CollectError::Place { place: place.clone(), source };
        if !fs::metadata(place).map_err(unreadable)?.is_dir() {
            if !["mcap", "csv", "npz"].iter().any(|ending| ends(place, ending)) {
                return Err(CollectError::Kind { file: place.clone() });
            }
            files.push((place.clone(), true));
            continue;
        }
        let before = files.len();
        walk(place, DEEPEST, &mut files)?;
        files.retain(|(file, named)| *named || is_wanted(file));
        if files.len() == before {
            return Err(CollectError::Nothing { place: place.clone() });
        }
    }
    files.sort();
    files.dedup_by(|later, first| {
        let same = later.0 == first.0;
        first.1 |= same && later.1;
        same
    });
    Ok(runs(files))
}

/// Links are not followed: a folder may be its own.
fn walk(
    folder: &Path,
    deepest: usize,
    files: &mut Vec<(PathBuf, bool)>,
) -> Result<(), CollectError> {
    let unreadable = |source| CollectError::Place { place: folder.to_owned(), source };
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let kind = entry.file_type().map_err(unreadable)?;
        let path = entry.path();
        if kind.is_dir() && deepest > 0 {
            walk(&path, deepest - 1, files)?;
        } else if kind.is_file() && is_recording(&path) {
            files.push((path, false));
        }
    }
    Ok(())
}

fn is_recording(file: &Path) -> bool {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let tables = ["labels", "phases", "alarms"];
    let beside =
        || tables.contains(&stem.as_ref()) || BESIDE.iter().any(|ending| stem.ends_with(ending));
    ends(file, "mcap") || ends(file, "csv") && !beside()
}

/// Puts the files of one run together. What has no run stands for itself.
fn runs(files: Vec<(PathBuf, bool)>) -> Vec<Recorded> {
    let mut reported: Vec<(Option<Place>, PathBuf, bool)> =
        files.into_iter().map(|(file, named)| (place(&file), file, named)).collect();
    reported.sort_by(|one, other| (&one.0, &one.1).cmp(&(&other.0, &other.1)));
    let mut all: Vec<Recorded> = Vec::new();
    let mut last: Option<Place> = None;
    for (place, file, named) in reported {
        let goes_on = last.as_ref().zip(place.as_ref()).is_some_and(|(last, place)| {
            (&last.folder, &last.run, last.part + 1) == (&place.folder, &place.run, place.part)
        });
        match all.last_mut().filter(|_| goes_on) {
            Some(before) => {
                before.named |= named;
                before.files.push(file);
            }
            None => all.push(Recorded { files: vec![file], named }),
        }
        last = place;
    }
    all.sort_by(|one, other| one.files.cmp(&other.files));
    all
}

/// Which part of which run a file is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    folder: PathBuf,
    run: String,
    part: u64,
}

/// It stands before the first message. Whatever is wrong with the file is reported when it is read.
fn place(file: &Path) -> Option<Place> {
    if !ends(file, "mcap") {
        return None;
    }
    let mut reader = McapReader::open(file).ok()?;
    while let Ok(Some(entry)) = reader.next_entry() {
        match entry {
            Entry::Metadata { name, values } if name == ABOUT => {
                let run = values.get(RUN).filter(|run| !run.is_empty())?.clone();
                let part = values.get(PART)?.parse().ok()?;
                return Some(Place { folder: file.parent()?.to_owned(), run, part });
            }
            Entry::Message { .. } => return None,
            Entry::Metadata { .. } | Entry::Attachment { .. } => {}
        }
    }
    None
}
