//! Reader of regular files, by their path: nothing that people name is waited for, or read whole before its size is known.

use std::{
    fs::{self, File},
    io::{self, Read as _},
    path::Path,
};

/// Most bytes of a configuration file.
pub const MOST_CONFIG: u64 = 1 << 20;
/// Most bytes of a calibration.
pub const MOST_CALIBRATION: u64 = 1 << 20;
/// Most bytes of a model.
pub const MOST_MODEL: u64 = 64 << 20;
/// Most bytes of what is read whole: rows of a learner, labels, companions of a recording. CSV and `.npz` recordings are read row by
/// row ([`MOST_HELD`](crate::MOST_HELD)), MCAP piece by piece.
pub const MOST_TABLE: u64 = 512 << 20;

fn refused(text: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, text)
}

/// Opens `file`.
///
/// # Errors
/// Where it cannot be read, or is no regular file (a FIFO would block, a device never ends).
pub fn open(file: &Path) -> io::Result<File> {
    // Asked before opening: to open a FIFO waits for its writer.
    let about = fs::metadata(file)?;
    if !about.is_file() {
        let what = if about.is_dir() { "it is a directory" } else { "it is not a regular file" };
        return Err(refused(what.to_owned()));
    }
    File::open(file)
}

/// The bytes of `file`, at most `most` of them.
///
/// # Errors
/// As [`open`], and where it is larger.
pub fn read(file: &Path, most: u64) -> io::Result<Vec<u8>> {
    let too_large =
        |bytes: u64| refused(format!("it has {bytes} bytes, more than the {most} that are read"));
    let input = open(file)?;
    let reported = input.metadata()?.len();
    if reported > most {
        return Err(too_large(reported));
    }
    let mut bytes = Vec::new();
    input.take(most + 1).read_to_end(&mut bytes)?;
    let len = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
    if len > most { Err(too_large(len)) } else { Ok(bytes) }
}

/// [`read`], as text.
///
/// # Errors
/// As [`read`], and where it is not UTF-8.
pub fn read_text(file: &Path, most: u64) -> io::Result<String> {
    let refused = |error| {
        let text = format!("it is not UTF-8: {error}");
        io::Error::new(io::ErrorKind::InvalidData, text)
    };
    String::from_utf8(read(file, most)?).map_err(|error| refused(error.utf8_error()))
}

#[cfg(test)]
mod tests {
    use super::{open, read, read_text};
    use std::{fs::File, path::Path};

    #[test]
    fn small_regular_files_are_read_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x");
        std::fs::write(&file, b"abc").unwrap();
        assert_eq!(read_text(&file, 3).unwrap(), "abc");
        let message = |file: &Path, most| read(file, most).unwrap_err().to_string();
        assert_eq!(message(&file, 2), "it has 3 bytes, more than the 2 that are read");
        File::create(&file).unwrap().set_len(1 << 40).unwrap();
        assert!(message(&file, 1 << 20).contains("1099511627776 bytes"));
        assert_eq!(message(folder.path(), 10), "it is a directory");
        assert_eq!(message(Path::new("/dev/zero"), 10), "it is not a regular file");
        assert_eq!(
            open(Path::new("/dev/zero")).unwrap_err().to_string(),
            "it is not a regular file"
        );
        std::fs::write(&file, [0xFF]).unwrap();
        assert!(read_text(&file, 3).is_err());
    }
}
