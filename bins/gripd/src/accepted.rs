//! Register of models that were put in force here, by SHA-256, to know one that comes again: the way back, which no signature closes.
//!
//! A model that was in force was taken by the rules of its time. The same bytes are taken again, also where `model_keys` was set since. Kept in
//! the folder of dumps, where there is one, since gripfleet gives a gripd that starts the model it has accepted; else until gripd ends.

use core::fmt::Write as _;
use grip_record::{files, outputs::replace};
use std::{fs, io, path::PathBuf};

/// Models that are known, the latest ones: the one in force, the one before, and some that a trial has ended.
const MOST: usize = 8;
const FILE: &str = "accepted-models";
const MOST_BYTES: u64 = 4096;

/// Models that were in force here.
#[derive(Debug, Default)]
pub(crate) struct Accepted {
    folder: Option<PathBuf>,
    /// The latest last.
    digests: Vec<[u8; 32]>,
}

impl Accepted {
    /// What an earlier run has noted in `folder`; nothing where no file is there.
    pub(crate) fn open(folder: Option<PathBuf>) -> io::Result<Self> {
        let Some(path) = folder.as_ref().map(|folder| folder.join(FILE)) else {
            return Ok(Self::default());
        };
        match files::read_text(&path, MOST_BYTES) {
            Ok(text) => Ok(Self { folder, digests: text.lines().filter_map(digest).collect() }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Ok(Self { folder, digests: Vec::new() })
            }
            Err(error) => Err(io::Error::other(format!("{}: {error}", path.display()))),
        }
    }

    /// Whether it was in force here.
    pub(crate) fn knows(&self, sha256: &[u8; 32]) -> bool {
        self.digests.contains(sha256)
    }

    /// Notes a model that is in force, first for this run, then on disk: beside its place, synced, renamed.
    pub(crate) fn note(&mut self, sha256: [u8; 32]) -> io::Result<()> {
        if self.digests.last() == Some(&sha256) {
            return Ok(());
        }
        self.digests.retain(|known| *known != sha256);
        if self.digests.len() >= MOST {
            self.digests.remove(0);
        }
        self.digests.push(sha256);
        let Some(folder) = &self.folder else { return Ok(()) };
        fs::create_dir_all(folder)?;
        replace(&folder.join(FILE), self.text())
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for digest in &self.digests {
            for byte in digest {
                // Writing to a string cannot fail.
                let _written = write!(text, "{byte:02x}");
            }
            text.push('\n');
        }
        text
    }
}

/// 64 hexadecimal digits.
fn digest(line: &str) -> Option<[u8; 32]> {
    let mut digest = [0; 32];
    if line.len() != 64 {
        return None;
    }
    for (at, byte) in digest.iter_mut().enumerate() {
        *byte = u8::from_str_radix(line.get(2 * at..2 * at + 2)?, 16).ok()?;
    }
    Some(digest)
}

#[cfg(test)]
mod tests {
    use super::{Accepted, FILE, MOST};
    use std::fs;

    #[test]
    fn the_latest_models_are_known_at_the_next_start() {
        let folder = tempfile::tempdir().unwrap();
        let open = || Accepted::open(Some(folder.path().join("state"))).unwrap();
        let mut accepted = open();
        (0..=8).for_each(|n| accepted.note([n; 32]).unwrap());
        // Once more in force: it is the latest one, and none goes for it.
        accepted.note([1; 32]).unwrap();
        accepted.note([9; 32]).unwrap();
        let known = |accepted: &Accepted| -> Vec<u8> {
            (0..=10).filter(|&n| accepted.knows(&[n; 32])).collect()
        };
        assert_eq!(known(&accepted), [1, 3, 4, 5, 6, 7, 8, 9]);
        assert_eq!(known(&open()), known(&accepted));
        assert_eq!(known(&accepted).len(), MOST);
        // Without a folder they are known until the end.
        let mut accepted = Accepted::open(None).unwrap();
        accepted.note([1; 32]).unwrap();
        assert_eq!(known(&accepted), [1]);
    }

    #[test]
    fn what_is_no_digest_is_none_and_a_file_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE);
        let open = || Accepted::open(Some(folder.path().to_owned()));
        let one = "01".repeat(32);
        fs::write(&path, format!("{one}\n{}\n{}é\n", &one[..62], &one[..62])).unwrap();
        assert_eq!(open().unwrap().digests, [[1; 32]]);
        fs::write(&path, "x".repeat(5000)).unwrap();
        let error = open().unwrap_err().to_string();
        assert!(error.contains(FILE) && error.contains("5000 bytes"), "{error}");
    }
}
