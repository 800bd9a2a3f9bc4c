//! The recordings that are there where a daemon records, and their bytes, and nothing else of that folder.

use super::{LISTED, MOST, PIECE, Piece, Recording, is_plain};
use grip_session::config::RecordTemplate;
use std::{
    fs::{self, File, Metadata, TryLockError},
    io,
    os::unix::fs::{FileExt as _, MetadataExt as _},
    path::{Path, PathBuf},
    time::{SystemTime, UNIX_EPOCH},
};

/// The place of the start in a template.
const START: &str = "{start}";

/// Why there is nothing to report, or no such recording.
#[derive(Debug, thiserror::Error)]
pub enum ShelfError {
    /// Of recordings with such names none is reported: why.
    #[error("record = {0}: {1}")]
    Template(String, &'static str),
    /// Nothing of that name is reported.
    #[error("no recording of that name")]
    Unknown,
    /// It is another one now.
    #[error("the recording has changed")]
    Changed,
    /// There are not so many bytes.
    #[error("the recording has {bytes} bytes, none from {from} on")]
    Beyond {
        /// Its length.
        bytes: u64,
        /// The first one asked for.
        from: u64,
    },
    /// The system does not give it.
    #[error("the recordings cannot be read: {0}")]
    Unreadable(#[from] io::Error),
}

/// The recordings that a template makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shelf {
    folder: PathBuf,
    /// The name without its ending, with the places of the start.
    stem: String,
}

impl Shelf {
    /// The shelf of a template.
    ///
    /// # Errors
    /// [`ShelfError::Template`].
    pub fn new(template: &RecordTemplate) -> Result<Self, ShelfError> {
        let wrong = |why| ShelfError::Template(template.as_str().to_owned(), why);
        let path = Path::new(template.as_str());
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let stem = name.strip_suffix(".mcap");
        let stem =
            stem.ok_or_else(|| wrong("only recordings that end with .mcap can be fetched"))?;
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let folder = folder.unwrap_or_else(|| Path::new("."));
        if folder.to_string_lossy().contains(START) {
            return Err(wrong("recordings in folders named by their start cannot be fetched"));
        }
        if !is_plain(&name.replace(START, "20261121T225908Z-0001")) {
            return Err(wrong(
                "recordings of that name cannot be fetched: only letters, digits and ._-+@ and spaces may stand in it",
            ));
        }
        Ok(Self { folder: folder.to_owned(), stem: stem.to_owned() })
    }

    /// Everything there is, by name.
    ///
    /// # Errors
    /// Where the folder cannot be read. One that is not there has nothing in it.
    pub fn list(&self) -> io::Result<Vec<Recording>> {
        let entries = match fs::read_dir(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let mut all = Vec::new();
        for entry in entries {
            let name = entry?.file_name();
            // What has just gone, or cannot be opened, is not there for others either.
            if let Some(Ok((_, recording))) = name.to_str().map(|name| self.open(name)) {
                all.push(recording);
            }
        }
        all.sort_by(|one, other| one.name.cmp(&other.name));
        Ok(all)
    }

    /// The file of a recording of this shelf.
    #[must_use]
    pub fn path(&self, recording: &Recording) -> PathBuf {
        self.folder.join(&recording.name)
    }

    /// [`Shelf::list`] as it travels: parts of an answer.
    ///
    /// # Errors
    /// As [`Shelf::list`].
    pub fn reported(&self) -> io::Result<Vec<Vec<u8>>> {
        let all = self.list()?;
        if all.is_empty() {
            return Ok(vec![b"[]".to_vec()]);
        }
        all.chunks(LISTED).map(|some| Ok(serde_json::to_vec(some)?)).collect()
    }

    /// Bytes of a recording that somebody asks for by the words of [`super`]; `parameter` gives them.
    ///
    /// # Errors
    /// [`ShelfError`]; what cannot be understood is no recording.
    pub fn read(&self, parameter: &dyn Fn(&str) -> Option<String>) -> Result<Reading, ShelfError> {
        let number = |name: &str| parameter(name).and_then(|text| text.parse::<u64>().ok());
        let name = parameter("name").ok_or(ShelfError::Unknown)?;
        let (file, recording) = self.open(&name)?;
        let known = (number("size"), number("modified"));
        if known != (Some(recording.bytes), Some(recording.modified_ns)) {
            return Err(ShelfError::Changed);
        }
        let (from, bytes) = (number("from").unwrap_or(0), recording.bytes);
        if from >= bytes {
            return Err(ShelfError::Beyond { bytes, from });
        }
        let wanted = number("bytes").unwrap_or(MOST).min(MOST);
        Ok(Reading { file, at: from, end: bytes.min(from.saturating_add(wanted)) })
    }

    /// A file that this template names, and that is no link to another one.
    fn open(&self, name: &str) -> Result<(File, Recording), ShelfError> {
        let stem = name.strip_suffix(".mcap").filter(|_| is_plain(name));
        if !stem.is_some_and(|stem| names(&self.stem, stem)) {
            return Err(ShelfError::Unknown);
        }
        let path = self.folder.join(name);
        let gone = |_| ShelfError::Unknown;
        let looked = fs::symlink_metadata(&path).map_err(gone)?;
        if !looked.is_file() {
            return Err(ShelfError::Unknown);
        }
        let file = File::open(&path).map_err(gone)?;
        let meta = file.metadata()?;
        // What has become a link meanwhile is another file.
        if (looked.dev(), looked.ino()) != (meta.dev(), meta.ino()) || meta.len() == 0 {
            return Err(ShelfError::Unknown);
        }
        let recording = recording(name, &file, &meta)?;
        Ok((file, recording))
    }
}

fn recording(name: &str, file: &File, meta: &Metadata) -> io::Result<Recording> {
    // The recorder locks a file before it writes to it, and never one that has content: a lock that is held for a moment here is in nobody's way.
    let growing = match file.try_lock_shared() {
        Ok(()) => {
            file.unlock()?;
            false
        }
        Err(TryLockError::WouldBlock) => true,
        // A file system without locks.
        Err(TryLockError::Error(_)) => false,
    };
    Ok(Recording {
        name: name.to_owned(),
        bytes: meta.len(),
        begin_ns: meta.created().ok().map(since_1970),
        modified_ns: since_1970(meta.modified()?),
        growing,
    })
}

fn since_1970(time: SystemTime) -> u64 {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

/// Whether `stem` is what the recorder makes of `template`: the start in its places, and a number behind where it is not the first file.
fn names(template: &str, stem: &str) -> bool {
    let mut rest = stem;
    for (at, literal) in template.split(START).enumerate() {
        if at > 0 {
            let Some((start, behind)) = rest.split_at_checked(16) else { return false };
            if !is_start(start) {
                return false;
            }
            rest = behind;
        }
        let Some(behind) = rest.strip_prefix(literal) else { return false };
        rest = behind;
    }
    let is_number = |text: &str| text.len() >= 4 && text.bytes().all(|byte| byte.is_ascii_digit());
    rest.is_empty() || rest.strip_prefix('-').is_some_and(is_number)
}

/// `20261121T225908Z`.
fn is_start(text: &str) -> bool {
    text.bytes().enumerate().all(|(at, byte)| match at {
        8 => byte == b'T',
        15 => byte == b'Z',
        _ => byte.is_ascii_digit(),
    })
}

/// A recording on its way, piece by piece.
#[derive(Debug)]
pub struct Reading {
    file: File,
    at: u64,
    end: u64,
}

impl Reading {
    /// The next piece as it travels; `None` at the end.
    ///
    /// # Errors
    /// Where the system does not give it, or the file has become shorter.
    pub fn next_piece(&mut self) -> io::Result<Option<Vec<u8>>> {
        let left = self.end.saturating_sub(self.at);
        let count = usize::try_from(left).unwrap_or(PIECE).min(PIECE);
        if count == 0 {
            return Ok(None);
        }
        let mut bytes = vec![0; count];
        self.file.read_exact_at(&mut bytes, self.at)?;
        let wire = Piece { at: self.at, bytes: &bytes }.write();
        self.at += count as u64;
        Ok(Some(wire))
    }
}

#[cfg(test)]
mod tests {
    use super::{Shelf, ShelfError, names};
    use crate::recordings::{MOST, PIECE, Piece};
    use grip_session::config::RecordTemplate;
    use std::{
        collections::BTreeMap,
        fs::{self, File},
        path::Path,
    };

    fn shelf(folder: &Path, name: &str) -> Result<Shelf, ShelfError> {
        let text = folder.join(name).display().to_string();
        Shelf::new(&RecordTemplate::new(&text).unwrap())
    }

    #[test]
    fn only_what_the_template_makes_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        let shelf = shelf(here, "cell-{start}.mcap").unwrap();
        assert_eq!(shelf.list().unwrap(), []);
        let good = ["cell-20261121T225908Z-0001.mcap", "cell-20261121T225908Z.mcap"];
        for name in good {
            fs::write(here.join(name), "abc").unwrap();
        }
        let secret = here.join("secret");
        fs::write(&secret, "secret").unwrap();
        for name in [
            "other.mcap",
            "cell-.mcap",
            "cell-20261121T225908Z-1.mcap",
            "cell-20261121T225908Z.csv",
        ] {
            fs::write(here.join(name), "abc").unwrap();
        }
        fs::write(here.join("cell-20261121T225909Z.mcap"), "").unwrap();
        fs::create_dir(here.join("cell-20261121T225910Z.mcap")).unwrap();
        let link = "cell-20261121T225911Z.mcap";
        std::os::unix::fs::symlink(&secret, here.join(link)).unwrap();
        let names: Vec<String> = shelf.list().unwrap().into_iter().map(|one| one.name).collect();
        assert_eq!(names, good);
        for name in
            ["secret", "../secret", "../../etc/passwd", "/etc/passwd", link, "", "other.mcap"]
        {
            let words = BTreeMap::from([("name", name), ("size", "6"), ("modified", "0")]);
            let read = shelf.read(&|word| words.get(word).map(|text| (*text).to_owned()));
            assert!(matches!(read, Err(ShelfError::Unknown)), "{name}: {read:?}");
        }
    }

    #[test]
    fn one_that_is_being_written_is_reported_so() {
        let folder = tempfile::tempdir().unwrap();
        let shelf = shelf(folder.path(), "run.mcap").unwrap();
        fs::write(folder.path().join("run.mcap"), "abc").unwrap();
        let writing = File::options().append(true).open(folder.path().join("run.mcap")).unwrap();
        writing.try_lock().unwrap();
        assert!(shelf.list().unwrap()[0].growing);
        writing.unlock().unwrap();
        assert!(!shelf.list().unwrap()[0].growing);
        writing.try_lock().unwrap();
    }

    #[test]
    fn bytes_come_in_pieces_of_the_file_that_was_meant() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.mcap");
        let content: Vec<u8> =
            (0..1_500_000_u32).map(|at| at.to_le_bytes()[at as usize % 3]).collect();
        fs::write(&file, &content).unwrap();
        let shelf = shelf(folder.path(), "run.mcap").unwrap();
        let reported = shelf.list().unwrap().remove(0);
        let read = |from: &str, size: u64| {
            let words = BTreeMap::from([
                ("name", reported.name.clone()),
                ("from", from.to_owned()),
                ("bytes", "99999999999".to_owned()),
                ("size", size.to_string()),
                ("modified", reported.modified_ns.to_string()),
            ]);
            shelf.read(&|word| words.get(word).cloned())
        };
        let mut reading = read("100", reported.bytes).unwrap();
        let (mut at, mut pieces) = (100, 0);
        while let Some(wire) = reading.next_piece().unwrap() {
            let piece = Piece::read(&wire).unwrap();
            assert!(piece.at == at && piece.bytes.len() <= PIECE);
            let place = usize::try_from(at).unwrap();
            assert_eq!(piece.bytes, &content[place..place + piece.bytes.len()]);
            (at, pieces) = (at + piece.bytes.len() as u64, pieces + 1);
        }
        assert_eq!((at, pieces), (100 + MOST, 4));
        assert!(matches!(read("0", 5), Err(ShelfError::Changed)));
        assert!(matches!(read("1500000", reported.bytes), Err(ShelfError::Beyond { .. })));
        let mut reading = read("1400000", reported.bytes).unwrap();
        fs::write(&file, "short").unwrap();
        assert!(reading.next_piece().is_err());
    }

    #[test]
    fn templates_that_lead_to_no_one_folder_or_name_are_refused() {
        let text = |name: &str| shelf(Path::new("/rec"), name).map(drop).unwrap_err().to_string();
        assert!(text("a.csv").contains("only recordings that end with .mcap"));
        assert!(text("{start}/a.mcap").contains("in folders named by their start"));
        assert!(text("a;b.mcap").contains("only letters, digits"));
        assert!(names("a{start}b{start}", "a20261121T225908Zb20261121T225908Z-12345"));
        assert!(!names("a{start}", "a2026112äT225908Z"));
    }
}
