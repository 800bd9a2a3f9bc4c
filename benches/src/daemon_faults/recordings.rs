//! Recordings that a fault left behind in; whether they can be read or recovered, and where their samples end, out.

use anyhow::{Context as _, Result, ensure};
use grip_record::mcap::{Entry, McapError, McapReader, Record, no_unpack, recover};
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// What a recording holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// It can be read to its end: nothing had to be recovered.
    pub whole: bool,
    /// Not even its first bytes were written.
    pub empty: bool,
    /// Samples.
    pub samples: u64,
    /// Number of the last row; of the last pipeline, where there are several.
    pub last_row: Option<u32>,
}

/// Reads `file`, after a recovery (into memory: the disk may be full) where it was cut off.
///
/// # Errors
/// Where it can be neither read nor recovered, a log time goes back, or rows of a pipeline are not in their order.
pub fn read(file: &Path) -> Result<Found> {
    let bytes = fs::read(file).or_else(|error| match error.kind() {
        io::ErrorKind::NotFound => Ok(Vec::new()),
        _ => Err(error).with_context(|| file.display().to_string()),
    })?;
    if bytes.is_empty() {
        return Ok(Found { empty: true, ..Found::default() });
    }
    if let Ok(found) = walk(file, &bytes) {
        return Ok(Found { whole: true, ..found });
    }
    let mut saved = Vec::new();
    let recovered = recover(file, bytes.as_slice(), &mut saved, "daemon-faults", no_unpack);
    let recovered = recovered.with_context(|| file.display().to_string())?;
    let holes = recovered.holes;
    ensure!(holes.is_empty(), "{}: damaged in the middle: {holes:?}", file.display());
    walk(file, &saved).with_context(|| format!("{}: after its recovery", file.display()))
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
///
/// # Errors
/// As [`read`].
pub fn read_all(folder: &Path) -> Result<Vec<(PathBuf, Found)>> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let file = entry.with_context(|| folder.display().to_string())?.path();
        if file.extension().is_some_and(|end| end == "mcap") {
            let found = read(&file)?;
            all.push((file, found));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::{Found, read};
    use grip_record::mcap::McapWriter;
    use std::fs;

    #[test]
    fn whole_cut_and_empty_recordings_are_told_apart_and_rubbish_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.mcap");
        fs::write(&file, "").unwrap();
        assert_eq!(read(&file).unwrap(), Found { empty: true, ..Found::default() });
        let mut bytes = Vec::new();
        McapWriter::new(&mut bytes, "test", 5).unwrap().finish().unwrap();
        fs::write(&file, &bytes).unwrap();
        assert_eq!(read(&file).unwrap(), Found { whole: true, ..Found::default() });
        fs::write(&file, &bytes[..30]).unwrap();
        assert_eq!(read(&file).unwrap(), Found::default());
        fs::write(&file, "rubbish, and more than a few bytes of it").unwrap();
        assert!(read(&file).is_err());
    }
}
