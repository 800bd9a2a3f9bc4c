//! Folder of the models of one gripper, and which of them it has accepted, kept over an end of its daemon.
//!
//! `SHA256.json` are models, `standing.json` is [`Lasting`], `history.json` is [`History`]. A model is read only where its SHA-256 is that of its name.

use super::{History, Lasting, ModelId, examine::digest};
use crate::store::{StoreError, at, content, lock, read, write, write_json};
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

const STANDING: &str = "standing.json";
const HISTORY: &str = "history.json";

/// The folder, for one daemon at a time.
#[derive(Debug)]
pub(super) struct Shelf {
    folder: PathBuf,
    _lock: File,
}

impl Shelf {
    /// Opens the folder, which is made where it is missing; what an earlier run has left there.
    pub(super) fn open(folder: &Path) -> Result<(Self, Lasting), StoreError> {
        let lock = lock(folder, "lock", "another gripd keeps its models there")?;
        let lasting = read(&folder.join(STANDING))?;
        Ok((Self { folder: folder.to_owned(), _lock: lock }, lasting))
    }

    /// Keeps a model.
    pub(super) fn put(&self, model: &ModelId, text: &str) -> Result<(), StoreError> {
        write(&self.folder, &file_of(model), text.as_bytes())
    }

    /// The text of a model that is kept.
    pub(super) fn read(&self, model: &ModelId) -> Result<String, StoreError> {
        let path = self.folder.join(file_of(model));
        let text = fs::read_to_string(&path).map_err(at(&path))?;
        if digest(text.as_bytes()) == model.sha256 {
            return Ok(text);
        }
        Err(content(&path, &"the file has another SHA-256 than its name says"))
    }

    /// Which roll-outs were here; none where no file is there.
    pub(super) fn history(&self) -> Result<History, StoreError> {
        read(&self.folder.join(HISTORY))
    }

    /// Keeps which roll-outs were here.
    pub(super) fn note_history(&self, history: &History) -> Result<(), StoreError> {
        write_json(&self.folder, HISTORY, history)
    }

    /// Keeps how it stands, and lets go of models that nothing names any more.
    pub(super) fn note(&self, lasting: &Lasting) -> Result<(), StoreError> {
        write_json(&self.folder, STANDING, lasting)?;
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
}

fn file_of(model: &ModelId) -> String {
    format!("{}.json", model.sha256)
}
