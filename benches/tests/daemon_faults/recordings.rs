//! Check of recordings that a fault left behind: whether they can be read or recovered, and where their samples end.

use grip_record::mcap::{Entry, McapError, McapReader, Record, no_unpack, recover};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// What a recording holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Found {
    /// Samples.
    pub(crate) samples: u64,
    /// Number of the last row; of the last pipeline, where there are several.
    pub(crate) last_row: Option<u32>,
}

/// Reads `file`, after a recovery where it was cut off; it may be empty, or not even there. Panics where it can be neither read nor
/// recovered, a log time goes back, or rows of a pipeline are not in their order.
pub(crate) fn read(file: &Path) -> Found {
    let bytes = fs::read(file).unwrap_or_default();
    if bytes.is_empty() {
        return Found::default();
    }
    if let Ok(found) = walk(file, &bytes) {
        return found;
    }
    let mut saved = Vec::new();
    let recovered = recover(file, bytes.as_slice(), &mut saved, "daemon-faults", no_unpack);
    let holes = recovered.unwrap().holes;
    assert!(holes.is_empty(), "{}: damaged in the middle: {holes:?}", file.display());
    walk(file, &saved).unwrap()
}

fn walk(file: &Path, bytes: &[u8]) -> Result<Found, McapError> {
    let mut reader = McapReader::new(file, bytes)?;
    let (mut found, mut log_before) = (Found::default(), 0);
    let disorder = |what: String| McapError::Foreign { file: file.to_owned(), what };
    while let Some(entry) = reader.next_entry()? {
        let Entry::Message { log_ns, record } = entry else { continue };
        if log_ns < log_before {
            return Err(disorder(format!("log time went back from {log_before} to {log_ns}")));
        }
        log_before = log_ns;
        match record {
            Record::Pipeline(_) => found.last_row = None,
            Record::Sample(sample) => {
                if found.last_row.is_some_and(|last| last >= sample.index) {
                    return Err(disorder(format!("row {} comes twice", sample.index)));
                }
                found.last_row = Some(sample.index);
                found.samples += 1;
            }
            _ => {}
        }
    }
    Ok(found)
}

/// Every MCAP file in `folder`, read or recovered.
pub(crate) fn read_all(folder: &Path) -> Vec<(PathBuf, Found)> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = files.filter(|file| file.extension().is_some_and(|end| end == "mcap"));
    files.map(|file| (file.clone(), read(&file))).collect()
}
