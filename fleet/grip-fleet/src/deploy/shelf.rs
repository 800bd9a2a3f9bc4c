//! Folder of the models of one gripper, and which of them it has accepted, kept over an end of its daemon.
//!
//! `SHA256.json` are models, `standing.json` is [`Lasting`], `history.json` is [`History`]. A model is read only where its SHA-256 is that of its name.

use super::{History, Lasting, ModelId, examine::digest};
use crate::store::{StoreError, at, content, lock, read, write};
use serde::Serialize;
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

const STANDING: &str = "standing.json";
const HISTORY: &str = "history.json";

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
    /// [`StoreError`].
    pub fn open(folder: &Path) -> Result<(Self, Lasting), StoreError> {
        let lock = lock(folder, "lock", "another gripd keeps its models there")?;
        let lasting = read(&folder.join(STANDING))?;
        Ok((Self { folder: folder.to_owned(), _lock: lock }, lasting))
    }

    /// Keeps a model.
    ///
    /// # Errors
    /// [`StoreError::File`].
    pub fn put(&self, model: &ModelId, text: &str) -> Result<(), StoreError> {
        write(&self.folder, &file_of(model), text.as_bytes())
    }

    /// The text of a model that is kept.
    ///
    /// # Errors
    /// [`StoreError`], also where it is another one than its name states.
    pub fn read(&self, model: &ModelId) -> Result<String, StoreError> {
        let path = self.folder.join(file_of(model));
        let text = fs::read_to_string(&path).map_err(at(&path))?;
        if digest(text.as_bytes()) == model.sha256 {
            return Ok(text);
        }
        Err(content(&path, &"the file has another SHA-256 than its name says"))
    }

    /// Which roll-outs were here; none where no file is there.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn history(&self) -> Result<History, StoreError> {
        read(&self.folder.join(HISTORY))
    }

    /// Keeps which roll-outs were here.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn note_history(&self, history: &History) -> Result<(), StoreError> {
        self.json(HISTORY, history)
    }

    /// Keeps how it stands, and lets go of models that nothing names any more.
    ///
    /// # Errors
    /// [`StoreError::File`].
    pub fn note(&self, lasting: &Lasting) -> Result<(), StoreError> {
        self.json(STANDING, lasting)?;
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
    pub(super) fn unusable(&self, model: &ModelId, reason: &str) -> StoreError {
        content(&self.folder.join(file_of(model)), &reason)
    }

    fn json(&self, name: &str, what: &impl Serialize) -> Result<(), StoreError> {
        let bytes = serde_json::to_vec_pretty(what);
        let bytes = bytes.map_err(|error| content(&self.folder.join(name), &error))?;
        write(&self.folder, name, &bytes)
    }
}

fn file_of(model: &ModelId) -> String {
    format!("{}.json", model.sha256)
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
