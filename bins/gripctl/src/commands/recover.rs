//! `gripctl recover`: a recording without its end, or with damage, made whole.

use super::unreadable;
use crate::{cli::RecoverArgs, output};
use anyhow::{Context as _, anyhow};
use grip_record::{
    files,
    mcap::{Recovered, recover},
};
use grip_session::exit::{Exit, WrongArgument};
use serde::Serialize;
use std::{
    fs::{self, File, TryLockError},
    io::{BufReader, BufWriter, Write as _},
    path::{Path, PathBuf},
};

#[derive(Serialize)]
#[serde(tag = "type", rename = "recovered")]
struct Report<'a> {
    /// Whether the file was whole and was left as it is.
    whole: bool,
    messages: u64,
    attachments: u64,
    /// Host time between the first and the last message (s).
    duration_s: f64,
    /// Bytes at the end that are no whole record.
    lost_bytes: u64,
    holes: Vec<Hole<'a>>,
    output: Option<String>,
}

#[derive(Serialize)]
struct Hole<'a> {
    offset: u64,
    what: &'a str,
}

pub(crate) fn run(args: &RecoverArgs) -> anyhow::Result<Exit> {
    let input = files::open(&args.file).map_err(unreadable(&args.file))?;
    let len = input.metadata()?.len();
    if args.output.is_none() {
        refuse_live(&args.file, &input)?;
    }
    if let Some(output) = &args.output {
        refuse_same(&args.file, output)?;
    }
    let beside = with_ending(args.output.as_deref().unwrap_or(&args.file), "part");
    let saved = write(args, &input, &beside);
    let saved = match saved {
        Ok(saved) => saved,
        Err(error) => {
            // What was written is of no use; that it cannot be removed either is nothing new.
            let _ = fs::remove_file(&beside);
            return Err(error);
        }
    };
    let place = place(args, &saved);
    let meant = args.output.as_ref().or(Some(&args.file));
    if let Some(place) = place.as_ref().filter(|place| Some(*place) != meant && place.exists()) {
        let _ = fs::remove_file(&beside);
        return Err(anyhow!("{} is there already; name another file with -o", place.display()));
    }
    match &place {
        Some(place) => fs::rename(&beside, place),
        None => fs::remove_file(&beside),
    }
    .with_context(|| format!("cannot write {}", place.as_deref().unwrap_or(&beside).display()))?;
    let lost_bytes = saved.cut_at.map_or(0, |at| len.saturating_sub(at));
    report(args, &saved, lost_bytes, place.as_deref())?;
    let lossy = lost_bytes > 0 || !saved.holes.is_empty();
    Ok(if lossy { Exit::DataLost } else { Exit::Done })
}

fn write(args: &RecoverArgs, input: &File, beside: &Path) -> anyhow::Result<Recovered> {
    let name = || format!("cannot write {}", beside.display());
    let mut out = BufWriter::new(File::create_new(beside).with_context(name)?);
    let program = concat!("gripctl ", env!("CARGO_PKG_VERSION"));
    let saved = recover(&args.file, BufReader::new(input), &mut out, program)?;
    out.flush().with_context(name)?;
    out.get_ref().sync_all().with_context(name)?;
    Ok(saved)
}

/// Where the result goes; `None` where a whole file needs none.
fn place(args: &RecoverArgs, saved: &Recovered) -> Option<PathBuf> {
    match &args.output {
        Some(output) => Some(output.clone()),
        None if saved.was_whole() => None,
        None if saved.holes.is_empty() => Some(args.file.clone()),
        None => Some(with_ending(&args.file, "recovered.mcap")),
    }
}

/// A file that gripd writes to must not be replaced under it.
fn refuse_live(file: &Path, input: &File) -> anyhow::Result<()> {
    match input.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Err(WrongArgument(format!(
            "{} is being recorded now; stop gripd first, or give -o to save what is there so far",
            file.display()
        ))
        .into()),
        // A file system without locks has no lock of gripd either.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

fn refuse_same(file: &Path, output: &Path) -> anyhow::Result<()> {
    let same = fs::canonicalize(output).ok() == fs::canonicalize(file).ok();
    if same {
        return Err(WrongArgument(
            "-o names the recording itself; leave it out to recover in place".to_owned(),
        )
        .into());
    }
    Ok(())
}

/// `NAME.mcap` as `NAME.ending`.
fn with_ending(file: &Path, ending: &str) -> PathBuf {
    file.with_extension(ending)
}

fn report(
    args: &RecoverArgs,
    saved: &Recovered,
    lost_bytes: u64,
    place: Option<&Path>,
) -> anyhow::Result<()> {
    #[expect(clippy::cast_precision_loss, reason = "only shown")]
    let duration_s =
        saved.span_ns.map_or(0.0, |(first, last)| last.saturating_sub(first) as f64 / 1e9);
    let (messages, attachments) = (saved.messages, saved.attachments);
    if args.json {
        let holes = saved.holes.iter().map(|(offset, what)| Hole { offset: *offset, what });
        return output::json(&Report {
            whole: saved.was_whole(),
            messages,
            attachments,
            duration_s,
            lost_bytes,
            holes: holes.collect(),
            output: place.map(|place| place.display().to_string()),
        });
    }
    for (offset, what) in &saved.holes {
        output::line(&format!("damaged at byte {offset}, left out: {what}"))?;
    }
    if let Some(at) = saved.cut_at {
        let rest = match lost_bytes {
            0 => "every record of it is whole, only its index was missing or damaged".to_owned(),
            lost => format!("{lost} bytes at its end are no whole record and are lost"),
        };
        output::line(&format!("ends at byte {at}: {rest}"))?;
    }
    let file = args.file.display();
    let what = format!("{messages} messages in {duration_s:.3} s and {attachments} attachments");
    let text = match place {
        None => format!("{file} is whole: {what}; nothing was changed"),
        Some(place) => format!("{}: saved {what}", place.display()),
    };
    Ok(output::line(&text)?)
}
