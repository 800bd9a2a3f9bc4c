//! `gripctl recover`: a recording without its end, or with damage, made whole.

use super::unreadable;
use crate::{cli::RecoverArgs, output};
use grip_import::unpack;
use grip_record::{
    files,
    mcap::{Recovered, recover},
    outputs::{OutputError, OutputKind, OutputPath},
};
use grip_session::exit::{Exit, WrongArgument};
use serde::Serialize;
use std::{
    fs::{File, TryLockError},
    io::BufReader,
    path::Path,
};

const PROGRAM: &str = concat!("gripctl ", env!("CARGO_PKG_VERSION"));

#[derive(Serialize)]
#[serde(tag = "type", rename = "recovered")]
struct Report<'a> {
    /// Whether the file was whole and was left as it is.
    whole: bool,
    messages: u64,
    attachments: u64,
    /// Host time between the first and the last message (s).
    duration_s: f64,
    /// Bytes at the end that are no whole record, and messages that were saved of them.
    lost_bytes: u64,
    of_cut_chunk: u64,
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
    let named = args.output.as_deref().map(|output| new_file(args, output)).transpose()?;
    if named.is_none() {
        refuse_live(&args.file, &input)?;
    }
    let replacing = |file: &Path| OutputPath::new(file, OutputKind::ANY, [], Some(true));
    // What is saved is counted before it is known where it belongs.
    let part = args.file.with_extension("part");
    let mut out = named.clone().map_or_else(|| replacing(&part), Ok)?.create()?;
    let saved = recover(&args.file, BufReader::new(&input), &mut out, PROGRAM, unpack)?;
    let lost_bytes = saved.cut_at.map_or(0, |at| len.saturating_sub(at));
    if saved.messages + saved.attachments == 0 && !saved.was_whole() {
        report(args, &saved, lost_bytes, None)?;
        return Ok(Exit::Failed);
    }
    let place = match named {
        Some(named) => Some(named),
        None if saved.was_whole() => None,
        // Nothing of the original may be missing in what takes its place.
        None if saved.was_ours() && saved.holes.is_empty() => Some(replacing(&args.file)?),
        None => Some(new_file(args, &args.file.with_extension("recovered.mcap"))?),
    };
    if let Some(place) = &place {
        out.finish_as(place)?;
    }
    report(args, &saved, lost_bytes, place.as_ref().map(OutputPath::file))?;
    let lossy = lost_bytes > 0 || !saved.holes.is_empty();
    Ok(if lossy { Exit::DataLost } else { Exit::Done })
}

/// A file beside the recording.
fn new_file(args: &RecoverArgs, file: &Path) -> Result<OutputPath, OutputError> {
    output::path(file, OutputKind::data(&["mcap"]), &args.force, &[Some(&args.file)])
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

fn report(
    args: &RecoverArgs,
    saved: &Recovered,
    lost_bytes: u64,
    place: Option<&Path>,
) -> anyhow::Result<()> {
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
            of_cut_chunk: saved.of_cut_chunk,
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
            lost if saved.of_cut_chunk > 0 => format!(
                "the {lost} bytes at its end are a chunk that is cut off; {} messages of it are saved",
                saved.of_cut_chunk
            ),
            lost => format!("{lost} bytes at its end are no whole record and are lost"),
        };
        output::line(&format!("ends at byte {at}: {rest}"))?;
    }
    let file = args.file.display();
    let what = format!("{messages} messages in {duration_s:.3} s and {attachments} attachments");
    let text = match place {
        None if saved.was_whole() => format!("{file} is whole: {what}; nothing was changed"),
        None => format!(
            "{file}: no message can be saved (a compressed block is of no use without its end); the file stays as it is"
        ),
        Some(place) => format!("{}: saved {what}", place.display()),
    };
    Ok(output::line(&text)?)
}
