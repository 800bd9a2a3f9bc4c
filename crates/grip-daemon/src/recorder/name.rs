//! Names of files that nobody has written yet, from a wanted file and a number.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// The highest number that is tried.
const LAST: u32 = 999_999;

/// `run.mcap` for 0, else `run-0001.mcap` and so on.
pub(super) fn numbered(file: &Path, number: u32) -> PathBuf {
    if number == 0 {
        return file.to_owned();
    }
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let ending = file.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    file.with_file_name(format!("{stem}-{number:04}{ending}"))
}

/// Creates the first file from `number` on that is not there or is empty: it, its name and its number. What is no regular file
/// (a pipe, a device) is opened as it is.
pub(super) fn create(file: &Path, number: u32) -> io::Result<(File, PathBuf, u32)> {
    for number in number..=LAST {
        let name = numbered(file, number);
        let taken = match name.metadata() {
            Ok(meta) => meta.is_file() && meta.len() > 0,
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            Err(error) => return Err(error),
        };
        if !taken {
            let out = OpenOptions::new().write(true).create(true).truncate(false).open(&name)?;
            lock(&out)?;
            return Ok((out, name, number));
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, "every name up to number 999999 is taken"))
}

/// Reports to others that the file is being written; a file system without locks, or a pipe, cannot.
fn lock(out: &File) -> io::Result<()> {
    match out.try_lock() {
        Err(TryLockError::WouldBlock) => {
            Err(io::Error::new(io::ErrorKind::ResourceBusy, "another program is writing it"))
        }
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::{create, numbered};
    use std::path::Path;

    #[test]
    fn numbers_stand_before_the_ending() {
        assert_eq!(numbered(Path::new("a/run.mcap"), 0), Path::new("a/run.mcap"));
        assert_eq!(numbered(Path::new("a/run.mcap"), 1), Path::new("a/run-0001.mcap"));
        assert_eq!(numbered(Path::new("run"), 12_345), Path::new("run-12345"));
    }

    #[test]
    fn what_was_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        let wanted = folder.path().join("run.mcap");
        let number = |from| create(&wanted, from).unwrap().2;
        assert_eq!(number(0), 0);
        assert_eq!(number(0), 0, "an empty file is free");
        std::fs::write(&wanted, "x").unwrap();
        std::fs::write(folder.path().join("run-0001.mcap"), "x").unwrap();
        assert_eq!((number(0), number(2)), (2, 2));
        assert!(create(&folder.path().join("nowhere/run.mcap"), 0).is_err());
    }
}
