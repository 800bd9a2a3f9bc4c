//! Copy of a recording that a gripper reports to the same file in a folder here, through somebody who asks for its bytes.

use super::{MOST, PIECE, Piece, Recording, is_plain};
use std::{
    fs::{self, File, TryLockError},
    io,
    os::unix::fs::FileExt as _,
    path::{Path, PathBuf},
};

/// Asks for so many bytes from a place on: the parts of the answer.
pub type Asking<'a, E> = dyn FnMut(u64, u64) -> Result<Vec<Vec<u8>>, E> + 'a;

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fetched {
    /// It is here now.
    Copied {
        /// Bytes that came now.
        bytes: u64,
        /// Bytes that an earlier attempt had left.
        resumed: u64,
    },
    /// It was here already.
    There,
}

/// Why a recording is not here.
#[derive(Debug, thiserror::Error)]
pub enum FetchError<E: core::error::Error + 'static> {
    /// A name that leads elsewhere, or has what no recording has in its name.
    #[error("{0:?} is no name of a recording")]
    Name(String),
    /// It is being written.
    #[error("{0} is being written")]
    Growing(String),
    /// Another file of its name is here.
    #[error("{} is here, and another file than that of the gripper; it is left alone", .0.display())]
    Different(PathBuf),
    /// Somebody else fetches it.
    #[error("{} is being fetched by another program", .0.display())]
    Busy(PathBuf),
    /// What came are not the bytes that were asked for.
    #[error("{name}: what came at byte {at} is not what was asked for, or damaged")]
    Damaged {
        /// Its name.
        name: String,
        /// Where.
        at: u64,
    },
    /// The gripper does not give it.
    #[error(transparent)]
    Asked(E),
    /// It cannot be written here.
    #[error("{}: {source}", file.display())]
    Written {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// Brings `recording` into `folder`, which must be there: under a name of its own until it is whole, and going on there after an attempt that was
/// cut off. A file that is here already is compared at both ends, and never written to.
///
/// # Errors
/// [`FetchError`]; what came before the fault stays for the next attempt.
pub fn fetch<E: core::error::Error + 'static>(
    recording: &Recording,
    folder: &Path,
    ask: &mut Asking<'_, E>,
) -> Result<Fetched, FetchError<E>> {
    let name = &recording.name;
    if !is_plain(name) {
        return Err(FetchError::Name(name.clone()));
    }
    if recording.growing {
        return Err(FetchError::Growing(name.clone()));
    }
    let target = folder.join(name);
    if fs::symlink_metadata(&target).is_ok() {
        return match same(recording, &target, ask)? {
            true => Ok(Fetched::There),
            false => Err(FetchError::Different(target)),
        };
    }
    let part = folder.join(format!(".{name}.{}-{}.part", recording.bytes, recording.modified_ns));
    let written = |source| FetchError::Written { file: part.clone(), source };
    let mut options = File::options();
    let out = options.read(true).write(true).create(true).truncate(false).open(&part);
    let out = out.map_err(written)?;
    match out.try_lock() {
        Err(TryLockError::WouldBlock) => return Err(FetchError::Busy(target)),
        // A file system without locks has nobody else, as far as is known.
        Ok(()) | Err(TryLockError::Error(_)) => {}
    }
    // What was written last before a cut of power may be missing.
    let resumed = out.metadata().map_err(written)?.len().min(recording.bytes).saturating_sub(MOST);
    out.set_len(resumed).map_err(written)?;
    let mut at = resumed;
    while at < recording.bytes {
        at = pieces(recording, at, MOST.min(recording.bytes - at), ask, &mut |piece| {
            out.write_all_at(piece.bytes, piece.at).map_err(written)
        })?;
        out.sync_data().map_err(written)?;
    }
    out.sync_all().map_err(written)?;
    // A hard link takes no name that is taken, as a renaming would.
    fs::hard_link(&part, &target)
        .or_else(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => Err(error),
            // A file system without them.
            _ => fs::rename(&part, &target),
        })
        .map_err(|source| FetchError::Written { file: target.clone(), source })?;
    match fs::remove_file(&part) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(written(error)),
        _ => Ok(Fetched::Copied { bytes: recording.bytes - resumed, resumed }),
    }
}

/// Whether a file here is as long as that of the gripper, and the same at its start, where the name of the run stands, and at its end.
fn same<E: core::error::Error + 'static>(
    recording: &Recording,
    file: &Path,
    ask: &mut Asking<'_, E>,
) -> Result<bool, FetchError<E>> {
    let unreadable = |source| FetchError::Written { file: file.to_owned(), source };
    let looked = fs::symlink_metadata(file).map_err(unreadable)?;
    if !looked.is_file() || looked.len() != recording.bytes {
        return Ok(false);
    }
    let here = File::open(file).map_err(unreadable)?;
    let count = recording.bytes.min(PIECE as u64);
    let mut is_same = true;
    for from in [0, recording.bytes - count] {
        let mut at = from;
        while is_same && at < from + count {
            at = pieces(recording, at, from + count - at, ask, &mut |piece| {
                let mut bytes = vec![0; piece.bytes.len()];
                here.read_exact_at(&mut bytes, piece.at).map_err(unreadable)?;
                is_same &= bytes == piece.bytes;
                Ok(())
            })?;
        }
    }
    Ok(is_same)
}

/// Asks once for `bytes` from a place on, and takes what comes, piece by piece; how far it came.
fn pieces<E: core::error::Error + 'static>(
    recording: &Recording,
    mut at: u64,
    bytes: u64,
    ask: &mut Asking<'_, E>,
    take: &mut dyn FnMut(&Piece<'_>) -> Result<(), FetchError<E>>,
) -> Result<u64, FetchError<E>> {
    let damaged = |at| FetchError::Damaged { name: recording.name.clone(), at };
    let before = at;
    for wire in ask(at, bytes).map_err(FetchError::Asked)? {
        let fits =
            |piece: &Piece<'_>| piece.at == at && piece.bytes.len() as u64 <= recording.bytes - at;
        let piece = Piece::read(&wire).filter(fits).ok_or_else(|| damaged(at))?;
        take(&piece)?;
        at += piece.bytes.len() as u64;
    }
    if at == before { Err(damaged(at)) } else { Ok(at) }
}

#[cfg(test)]
mod tests {
    use super::{FetchError, Fetched, fetch};
    use crate::recordings::{MOST, PIECE, Piece, Recording};
    use std::{fs, io, path::Path};

    fn content() -> Vec<u8> {
        (0..3_000_000_u32).map(|at| at.to_le_bytes()[at as usize % 3]).collect()
    }

    fn reported(name: &str, bytes: usize) -> Recording {
        let bytes = bytes as u64;
        Recording { name: name.to_owned(), bytes, begin_ns: None, modified_ns: 5, growing: false }
    }

    /// Answers from `content`, and not at all from the question on that is no longer in patience.
    fn give(content: &[u8], patience: &mut u32, from: u64, bytes: u64) -> io::Result<Vec<Vec<u8>>> {
        *patience = patience.checked_sub(1).ok_or(io::ErrorKind::TimedOut)?;
        let place = |at: u64| usize::try_from(at).unwrap();
        let mut at = from;
        let wanted = &content[place(from)..place(from + bytes)];
        let pieces = wanted.chunks(PIECE).map(|bytes| {
            let wire = Piece { at, bytes }.write();
            at += bytes.len() as u64;
            wire
        });
        Ok(pieces.collect())
    }

    fn once(
        folder: &Path,
        content: &[u8],
        mut patience: u32,
    ) -> Result<Fetched, FetchError<io::Error>> {
        let reported = reported("run.mcap", content.len());
        fetch(&reported, folder, &mut |from, bytes| give(content, &mut patience, from, bytes))
    }

    #[test]
    fn what_was_cut_off_goes_on_and_is_whole_in_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let content = content();
        assert!(matches!(once(folder.path(), &content, 2), Err(FetchError::Asked(_))));
        assert!(!folder.path().join("run.mcap").exists());
        let bytes = content.len() as u64 - MOST;
        let copied = once(folder.path(), &content, 9).unwrap();
        assert_eq!(copied, Fetched::Copied { bytes, resumed: MOST });
        assert_eq!(fs::read(folder.path().join("run.mcap")).unwrap(), content);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else stays");
        assert_eq!(once(folder.path(), &content, 9).unwrap(), Fetched::There);
    }

    /// Somebody who gives less than is asked for, as over a slow line.
    #[test]
    fn short_answers_are_asked_for_until_all_is_there_and_compared() {
        let folder = tempfile::tempdir().unwrap();
        let content = content();
        let reported = reported("run.mcap", content.len());
        let mut asked = 0;
        let mut ask = |from, bytes: u64| {
            asked += 1;
            give(&content, &mut u32::MAX.clone(), from, bytes.min(100_000))
        };
        let copied = Fetched::Copied { bytes: content.len() as u64, resumed: 0 };
        assert_eq!(fetch(&reported, folder.path(), &mut ask).unwrap(), copied);
        assert_eq!(fetch(&reported, folder.path(), &mut ask).unwrap(), Fetched::There);
        assert_eq!(fs::read(folder.path().join("run.mcap")).unwrap(), content);
        assert_eq!(asked, 30 + 2 * 3);
    }

    #[test]
    fn another_file_of_the_name_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("run.mcap");
        let content = content();
        for (at, len) in [(0, content.len()), (content.len() - 1, content.len()), (0, 5)] {
            let mut other = content[..len].to_vec();
            if len > 5 {
                other[at] ^= 1;
            }
            fs::write(&target, &other).unwrap();
            let refused = once(folder.path(), &content, 9);
            assert!(matches!(refused, Err(FetchError::Different { .. })), "{refused:?}");
            assert_eq!(fs::read(&target).unwrap(), other);
        }
    }

    #[test]
    fn bad_names_and_bad_bytes_make_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("a/b");
        fs::create_dir_all(&inside).unwrap();
        let mut asked = 0;
        for name in ["../../etc/passwd", "../x.mcap", "/tmp/x.mcap", "a/../x.mcap", ""] {
            let reported = reported(name, 3);
            let refused = fetch(&reported, &inside, &mut |_, _| -> io::Result<_> {
                asked += 1;
                Ok(vec![])
            });
            assert!(matches!(refused, Err(FetchError::Name(_))), "{name}");
        }
        let growing = Recording { growing: true, ..reported("run.mcap", 3) };
        let refused = fetch(&growing, &inside, &mut |_, _| -> io::Result<_> { Ok(vec![]) });
        assert!(matches!(refused, Err(FetchError::Growing(_))) && asked == 0);
        let long = Piece { at: 0, bytes: b"four" }.write();
        let late = Piece { at: 1, bytes: b"thr" }.write();
        for wire in
            [vec![], vec![vec![]], vec![long], vec![late], vec![b"rubbish and more".to_vec()]]
        {
            let refused =
                fetch(&reported("run.mcap", 3), &inside, &mut |_, _| io::Result::Ok(wire.clone()));
            assert!(matches!(refused, Err(FetchError::Damaged { .. })), "{refused:?}");
            assert!(!inside.join("run.mcap").exists());
        }
    }
}
