//! Files in which a program keeps its own state: of one program at a time, each replaced as a whole.

use core::fmt::Display;
use serde::{Serialize, de::DeserializeOwned};
use std::{
    fs::{self, File, TryLockError},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

/// Why state cannot be kept.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Folder or file cannot be used.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Another program keeps its state there.
    #[error("{}: {by}", path.display())]
    Locked {
        /// The folder.
        path: PathBuf,
        /// Which one, as a sentence.
        by: &'static str,
    },
    /// The file states something else.
    #[error("{}: {reason}", path.display())]
    Content {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

/// The fault of a folder or file.
pub(crate) fn at(path: &Path) -> impl Fn(io::Error) -> StoreError + use<> {
    let path = path.to_owned();
    move |source| StoreError::File { path: path.clone(), source }
}

/// The fault of what stands in a file.
pub(crate) fn content(path: &Path, reason: &dyn Display) -> StoreError {
    StoreError::Content { path: path.to_owned(), reason: reason.to_string() }
}

/// Takes a folder, which is made where it is missing, by a file of this name in it, until the file is dropped or the process ends.
pub(crate) fn lock(folder: &Path, name: &str, by: &'static str) -> Result<File, StoreError> {
    fs::create_dir_all(folder).map_err(at(folder))?;
    let path = folder.join(name);
    let file = File::options().create(true).append(true).open(&path).map_err(at(&path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StoreError::Locked { path: folder.to_owned(), by }),
        Err(TryLockError::Error(source)) => Err(at(&path)(source)),
    }
}

/// What a JSON file holds; nothing, where there is none.
pub(crate) fn read<T: DeserializeOwned + Default>(path: &Path) -> Result<T, StoreError> {
    match fs::read(path) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|error| content(path, &error)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(T::default()),
        Err(source) => Err(at(path)(source)),
    }
}

/// Beside its place, synced, then in it: after a crash there is the old file or the new one.
pub(crate) fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
    let new = folder.join(format!("{name}.new"));
    let mut file = File::create(&new).map_err(at(&new))?;
    file.write_all(bytes).map_err(at(&new))?;
    rename(&new, &file, folder, name)
}

/// What [`read`] reads.
pub(crate) fn write_json(
    folder: &Path,
    name: &str,
    what: &impl Serialize,
) -> Result<(), StoreError> {
    let bytes = serde_json::to_vec_pretty(what);
    let bytes = bytes.map_err(|error| content(&folder.join(name), &error))?;
    write(folder, name, &bytes)
}

/// Gives a finished file its name, on disk too.
pub(crate) fn rename(
    from: &Path,
    file: &File,
    folder: &Path,
    name: &str,
) -> Result<(), StoreError> {
    file.sync_all().map_err(at(from))?;
    fs::rename(from, folder.join(name)).map_err(at(from))?;
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(at(folder))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of a user may hold anything.
    #[test]
    fn what_lies_beside_the_state_stays() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        fs::write(folder.join("new"), "mine").unwrap();
        write(folder, "a.json", b"1").unwrap();
        write(folder, "b.json", b"2").unwrap();
        let kept = |name| read::<u8>(&folder.join(name)).unwrap();
        assert_eq!((kept("a.json"), kept("b.json"), kept("c.json")), (1, 2, 0));
        assert_eq!(fs::read(folder.join("new")).unwrap(), b"mine");
        assert_eq!(fs::read_dir(folder).unwrap().count(), 3);
    }
}
