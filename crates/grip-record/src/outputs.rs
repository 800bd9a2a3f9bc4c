//! The one way in which a program makes a file: what is there already is looked at first, the content is written beside it and renamed.
//!
//! A path is refused that is an input of the command under any name (path, symbolic or hard link), `force` or not; that holds what
//! the command did not visibly make, without `force`; and whose ending promises another kind of file. What is no regular file (a pipe,
//! a device, `/dev/stdout`) is written as it is. Limit: folders that are read are compared by place and by the files that stand in
//! them, not by those of their folders; and of two programs that make the same file at once the later one wins.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Read as _, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

/// Endings of the files that these programs read or write.
const KNOWN: [&str; 20] = [
    "bag", "c", "csv", "db3", "flac", "h", "html", "json", "mat", "mcap", "npy", "npz", "onnx",
    "parquet", "png", "svg", "toml", "tsv", "wav", "xlsx",
];

/// Bytes at the start of a file by which its maker is known.
const HEAD: u64 = 4096;

/// What a command writes.
#[derive(Clone, Copy, Debug)]
pub struct OutputKind {
    /// Endings that such a file may have, in lower case.
    pub endings: &'static [&'static str],
    /// Whether any other ending is refused, and not only those of other kinds.
    pub strict: bool,
    /// Whether the first bytes of a file show that an earlier run of the command made it. Of recordings and tables they never do.
    pub is_ours: fn(&[u8]) -> bool,
}

impl OutputKind {
    /// A file of any ending; one that is there needs `force`.
    pub const ANY: Self = Self { endings: &[], strict: false, is_ours: |_| false };

    /// A recording, or a table of data: one that is there needs `force`.
    #[must_use]
    pub const fn data(endings: &'static [&'static str]) -> Self {
        Self { endings, strict: false, is_ours: |_| false }
    }

    fn takes(&self, file: &Path) -> bool {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let is_its = |ending: &str| self.endings.contains(&ending);
        self.endings.is_empty()
            || ending.is_some_and(|e| is_its(&e) || !self.strict && !KNOWN.contains(&e.as_str()))
            || !self.strict && file.extension().is_none()
    }
}

/// Why a file is not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// It is an input.
    #[error(
        "{}: is {}, which is read; it would be lost, so choose another name",
        file.display(), if file == input { "the input itself".to_owned() } else { format!("the same file as {}", input.display()) }
    )]
    Input {
        /// The file.
        file: PathBuf,
        /// The input, as it was named.
        input: PathBuf,
    },
    /// It holds something that the command did not make.
    #[error(
        "{}: is there already, and nothing shows that this command made it; choose another name{}",
        file.display(), if *has_force { ", or add --force to replace it" } else { "" }
    )]
    Exists {
        /// The file.
        file: PathBuf,
        /// Whether the command has a `--force`.
        has_force: bool,
    },
    /// It stands in a folder that is read and holds something that the command did not make.
    #[error("{}: is there already, in a folder that is read; choose another name", file.display())]
    Folder {
        /// The file.
        file: PathBuf,
    },
    /// Another output of the command has this name.
    #[error("{}: two outputs have this name; choose another one for one of them", file.display())]
    Twice {
        /// The file.
        file: PathBuf,
    },
    /// Its ending belongs to another kind of file.
    #[error("{}: expected a name that ends in .{}", file.display(), endings.join(" or ."))]
    Ending {
        /// The file.
        file: PathBuf,
        /// Endings of the kind.
        endings: &'static [&'static str],
    },
    /// The system does not let it be written.
    #[error("cannot write {}: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl OutputError {
    /// Whether another name, or `force`, is the way out; otherwise the system is at fault.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        !matches!(self, Self::Write { .. })
    }
}

impl From<OutputError> for io::Error {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Write { source, .. } => source,
            refused => Self::other(refused),
        }
    }
}

/// Replaces a file that a program keeps its own state in, where it leads over links, in one go.
///
/// # Errors
/// Where it cannot be written.
pub fn replace(file: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    Ok(OutputPath::new(file, OutputKind::ANY, [], Some(true))?.write(content)?)
}

/// The name of a file to be made, looked at.
#[derive(Clone, Debug)]
pub struct OutputPath {
    file: PathBuf,
    kind: OutputKind,
    inputs: Vec<PathBuf>,
    force: Option<bool>,
}

impl OutputPath {
    /// Looks at `file` before any work is done for it; `inputs` are all files and folders that the command reads, those that are not
    /// there are left out. `force` replaces what the command did not make; `None` where there is no such flag.
    ///
    /// # Errors
    /// Where it must not, or cannot, be written.
    pub fn new<'a>(
        file: &Path,
        kind: OutputKind,
        inputs: impl IntoIterator<Item = &'a Path>,
        force: Option<bool>,
    ) -> Result<Self, OutputError> {
        let inputs = inputs.into_iter().map(Path::to_owned).collect();
        let path = Self { file: file.to_owned(), kind, inputs, force };
        path.place().map(|_| path)
    }

    /// The name.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Refuses another output of the same command under this name.
    ///
    /// # Errors
    /// [`OutputError::Twice`].
    pub fn apart_from(self, other: &Path) -> Result<Self, OutputError> {
        let place = |file: &Path| Some((led_to(file).ok()?, folder(file).canonicalize().ok()?));
        let name =
            |(file, folder): (PathBuf, PathBuf)| folder.join(file.file_name().unwrap_or_default());
        let same =
            place(&self.file).map(name).zip(place(other).map(name)).is_some_and(|(a, b)| a == b);
        if same && self.place()?.is_some() {
            return Err(OutputError::Twice { file: self.file });
        }
        Ok(self)
    }

    /// Opens a file beside it, or what is no regular file itself.
    ///
    /// # Errors
    /// As [`OutputPath::new`].
    pub fn create(&self) -> Result<OutputFile, OutputError> {
        let failed = |source| self.unwritable(source);
        let (out, place) = match self.place()? {
            None => (stream(&self.file).map_err(failed)?, None),
            Some(place) => {
                let mut builder = tempfile::Builder::new();
                builder.prefix(".grip-").suffix(".part");
                #[cfg(unix)]
                builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
                let (out, beside) =
                    builder.tempfile_in(folder(&place)).map_err(failed)?.into_parts();
                (out, Some((beside, place)))
            }
        };
        Ok(OutputFile {
            file: self.file.clone(),
            out: BufWriter::with_capacity(1 << 16, out),
            place,
        })
    }

    /// Writes the whole file in one go.
    ///
    /// # Errors
    /// As [`OutputPath::create`], and where it cannot be written.
    pub fn write(&self, content: impl AsRef<[u8]>) -> Result<(), OutputError> {
        let mut out = self.create()?;
        out.write_all(content.as_ref()).map_err(|source| self.unwritable(source))?;
        out.finish()
    }

    /// The regular file that is made or replaced; `None` where what is there is no regular file.
    fn place(&self) -> Result<Option<PathBuf>, OutputError> {
        let file = || self.file.clone();
        let place = led_to(&self.file).map_err(|source| self.unwritable(source))?;
        let about = match fs::metadata(&self.file) {
            Ok(about) if about.is_dir() => {
                return Err(self.unwritable(io::ErrorKind::IsADirectory.into()));
            }
            Ok(about) if !about.is_file() => return Ok(None),
            Ok(about) => Some(about),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(source) => return Err(self.unwritable(source)),
        };
        if about.is_some()
            && let Some(input) = self.inputs.iter().find(|input| is_same(input, &self.file))
        {
            return Err(OutputError::Input { file: file(), input: input.clone() });
        }
        if ["/dev", "/proc"].iter().any(|system| self.file.starts_with(system)) {
            return Ok(None);
        }
        if !self.kind.takes(&self.file) {
            return Err(OutputError::Ending { file: file(), endings: self.kind.endings });
        }
        if let Some(about) = about {
            self.check_replaced(&about)?;
        } else if !folder(&place).is_dir() {
            let missing = io::Error::new(io::ErrorKind::NotFound, "there is no such folder");
            return Err(self.unwritable(missing));
        }
        Ok(Some(place))
    }

    fn check_replaced(&self, about: &Metadata) -> Result<(), OutputError> {
        let failed = |source| self.unwritable(source);
        // What may not be written is not to be replaced either.
        let mut there =
            OpenOptions::new().read(true).write(true).open(&self.file).map_err(failed)?;
        let mut head = Vec::new();
        (&mut there).take(HEAD).read_to_end(&mut head).map_err(failed)?;
        let file = || self.file.clone();
        if about.len() == 0 || (self.kind.is_ours)(&head) {
            return Ok(());
        }
        if self.inputs.iter().any(|folder| holds(folder, &self.file)) {
            return Err(OutputError::Folder { file: file() });
        }
        let has_force = self.force.is_some();
        if self.force == Some(true) {
            Ok(())
        } else {
            Err(OutputError::Exists { file: file(), has_force })
        }
    }

    fn unwritable(&self, source: io::Error) -> OutputError {
        OutputError::Write { file: self.file.clone(), source }
    }
}

/// A file that is being made: without [`OutputFile::finish`] nothing has changed.
#[derive(Debug)]
pub struct OutputFile {
    file: PathBuf,
    out: BufWriter<File>,
    place: Option<(TempPath, PathBuf)>,
}

impl OutputFile {
    /// Ends the file: it is on the disk, and has its name.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn finish(self) -> Result<(), OutputError> {
        self.end()
    }

    /// [`OutputFile::finish`] under another name, on the same file system.
    ///
    /// # Errors
    /// As there, and where that name must not be written.
    pub fn finish_as(mut self, path: &OutputPath) -> Result<(), OutputError> {
        if let (Some((_, place)), Some(other)) = (&mut self.place, path.place()?) {
            *place = other;
        }
        self.end()
    }

    fn end(mut self) -> Result<(), OutputError> {
        let finished = self.out.flush().and_then(|()| match self.place {
            None => Ok(()),
            Some((beside, place)) => {
                if let Ok(about) = fs::metadata(&place) {
                    self.out.get_ref().set_permissions(about.permissions())?;
                }
                self.out.get_ref().sync_all()?;
                beside.persist(place).map_err(|error| error.error)
            }
        });
        finished.map_err(|source| OutputError::Write { file: self.file, source })
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.out.seek(to)
    }
}

/// Opens what is no regular file, or a regular one by the name of a descriptor, behind what it holds.
fn stream(file: &Path) -> io::Result<File> {
    #[cfg(unix)]
    if file == Path::new("/dev/stdout") {
        use std::os::fd::AsFd as _;
        return Ok(io::stdout().as_fd().try_clone_to_owned()?.into());
    }
    OpenOptions::new().append(true).open(file)
}

fn folder(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether both are one file, or one folder.
fn is_same(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    let identity = |file: &Path| {
        use std::os::unix::fs::MetadataExt as _;
        fs::metadata(file).map(|about| (about.dev(), about.ino())).ok()
    };
    #[cfg(not(unix))]
    let identity = |file: &Path| file.canonicalize().ok();
    identity(a).is_some_and(|a| Some(a) == identity(b))
}

/// Whether `file` stands in `folder` or below, or is another name of a file in it.
fn holds(folder: &Path, file: &Path) -> bool {
    let below = || Some(file.canonicalize().ok()?.starts_with(folder.canonicalize().ok()?));
    let linked = || {
        fs::read_dir(folder)
            .is_ok_and(|mut all| all.any(|one| one.is_ok_and(|one| is_same(&one.path(), file))))
    };
    folder.is_dir() && (below() == Some(true) || linked())
}

/// Links that are followed from one to the next.
const LINKS: usize = 16;

/// The file that a path leads to, over links, whether it is there or not.
///
/// # Errors
/// Where links lead in a circle.
fn led_to(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        match fs::read_link(&path) {
            Ok(target) => path = path.parent().unwrap_or(Path::new("")).join(target),
            // It is no link, or not there yet.
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, "links lead in a circle"))
}

#[cfg(test)]
mod tests {
    use super::{OutputError, OutputKind, OutputPath};
    use std::fs;
    use std::io::Write as _;
    use std::path::Path;

    const TEXT: OutputKind =
        OutputKind { endings: &["txt"], strict: true, is_ours: |head| head.starts_with(b"# ours") };

    fn refused(path: &Path, kind: OutputKind, input: &Path, force: bool) -> String {
        let error = OutputPath::new(path, kind, [input], Some(force)).unwrap_err();
        assert!(error.is_refusal(), "{error}");
        error.to_string()
    }

    #[test]
    fn an_input_is_never_written_under_any_name() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("run.mcap");
        fs::write(&input, "messages").unwrap();
        let [hard, soft] = ["hard.csv", "soft.csv"].map(|name| folder.path().join(name));
        fs::hard_link(&input, &hard).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink("run.mcap", &soft).unwrap();
        #[cfg(not(unix))]
        fs::hard_link(&input, &soft).unwrap();
        let dots = folder.path().join(".").join("run.mcap");
        for path in [&input, &hard, &soft, &dots] {
            let text = refused(path, OutputKind::ANY, &input, true);
            assert!(text.contains("which is read"), "{text}");
        }
        // A folder that is read: what stands in it stays, what is new in it may be made.
        let text = refused(&hard, OutputKind::ANY, folder.path(), true);
        assert!(text.contains("in a folder that is read"), "{text}");
        OutputPath::new(&folder.path().join("new.csv"), OutputKind::ANY, [folder.path()], None)
            .unwrap();
        assert_eq!(fs::read(&input).unwrap(), b"messages");
    }

    #[test]
    fn what_is_there_is_replaced_where_it_is_ours_or_by_force() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let write = |force| {
            OutputPath::new(&path, TEXT, [], Some(force)).and_then(|out| out.write("# ours"))
        };
        write(false).unwrap();
        write(false).unwrap();
        fs::write(&path, "of somebody").unwrap();
        assert!(matches!(write(false), Err(OutputError::Exists { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"of somebody");
        write(true).unwrap();
        fs::write(&path, "").unwrap();
        write(false).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"# ours");
        let ending =
            |name: &str, kind| OutputPath::new(Path::new(name), kind, [], Some(true)).is_err();
        let lenient = OutputKind { strict: false, ..TEXT };
        assert!(ending("a.mcap", TEXT) && ending("a", TEXT) && ending("a.mcap", lenient));
        assert!(!ending("a", lenient) && !ending("a.TXT", TEXT) && !ending("a.b", lenient));
        let out = OutputPath::new(&path, TEXT, [], None).unwrap();
        let other = folder.path().join("./a.txt");
        assert!(matches!(out.apart_from(&other), Err(OutputError::Twice { .. })));
        assert!(OutputPath::new(&folder.path().join("no/a.txt"), TEXT, [], None).is_err());
        assert!(OutputPath::new(folder.path(), OutputKind::ANY, [], Some(true)).is_err());
    }

    #[test]
    fn a_file_that_is_not_finished_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "before").unwrap();
        let mut out = OutputPath::new(&path, TEXT, [], Some(true)).unwrap().create().unwrap();
        out.write_all(&[b'x'; 1 << 17]).unwrap();
        drop(out);
        assert_eq!(fs::read(&path).unwrap(), b"before");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_rights_stay_and_devices_are_written_as_they_are() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["a.txt", "link.txt"].map(|name| folder.path().join(name));
        symlink("a.txt", &link).unwrap();
        let write = || OutputPath::new(&link, TEXT, [], None).and_then(|out| out.write("# ours"));
        write().unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        write().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        OutputPath::new(Path::new("/dev/null"), TEXT, [], None).unwrap().write("x").unwrap();
        let circle = folder.path().join("circle");
        symlink("circle", &circle).unwrap();
        assert!(OutputPath::new(&circle, OutputKind::ANY, [], None).is_err());
    }
}
