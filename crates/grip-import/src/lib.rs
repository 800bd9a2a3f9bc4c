//! Import of recordings of other programs as recordings of this workspace, and how each signal was interpreted.
//!
//! | file | its signals | times |
//! |---|---|---|
//! | `.wav`, `.w64` | `channel_1`, .. (share of full scale) | the rate in its header |
//! | `.npy`, one or two dimensions | `column_0`, .. | the first column, or a rate |
//! | `.npy` of structures, `.npz` | its fields, its arrays | as in a table, or `datetime64` |
//! | `.csv`, `.txt`, `.tsv` with `,`, `;` or tabs | its columns | a column in s, ms, us or ns, or a rate |
//! | Robotiq TSF-85 `.csv` | its dynamic channel and taxels | `Time(ms)` |
//! | `.mcap` with JSON or ROS 2 messages | `/topic.field`, `/topic.field[0]`, .. | stamps of the headers, or log times |
//! | rosbag2 `.db3`, or the folder of a bag | the same | the same |
//!
//! Tables are read by grip-record, which finds their channels and times, and so are numbers of a fixed size: WAV, NPY and NPZ of
//! any length, row by row ([`open`], [`ArrayRows`]). Every other format becomes [`Stream`]s of named numbers, of which 4 bytes a
//! number and 8 a time are kept, at most [`MOST_VALUES`] numbers; [`assign`](mod@assign) finds the channels among them by the
//! same rules and puts them on the times of the first.

mod arrays;
pub mod assign;
#[cfg(feature = "db3")]
mod db3;
mod error;
mod json;
mod mcap_file;
mod ros;
mod stream;
mod topic;
mod wav;
mod zstd;

pub use arrays::ArrayRows;
pub use assign::Imported;
pub use error::ImportError;
pub use grip_record::{TimeUnit, Use};
pub use stream::{MOST_VALUES, Stream, Times};
pub use zstd::unpack;

use topic::Topics;

use core::mem;
use grip_record::{CsvOptions, CsvSamples, Recording};
use slip_core::PipelineConfig;
use std::path::{Path, PathBuf};

/// What a file does not contain.
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// Samples per second, where the file has no times, or only coarse ones.
    pub rate_hz: Option<f32>,
    /// Renamings: (known name, the file's signal).
    pub map: Vec<(String, String)>,
    /// Unit of the times, where name and numbers leave it open.
    pub time_unit: Option<TimeUnit>,
    /// Topics to read; empty for all.
    pub topics: Vec<String>,
    /// Finger of a TSF-85 recording, by the number in its columns; the first one otherwise.
    pub finger: Option<u32>,
}

/// Whether a file of this name is no table; a folder is none either: it is a bag, or what is in it has to be named.
#[must_use]
pub fn is_foreign(file: &Path) -> bool {
    ["wav", "w64", "npy", "npz", "db3"].into_iter().any(|ending| has_ending(file, ending))
        || file.is_dir()
}

fn has_ending(file: &Path, wanted: &str) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(wanted))
}

/// Reads `file`, finds its channels and holds its samples.
///
/// # Errors
/// Where the file cannot be read, or nothing in it can be used.
pub fn import(file: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    find(file, options, true)
}

/// The same; where [`Imported::rows`] gives the samples they are not held, so that a file of any length can be read.
///
/// # Errors
/// Where the file cannot be read, or nothing in it can be used.
pub fn open(file: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    find(file, options, false)
}

fn find(file: &Path, options: &ImportOptions, hold: bool) -> Result<Imported, ImportError> {
    let imported = if let Some((format, table)) = arrays::table(file)? {
        arrays::import(format, table, options, hold)?
    } else {
        match read_streams(file, options)? {
            Some((format, streams)) => assign::assign(file, format, streams, options)?,
            None => table(file, options)?,
        }
    };
    let rate_hz = imported.recording.rate_hz;
    if rate_hz > PipelineConfig::HIGHEST_RATE_HZ {
        return Err(ImportError::TooFast { file: file.to_owned(), rate_hz });
    }
    Ok(imported)
}

/// What kind of file it is, and every signal in it; `None` for a table.
fn read_streams(
    file: &Path,
    options: &ImportOptions,
) -> Result<Option<(&'static str, Vec<Stream>)>, ImportError> {
    let (format, streams) = if has_ending(file, "mcap") || has_ending(file, "db3") || file.is_dir()
    {
        let mut topics = Topics::default();
        let files = files_of(file)?;
        for file in &files {
            match has_ending(file, "mcap") {
                true => mcap_file::read(file, options, &mut topics)?,
                #[cfg(feature = "db3")]
                false => db3::read(file, options, &mut topics)?,
                #[cfg(not(feature = "db3"))]
                false => {
                    let what = "is SQLite, which is not built in (feature `db3`): `gripctl import` reads it";
                    return Err(ImportError::nothing(file, what));
                }
            }
        }
        if files.len() > 1 {
            topics.note(format!("{} files, read in the order of their numbers", files.len()));
        }
        let is_mcap = files.first().is_some_and(|file| has_ending(file, "mcap"));
        (if is_mcap { "MCAP" } else { "rosbag2" }, topics.finish(file)?)
    } else {
        return Ok(None);
    };
    if streams.iter().all(|stream| stream.rows() == 0 || stream.names.is_empty()) {
        return Err(ImportError::nothing(file, "it holds no numbers"));
    }
    Ok(Some((format, streams)))
}

/// A table.
fn table(file: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let samples = CsvSamples::open(file, &options.csv())?;
    let (format, clock) = samples.kind();
    let clock = clock.to_owned();
    Ok(Imported::of(format, clock, samples.hold()?))
}

impl ImportOptions {
    fn csv(&self) -> CsvOptions {
        let Self { rate_hz, map, time_unit, finger, .. } = self.clone();
        CsvOptions { rate_hz, map, time_unit, finger }
    }
}

impl Imported {
    fn of(format: &'static str, clock: String, mut recording: Recording) -> Self {
        let notes = &mut recording.notes;
        let (uses, unused) = (mem::take(&mut notes.uses), mem::take(&mut notes.ignored_columns));
        let notes = mem::take(&mut notes.remarks);
        Self { format, clock, uses, unused, notes, recording, rows: None }
    }
}

/// Endings of what may be a recording of its own in a folder that is no bag, and how many of them a refusal names.
const OTHERS: [&str; 8] = ["csv", "txt", "tsv", "xlsx", "npz", "npy", "wav", "w64"];
const MOST_NAMED: usize = 5;

/// The file itself, or the files of messages in the folder of a bag, in the order of their numbers.
fn files_of(path: &Path) -> Result<Vec<PathBuf>, ImportError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let (mut found, mut packed, mut others) = (Vec::new(), Vec::new(), Vec::new());
    for entry in std::fs::read_dir(path).map_err(ImportError::unreadable(path))? {
        let file = entry.map_err(ImportError::unreadable(path))?.path();
        if has_ending(&file, "mcap") || has_ending(&file, "db3") {
            found.push(file);
        } else if has_ending(&file, "zstd") || has_ending(&file, "zst") {
            packed.push(file);
        } else if OTHERS.into_iter().any(|ending| has_ending(&file, ending)) {
            others.push(file);
        }
    }
    others.sort();
    let folder = path.display();
    let what = match (found.as_slice(), packed.as_slice(), others.as_slice()) {
        ([_, ..], [], _) => {
            found.sort_by_cached_key(|file| numbered(file));
            return Ok(found);
        }
        (_, [_, ..], _) => {
            format!("its files are compressed; unpack them with: zstd -d --rm '{folder}'/*.zst*")
        }
        (_, _, [first, ..]) => {
            let name = |file: &PathBuf| file.file_name().unwrap_or_default().display().to_string();
            let names: Vec<_> = others.iter().take(MOST_NAMED).map(name).collect();
            let shell = |path: &Path| grip_record::shell(&path.display().to_string());
            format!(
                "it is no bag; what may be a recording in it: {}{} (files: {}); `gripctl replay {}/*.{}` finds the slips of each, \
                 `gripctl import {} -o run.csv` makes a recording of one",
                names.join(", "),
                if others.len() > MOST_NAMED { ", ..." } else { "" },
                others.len(),
                shell(path),
                first.extension().unwrap_or_default().display(),
                shell(first)
            )
        }
        _ => "the folder holds neither .mcap nor .db3, and no other recording".to_owned(),
    };
    Err(ImportError::nothing(path, &what))
}

/// A name by the number at its end: `bag_10` behind `bag_9`.
fn numbered(file: &Path) -> (String, u64, PathBuf) {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = stem.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = stem.get(name.len()..).and_then(|number| number.parse().ok());
    (name.to_owned(), number.unwrap_or(0), file.to_owned())
}
