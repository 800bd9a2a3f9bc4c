//! File of the memory: its objects, read and written.

use super::{LONGEST_NAME, MOST_OBJECTS, Memory, Object};
use std::{
    collections::BTreeMap,
    fs,
    io::{self, Read as _},
    path::Path,
};

/// A file of objects is not longer than this (bytes).
const MOST_BYTES: u64 = 16 << 20;

/// Why a memory cannot be read or written, or a name is none.
#[derive(Debug, thiserror::Error)]
pub enum MemoryError {
    /// A name that no object can have.
    #[error("the name of an object has at most {LONGEST_NAME} bytes and no control characters")]
    Name,
    /// An object is named, and nothing is to be remembered of it.
    #[error("memory.object is set without memory.file")]
    NoFile,
    /// The file cannot be read or written.
    #[error("{file}: {source}")]
    File {
        /// The file.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// The file holds something else.
    #[error("{file}: {what}")]
    Content {
        /// The file.
        file: String,
        /// What is wrong.
        what: String,
    },
}

impl Memory {
    /// Reads the objects of a file; none where there is no file.
    ///
    /// # Errors
    /// Where it cannot be read, is longer than 16 MiB, or holds a figure that none can have.
    pub fn read(file: &Path) -> Result<Self, MemoryError> {
        let name = || file.display().to_string();
        let content = |what: String| MemoryError::Content { file: name(), what };
        let mut text = String::new();
        let read = fs::metadata(file).and_then(|data| {
            if !data.is_file() {
                return Err(io::Error::other("not a file"));
            }
            fs::File::open(file)?.take(MOST_BYTES + 1).read_to_string(&mut text)
        });
        match read {
            Ok(count) if count as u64 > MOST_BYTES => Err(content("longer than 16 MiB".to_owned())),
            Ok(_) => {
                let objects = toml::from_str::<BTreeMap<String, Object>>(&text)
                    .map_err(|error| content(error.to_string().trim_end().to_owned()))?;
                Self::of(objects).map_err(content)
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound && has_folder(file) => {
                Ok(Self::default())
            }
            Err(source) => Err(MemoryError::File { file: name(), source }),
        }
    }

    fn of(objects: BTreeMap<String, Object>) -> Result<Self, String> {
        if objects.len() > MOST_OBJECTS {
            return Err(format!("more than {MOST_OBJECTS} objects"));
        }
        for (name, object) in &objects {
            if name.is_empty() || !super::is_name(name) {
                return Err(format!("{name:?}: {}", MemoryError::Name));
            }
            let Object { needed_n, friction_ratio, spacing_um, height_um, .. } = object;
            let figures = [needed_n, friction_ratio, spacing_um, height_um];
            if needed_n.is_unknown() || !figures.into_iter().all(super::Figure::is_possible) {
                return Err(format!(
                    "{name}: a figure has a value above 0, a deviation, and grasps"
                ));
            }
        }
        Ok(Self { objects, ..Self::default() })
    }

    /// Writes the objects to a file: beside it first, so that a crash leaves the old one.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), MemoryError> {
        let failed = |source| MemoryError::File { file: file.display().to_string(), source };
        let text =
            toml::to_string(&self.objects).map_err(|error| failed(io::Error::other(error)))?;
        grip_record::outputs::replace(file, text).map_err(failed)
    }
}

/// Whether a file could be made there.
fn has_folder(file: &Path) -> bool {
    let folder =
        file.parent().map(|folder| if folder == Path::new("") { Path::new(".") } else { folder });
    file.file_name().is_some() && folder.is_some_and(Path::is_dir)
}
