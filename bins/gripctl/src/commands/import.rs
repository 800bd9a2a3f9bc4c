//! `gripctl import`: a recording of another program as one of this project.

use super::{csv_options, replay::is_mcap};
use crate::{cli::import::ImportArgs, output};
use anyhow::Context as _;
use grip_import::{ImportOptions, Imported, Use};
use grip_record::{
    ChannelSet, CsvOptions, CsvWriter, Recording, is_npz,
    mcap::{McapWriter, Record, SampleRecord},
};
use grip_session::{
    HostConfig,
    exit::{Exit, WrongArgument},
    model,
    recording::{ABOUT, PART, RUN, event_record, pipeline_record},
    replay::{self, Replay},
    report::EventLog,
    session::Beginning,
};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufWriter, Write as _},
    path::Path,
};

/// Names that are shown of what is not used.
const MOST_UNUSED: usize = 20;

#[derive(Serialize)]
#[serde(tag = "type", rename = "channel")]
struct ChannelLine<'a> {
    column: &'a str,
    signal: &'a str,
    unit: &'a str,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "import")]
struct Summary<'a> {
    format: &'a str,
    times: &'a str,
    rate_hz: f32,
    samples: usize,
    duration_s: f64,
    gaps: usize,
    unused: &'a [String],
    notes: &'a [String],
    output: Option<String>,
}

pub(crate) fn run(args: &ImportArgs) -> anyhow::Result<Exit> {
    if let Some(output) = &args.output {
        check_output(&args.file, output, args.force)?;
    }
    let options = ImportOptions {
        topics: args.topic.clone(),
        finger: args.finger,
        ..import_options(&csv_options(&args.csv)?)
    };
    let imported = import(&args.file, &options)?;
    if let Some(output) = &args.output {
        refuse_axes(&imported.recording, output)?;
        write(&imported.recording, output)
            .with_context(|| format!("cannot write {}", output.display()))?;
    }
    show(&imported, args)?;
    Ok(if imported.recording.notes.cut { Exit::DataLost } else { Exit::Done })
}

/// Reads a recording of another program; a file that cannot be used is a wrong argument.
fn import(file: &Path, options: &ImportOptions) -> Result<Imported, WrongArgument> {
    grip_import::import(file, options).map_err(|error| WrongArgument(error.to_string()))
}

/// The recording in a file of another program; what is taken for what, on standard error.
pub(super) fn shown(file: &Path, csv: &CsvOptions) -> anyhow::Result<Recording> {
    let imported = import(file, &import_options(csv))?;
    show_uses(file, &imported.uses);
    Ok(imported.recording)
}

/// What is taken for what, on standard error; nothing where every name and unit is that of a recording.
pub(super) fn show_uses(file: &Path, uses: &[Use]) {
    #[expect(clippy::float_cmp, reason = "exactly 1 changes nothing")]
    let own = |used: &Use| used.ours == used.theirs && used.scale == 1.0;
    if uses.iter().all(own) {
        return;
    }
    for line in use_lines(uses) {
        eprintln!("{}: {}", file.display(), line.trim_start());
    }
}

fn import_options(csv: &CsvOptions) -> ImportOptions {
    let CsvOptions { rate_hz, map, time_unit, finger } = csv.clone();
    ImportOptions { rate_hz, map, time_unit, finger, topics: Vec::new() }
}

fn check_output(file: &Path, output: &Path, force: bool) -> Result<(), WrongArgument> {
    let csv = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    if !(csv || is_npz(output) || is_mcap(output)) {
        let text =
            format!("-o {}: a recording is written as .csv, .npz or .mcap", output.display());
        return Err(WrongArgument(text));
    }
    let same = file.canonicalize().ok().zip(output.canonicalize().ok());
    if same.is_some_and(|(file, output)| file == output) {
        let text = format!("-o {}: would overwrite what is read", output.display());
        return Err(WrongArgument(text));
    }
    if output.exists() && !force {
        let text = format!("-o {}: is there already; --force replaces it", output.display());
        return Err(WrongArgument(text));
    }
    Ok(())
}

/// Messages of a recording have one axis a sensor.
fn refuse_axes(recording: &Recording, output: &Path) -> Result<(), WrongArgument> {
    let ChannelSet { axes, reference_axes, .. } = &recording.channels;
    if !is_mcap(output) || (axes.is_empty() && reference_axes.is_empty()) {
        return Ok(());
    }
    Err(WrongArgument(format!(
        "-o {}: an .mcap has one axis a sensor; write .csv or .npz, or choose an axis with --map",
        output.display()
    )))
}

/// The recording as gripd would have made it, with the events of the shipped settings: what `replay` of the CSV shows.
fn write_mcap(recording: &Recording, file: &Path) -> anyhow::Result<()> {
    let config = replay::pipeline_config(recording, &HostConfig::default(), false);
    let mut events = Replay::new(recording, config, Some(model::default_estimator()?))?;
    let program = concat!("gripctl ", env!("CARGO_PKG_VERSION"));
    let mut writer = McapWriter::new(BufWriter::new(File::create(file)?), program, 0)?;
    let facts = [("program", program), (RUN, &recording.name), (PART, "0")];
    let facts = facts.map(|(name, value)| (name.to_owned(), value.to_owned()));
    writer.metadata(ABOUT, &BTreeMap::from(facts))?;
    let beginning = Beginning {
        config,
        carried_n: None,
        least_n: 0.0,
        released: false,
        taxels: recording.channels.taxels,
    };
    let (mut json, mut log) = (Vec::new(), EventLog::default());
    writer.write(0, &Record::Pipeline(pipeline_record(&beginning, &mut json)?))?;
    let bar = output::progress(recording.samples.len(), "samples");
    for (at, sample) in bar.wrap_iter(recording.samples.iter().enumerate()) {
        let taxels = recording.taxels.as_ref().map_or(&[] as &[f32], |taxels| taxels.frame(at));
        let index = u32::try_from(at % (1 << 32))?;
        let record = SampleRecord { index, sample: *sample, taxels };
        writer.write(sample.t.0, &Record::Sample(record))?;
        let Some(step) = events.next() else { continue };
        for line in log.events(&step).into_iter().flatten() {
            writer.write(sample.t.0, &Record::Event(event_record(&line, &mut json)?))?;
        }
    }
    writer.finish()?;
    Ok(())
}

fn write(recording: &Recording, file: &Path) -> anyhow::Result<()> {
    if is_mcap(file) {
        return write_mcap(recording, file);
    }
    if is_npz(file) {
        return Ok(recording.write_npz(file)?);
    }
    let out = BufWriter::new(File::create(file)?);
    let mut writer = CsvWriter::new(out, &recording.channels)?;
    let bar = output::progress(recording.samples.len(), "samples");
    for (at, sample) in bar.wrap_iter(recording.samples.iter().enumerate()) {
        let frame = recording.taxels.as_ref().map_or(&[] as &[f32], |taxels| taxels.frame(at));
        writer.write_with(sample, frame)?;
    }
    writer.finish()?.flush()?;
    Ok(())
}

fn show(imported: &Imported, args: &ImportArgs) -> anyhow::Result<()> {
    let Imported { format, clock, uses, unused, notes, recording } = imported;
    let first = recording.samples.first().map_or(0.0, |sample| sample.t.as_seconds());
    let last = recording.samples.last().map_or(0.0, |sample| sample.t.as_seconds());
    let times = if clock.is_empty() { "--rate" } else { clock };
    let mut notes = notes.clone();
    notes.extend(Some(recording.notes.to_string()).filter(|text| !text.is_empty()));
    let output = args.output.as_ref().map(|output| output.display().to_string());
    if args.json {
        for Use { ours, theirs, unit, .. } in uses {
            output::json(&ChannelLine { column: ours, signal: theirs, unit })?;
        }
        return output::json(&Summary {
            format,
            times,
            rate_hz: recording.rate_hz,
            samples: recording.samples.len(),
            duration_s: last - first,
            gaps: recording.notes.gaps,
            unused,
            notes: &notes,
            output,
        });
    }
    output::line(&format!("{}: {format}, times from {times}", args.file.display()))?;
    for line in use_lines(uses) {
        output::line(&line)?;
    }
    if !unused.is_empty() {
        let shown = unused.iter().take(MOST_UNUSED).cloned().collect::<Vec<_>>().join(", ");
        let more = unused.len().saturating_sub(MOST_UNUSED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        output::line(&format!("  not used: {shown}{more}"))?;
    }
    for note in &notes {
        output::line(&format!("  {note}"))?;
    }
    let samples = recording.samples.len();
    output::line(&format!(
        "{samples} samples in {:.3} s at {:.1} Hz{}",
        last - first,
        recording.rate_hz,
        output.map_or_else(
            || "; nothing written without -o FILE.csv, FILE.npz or FILE.mcap".to_owned(),
            |output| format!(" -> {output}")
        )
    ))?;
    Ok(())
}

/// What was taken for what; the taxels of an array in one line.
fn use_lines(uses: &[Use]) -> Vec<String> {
    let is_taxel = |used: &&Use| {
        used.ours.strip_prefix("pressure_").is_some_and(|k| k.parse::<usize>().is_ok())
    };
    let mut lines: Vec<String> = uses
        .iter()
        .filter(|used| !is_taxel(used))
        .map(|Use { ours, theirs, unit, .. }| format!("  {theirs} -> {ours} ({unit})"))
        .collect();
    let taxels: Vec<&Use> = uses.iter().filter(is_taxel).collect();
    let place =
        |wanted: usize| taxels.iter().find(|used| used.ours == format!("pressure_{wanted}"));
    if let Some((first, last)) = place(0).zip(place(taxels.len().saturating_sub(1))) {
        lines.push(format!(
            "  {} .. {} -> pressure_0 .. pressure_{} ({})",
            first.theirs,
            last.theirs,
            taxels.len() - 1,
            first.unit
        ));
    }
    lines
}
