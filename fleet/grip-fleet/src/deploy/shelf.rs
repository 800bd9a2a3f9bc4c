//! A folder in; the models of one gripper, and which of them it has accepted, kept over an end of its daemon out.
//!
//! `SHA256.json` are models, `standing.json` is [`Lasting`], `history.json` is [`History`]. Each file is written beside its place, synced and renamed: after a crash there is the
//! old one or the new one. A model is read only where its SHA-256 is that of its name.

use super::{History, Lasting, ModelId, examine::digest};
use std::{
    fs::{self, File, TryLockError},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

const STANDING: &str = "standing.json";
const HISTORY: &str = "history.json";

/// Why models cannot be kept.
#[derive(Debug, thiserror::Error)]
pub enum ShelfError {
    /// Folder or file cannot be used.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Another daemon keeps its models there.
    #[error("{}: another gripd keeps its models there", path.display())]
    Locked {
        /// The folder.
        path: PathBuf,
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

/// The folder, for one daemon at a time.
#[derive(Debug)]
pub struct Shelf {
    folder: PathBuf,
    _lock: File,
}

impl Shelf {
    /// Opens the folder, which is made where it is missing; what an earlier run has left there.
    ///
    /// # Errors
    /// [`ShelfError`].
    pub fn open(folder: &Path) -> Result<(Self, Lasting), ShelfError> {
        fs::create_dir_all(folder).map_err(at(folder))?;
        let path = folder.join("lock");
        let lock = File::options().create(true).append(true).open(&path).map_err(at(&path))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(ShelfError::Locked { path: folder.to_owned() });
            }
            Err(TryLockError::Error(source)) => return Err(ShelfError::File { path, source }),
        }
        let shelf = Self { folder: folder.to_owned(), _lock: lock };
        let path = folder.join(STANDING);
        let lasting = match fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes)
                .map_err(|error| ShelfError::Content { path, reason: error.to_string() })?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Lasting::default(),
            Err(source) => return Err(ShelfError::File { path, source }),
        };
        Ok((shelf, lasting))
    }

    /// Keeps a model.
    ///
    /// # Errors
    /// [`ShelfError::File`].
    pub fn put(&self, model: &ModelId, text: &str) -> Result<(), ShelfError> {
        self.write(&file_of(model), text.as_bytes())
    }

    /// The text of a model that is kept.
    ///
    /// # Errors
    /// [`ShelfError`], also where it is another one than its name states.
    pub fn read(&self, model: &ModelId) -> Result<String, ShelfError> {
        let path = self.folder.join(file_of(model));
        let text = fs::read_to_string(&path).map_err(at(&path))?;
        if digest(text.as_bytes()) == model.sha256 {
            return Ok(text);
        }
        let reason = "the file has another SHA-256 than its name says".to_owned();
        Err(ShelfError::Content { path, reason })
    }

    /// Which roll-outs were here; none where no file is there.
    ///
    /// # Errors
    /// [`ShelfError`].
    pub fn history(&self) -> Result<History, ShelfError> {
        let path = self.folder.join(HISTORY);
        match fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes)
                .map_err(|error| ShelfError::Content { path, reason: error.to_string() }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(History::default()),
            Err(source) => Err(ShelfError::File { path, source }),
        }
    }

    /// Keeps which roll-outs were here.
    ///
    /// # Errors
    /// [`ShelfError`].
    pub fn note_history(&self, history: &History) -> Result<(), ShelfError> {
        let path = || self.folder.join(HISTORY);
        let bytes = serde_json::to_vec_pretty(history)
            .map_err(|error| ShelfError::Content { path: path(), reason: error.to_string() })?;
        self.write(HISTORY, &bytes)
    }

    /// Keeps how it stands, and lets go of models that nothing names any more.
    ///
    /// # Errors
    /// [`ShelfError::File`].
    pub fn note(&self, lasting: &Lasting) -> Result<(), ShelfError> {
        let path = || self.folder.join(STANDING);
        let bytes = serde_json::to_vec_pretty(lasting)
            .map_err(|error| ShelfError::Content { path: path(), reason: error.to_string() })?;
        self.write(STANDING, &bytes)?;
        let named = [&lasting.accepted, &lasting.before, &lasting.trial];
        let named: Vec<String> = named.into_iter().flatten().map(file_of).collect();
        for entry in fs::read_dir(&self.folder).map_err(at(&self.folder))?.flatten() {
            let name = entry.file_name();
            let Some(name) = name.to_str() else { continue };
            let is_model = name.len() == 69 && name.ends_with(".json");
            if is_model && !named.iter().any(|named| named == name) {
                fs::remove_file(entry.path()).map_err(at(&entry.path()))?;
            }
        }
        Ok(())
    }

    /// The fault of a file that holds what it should and is of no use all the same.
    pub(super) fn unusable(&self, model: &ModelId, reason: String) -> ShelfError {
        ShelfError::Content { path: self.folder.join(file_of(model)), reason }
    }

    /// Beside its place, then in it.
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ShelfError> {
        let (path, new) = (self.folder.join(name), self.folder.join("new"));
        let mut file = File::create(&new).map_err(at(&new))?;
        file.write_all(bytes).and_then(|()| file.sync_all()).map_err(at(&new))?;
        fs::rename(&new, &path).map_err(at(&path))?;
        File::open(&self.folder).and_then(|folder| folder.sync_all()).map_err(at(&self.folder))
    }
}

fn file_of(model: &ModelId) -> String {
    format!("{}.json", model.sha256)
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> ShelfError + use<> {
    let path = path.to_owned();
    move |source| ShelfError::File { path, source }
}

#[cfg(test)]
mod tests {
    use super::{Lasting, ModelId, Shelf, digest};
    use std::fs;

    #[test]
    fn what_is_kept_is_there_at_the_next_start_and_the_rest_is_let_go() {
        let folder = tempfile::tempdir().unwrap();
        let model = |text: &str| ModelId { name: "m".to_owned(), sha256: digest(text.as_bytes()) };
        let lasting = Lasting { accepted: Some(model("two")), ..Lasting::default() };
        {
            let (shelf, empty) = Shelf::open(folder.path()).unwrap();
            assert_eq!(empty, Lasting::default());
            shelf.put(&model("one"), "one").unwrap();
            shelf.put(&model("two"), "two").unwrap();
            shelf.note(&lasting).unwrap();
            let second = Shelf::open(folder.path()).unwrap_err().to_string();
            assert!(second.ends_with("another gripd keeps its models there"), "{second}");
        }
        let (shelf, found) = Shelf::open(folder.path()).unwrap();
        assert_eq!(found, lasting);
        assert_eq!(shelf.read(&model("two")).unwrap(), "two");
        assert!(shelf.read(&model("one")).is_err(), "nothing names it");
    }

    #[test]
    fn a_file_that_was_changed_is_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let (shelf, _) = Shelf::open(folder.path()).unwrap();
        let model = ModelId { name: "m".to_owned(), sha256: digest(b"one") };
        shelf.put(&model, "one").unwrap();
        fs::write(folder.path().join(format!("{}.json", model.sha256)), "other").unwrap();
        let reported = shelf.read(&model).unwrap_err().to_string();
        assert!(reported.ends_with("another SHA-256 than its name says"), "{reported}");
        fs::write(folder.path().join("standing.json"), "{").unwrap();
        drop(shelf);
        let reported = Shelf::open(folder.path()).unwrap_err().to_string();
        assert!(reported.contains("standing.json: EOF"), "{reported}");
    }
}
